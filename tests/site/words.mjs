// Words that people search for, and the pages that help at the first hit: concepts, synonyms, products of others.

const own = (words, ...pages) => words.split(", ").map((word) => [word, ...pages]);

const STICK = "docs/stick-slip.html";
const QUESTIONS = "docs/questions.html";
const MACHINES = ["docs/machines.html", "docs/parameters.html"];
const INSTALL = ["docs/start/install.html", "docs/start/python.html", "docs/start/fmu.html", "docs/start/rust.html"];
const PLATFORMS = ["docs/platforms.html", "docs/start/install.html"];

export const WORDS = [
  ...own("stick slip, stick-slip, hunting, limit cycle, dither, steady-state error, staircase, jerky, integral, steady state", STICK, "docs/glossary.html"),
  ...own("stiction, static friction, Stribeck, Coulomb, friction law, break-away", "docs/friction-laws.html", STICK, "laws/", "docs/glossary.html"),
  ...own("LuGre, Dahl, Karnopp, GMS, Leuven", "laws/", "docs/friction-laws.html"),
  ...own("presliding, tanh, creep, drift, sticking", "docs/friction-laws.html", "docs/glossary.html", "laws/", STICK),
  ...own("deadband, dead zone, hysteresis, backlash", "docs/glossary.html", "docs/parameters.html", "docs/data-sheets.html", STICK, "docs/machines.html", "docs/friction-laws.html"),
  ...own("PID, controller, tuning, gain, anti-windup, windup", STICK, "docs/tutorial/README.html", "models/PositionController.html", "docs/tools/fmpy.html", "docs/models.html", "docs/tutorial/tutorial.html"),
  ...own("install, installation, download, pip", ...INSTALL),
  ...own("license, licence, commercial", "docs/start/install.html", "README.html"),
  ...own("Windows, Linux, macOS, platform", ...PLATFORMS),
  ...own("ROS, Docker, Arduino, conda, LabVIEW, Julia, Excel, vacuum, hydraulics, GPU, cloud", QUESTIONS),
  ...own("dSPACE, Speedgoat, HIL, real time", QUESTIONS, "docs/realtime.html"),
  ...own("PLC, TwinCAT, CODESYS, microcontroller", "docs/target.html", QUESTIONS, "docs/machines.html"),
  ...own("Matlab, Simulink", "docs/tools/simulink.html"),
  ...own("OpenModelica, Dymola, FMPy, CasADi", "docs/tools/"),
  ...own("MuJoCo, Gazebo, multibody", "docs/tools/multibody.html"),
  ...own("gym, gymnasium, RL, reinforcement learning, stable baselines", "docs/environments.html"),
  ...own("Kalman, observer", "docs/observer.html"),
  ...own("MPC, optimal control", "docs/tutorial/README.html", "docs/sensitivities.html", "docs/tools/casadi.html", QUESTIONS),
  ...own("solver, step size, event, tolerance", "docs/solver.html"),
  ...own("gradient, sensitivity, adjoint", "docs/sensitivities.html"),
  ...own("linearise", "reference/python/derivatives.html", "docs/tutorial/", "docs/sensitivities.html"),
  ...own("identification, fit, uncertainty, calibration, measured data", "docs/identification", "docs/start/data.html", "docs/your-machine.html"),
  ...own("gravity, spring return, solenoid, PWM, hose, cushion, leakage, 5/2", ...MACHINES),
  ...own("Cv, conductance, data sheet", "docs/data-sheets.html"),
  ...own("API", "reference/", QUESTIONS),
  ...own("units", "docs/data-sheets.html", "docs/parameters.html", "docs/start/data.html", "docs/identification"),
  ...own("model exchange, co-simulation, FMI, SSP", "docs/model-exchange.html", "docs/interfaces.html", "docs/start/fmu.html", "docs/tools/", "docs/glossary.html"),
];

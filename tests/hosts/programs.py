"""The cylinder under 7 V in other people's importers: a function for each, which says where the carriage ends.

`python programs.py <tool> <folder of FMUs>` prints a JSON object: `position` in m, `steps`, `step` in s, `law`
by number (0 is the default), `voltage` in V at initialization. A tool that refuses prints why, and ends with 1.
With `--configured` it is a cylinder of its own, `LuGre.fmu` with few ports, in which nobody has to choose the law.
"""

from __future__ import annotations

import json
import sys
import zipfile
from pathlib import Path
from typing import Any

VOLTAGE, STEPS, STEP, LUGRE = 7.0, 200, 1e-3, 14
NAME = "PneumaticServoCylinder"
IS_CONFIGURED = "--configured" in sys.argv
FMU = "LuGre" if IS_CONFIGURED else NAME
LAW = {} if IS_CONFIGURED else {"friction.lawNumber": LUGRE}
START = LAW | {"valveVoltage": VOLTAGE}
HELD = {"valveVoltage": VOLTAGE} if IS_CONFIGURED else {"valveVoltage": VOLTAGE, "supplyPressure": 5e5}
"""Inputs that a tool without start values of its own must set."""


def at_end(position: Any, **changed: Any) -> dict[str, Any]:
    told = {"steps": STEPS, "step": STEP, "law": LUGRE, "voltage": VOLTAGE}
    if IS_CONFIGURED:
        changed.pop("law", None)
    return {"position": float(position), **told, **changed}


def fmpy(fmus: Path) -> dict[str, Any]:
    from fmpy import simulate_fmu

    run = simulate_fmu(
        fmus / f"{FMU}.fmu", stop_time=STEPS * STEP, output_interval=STEP, start_values=START, output=["position"]
    )
    return at_end(run["position"][-1])


def sofirpy(fmus: Path) -> dict[str, Any]:
    from sofirpy import simulate

    frame = simulate(
        stop_time=STEPS * STEP,
        step_size=STEP,
        fmu_paths={"plant": fmus / f"{FMU}.fmu"},
        start_values={"plant": START},
        logging_step_size=STEP,
        parameters_to_log={"plant": ["position"]},
    )
    return at_end(frame["plant.position"].iloc[-1])


def gemseo_fmu(fmus: Path) -> dict[str, Any]:
    import numpy as np
    from gemseo_fmu.disciplines.fmu_discipline import FMUDiscipline

    plant = FMUDiscipline(fmus / f"{FMU}.fmu", ["valveVoltage"], ["position"], final_time=STEPS * STEP, time_step=STEP)
    return at_end(plant.execute({"valveVoltage": np.array([VOLTAGE])})["position"][-1], law=0)


def fmugym(fmus: Path) -> dict[str, Any]:
    import numpy as np
    from fmugym.fmugym import FMUGym
    from fmugym.fmugym_config import FMUGymConfig, VarSpace

    class Environment(FMUGym):
        def _noisy_init(self) -> dict[int, float]:
            return {}

        def compute_reward(self, *arguments: Any) -> float:
            return 0.0

    step = 2.0**-10  # a sum of these is exact, so that an action is one step
    inputs, outputs, none = VarSpace("inputs"), VarSpace("outputs"), VarSpace("none")
    inputs.add_var_box("valveVoltage", 0.0, 10.0)
    outputs.add_var_box("position", 0.0, 1.0)
    environment = Environment(
        FMUGymConfig(
            fmu_path=str(fmus / f"{FMU}.fmu"),
            start_time=0.0,
            stop_time=1.0,
            sim_step_size=step,
            action_step_size=step,
            inputs=inputs,
            outputs=outputs,
            random_vars=none,
            input_noise=none,
            output_noise=none,
        )
    )
    environment.reset(seed=1)
    for _ in range(STEPS):
        seen = environment.step(np.array([VOLTAGE]))[0]
    return at_end(seen[0], step=step, law=0, voltage=5.0)


def syssimx(fmus: Path) -> dict[str, Any]:
    from syssimx.components.fmu import FMUComponent

    plant = FMUComponent("plant", str(fmus / f"{FMU}.fmu"))
    plant.set_parameters(**LAW)
    plant.initialize(0.0)  # with all inputs at 0
    for step in range(STEPS):
        plant.set_inputs(HELD)
        plant.do_step(step * STEP, STEP)
    return at_end(plant.get_outputs()["position"].magnitude)


def estim8(fmus: Path) -> dict[str, Any]:
    from estim8.models import FmuModel

    model = FmuModel(str(fmus / f"{FMU}.fmu"), fmi_type="CoSimulation")
    run = model.simulate(0, STEPS * STEP, STEP, parameters=START, observe=["position"], r_tol=1e-6)
    return at_end(run["position"].values[-1])


def fmuloader(fmus: Path) -> dict[str, Any]:
    from xml.etree import ElementTree

    from fmuloader.fmi2 import Fmi2Slave, Fmi2Type

    fmu = fmus / f"{FMU}.fmu"
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    reference = {v.attrib["name"]: int(v.attrib["valueReference"]) for v in root.iter("ScalarVariable")}
    plant = Fmi2Slave(fmu, model_identifier=NAME)
    plant.instantiate("plant", Fmi2Type.CO_SIMULATION, guid=root.attrib["guid"])
    plant.setup_experiment(start_time=0.0)
    for name, law in LAW.items():
        plant.set_integer([reference[name]], [law])
    plant.enter_initialization_mode()
    plant.set_real([reference["valveVoltage"]], [VOLTAGE])
    plant.exit_initialization_mode()
    for step in range(STEPS):
        plant.do_step(step * STEP, STEP)
    return at_end(plant.get_real([reference["position"]])[0])


def without_booleans(fmus: Path) -> Path:
    """An FMU without Boolean inputs and outputs, by the toolbox."""
    import subprocess

    target = Path("reduced.fmu").resolve()
    tool = Path(sys.executable).with_name("fmutool")
    of = ["-remove-regexp", r"sticking|sensor\.end\[.*|coil\[.*"]
    subprocess.run([tool, "-input", fmus / f"{FMU}.fmu", "-output", target, *of], check=True, capture_output=True)
    return target


def pathsim(fmus: Path) -> dict[str, Any]:
    from pathsim import Connection, Simulation
    from pathsim.blocks import Constant, Scope
    from pathsim_fmi import CoSimulationFMU

    fmu = fmus / f"{FMU}.fmu" if IS_CONFIGURED else without_booleans(fmus)
    plant = CoSimulationFMU(str(fmu), dt=STEP, start_values=START)
    sources, scope = {name: Constant(value) for name, value in HELD.items()}, Scope()
    connections = [Connection(source, plant[name]) for name, source in sources.items()]
    connections.append(Connection(plant["position"], scope))
    Simulation([plant, scope, *sources.values()], connections, dt=STEP, log=False).run((STEPS - 0.5) * STEP)
    _, (position,) = scope.read()
    return at_end(position[STEPS - 1])  # one step early


def fmucontainer(fmus: Path) -> dict[str, Any]:
    import subprocess

    from fmpy import simulate_fmu

    names = dict.fromkeys(START, "input") | {"position": "output"}
    described: dict[str, Any] = {"name": "container.fmu", "step_size": STEP, "fmu": [f"{FMU}.fmu"]}
    for name, kind in names.items():
        ends = [name, f"{FMU}.fmu", name] if kind == "input" else [f"{FMU}.fmu", name, name]
        described.setdefault(kind, []).append(ends)
    Path("container.json").write_text(json.dumps(described))
    tool = Path(sys.executable).with_name("fmucontainer")
    where = ["-fmu-directory", ".", "-no-auto-input", "-no-auto-output"]
    Path(f"{FMU}.fmu").write_bytes((fmus / f"{FMU}.fmu").read_bytes())
    subprocess.run([tool, "-container", "container.json", *where], check=True, capture_output=True)
    run = simulate_fmu(
        "container.fmu", stop_time=STEPS * STEP, output_interval=STEP, start_values=START, output=["position"]
    )
    return at_end(run["position"][-1])


def libcosim(fmus: Path) -> dict[str, Any]:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(step_size=1_000_000)
    slave = CosimLocalSlave(fmu_path=str(fmus / f"{FMU}.fmu"), instance_name="plant")
    plant = execution.add_local_slave(slave)
    if LAW:
        execution.integer_initial_value(plant, 30000, LUGRE)
    execution.real_initial_value(plant, 1, VOLTAGE)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    for _ in range(STEPS):
        execution.step()
    return at_end(observer.last_real_values(plant, [101])[0])


def ecos(fmus: Path) -> dict[str, Any]:
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        structure.add_model("plant", fmus / f"{FMU}.fmu")
        structure.add_parameter_set("set", {f"plant::{name}": value for name, value in START.items()})
        with EcosSimulation(structure=structure, step_size=STEP) as simulation:
            simulation.init(parameter_set="set")
            simulation.step(STEPS)
            return at_end(simulation.get_real("plant::position"))


def reference(fmus: Path, told: dict[str, Any]) -> float:
    """The position by FMPy, step by step, for what a tool was able to set."""
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    fmu = fmus / f"{NAME}.fmu"
    description = read_model_description(fmu)
    number = {variable.name: variable.valueReference for variable in description.modelVariables}
    plant = FMU2Slave(
        guid=description.guid, unzipDirectory=extract(fmu), modelIdentifier=NAME, instanceName="reference"
    )
    plant.instantiate()
    plant.setupExperiment(startTime=0.0)
    plant.setInteger([number["friction.lawNumber"]], [told["law"]])
    plant.enterInitializationMode()
    plant.setReal([number["valveVoltage"]], [told["voltage"]])
    plant.exitInitializationMode()
    plant.setReal([number["valveVoltage"]], [VOLTAGE])
    for step in range(told["steps"]):
        plant.doStep(step * told["step"], told["step"])
    return float(plant.getReal([number["position"]])[0])


if __name__ == "__main__":
    tool, folder, *rest = (word for word in sys.argv[1:] if word != "--configured")
    if tool == "reference":
        print(json.dumps(reference(Path(folder), json.loads(rest[0]))))
    else:
        try:
            print("\n" + json.dumps(globals()[tool](Path(folder))), flush=True)
        except Exception as error:
            print("\n" + json.dumps(f"{type(error).__name__}: {error}".splitlines()[0]), flush=True)
            sys.exit(1)

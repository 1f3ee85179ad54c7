"""Cost of a millisecond of a plant in programs that users know, in µs of processor time.

The default experiment under the law LuGre, whose runs have no events of friction: 3 s of `5 + 2 sin(2 pi t)` V. A valve
without play lets solvers see one smooth function. The position is recorded each millisecond. The rows:

- this package, which gets a voltage each millisecond, and holds it;
- FMPy with the FMU for co-simulation, step by step: what its calls add;
- FMPy with its CVode and the FMU for model exchange;
- `scipy.integrate.solve_ivp` by BDF, LSODA and Radau, with the derivatives of the same FMU; the voltage is the sine;
- a step of 1 ms of MuJoCo, for a slide with dry friction and an actuator: another plant, without air, given as an order
  of magnitude.

Errors are the largest ones of the position, against the package at a tolerance of 1e-11. It is given the voltage every
10 µs where a row has the sine itself. Of some runs the least time counts.

It needs the package, FMPy and SciPy; without MuJoCo (`pip install mujoco`) that row is left out.
Usage: python tests/benches/peers.py [target/fmu/PneumaticServoCylinder.fmu]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from ctypes import POINTER, c_double
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Model
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]

STEP, STEPS, TOLERANCE = 1e-3, 3000, 1e-6
TIMES = np.arange(STEPS + 1) * STEP
FINE = 100
"""Parts of a step where the reference is given the sine itself."""
LAW, SETTINGS = 14, {"friction.law": "LuGre", "valve.hysteresis": 0.0, "supplyPressure": 6e5}
ROOT = Path(__file__).resolve().parents[2]
SLIDE = """
<mujoco><option timestep="0.001"/>
  <worldbody><body>
    <joint name="x" type="slide" axis="1 0 0" frictionloss="8" damping="25" limited="true" range="0 0.5"/>
    <geom type="box" size="0.05 0.05 0.05" mass="0.88"/>
  </body></worldbody>
  <actuator><motor joint="x" gear="10"/></actuator>
</mujoco>
"""


def voltage(times: Array | float) -> Array:
    return np.asarray(5.0 + 2.0 * np.sin(2.0 * np.pi * np.asarray(times)))


def least(work: Callable[[], object], repetitions: int) -> float:
    """The shortest processor time in s."""
    times = []
    for _ in range(repetitions):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return min(times)


def package(tolerance: float = TOLERANCE, parts: int = 1) -> Array:
    """The position at each millisecond; of several parts of a step, the voltage in the middle of each."""
    times = np.arange(STEPS * parts) * STEP / parts
    middle = 0.0 if parts == 1 else 0.5 * STEP / parts
    run = ps.Model().simulate(
        SETTINGS | {"solver.relativeTolerance": tolerance}, inputs={"valveVoltage": (times, voltage(times + middle))},
        stop=STEPS * STEP, step=STEP / parts, every=parts, outputs=["position"],
    )  # fmt: skip
    return run["position"]


def fmpy(fmu: Path, kind: str) -> Callable[[], Array]:
    """The position by FMPy, for co-simulation or model exchange."""
    description = read_model_description(str(fmu))
    folder = extract(str(fmu))
    columns = np.broadcast_arrays(TIMES, voltage(TIMES), 6e5, 0.0)
    inputs = np.rec.fromarrays(columns, names="time,valveVoltage,supplyPressure,externalForce")
    start = {"friction.law": LAW, "valve.hysteresis": 0.0}
    given = {} if kind == "CoSimulation" else {"solver": "CVode", "relative_tolerance": TOLERANCE}

    def run() -> Array:
        found = simulate_fmu(
            folder, model_description=description, fmi_type=kind, stop_time=STEPS * STEP, step_size=STEP,
            output_interval=STEP, start_values=start, input=inputs, output=["position"], **given,
        )  # fmt: skip
        return np.asarray(found["position"][: STEPS + 1])

    return run


class Equations:
    """The derivatives of the FMU for model exchange, as SciPy asks for them."""

    def __init__(self, fmu: Path) -> None:
        description = read_model_description(str(fmu))
        number = {variable.name: variable.valueReference for variable in description.modelVariables}
        self.voltage = [number["valveVoltage"]]
        names = [unknown.variable.derivative.name for unknown in description.derivatives]
        self.position = names.index("position")
        self.model = FMU2Model(
            guid=description.guid, unzipDirectory=extract(str(fmu)), instanceName="plant",
            modelIdentifier=description.modelExchange.modelIdentifier,
        )  # fmt: skip
        self.model.instantiate()
        self.model.setReal([number["valve.hysteresis"], number["supplyPressure"]], [0.0, 6e5])
        self.model.setInteger([number["friction.law"]], [LAW])
        self.model.setupExperiment(startTime=0.0)
        self.model.enterInitializationMode()
        self.model.exitInitializationMode()
        while self.model.newDiscreteStates()[0]:
            pass
        self.model.enterContinuousTimeMode()
        self.start = np.zeros(len(names))
        self.rates = np.zeros(len(names))
        self.model.getContinuousStates(_pointer(self.start), len(names))
        self.nominal = np.zeros(len(names))
        self.model.getNominalsOfContinuousStates(_pointer(self.nominal), len(names))

    def __call__(self, now: float, states: Array) -> Array:
        self.model.setTime(now)
        states = np.ascontiguousarray(states)
        self.model.setContinuousStates(_pointer(states), len(states))
        self.model.setReal(self.voltage, [float(voltage(now))])
        self.model.getDerivatives(_pointer(self.rates), len(states))
        return self.rates.copy()

    def solved(self, method: str) -> Callable[[], Array]:
        def run() -> Array:
            found = solve_ivp(
                self, (0.0, STEPS * STEP), self.start, method=method, t_eval=TIMES, rtol=TOLERANCE,
                atol=TOLERANCE * self.nominal,
            )  # fmt: skip
            if not found.success:
                raise RuntimeError(found.message)
            return np.asarray(found.y[self.position])

        return run


def _pointer(values: Array) -> object:
    return values.ctypes.data_as(POINTER(c_double))


def mujoco_step() -> float | None:
    """Processor time in s of the steps of MuJoCo, if it is there."""
    try:
        import mujoco
    except ImportError:
        return None
    model = mujoco.MjModel.from_xml_string(SLIDE)
    data = mujoco.MjData(model)

    def run() -> None:
        mujoco.mj_resetData(model, data)
        # The steps of MuJoCo alone, without a call from Python for each.
        mujoco.mj_step(model, data, nstep=STEPS)

    return least(run, 10)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmu", type=Path, nargs="?", default=ROOT / "target/fmu/PneumaticServoCylinder.fmu")
    fmu = parser.parse_args().fmu
    held, smooth = package(1e-11), package(1e-11, FINE)
    equations = Equations(fmu)
    rows: list[tuple[str, Callable[[], Array], Array, int]] = [
        ("this package, a voltage each millisecond", package, held, 15),
        ("FMPy, co-simulation, step by step", fmpy(fmu, "CoSimulation"), held, 3),
        ("FMPy with its CVode, model exchange", fmpy(fmu, "ModelExchange"), smooth, 3),
        *((f"SciPy, solve_ivp, {method}", equations.solved(method), smooth, 3) for method in ("BDF", "LSODA", "Radau")),
    ]
    print("| what | µs for a millisecond | times this package | error of the position |\n|---|--:|--:|--:|")
    first = None
    for name, run, reference, repetitions in rows:
        cost = 1e6 * least(run, repetitions) / STEPS
        first = first or cost
        error = 1e6 * float(np.max(np.abs(run() - reference)))
        print(f"| {name} | {cost:.3g} | {cost / first:.3g} | {error:.2g} µm |", flush=True)
    steps = mujoco_step()
    if steps is not None and first is not None:
        print(
            f"| a step of MuJoCo, *another plant* | {1e6 * steps / STEPS:.3g} | {1e6 * steps / STEPS / first:.3g} | |"
        )


if __name__ == "__main__":
    main()

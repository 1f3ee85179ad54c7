"""Measures the Python package against what it replaces, as ratios within one run.

- `simulate` with a fresh voltage each millisecond, against the same loop through FMPy's FMU2Slave and in Rust;
- `simulate_many` on all cores against one, with 0.5 s per roll-out, and beside it as many processes that share nothing:
  what the machine gives;
- plant steps a second and core of `simulate_many` and of the vector environment with 1,024 plants, at the default
  tolerance, and at 1e-4 and 1e-3, which leave errors of some micrometres;
- a fit of five parameters to 10 s of a rig, from its start to its intervals.

It needs the package with SciPy, FMPy and Gymnasium.
Usage: python tests/benches/python_package.py [target/fmu/PneumaticServoCylinder.fmu]
"""

from __future__ import annotations

import argparse
import multiprocessing
import subprocess
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import gymnasium
import numpy as np
import pneumatic_servo as ps
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from pneumatic_servo.tasks import available_cores

ROOT = Path(__file__).resolve().parents[2]
STEP, STEPS = 1e-3, 3000
ROLL_OUTS = 2000
TIMES = np.arange(STEPS) * STEP
VOLTAGES = 5.0 + 2.0 * np.sin(2.0 * np.pi * TIMES)


def best(work: Callable[[], object], repetitions: int = 15) -> float:
    """The shortest time in s."""
    times = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def ratios(works: Sequence[Callable[[], object]], repetitions: int = 15) -> np.ndarray:
    """Ratio of the first's time to each of the others'.

    They take turns, so that both of a ratio meet the same machine, and the median of the turns counts.
    """
    times = np.array([[best(work, 1) for work in works] for _ in range(repetitions)])
    return np.median(times[:, :1] / times[:, 1:], axis=0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmu", type=Path, nargs="?", default=ROOT / "target/fmu/PneumaticServoCylinder.fmu")
    fmu = parser.parse_args().fmu
    package = best(simulate) / STEPS
    host = best(fmpy_loop(fmu), 5) / STEPS
    rust = rust_loop()
    print(f"a step of 1 ms: package {1e9 * package:.0f} ns, FMPy {1e9 * host:.0f} ns, Rust {1e9 * rust:.0f} ns")
    print(f"FMPy / package: {host / package:.1f} (at least 8)")
    print(f"package / Rust: {package / rust:.2f} (at most 1.3)")
    cores = available_cores()
    with ProcessPoolExecutor(cores, multiprocessing.get_context("spawn")) as processes:

        def apart() -> None:
            list(processes.map(many_on_one_thread, [ROLL_OUTS // cores] * cores))

        apart()
        threads, separate = ratios([lambda: many(1), lambda: many(cores), apart]) / cores
    print(f"{cores} cores are {threads:.2f} times as fast for each as one (at least 0.9); as processes {separate:.2f}")
    for tolerance, least in [(1e-6, 1), (1e-4, 1), (1e-3, 4)]:
        roll_outs = ROLL_OUTS * 500 / best(partial(many, 1, tolerance=tolerance), 5)
        steps = [1e-6 * number for number in (roll_outs, environment_steps(1, tolerance))]
        print(
            f"tolerance {tolerance:g}: simulate_many {steps[0]:.2f}, vector environment {steps[1]:.2f}"
            f" million steps a second on one core (at least {least})"
        )
    elapsed, processor = fit()
    print(f"a fit of five parameters to 10 s of a rig: {elapsed:.1f} s (at most 10), {processor:.1f} s on the cores")


def simulate() -> ps.Run:
    inputs = {"valveVoltage": (TIMES, VOLTAGES)}
    return PLANT.simulate(inputs=inputs, stop=STEPS * STEP, step=STEP, outputs=["position"])


def many_on_one_thread(number: int) -> None:
    many(1, number)


def many(workers: int, number: int = ROLL_OUTS, tolerance: float = 1e-6) -> ps.Runs:
    return PLANT.simulate_many(
        {"solver.relativeTolerance": tolerance},
        number=number,
        inputs={"valveVoltage": (TIMES, VOLTAGES)},
        stop=0.5,
        step=STEP,
        every=500,
        outputs=["position"],
        workers=workers,
        progress=False,
    )


def fmpy_loop(fmu: Path) -> Callable[[], None]:
    description = read_model_description(str(fmu))
    number = {variable.name: variable.valueReference for variable in description.modelVariables}
    voltage, position = [number["valveVoltage"]], [number["position"]]
    folder = extract(str(fmu))

    def loop() -> None:
        slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="plant",
        )
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        for index, value in enumerate(VOLTAGES.tolist()):
            slave.setReal(voltage, [value])
            slave.doStep(currentCommunicationPoint=index * STEP, communicationStepSize=STEP)
            slave.getReal(position)
        slave.freeInstance()

    return loop


def rust_loop() -> float:
    """Time in s of a step of the same loop in Rust."""
    command = ["cargo", "run", "--quiet", "--release", "--package", "benchmark"]
    done = subprocess.run([*command, "--bin", "rust_loop"], cwd=ROOT, check=True, capture_output=True, text=True)
    return 1e-9 * float(done.stdout)


def environment_steps(workers: int, tolerance: float) -> float:
    """Plant steps a second in the default experiment, from positions all over the stroke."""
    number, parameters = 1024, {"solver.relativeTolerance": tolerance}
    fleet = gymnasium.make_vec(
        "pneumatic_servo/Positioning-v0", num_envs=number, workers=workers, duration=STEPS * STEP, parameters=parameters
    )
    actions = [np.full((number, 1), voltage / 5.0 - 1.0, dtype=np.float32) for voltage in VOLTAGES]

    def steps() -> None:
        fleet.reset(seed=1)
        for action in actions[:-1]:
            fleet.step(action)

    return (STEPS - 1) * number / best(steps, 5)


def fit() -> tuple[float, float]:
    """Elapsed and processor time in s; position and pressures have a noise of 10 um and 0.5 kPa."""
    times = np.arange(10_001) * STEP
    voltage = 5.0 - np.sin(np.pi * times) + 0.8 * np.sin(3.4 * np.pi * times)
    noises = {"position": 1e-5, "chamberA.pressure": 500.0, "chamberB.pressure": 500.0}
    known = {"supplyPressure": 6e5, "friction.law": "Stribeck"}
    truth = PLANT.simulate(known, inputs={"valveVoltage": (times, voltage)}, stop=10.0, step=STEP, outputs=list(noises))
    rng = np.random.default_rng(1)
    data = {name: truth[name] + noise * rng.standard_normal(len(times)) for name, noise in noises.items()}
    free = ["friction.stribeck.Fs", "friction.stribeck.Fc", "friction.stribeck.sigma2", "valve.deadZone", "valve.C"]
    begin, spent = time.perf_counter(), time.process_time()
    ps.fit({"time": times, "valveVoltage": voltage, **data}, experiment="rig", law="Stribeck",
           fit=[f"{name}={1.2 * PLANT.parameters[name].default}" for name in free],
           settings={"supplyPressure": 6e5})  # fmt: skip
    return time.perf_counter() - begin, time.process_time() - spent


PLANT = ps.Model("PneumaticServoCylinder")

if __name__ == "__main__":
    main()

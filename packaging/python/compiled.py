"""Compiles the sources of FMUs with FMPy, and compares what they do with the library beside them, bit for bit."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
from pathlib import Path

import experiment
import fmpy
import numpy as np
from client import Client, Value
from experiment import LAW, laws_of, signals, simulate
from fmpy.build import build_platform_binary

STEP = 1e-3
"""Communication step of the runs that are saved and restored, in s."""
STEPS = 100
"""Numbers of steps before a state is saved, after it, and of a run by FMI 3.0."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("fmus", type=Path, nargs=2, metavar="FMU", help="of FMI 2.0 and of FMI 3.0")
    parser.add_argument("--experiments", type=Path, required=True, metavar="FILE", help="default experiments, as JSON")
    arguments = parser.parse_args()
    experiment.EXPERIMENTS.update(json.loads(arguments.experiments.read_text("utf-8")))
    fmi2, fmi3 = arguments.fmus
    with tempfile.TemporaryDirectory() as folder:
        compiled = compile_sources(fmi2, Path(folder) / "fmi2")
        laws = laws_of(fmi2)
        for law in laws:
            same_run(fmi2, compiled, law)
            saved_states_are_interchangeable(fmi2, compiled, law)
        print(f"FMI 2.0: {len(laws)} laws, saved states both ways: the bits of the library")
        compiled = compile_sources(fmi3, Path(folder) / "fmi3")
        for law, number in numbers_of(fmi2).items():
            same_run_by_fmi3(fmi3, compiled, law, number)
        print(f"FMI 3.0: {len(laws)} laws: the bits of the library")
    return 0


def numbers_of(fmu: Path) -> dict[str, dict[str, int]]:
    """The start values that choose each law; none for a model without a choice."""
    with Client(fmu) as client:
        if LAW not in client.variables:
            return {"": {}}
        return {law: {LAW: number} for law, number in client.items(LAW).items()}


def compile_sources(fmu: Path, folder: Path) -> Path:
    """The FMU with nothing but the library that FMPy makes of its sources."""
    fmpy.extract(str(fmu), unzipdir=str(folder / "contents"))
    shutil.rmtree(folder / "contents" / "binaries")
    build_platform_binary(folder / "contents", configuration="Release")
    compiled = shutil.make_archive(str(folder / "compiled"), "zip", folder / "contents")
    return Path(compiled).rename(folder / fmu.name)


def same_run(fmu: Path, compiled: Path, law: str) -> None:
    """The default experiment."""
    expected, found = (simulate(file, law) for file in (fmu, compiled))
    for name, values in expected.columns.items():
        if values.tobytes() != found.columns[name].tobytes():
            raise AssertionError(f"{law}: {name} differs in FMI 2.0")


def saved_states_are_interchangeable(fmu: Path, compiled: Path, law: str) -> None:
    """Each library goes on from what the other has saved, and comes to the same."""
    for one, other in ((fmu, compiled), (compiled, fmu)):
        with Client(one) as first, Client(other) as second:
            start: dict[str, Value] = {LAW: law} if law else {}
            first.start(start)
            drive(first, STEPS)
            state = first.slave.getFMUstate()
            saved = bytes(first.slave.serializeFMUstate(state))
            first.slave.freeFMUstate(state)
            state = second.slave.deSerializeFMUstate(saved)
            second.slave.setFMUstate(state)
            second.slave.freeFMUstate(state)
            second.time = first.time
            for client in (first, second):
                drive(client, STEPS)
            expected, found = (np.array(client.get(client.names("output"))) for client in (first, second))
            if expected.tobytes() != found.tobytes():
                raise AssertionError(f"{law}: a state that {one} saved goes on otherwise in {other}")


def drive(client: Client, steps: int) -> None:
    """Steps of the default experiment."""
    moving = signals(client.description.modelName)
    for _ in range(steps):
        client.set({name: signal(client.time) for name, signal in moving.items()})
        client.advance(client.time + STEP)


def same_run_by_fmi3(fmu: Path, compiled: Path, law: str, start: dict[str, int]) -> None:
    """The first tenth of a second of the default experiment, as FMPy runs it."""
    moving = signals(fmu.stem)
    times = STEP * np.arange(STEPS + 1)
    inputs = np.array(
        [(time, *(signal(time) for signal in moving.values())) for time in times],
        dtype=[(name, float) for name in ("time", *moving)],
    )
    results = [
        fmpy.simulate_fmu(
            str(file),
            stop_time=STEPS * STEP,
            output_interval=STEP,
            start_values=start,
            input=inputs if moving else None,
        )
        for file in (fmu, compiled)
    ]
    if results[0].tobytes() != results[1].tobytes():
        raise AssertionError(f"{law}: a run differs in FMI 3.0")


if __name__ == "__main__":
    sys.exit(main())

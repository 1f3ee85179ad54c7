"""Runs the default experiment of an FMU under every friction law; leaves a CSV and a figure per law beside it."""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import figures
from client import Client, Value

LAW = "friction.law"
"""The parameter that is varied, where a model has it."""

SIGNALS: dict[str, Callable[[float], float]] = {
    "valveVoltage": lambda t: 5.0 + 2.0 * np.sin(2.0 * np.pi * t),
    # A controller alone: a carriage that lags behind its reference.
    "referencePosition": lambda t: 0.25 + 0.1 * np.sin(np.pi * t),
    "position": lambda t: 0.25 + 0.1 * np.sin(np.pi * (t - 0.02)),
    "velocity": lambda t: 0.1 * np.pi * np.cos(np.pi * (t - 0.02)),
    # The crane trolley pulls for 10 s, rests, and returns.
    "craneVelocity": lambda t: 0.25 * ((t < 10.0) - float(15.0 <= t < 25.0)),
}
"""Inputs that move; all others stay at their start values. A value is set at a communication point and held."""


@dataclass
class Run:
    """What an experiment gave: one column per variable, one row per communication point."""

    model: str
    law: str
    columns: dict[str, np.ndarray]
    units: figures.Units

    @property
    def name(self) -> str:
        return f"{self.model}_{self.law}" if self.law else self.model


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("fmu", type=Path)
    parser.add_argument("--output", type=Path, help="folder of the results (default: beside the FMU)")
    arguments = parser.parse_args()
    folder: Path = arguments.output or arguments.fmu.parent
    folder.mkdir(parents=True, exist_ok=True)
    runs = []
    laws = laws_of(arguments.fmu)
    for number, law in enumerate(laws, start=1):
        begin = time.perf_counter()
        run = simulate(arguments.fmu, law)
        seconds = time.perf_counter() - begin
        write_csv(run, folder / f"{run.name}.csv")
        figures.draw_run(run, folder / f"{run.name}.png")
        print(f"[{number:2}/{len(laws)}] {run.name}: {len(run.columns['time']) - 1} steps in {seconds:.2f} s", flush=True)
        runs.append(run)
    if len(runs) > 1:
        figures.draw_overview(runs, folder / f"{runs[0].model}.png")
    print(f"results and figures: {folder}")
    return 0


def laws_of(fmu: Path) -> list[str]:
    """The laws to run; one empty name for a model without a choice."""
    with Client(fmu) as client:
        return list(client.items(LAW)) if LAW in client.variables else [""]


def simulate(fmu: Path, law: str = "", parameters: dict[str, Value] | None = None) -> Run:
    """Runs the default experiment."""
    with Client(fmu) as client:
        default = client.description.defaultExperiment
        step = float(default.stepSize)
        count = round(float(default.stopTime) / step)
        signals = {name: SIGNALS[name] for name in client.names("input") if name in SIGNALS}
        start: dict[str, Value] = dict(parameters or {})
        start |= {name: signal(0.0) for name, signal in signals.items()}
        if law:
            start[LAW] = law
        names = client.names("input") + client.names("output")
        rows = np.empty((count + 1, len(names) + 1))
        client.start(start)
        for index in range(count + 1):
            client.set({name: signal(index * step) for name, signal in signals.items()})
            rows[index] = [client.time, *client.get(names)]
            if index < count:
                client.advance((index + 1) * step)
        columns = dict(zip(["time", *names], rows.T, strict=True))
        return Run(client.description.modelName, law, columns, figures.Units.of(client.description))


def write_csv(run: Run, file: Path) -> None:
    """Writes every number so that reading it gives the same bits."""
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(run.columns)
        writer.writerows(zip(*(column.tolist() for column in run.columns.values()), strict=True))


if __name__ == "__main__":
    sys.exit(main())

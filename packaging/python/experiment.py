"""Runs the default experiment of FMUs and leaves a CSV per FMU beside it."""

from __future__ import annotations

import argparse
import csv
import json
import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from client import Client, Value

EXPERIMENTS = json.loads((Path(__file__).parents[2] / "modelDescription" / "experiments.json").read_text("utf-8"))
"""The default experiment of every model, as the plant states it."""

LAW = "friction.law"
"""The parameter that is varied, where a model has it."""


@dataclass
class Run:
    """Results of an experiment: one column per variable, one row per communication point."""

    model: str
    law: str
    columns: dict[str, np.ndarray]


def signals(model: str) -> dict[str, Callable[[float], float]]:
    """Inputs that move in the default experiment, as functions of time; all others stay at their start values.

    A value is set at a communication point and held.
    """
    return {signal["input"]: course(signal["course"]) for signal in EXPERIMENTS[model]["signals"]}


def course(stated: dict[str, Any]) -> Callable[[float], float]:
    """A course as the plant states it."""
    match stated:
        case {"Sine": {"mean": mean, "amplitude": amplitude, "frequency": frequency, "delay": delay}}:
            return lambda time: mean + amplitude * math.sin(2.0 * math.pi * frequency * (time - delay))
        case {"Steps": steps}:
            return lambda time: next((value for begin, value in reversed(steps) if begin <= time), 0.0)
    raise ValueError(f"{stated} is no course of an input")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("fmus", type=Path, nargs="+", metavar="FMU")
    parser.add_argument("--experiments", type=Path, metavar="FILE", help="experiments of other models, as JSON")
    arguments = parser.parse_args()
    if arguments.experiments:
        EXPERIMENTS.update(json.loads(arguments.experiments.read_text("utf-8")))
    for fmu in arguments.fmus:
        write_csv(timed(fmu), fmu.with_suffix(".csv"))
    return 0


def timed(fmu: Path, law: str = "") -> Run:
    """Runs, and says how long that took."""
    begin = time.perf_counter()
    run = simulate(fmu, law)
    name = f"{run.model}, {law}" if law else run.model
    print(f"{name}: {len(run.columns['time']) - 1} steps in {time.perf_counter() - begin:.2f} s", flush=True)
    return run


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
        moving = signals(client.description.modelName)
        start: dict[str, Value] = dict(parameters or {})
        start |= {name: signal(0.0) for name, signal in moving.items()}
        if law:
            start[LAW] = law
        names = client.names("input") + client.names("output")
        rows = np.empty((count + 1, len(names) + 1))
        client.start(start)
        for index in range(count + 1):
            client.set({name: signal(index * step) for name, signal in moving.items()})
            rows[index] = [client.time, *client.get(names)]
            if index < count:
                client.advance((index + 1) * step)
        columns = dict(zip(["time", *names], rows.T, strict=True))
        return Run(client.description.modelName, law, columns)


def write_csv(run: Run, file: Path) -> None:
    """Writes every number so that reading it gives the same bits; the file is there as a whole or not at all."""
    file.parent.mkdir(parents=True, exist_ok=True)
    partial = file.with_name(f".{file.name}")
    with partial.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(run.columns)
        writer.writerows(zip(*(column.tolist() for column in run.columns.values()), strict=True))
    partial.replace(file)


if __name__ == "__main__":
    sys.exit(main())

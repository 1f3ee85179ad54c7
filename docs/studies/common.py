"""Helpers of the studies: many runs of a model on all cores, with a progress bar, and figures of one style."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Iterable, Mapping
from multiprocessing import Pool
from pathlib import Path
from typing import TypeVar

import matplotlib as mpl
import pneumatic_servo as ps
from tqdm import tqdm

mpl.use("Agg")

import matplotlib.pyplot as plt

ROOT = Path(__file__).resolve().parents[2]

Task = TypeVar("Task")
Result = TypeVar("Result")


class Plant:
    """A running model that is advanced to points of time."""

    def __init__(self, model: str, parameters: Mapping[str, ps.Value]) -> None:
        self.simulation = ps.Model(model).start(parameters)
        self.set, self.get = self.simulation.set, self.simulation.get

    @property
    def time(self) -> float:
        return self.simulation.time

    def advance(self, end: float) -> None:
        self.simulation.step(end - self.simulation.time)


def parameter_set(name: str) -> dict[str, ps.Value]:
    """The values of a set, as it is packed into the FMU."""
    sets = json.loads((ROOT / "modelDescription" / "parameter_sets.json").read_text(encoding="utf-8"))
    values: dict[str, ps.Value] = next(one["values"] for one in sets if one["name"] == name)
    return values


def arguments(text: str) -> argparse.Namespace:
    """Folder of the results, size, and number of processes."""
    own = parser(text)
    own.add_argument("--small", action="store_true", help="a few points only, in seconds")
    return parsed(own)


def repeated(text: str, laws: Iterable[str], chosen: Iterable[str], count: int) -> argparse.ArgumentParser:
    """Options: laws, repetitions, duration of the records, folder of the results, number of processes."""
    own = parser(text)
    own.add_argument("--laws", nargs="+", default=list(chosen), choices=laws)
    own.add_argument("--repetitions", type=int, default=count)
    own.add_argument("--duration", type=float, default=3.0, help="of the records in s")
    return own


def parser(text: str) -> argparse.ArgumentParser:
    """Options: folder of the results, number of processes."""
    own = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    own.add_argument("--output", type=Path, default=ROOT / "target" / "studies", help="folder of figures and tables")
    own.add_argument("--workers", type=int, default=os.cpu_count(), help="number of processes (default: all cores)")
    return own


def parsed(own: argparse.ArgumentParser) -> argparse.Namespace:
    """Options of the command line, with the folder of the results made."""
    options = own.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    return options


def parallel(
    options: argparse.Namespace, label: str, function: Callable[[Task], Result], tasks: Iterable[Task]
) -> list[Result]:
    """The results of a function, in the order of the tasks."""
    tasks = list(tasks)
    with Pool(options.workers) as pool:
        return list(tqdm(pool.imap(function, tasks, chunksize=1), label, len(tasks), disable=None))


def save(figure: plt.Figure, file: Path) -> None:
    figure.savefig(file, metadata={"Software": None})
    plt.close(figure)

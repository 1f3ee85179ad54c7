"""What the studies share: many runs of an FMU on all cores, with a progress bar."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterable
from multiprocessing import Pool
from pathlib import Path
from typing import TypeVar

from tqdm import tqdm

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "packaging" / "python"))
from client import Client, Value  # noqa: E402

Task = TypeVar("Task")
Result = TypeVar("Result")

_client: Client | None = None
"""The instance of this process; it is reset for every run."""


def arguments(text: str, model: str) -> argparse.Namespace:
    """FMU, folder of the results, and size."""
    parser = argparse.ArgumentParser(description=text.partition("\n")[0])
    parser.add_argument("fmu", type=Path, nargs="?", default=ROOT / "target" / "fmu" / f"{model}.fmu")
    parser.add_argument("--output", type=Path, default=ROOT / "target" / "studies", help="folder of figures and tables")
    parser.add_argument("--small", action="store_true", help="a few points only, in seconds")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="number of processes (default: all cores)")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    return options


def parallel(
    options: argparse.Namespace, label: str, function: Callable[[Task], Result], tasks: Iterable[Task]
) -> list[Result]:
    """The results of a function that uses `run`, in the order of the tasks."""
    tasks = list(tasks)
    with Pool(options.workers, _open, [options.fmu]) as pool:
        return list(tqdm(pool.imap(function, tasks, chunksize=1), label, len(tasks), disable=None))


def run(parameters: dict[str, Value]) -> Client:
    """The instance of this process, started anew."""
    assert _client is not None, "runs are made by `parallel`"
    _client.slave.reset()
    _client.start(parameters)
    return _client


def _open(fmu: Path) -> None:
    global _client
    _client = Client(fmu)

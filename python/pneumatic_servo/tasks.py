"""Work on many cores."""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import Future
from typing import Any


def available_cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def is_finished(task: Future[Any]) -> bool:
    """Tell whether a task has come to a result."""
    return task.done() and not task.cancelled() and task.exception() is None


def cancel(tasks: Iterable[Future[Any]]) -> None:
    """Begin none of the tasks that have not begun."""
    for task in tasks:
        task.cancel()

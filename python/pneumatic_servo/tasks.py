"""Work that was given to an executor."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Future
from typing import Any


def is_finished(task: Future[Any]) -> bool:
    """Tell whether a task has come to a result."""
    return task.done() and not task.cancelled() and task.exception() is None


def cancel(tasks: Iterable[Future[Any]]) -> None:
    """Begin none of the tasks that have not begun."""
    for task in tasks:
        task.cancel()

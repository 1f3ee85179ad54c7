"""The progress of long work, shown on a terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm

Progress = bool | Callable[[int, int], None]
"""True shows a bar on a terminal, False nothing; a function is called with the finished part and the whole."""


@contextmanager
def shown(progress: Progress, label: str, total: int, unit: str) -> Iterator[Callable[[int], None] | None]:
    """Yield an observer of the progress."""
    if callable(progress):
        yield lambda done: progress(done, total)
    elif not progress:
        yield None
    else:
        # `disable=None` shows nothing where there is no terminal.
        with tqdm(total=total, desc=label, unit=unit, disable=None, delay=0.5) as bar:

            def move(done: int) -> None:
                bar.update(max(0, done - bar.n))

            yield move

"""Progress of a fit, and the best result so far when it is interrupted."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

Array = NDArray[np.float64]

Told = bool | Callable[[str], None]
"""Whether to show progress, or the function that is told it."""
QUIET = 10.0
"""Interval in s of lines of progress where there is no terminal."""


class Watch:
    """Looks after a search.

    Attributes
    ----------
    best : ndarray or None
        The best vector of the present stage, or of the last one that had any.
    runs : int
        Vectors that were simulated.
    """

    def __init__(self, label: str) -> None:
        self.label = label
        self.best: Array | None = None
        self.runs = 0
        self._cost = np.inf
        self._stage = "first search"
        self._tell: Callable[[str], None] = lambda text: None
        self._say: Callable[[str], None] = lambda text: None

    def told_by(self, tell: Callable[[str], None], say: Callable[[str], None]) -> None:
        """Tell one function how far it is from now on, and another what has to be known at once."""
        self._tell, self._say = tell, say

    def stage(self, name: str) -> None:
        """Begin something else, whose misfits are not to be compared with those before."""
        self._stage, self._cost = name, np.inf
        self._tell(name)

    def see(self, x: Array, cost: float) -> None:
        """Take notice of a vector and its mean square in units of the noise."""
        self.runs += 1
        if cost <= self._cost or self.best is None or len(x) != len(self.best):
            self.best, self._cost = np.array(x), min(cost, self._cost)
        best = f"the best leaves {np.sqrt(self._cost):.4g} times the noise"
        self._tell(f"cost {cost:.5g} ({best}; {self._stage}, {self.runs} runs)")

    def done(self, text: str) -> None:
        """Tell how far something has come."""
        self._tell(text)

    def say(self, text: str) -> None:
        """Tell something that has to be known at once, and stays to be read."""
        self._say(text)


@contextmanager
def told(progress: Told, watch: Watch) -> Iterator[None]:
    """Show what a watch tells: on a terminal in one line, elsewhere now and then; or tell it to a function."""
    if callable(progress):
        watch.told_by(progress, progress)
        yield
    elif not progress:
        yield
    elif sys.stderr.isatty():
        with tqdm(total=None, bar_format="{desc} [{elapsed}]", leave=False) as bar:
            watch.told_by(
                lambda text: bar.set_description_str(f"{watch.label}: {text}"),
                lambda text: bar.write(f"{watch.label}: {text}", file=sys.stderr),
            )
            yield
    else:
        watch.told_by(_lines(watch.label), lambda text: print(f"{watch.label}: {text}", file=sys.stderr, flush=True))
        yield


def _lines(label: str) -> Callable[[str], None]:
    """Return a function that writes a line every now and then."""
    begun = last = time.monotonic()

    def tell(text: str) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= QUIET:
            last = now
            print(f"{label}: {text} [{now - begun:.0f} s]", file=sys.stderr, flush=True)

    return tell

"""Progress of a fit, and the best result so far when it is interrupted."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Container, Iterator, Sequence
from contextlib import contextmanager
from functools import partial

from tqdm import tqdm

from pneumatic_servo.argument_names import quoted

Told = bool | Callable[[str], None]
"""Whether to show progress, or the function that is told it."""
QUICK = 0.1
"""Interval in s at which a line on a terminal changes."""
QUIET = 10.0
"""Interval in s of lines of progress where there is no terminal."""


class Watch:
    """Looks after a search.

    Attributes
    ----------
    runs : int
        Vectors that were simulated.
    notes : list of str
        What it has told that stays to be read.
    every : float
        Interval in s at which it wants to hear of vectors; infinity if it tells nobody.
    """

    def __init__(self, label: str) -> None:
        self.label = label
        self.runs = 0
        self.lost: Sequence[str] = ()
        self.every = math.inf
        self._cost = math.inf
        self._stage = "first search"
        self._tell: Callable[[str], None] = lambda text: None
        self._say: Callable[[str], None] = lambda text: None

    def told_by(self, tell: Callable[[str], None], say: Callable[[str], None], every: float = 0.0) -> None:
        """Tell one function how far it is from now on, and another what has to be known at once."""
        self._tell, self._say, self.every = tell, say, every

    def stage(self, name: str) -> None:
        """Begin something else, whose misfits are not to be compared with those before."""
        self._stage, self._cost = name, math.inf
        self._tell(name)

    def see(self, cost: float, least: float = math.inf, number: int = 1) -> None:
        """Take notice of the mean square of a vector in units of the noise, and the least one of the last vectors."""
        self.runs += number
        self._cost = min(cost, least, self._cost)
        best = f"the best leaves {math.sqrt(self._cost):.4g} times the noise"
        self._tell(f"cost {cost:.5g} ({best}; {self._stage}, {self.runs} runs)")

    def done(self, text: str) -> None:
        """Tell how far something has come."""
        self._tell(text)

    def hidden(self, names: Sequence[str]) -> None:
        """Tell which parameters are hardly identifiable, if there are any, before the search."""
        self.lost = names
        if names:
            self.say(self._lost(names))

    def still_hidden(self, names: Container[str] | None = None) -> list[str]:
        """Return a note of those among them that are not identifiable in the end either; of all, if nobody knows."""
        lost = [name for name in self.lost if names is None or name in names]
        return [self._lost(lost)] if lost else []

    @staticmethod
    def _lost(names: Sequence[str]) -> str:
        return (
            f"not identifiable at the start values: {', '.join(names)}; what is found may be anything; where a value "
            f"is known, give it by {quoted('settings')}"
        )

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
                QUICK,
            )
            yield
    else:
        say = partial(print, f"{watch.label}:", file=sys.stderr, flush=True)
        watch.told_by(_lines(watch.label), say, QUIET)
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

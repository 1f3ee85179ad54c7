"""Errors of runs that ended too early, with the part that was finished."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pneumatic_servo.run import Run, Runs


class SimulationError(RuntimeError):
    """A run that cannot go on: the message says when and why.

    Attributes
    ----------
    finished : Run, Runs or None
        The record until then.
    """

    finished: Run | Runs | None = None


class Interrupted(KeyboardInterrupt):
    """An interrupt from the keyboard (Ctrl-C) during long work.

    Attributes
    ----------
    finished : Run, Runs or None
        The record until then; of a fit the best one found so far.
    """

    finished: object = None

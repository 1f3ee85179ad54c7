"""Errors of runs that ended too early, with the part that was finished."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pneumatic_servo.comparison import Comparison
    from pneumatic_servo.identification import Fit, Plan, Ranking, Telling
    from pneumatic_servo.run import Run, Runs


class SimulationError(RuntimeError):
    """A run that cannot go on: the message says when and why.

    Attributes
    ----------
    finished : Run, Runs or None
        The record until then.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> try:
    ...     ps.Model().simulate({"solver.maxStepsPerCommunicationStep": 10}, stop=1.0, step=0.5)
    ... except ps.SimulationError as error:
    ...     kept = error.finished
    >>> len(kept.time) < 3
    True
    """

    finished: Run | Runs | None = None


class Interrupted(KeyboardInterrupt):
    """An interrupt from the keyboard (Ctrl-C) during long work.

    Attributes
    ----------
    finished : Run, Runs, Comparison, Fit, list of Fit, Ranking, Plan, Telling or None
        What the interrupted call returns, as far as it had come; of a fit the best one found so far.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> def stop(done, total):
    ...     if done >= 2:
    ...         raise KeyboardInterrupt
    >>> try:
    ...     ps.Model().simulate_many(number=50, stop=0.5, step=1e-3, workers=1, progress=stop)
    ... except ps.Interrupted as interrupted:
    ...     kept = interrupted.finished
    >>> len(kept)
    50
    """

    finished: Run | Runs | Comparison | Fit | list[Fit] | Ranking | Plan | Telling | None = None

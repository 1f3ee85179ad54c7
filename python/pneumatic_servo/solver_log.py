"""What the solver has done in a run."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
Logged = tuple[Array, list[tuple[float, str]]]
"""Counters at each row, of shape (rows, counters), and times in s and names of events: from the extension module."""
COUNTERS = ("solver.steps", "solver.rejectedSteps", "solver.jacobians")
"""Variables that count the work."""


class SolverEvent(NamedTuple):
    """An event: a change of the equations that the solver has located, or that a jump of an input has set off.

    The pair of its ``time`` in s and its ``kind``, a name as ``breakAway``.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> run = ps.Model().simulate(inputs={"valveVoltage": 7}, stop=0.2, step=1e-3, solver_log=True)
    >>> time, kind = run.solver_log.events[0]
    >>> 0.0 <= time <= 0.2
    True
    """

    time: float
    kind: str


@dataclass(frozen=True)
class SolverLog:
    """Steps and events of the solver in a run of `Model.simulate` with ``solver_log=True``.

    Attributes
    ----------
    time : ndarray of shape (rows,)
        Times in s of the rows.
    steps, rejected, jacobians : ndarray of shape (rows,)
        Accepted steps, rejected steps and evaluations of the Jacobian since the row before; 0 in the first one.
    events : tuple of SolverEvent
        The events in the order in which they happened.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> run = ps.Model().simulate(inputs={"valveVoltage": 7}, stop=0.2, step=1e-3, solver_log=True)
    >>> log = run.solver_log
    >>> int(log.steps.sum()) >= 200 and log.steps.shape == run.time.shape
    True
    >>> sum(log.kinds.values()) == len(log.events)
    True
    """

    time: Array
    steps: Counts
    rejected: Counts
    jacobians: Counts
    events: tuple[SolverEvent, ...]

    @classmethod
    def of(cls, time: Array, logged: Logged) -> SolverLog:
        """Return the log of counters at the rows, and of events."""
        counters, events = logged
        steps, rejected, jacobians = np.diff(counters, axis=0, prepend=counters[:1]).astype(np.int64).T
        return cls(time, steps, rejected, jacobians, tuple(SolverEvent(*event) for event in events))

    @property
    def kinds(self) -> dict[str, int]:
        """Number of events of each kind, the most frequent first."""
        return dict(Counter(event.kind for event in self.events).most_common())

    def times_of(self, kind: str) -> Array:
        """Return the times in s of the events of a kind, of shape (events,)."""
        return np.array([event.time for event in self.events if event.kind == kind])

    def __repr__(self) -> str:
        steps, rejected, jacobians = (int(one.sum()) for one in (self.steps, self.rejected, self.jacobians))
        kinds = ", ".join(f"{number} {kind}" for kind, number in self.kinds.items())
        return (
            f"<SolverLog: {steps} steps, {rejected} rejected, {jacobians} Jacobians, "
            f"{len(self.events)} events{': ' if kinds else ''}{kinds}>"
        )

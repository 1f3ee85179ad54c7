"""Many closed loops: on threads beside a controller of the library, one after the other with one of Python."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pneumatic_servo import _native
from pneumatic_servo.closed_loop import Loop
from pneumatic_servo.grid import courses_of
from pneumatic_servo.many import (
    Done,
    Work,
    aligned,
    check_same,
    check_same_inputs,
    unfinished,
    widened,
)
from pneumatic_servo.run import Runs, of_run
from pneumatic_servo.run_errors import SimulationError


@dataclass(frozen=True)
class ClosedWork(Work):
    """Runs in closed loops; it can be pickled if the controller can.

    Attributes
    ----------
    loop : Loop
        Controller and sampling. Its recorded variables are the last among the outputs; its inputs are among those
        of the plant.
    """

    loop: Loop = field(kw_only=True)

    def missing(self, earlier: Runs) -> list[int]:
        """Return the numbers of the runs that earlier ones of the same work did not finish."""
        check_same(earlier, [{**self.shared, **own} for own in self.runs], self.outputs)
        if earlier.time.tobytes() != self.loop.grid.times().tobytes():
            raise ValueError("resume: the earlier runs have other times")
        if earlier._controlled != self.loop.text:
            raise ValueError("resume: the earlier runs had another controller, period or delay")
        check_same_inputs(earlier, self.inputs)
        return unfinished(earlier)

    def make(self, threads: int, progress: Callable[[int], None] | None = None) -> Done:
        """Make the runs in this process."""
        return self._beside(threads, progress) if self.loop.runs_beside else self._one_by_one(progress)

    def _beside(self, threads: int, progress: Callable[[int], None] | None) -> Done:
        loop = self.loop
        of_plant, of_controller = (
            [(name, aligned(course)) for name, course in inputs.items()] for inputs in self._divided(self.inputs)
        )
        loop.refuse_twice(dict(of_plant))
        model, given, *names = loop.native
        values, reached, ended, noticed, extremes, _ = _native.simulate_closed(
            loop.model._native, list(self.shared.items()), [list(settings.items()) for settings in self.runs],
            of_plant, (model, given, of_controller, *names), loop.sampling, self.grid, self._of_plant, threads,
            progress, False, None,
        )  # fmt: skip
        ends = {name: one for name, one in zip(loop.model.inputs, extremes, strict=True) if one[0] <= one[1]}
        return Done.of(values, reached, ended, noticed, ends)

    def _one_by_one(self, progress: Callable[[int], None] | None) -> Done:
        loop, number = self.loop, len(self.runs)
        values = np.full((number, len(self.outputs), loop.grid.rows), np.nan)
        done = Done(values, np.zeros(number, np.int64), {}, None, [])
        ended: BaseException | None = None
        for place, settings in enumerate(self.runs):
            inputs = courses_of({name: of_run(one, place, number) for name, one in self.inputs.items()}, loop.grid)
            of_plant, of_controller = self._divided(inputs)
            try:
                one = loop.run({**self.shared, **settings}, of_plant, of_controller, self._of_plant)
                values[place, :, : len(one.times)], done.rows[place] = one.values, len(one.times)
                widened(done.extremes, {name: (min(own), max(own)) for name, own in one.held.items() if len(own)})
                known = {name for _, name, _, _ in done.noticed}
                done.noticed.extend((place, *notice) for notice in one.noticed if notice[0] not in known)
                if isinstance(one.ended, SimulationError):
                    done.failures[place] = str(one.ended)
                else:
                    ended = one.ended
                if progress is not None and ended is None:
                    progress(place + 1)
            except KeyboardInterrupt as interrupt:
                ended = interrupt
            if ended is not None:
                break
        return Done(values, done.rows, done.failures, ended, done.noticed, done.extremes)

    @property
    def _of_plant(self) -> list[str]:
        return [name for name in self.outputs if name not in self.loop.record]

    def _divided(self, inputs: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the inputs of the plant and those of the controller."""
        own = self.loop.own_inputs or ()
        return (
            {name: one for name, one in inputs.items() if name not in own},
            {name: one for name, one in inputs.items() if name in own},
        )

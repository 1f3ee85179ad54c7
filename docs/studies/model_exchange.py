"""Runs FMUs for model exchange where it is hard: into stops, onto springs, along ropes; exits with 1 if a run fails.

Each run is compared with the solver inside. It must not end in an error, and its position must be within ten times the
tolerance, in metres (`WITHIN`), of co-simulation. With `--wrong` the host's solver does not suit the model:
it may be inaccurate then, but must not end in an error.
"""

from __future__ import annotations

import argparse
import contextlib
import shutil
import sys
from collections.abc import Iterable, Iterator
from ctypes import c_double, c_int, c_void_p
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

import fmpy.sundials
import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.model_description import ModelDescription
from fmpy.sundials.cvode import sundials_cvode

Start = dict[str, float | int]

TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-8)
VOLTAGES = (0.0, 3.0, 4.0, 6.0, 6.5, 8.0, 10.0)
LAWS = {"Stribeck": 7, "LuGre": 14, "Coulomb": 2, "Dahl": 10}
WITHIN = 10.0
"""Deviation from the solver inside, in metres, that a run may have at a tolerance of 1."""
UNDAMPED = {"Dahl": 100.0}
"""The same under laws whose bristles keep swinging: errors in the phase of many periods add up."""
EXPLODES = {
    "None", "Dahl", "Bristle", "ResetIntegrator", "LuGre", "Leuven", "GMS", "BlimanSorine", "ElastoPlastic",
    "RevisedLuGre",
}  # fmt: skip
"""Laws with too little damping, or too stiff a bristle, for an explicit step of 1 ms. What it accepts when it explodes,
beyond the covers of the cylinder, is refused."""
INTERVAL = 1e-3
"""Time in s between values that are compared."""


def of_laws(*starts: Start, laws: Iterable[int] = LAWS.values()) -> list[Start]:
    """Start values under each of the laws."""
    return [{**start, "friction.law": law} for start, law in product(starts, laws)]


RUNS = {
    "PneumaticServoCylinder": of_laws(*({"valveVoltage": voltage} for voltage in VOLTAGES)),
    "FrictionBench": of_laws(
        {"spring.stiffness": 1e4, "driveVelocity": 1.0}, {"spring.stiffness": 1e4, "velocity0": 1.0}
    ),
    "DrivenSlider": of_laws({"walk.stepsPerPeriod": 0, "tray.velocityAmplitude": 0.2}, {"walk.stepsPerPeriod": 0}),
    "VibroImpact": of_laws({"displacement0": 0.01, "displacementRate0": 1.0}, {"impact.gap": -0.01}),
    "Festoon": of_laws({"spacing0": 1.0, "craneVelocity": 1.0}, {"spacing0": 0.2, "craneVelocity": -1.0}),
}
"""Start values, by model: every voltage into a stop; a stiff and fast spring; a tray that is driven five times as
hard as usual, and as usual; a mass on the impact spring; trolleys at full extension, and pushed together."""

ONE_SECOND = 1.0


@dataclass
class Solver:
    """Settings of the host's solver."""

    name: str = "CVode"
    step: float = INTERVAL
    """Time in s of a step of a solver that takes steps of one length."""
    first_step: float | None = None
    highest_order: int | None = None


WRONG = {
    "explicit Euler, 1 ms": (Solver("Euler"), 1e-4),
    "tolerance 1e-2": (Solver(), 1e-2),
    "first step 10 s": (Solver(first_step=10.0), 1e-4),
    "first order": (Solver(highest_order=1), 1e-4),
}
"""Solvers that do not suit, with the tolerance they are given."""


@dataclass
class Counts:
    """Cost of a run of CVODE."""

    rates: int = 0
    roots: int = 0
    events: int = 0


@dataclass
class Outcome:
    """A run outside, compared with the solver inside."""

    deviation: float = np.nan
    """Of the position, in m."""
    problems: list[str] = field(default_factory=list)
    """Exceptions, also those that FMPy prints and forgets."""
    counts: Counts = field(default_factory=Counts)


class Fmu:
    """An unpacked FMU, to be closed."""

    def __init__(self, file: Path) -> None:
        self.folder = extract(str(file))
        self.description: ModelDescription = read_model_description(self.folder)
        names = {variable.name for variable in self.description.modelVariables}
        self.laws = {
            int(item.value): item.name
            for kind in self.description.typeDefinitions
            if kind.name == "FrictionLaw"
            for item in kind.items
        }
        self.compared = next(name for name in ("position", "trolley[1].position") if name in names)

    def runs(self, *, every_law: bool) -> list[Start]:
        """Start values of the runs of this model: under four laws, or of the cylinder under all.

        Some laws make the other models undamped or chaotic, so that no two solvers agree.
        """
        starts = RUNS[self.description.modelName]
        if not every_law or self.description.modelName != "PneumaticServoCylinder":
            return starts
        others = (start for start in starts if start["friction.law"] == LAWS["Stribeck"])
        return of_laws(*others, laws=self.laws)

    def law(self, start: Start) -> str:
        """Name of the friction law of a run."""
        return self.laws[int(start["friction.law"])]

    def __enter__(self) -> Fmu:
        return self

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)

    def inside(self, start: Start) -> np.ndarray:
        """Positions in m at each interval, by the solver inside."""
        tight = {"solver.relativeTolerance": 1e-10}
        return self._run(fmi_type="CoSimulation", start_values={**start, **tight})[self.compared]

    def outside(self, start: Start, tolerance: float, expected: np.ndarray, solver: Solver | None = None) -> Outcome:
        """The same with the solver of the host."""
        solver, outcome = solver or Solver(), Outcome()
        with watched(outcome, solver):
            try:
                result = self._run(
                    fmi_type="ModelExchange",
                    solver=solver.name,
                    step_size=solver.step,
                    start_values=start,
                    relative_tolerance=tolerance,
                )
            except Exception as error:
                outcome.problems.append(str(error))
                return outcome
        # Both sides of events are recorded; of values at one instant the last counts.
        times, last = np.unique(result["time"][::-1], return_index=True)
        found = np.interp(INTERVAL * np.arange(len(expected)), times, result[self.compared][::-1][last])
        outcome.deviation = float(np.abs(found - expected).max())
        if not np.isfinite(found).all():
            outcome.problems.append("positions are not finite")
        return outcome

    def _run(self, **arguments: Any) -> np.ndarray:
        return simulate_fmu(
            self.folder,
            model_description=self.description,
            stop_time=ONE_SECOND,
            output_interval=INTERVAL,
            output=[self.compared],
            **arguments,
        )


@contextlib.contextmanager
def watched(outcome: Outcome, solver: Solver) -> Iterator[None]:
    """Sets FMPy's solver, counts what it does, and keeps what it prints and forgets: exceptions in callbacks of C."""
    original, hook = fmpy.sundials.CVodeSolver, sys.unraisablehook

    class Watched(original):
        def __init__(self, *arguments: object, **named: object) -> None:
            super().__init__(*arguments, **named)
            for function, kind, value in (
                ("CVodeSetInitStep", c_double, solver.first_step),
                ("CVodeSetMaxStep", c_double, solver.first_step),
                ("CVodeSetMaxOrd", c_int, solver.highest_order),
            ):
                if value is not None:
                    assert getattr(sundials_cvode, function)(c_void_p(self.cvode_mem), kind(value)) == 0

        def f(self, *arguments: object) -> int:
            outcome.counts.rates += 1
            return super().f(*arguments)

        def g(self, *arguments: object) -> int:
            outcome.counts.roots += 1
            return super().g(*arguments)

        def reset(self, time: float) -> None:
            outcome.counts.events += 1
            super().reset(time)

    fmpy.sundials.CVodeSolver = Watched
    sys.unraisablehook = lambda failure: outcome.problems.append(str(failure.exc_value))
    try:
        yield
    finally:
        fmpy.sundials.CVodeSolver, sys.unraisablehook = original, hook


def allowed(law: str, events: int) -> float:
    """Deviation in metres that a run may have at a tolerance of 1.

    CVODE restarts at order 1 behind each event, with an error of up to the tolerance. That adds up under laws that are
    sampled or renew their bristles: to thousands of restarts a second. The four laws of the table do without.
    """
    return UNDAMPED.get(law, WITHIN) + (0 if law in LAWS else events)


def unexpected(outcome: Outcome, law: str, solver: Solver) -> list[str]:
    """Problems other than that an explicit step has led to states without a meaning, as it must under some laws."""
    may_explode = solver.name == "Euler" and law in EXPLODES
    return [it for it in outcome.problems if not (may_explode and "CompletedIntegratorStep failed" in it)]


def table(file: Path, *, wrong: bool, every_law: bool) -> int:
    """Prints all runs of an FMU, and returns how many failed."""
    failed = 0
    with Fmu(file) as fmu:
        for start in fmu.runs(every_law=every_law):
            expected = fmu.inside(start)
            settings = WRONG if wrong else {f"{tolerance:g}": (Solver(), tolerance) for tolerance in TOLERANCES}
            for name, (solver, tolerance) in settings.items():
                outcome = fmu.outside(start, tolerance, expected, solver)
                bound = allowed(fmu.law(start), outcome.counts.events) * tolerance
                is_far = not wrong and not outcome.deviation <= bound
                failed += bool(is_far or unexpected(outcome, fmu.law(start), solver))
                counts = outcome.counts
                print(
                    file.stem,
                    *(f"{key}={value:g}" for key, value in start.items()),
                    f"{name}: {outcome.deviation:.1e} m,",
                    f"{counts.rates} rates, {counts.roots} roots, {counts.events} events",
                    *outcome.problems[:1],
                    *(["FAR"] if is_far else []),
                    flush=True,
                )
    return failed


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmus", type=Path, nargs="+", metavar="FMU", help="of FMI 2.0 or 3.0")
    parser.add_argument("--wrong", action="store_true", help="with solvers that do not suit")
    parser.add_argument(
        "--every-law", action="store_true", help="the cylinder under every friction law, not under four"
    )
    arguments = parser.parse_args()
    chosen = {"wrong": arguments.wrong, "every_law": arguments.every_law}
    failed = sum([table(file, **chosen) for file in arguments.fmus])
    print(f"{failed} runs failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

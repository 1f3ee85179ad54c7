"""Intervals that plans predict, against the intervals of rigs measured by these plans.

For each law the experiment that `plan` recommends is done on a rig that is integrated independently of this library
(synthetic_rig.py), seen by sensors with the noise that the plan was given, again and again with other noise. Each
record is fitted. Half of the predicted 95 % interval is compared with the mean of the fits' intervals, and with
1.96 standard deviations of the fitted values.

Usage: python docs/studies/plans_kept.py [--laws Coulomb ...] [--repetitions 50] [--duration 3] [--workers N]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice

import matplotlib as mpl
import numpy as np
import pneumatic_servo as ps
from common import parallel, parsed, repeated, save
from matplotlib.figure import Figure
from numpy.typing import NDArray
from pneumatic_servo.figures import BLUE, GREY, STYLE, VERMILION, WIDTH, Drawing
from pneumatic_servo.files import write_csv
from synthetic_rig import COMMON, LAWS, NOISES, STEP, SUPPLY, measured, truth

COLUMNS = ["law", "experiment", "parameter", "true", "unit", "predicted (%)", "of the fits (%)", "of the values (%)",
           "repetitions"]  # fmt: skip
CHOSEN = ("Coulomb", "Stribeck", "LuGre")
WITHIN = 0.25
"""Accepted error of a prediction."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Promise:
    """A law, the experiment that is recommended for it, half of the predicted intervals, and the rig's response."""

    law: str
    plan: ps.Plan
    true: dict[str, Array]


def start(law: str) -> list[str]:
    """Estimated parameters with their start values; predictions hold there."""
    return [f"{name}={value}" for name, value in {**LAWS[law], **COMMON}.items()]


def promised(law: str, duration: float) -> Promise:
    """Plan, and do the experiment."""
    noise = {"position": NOISES["position"], **{f"chamber{c}.pressure": NOISES["pressure"] for c in "AB"}}
    found = ps.plan(law=law, fit=start(law), settings={"supplyPressure": SUPPLY}, noise=noise, duration=duration,
                    step=STEP, progress=False)  # fmt: skip
    course = found.best.course
    return Promise(law, found, truth(law, duration, driven=lambda time: float(course[round(time / STEP)])))


def fitted(task: tuple[Promise, int]) -> list[ps.Estimate]:
    """Fit with the noise of a seed."""
    promise, seed = task
    seen = measured(promise.true, seed, is_rounded=False)
    found = ps.fit(seen, experiment="rig", law=promise.law, fit=start(promise.law), starts=0, workers=1,
                   settings={"supplyPressure": SUPPLY}, progress=False)  # fmt: skip
    return list(found.parameters.values())


def rows(promise: Promise, found: Sequence[Sequence[ps.Estimate]]) -> list[list[object]]:
    """The table of a law."""
    best, table = promise.plan.best, []
    for (name, true), every in zip(promise.plan.values.items(), zip(*found, strict=True), strict=True):
        halves = [0.5 * (one.high - one.low) for one in every]
        spread = 1.96 * float(np.std([one.value for one in every], ddof=1))
        percents = (f"{100.0 * width / true:.3g}" for width in (best.half[name], float(np.mean(halves)), spread))
        table.append([promise.law, best.name, name, true, promise.plan.units[name], *percents, len(every)])
    return table


def drawn(table: Sequence[Sequence[object]]) -> Figure:
    """Achieved over predicted intervals, and whether the prediction was kept."""
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 3.4), layout="constrained")
        axis = figure.subplots()
        labels = [f"{row[0]}: {_short(str(row[2]))}" for row in table]
        predicted, fits, values = (np.array([float(str(row[place])) for row in table]) for place in (5, 6, 7))
        places = np.arange(len(labels))
        axis.axvspan(1.0 - WITHIN, 1.0 + WITHIN, color=GREY, alpha=0.25, label=f"within {100.0 * WITHIN:.0f} %")
        axis.axvline(1.0, color=GREY, lw=0.8)
        axis.plot(fits / predicted, places, "o", color=BLUE, ms=5, label="mean interval of the fits")
        axis.plot(values / predicted, places, "x", color=VERMILION, ms=5, label="1.96 deviations of the values")
        axis.set_yticks(places, labels)
        axis.invert_yaxis()
        axis.set_xlim(0.5, max(1.8, 1.1 * float(np.max([fits / predicted, values / predicted]))))
        axis.set_xlabel("achieved over predicted")
        axis.legend(loc="lower right", fontsize=7)
    return figure


def _short(name: str) -> str:
    """A parameter without the law, which is named anyway."""
    return name.rpartition(".")[2] if name.startswith("friction.") else name


def main() -> int:
    options = parsed(repeated(__doc__, LAWS, CHOSEN, 50))
    promises = parallel(options, "plans", partial(promised, duration=options.duration), options.laws)
    tasks = [(promise, seed) for promise in promises for seed in range(options.repetitions)]
    found = iter(parallel(options, "fits", fitted, tasks))
    table = [row for promise in promises for row in rows(promise, list(islice(found, options.repetitions)))]
    write_csv(options.output / "plans.csv", COLUMNS, table)
    save(drawn(table), options.output / "plans.png")
    for row in table:
        print(*row)
    return 0


if __name__ == "__main__":
    sys.exit(main())

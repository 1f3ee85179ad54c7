"""Coverage of the 95 % intervals of a fit.

Rigs that are integrated independently of this library (synthetic_rig.py), seen by sensors with noise and 12 bits, are
fitted again and again with other noise. For every law and parameter the number of repetitions is counted in which the
true value lies within its interval; with --posterior, within the middle 95 % of draws from the posterior.

Usage: python docs/studies/identification_coverage.py [--laws Stribeck ...] [--repetitions 100] [--duration 3]
       [--workers N] [--posterior]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np
import pneumatic_servo as ps
from common import parallel, parsed, repeated
from numpy.typing import NDArray
from pneumatic_servo.files import write_csv
from synthetic_rig import COMMON, LAWS, SUPPLY, measured, truth

COLUMNS = ["law", "parameter", "true", "repetitions", "covered", "mean error (%)", "half interval (%)"]

Array = NDArray[np.float64]


def fitted(
    seen: dict[str, Array], law: str, start: dict[str, float], workers: int | None = None, *, posterior: bool = False
) -> ps.Fit:
    """A fit of everything that is unknown; it starts at given values, since coverage is no matter of the start."""
    free = [f"{name}={value}" for name, value in start.items()]
    known: dict[str, ps.Value] = {"supplyPressure": SUPPLY}
    return ps.fit(seen, experiment="rig", law=law, fit=free, settings=known, starts=0, workers=workers,
                  posterior=posterior, progress=False)  # fmt: skip


def estimates(task: tuple[str, dict[str, Array], int], *, posterior: bool = False) -> list[ps.Estimate]:
    """Estimates of a repetition, in the order of the true values; the repetitions share the cores."""
    law, true, seed = task
    found = fitted(measured(true, seed), law, {**LAWS[law], **COMMON}, workers=1, posterior=posterior)
    if found.posterior is None:
        return list(found.parameters.values())
    return [
        replace(one, low=low, high=high)
        for name, one in found.parameters.items()
        for low, high in [found.posterior.interval(name)]
    ]


def rows(law: str, found: Sequence[Sequence[ps.Estimate]]) -> list[tuple[object, ...]]:
    """The table of a law."""
    table: list[tuple[object, ...]] = []
    for (name, true), repetitions in zip({**LAWS[law], **COMMON}.items(), zip(*found, strict=True), strict=True):
        covered = sum(one.low <= true <= one.high for one in repetitions)
        errors = [abs(one.value / true - 1.0) for one in repetitions]
        halves = [0.5 * (one.high - one.low) / true for one in repetitions]
        percents = (f"{100 * np.mean(values):.3f}" for values in (errors, halves))
        table.append((law, name, true, len(repetitions), covered, *percents))
    return table


def main() -> int:
    parser = repeated(__doc__, LAWS, LAWS, 100)
    parser.add_argument("--posterior", action="store_true", help="count draws from the posterior; needs emcee")
    options = parsed(parser)
    truths = parallel(options, "rigs", partial(truth, duration=options.duration), options.laws)
    tasks = [(law, true, seed) for law, true in zip(options.laws, truths, strict=True)
             for seed in range(options.repetitions)]  # fmt: skip
    found = iter(parallel(options, "fits", partial(estimates, posterior=options.posterior), tasks))
    table = [row for law in options.laws for row in rows(law, list(islice(found, options.repetitions)))]
    write_csv(options.output / ("posterior.csv" if options.posterior else "coverage.csv"), COLUMNS, table)
    for row in table:
        print(*row)
    return 0


if __name__ == "__main__":
    sys.exit(main())

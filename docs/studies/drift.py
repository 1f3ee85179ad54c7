"""Friction that falls while a machine runs in, and grows while it rests.

One run of the cylinder over a hundred cycles, in which static and Coulomb friction fall by a fifth (the parameters of a
law are tunable). `fit_series` identifies the drift from short records of position and pressures with noise. Then
break-away after rests of seconds to days, under the laws that know how long a contact has rested.

Leaves a figure and tables (CSV).

Break-away of rubber rings in air grew by more than 50 % in five days (An experiment on the dwell time effect of rubber
seal O-rings: friction force in intermittent reciprocating motion; FPM, silicone and NBR on stainless steel). Of a ring
of 70 Shore A it is at most three times the running friction (Parker, Friction estimation). The parameters here keep to
both.

Usage: python docs/studies/drift.py [--small]
"""

from __future__ import annotations

import argparse
import sys
import warnings

import numpy as np
import pneumatic_servo as ps
from common import arguments, parallel, plt, save
from numpy.typing import NDArray
from pneumatic_servo import figures
from pneumatic_servo.files import write_csv

Array = NDArray[np.float64]

STATIC, COULOMB = "friction.stribeck.Fs", "friction.stribeck.Fc"
NEW = {STATIC: 13.75, COULOMB: 10.375}
"""Friction in N of the new machine; a fifth less is left, as of the defaults."""
FALL, CYCLES = 0.2, 30.0
"""Share that is lost, with the number of cycles as its constant."""
FREQUENCY, SWING, GAIN = 1.0, 0.08, 20.0
"""Of the reference in Hz and m about the middle of the stroke, and of the loop in V/m."""
STEP = 1e-3
NOISE = {"position": 10e-6, "chamberA.pressure": 500.0, "chamberB.pressure": 500.0}
"""Standard deviations in m and Pa."""

DAY = 86_400.0
REST = 1000.0
"""Longest step in s of a rest."""
RUNNING = 8.3
"""Coulomb friction of the defaults in N."""
RESTED = {
    "Stribeck": {"friction.stribeck.Fs": 11.0, "friction.stribeck.FsInf": 18.0, "friction.stribeck.gamma": 0.5 * DAY},
    "Armstrong": {"friction.armstrong.FsInf": 9.7, "friction.armstrong.gamma": 600.0},
    "RevisedLuGre": {"friction.revisedLuGre.Fs": 18.0, "friction.revisedLuGre.tauH0": 0.5 * DAY},
    "CoulombStiction": {"friction.coulombStiction.Fs": 11.0},
}
"""Laws with a memory of the rest, and one without. Half a day brings half of the growth, or two thirds of a film; the
law of Armstrong, whose lag asks for steps of milliseconds, ages in minutes."""
LONGEST = {"Armstrong": 3600.0}
"""Longest rest in s."""
COLORS = (figures.BLUE, figures.GREEN, figures.VERMILION, figures.GREY)


def friction(cycle: int) -> dict[str, float]:
    """Return the true friction in N during a cycle, the first of which is 0."""
    left = 1.0 - FALL * (1.0 - np.exp(-cycle / CYCLES)) / (1.0 - np.exp(-100.0 / CYCLES))
    return {name: value * left for name, value in NEW.items()}


def run_in(starts: list[int], length: int) -> dict[str, dict[str, Array]]:
    """Return records of a number of cycles that begin at some cycles of one run, with noise."""
    plant = ps.Model().start(friction(0))
    names = ["time", "valveVoltage", *NOISE]
    rng = np.random.default_rng(1)
    records: dict[str, dict[str, Array]] = {}
    steps = round(1.0 / FREQUENCY / STEP)
    rows = []
    for cycle in range(starts[-1] + length):
        for name, value in friction(cycle).items():
            plant[name] = value
        for step in range(steps):
            reference = 0.25 + SWING * np.sin(2.0 * np.pi * step / steps)
            plant["valveVoltage"] = 5.0 + GAIN * (reference - plant["position"])
            if any(start <= cycle < start + length for start in starts):
                rows.append([plant.time, *plant.get(names[1:])])
            plant.step(STEP)
        if cycle + 1 - length in starts:
            record = dict(zip(names, np.array(rows).T, strict=True))
            record["time"] = record["time"] - record["time"][0]
            for name, deviation in NOISE.items():
                record[name] = record[name] + deviation * rng.standard_normal(len(rows))
            records[f"cycle {cycle + 1 - length}"] = record
            rows = []
    return records


def identified(records: dict[str, dict[str, Array]]) -> ps.Series:
    return ps.fit_series(
        records,
        experiment="mechanical",
        law="Stribeck",
        changing=[STATIC, COULOMB],
        shared=["friction.stribeck.vs", "friction.stribeck.sigma2"],
        starts=0,
        progress=False,
    )


def break_away(task: tuple[str, float]) -> float:
    """Return the largest friction in N when the mass is pulled by a spring after a rest in s; it slid before."""
    law, rest = task
    # Half a day is asked whether it is meant in milliseconds.
    warnings.simplefilter("ignore", ps.PlantWarning)
    bench = ps.Model("FrictionBench").start({
        "friction.law": law, **RESTED[law], "spring.stiffness": 5e3, "spring.damping": 50.0, "driveVelocity": 0.1
    })  # fmt: skip
    bench.step(3.0)
    bench["driveVelocity"] = 0.0
    for part in np.diff(np.append(np.arange(0.0, rest, REST), rest)):
        bench.step(float(part))
    bench["driveVelocity"] = 0.01
    most = 0.0
    for _ in range(1000):
        bench.step(1e-3)
        most = max(most, bench["frictionForce"])
    return most


def draw(
    found: ps.Series, starts: list[int], length: int, rows: list[tuple[str, float, float]], options: argparse.Namespace
) -> None:
    with plt.rc_context(figures.STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
        cycles = np.arange(starts[-1] + 1)
        middles = [start + 0.5 * (length - 1) for start in starts]
        for (name, label), color in zip(((STATIC, "static"), (COULOMB, "Coulomb")), COLORS, strict=False):
            left.plot(cycles, [friction(int(cycle))[name] for cycle in cycles], color=figures.GREY)
            own = found.changing[name]
            spans = np.array([(one.value - one.low, one.high - one.value) for one in own]).T
            left.errorbar(middles, [one.value for one in own], spans, fmt="o", color=color, label=label, ms=4)
        left.set(title="running in", xlabel="cycle", ylabel="friction (N)", ylim=(0.0, 16.0))
        left.legend()
        for law, color in zip(RESTED, COLORS, strict=True):
            own = np.array([row[1:] for row in rows if row[0] == law])
            right.semilogx(*own.T, ".-", color=color, label=law)
        right.axhline(3.0 * RUNNING, color=figures.GREY, linestyle="dotted")
        right.text(1.0, 3.0 * RUNNING - 0.3, "three times the running friction", va="top", fontsize=8)
        right.set(title="break-away after a rest", xlabel="rest (s)", ylabel="friction (N)", ylim=(0.0, 27.0))
        right.legend(loc="lower left")
        save(figure, options.output / "Drift.png")


def main() -> int:
    options = arguments(__doc__ or "")
    starts = [0, 30] if options.small else [0, 5, 10, 20, 40, 60, 97]
    length = 1 if options.small else 3
    found = identified(run_in(starts, length))
    print(found)
    found.to_csv(options.output / "Drift.csv")
    write_csv(options.output / "Drift_true.csv", ["record", STATIC, COULOMB], (
        (f"cycle {start}", *np.mean([list(friction(start + one).values()) for one in range(length)], axis=0))
        for start in starts
    ))  # fmt: skip
    rests = np.geomspace(1.0, 600.0 if options.small else 5.0 * DAY, 3 if options.small else 13)
    tasks = [(law, float(rest)) for law in RESTED for rest in rests if rest <= LONGEST.get(law, rest)]
    # The longest first, for a pool that is busy to its end.
    tasks.sort(key=lambda task: -task[1])
    peaks = dict(zip(tasks, parallel(options, "rests", break_away, tasks), strict=True))
    rows = [(law, rest, peaks[law, rest]) for law, rest in sorted(peaks)]
    write_csv(options.output / "Drift_rests.csv", ["law", "rest (s)", "break-away (N)"], rows)
    draw(found, starts, length, rows, options)
    print(f"figure and tables: {options.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

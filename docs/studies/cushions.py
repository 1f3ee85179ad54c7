"""End cushions: what their needle does, swept from closed to open for three loads.

A cylinder of 32 mm drives a load against an end of its stroke, with cushions of 20 mm and flow controls at its ports.
Leaves a figure and a table (CSV) with the speed of the blow on the cover, the bounce, which is the longest way back
before it, the rebound from the cover, the reversals before the cover, and the time until the load rests at the end.

Makers say that a needle has one ideal setting for a load and a pressure, and that with a needle that is closed too far
the piston changes its direction two or three times (All about cylinder cushioning, Hydraulics & Pneumatics, 2006).

Usage: python docs/studies/cushions.py [--small]
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass

import numpy as np
import pneumatic_servo as ps
from common import arguments, parallel, plt, save
from numpy.typing import NDArray
from pneumatic_servo import figures
from pneumatic_servo.files import write_csv

Array = NDArray[np.float64]

BORE, STROKE, LENGTH = 32.0, 200.0, 20.0
"""In mm."""
QN, SUPPLY = 200.0, 6.0
"""Of the valve in l/min (ANR); in bar above ambient."""
THROTTLE = 0.4
"""Of the flow controls in dm3/(s.bar)."""
STOP, STEP = 1.5, 2e-4
"""In s."""
NEAR, SLOW = 1e-4, 1e-3
"""Distance in m from the end, and speed in m/s, below which the load rests; shorter ways back are no bounce."""

MASSES = (5.0, 10.0, 20.0)
"""In kg."""
COLORS = (figures.GREEN, figures.BLUE, figures.VERMILION)
SHOWN = 20.0
"""Load in kg whose courses are drawn."""


@dataclass(frozen=True)
class Case:
    """A load in kg, and the conductance of the needle in dm3/(s.bar)."""

    mass: float
    needle: float


@dataclass(frozen=True)
class Arrival:
    """The end of a stroke."""

    case: Case
    entry: float
    """Speed in m/s at which the piston enters the cushion."""
    blow: float
    """Speed in m/s at which it first meets the cover, 0 if it does not."""
    bounce: float
    """Longest way back in m before it meets the cover."""
    rebound: float
    """Longest way back in m from the cover."""
    reversals: int
    """Changes of the direction of motion before it meets the cover."""
    time: float
    """In s from the entry until the load rests; not a number, if that is later than the run."""
    course: Array
    """Rows of time in s from the entry and distance to the end in m."""


def arrive(case: Case) -> Arrival:
    sheet = ps.DataSheet(
        bore=BORE, rod=12, stroke=STROKE, mass=case.mass, qn=QN, supply=SUPPLY, min_pressure=0.3,
        cushion=(LENGTH, case.needle),
    )  # fmt: skip
    settings: dict[str, ps.Value] = {
        **sheet.settings,
        **dict.fromkeys(("throttleA.C", "throttleB.C"), THROTTLE * 1e-8),
        "position0": 0.0,
        "chamberB.pressure0": sheet.settings["supplyPressure"],
    }
    run = ps.Model().simulate(settings, inputs={"valveVoltage": 10.0}, stop=STOP, step=STEP)
    return measured(case, run["time"], run["position"], run["velocity"])


def measured(case: Case, time: Array, position: Array, velocity: Array) -> Arrival:
    end = STROKE * 1e-3
    first = int(np.argmax(position > end - LENGTH * 1e-3))
    time, left, velocity = time[first:] - time[first], end - position[first:], velocity[first:]
    meets = np.flatnonzero(left <= 0.0)
    hit = int(meets[0]) if len(meets) else len(left)
    turns, extreme, heading = 0, left[0], -1.0
    for here in left[:hit]:
        if (here - extreme) * heading > 0.0:
            extreme = here
        elif abs(here - extreme) > NEAR:
            turns, extreme, heading = turns + 1, here, -heading
    bounces = left - np.minimum.accumulate(left)
    moving = np.flatnonzero((left > NEAR) | (np.abs(velocity) > SLOW))
    return Arrival(
        case=case,
        entry=velocity[0],
        blow=velocity[hit - 1] if len(meets) else 0.0,
        bounce=float(bounces[:hit].max()),
        rebound=float(left[hit:].max(initial=0.0)),
        reversals=turns,
        time=float(time[moving[-1] + 1]) if moving[-1] + 1 < len(time) else math.nan,
        course=np.column_stack([time, left]),
    )


def ideal(arrivals: list[Arrival]) -> Arrival:
    """The softest blow of those that never turn back before the cover."""
    return min((one for one in arrivals if one.bounce < NEAR), key=lambda one: one.blow)


def draw(swept: dict[float, list[Arrival]], shown: list[tuple[str, Arrival]], options: argparse.Namespace) -> None:
    with plt.rc_context(figures.STYLE):
        figure, axes = plt.subplots(2, 2, figsize=(9, 6), layout="constrained")
        (courses, blows), (bounces, times) = axes
        for (label, one), color in zip(shown, COLORS, strict=True):
            text = f"{label}: {one.case.needle:.2g} dm³/(s·bar)"
            courses.plot(1e3 * one.course[:, 0], 1e3 * one.course[:, 1], color=color, label=text)
        title = f"{SHOWN:g} kg enter at {shown[0][1].entry:.2f} m/s"
        courses.set(title=title, xlabel="time (ms)", ylabel="distance to the end (mm)", xlim=(0.0, 300.0))
        courses.legend()
        for (mass, arrivals), color in zip(swept.items(), COLORS, strict=True):
            needles = [one.case.needle for one in arrivals]
            label = f"{mass:g} kg, {arrivals[0].entry:.2f} m/s"
            blows.semilogx(needles, [one.blow for one in arrivals], color=color, label=label)
            best = ideal(arrivals)
            bounces.semilogx(needles, [1e3 * one.bounce for one in arrivals], color=color)
            times.semilogx(needles, [1e3 * one.time for one in arrivals], color=color)
            for axis, value in ((blows, best.blow), (bounces, 0.0), (times, 1e3 * best.time)):
                axis.plot(best.case.needle, value, "o", color=color)
        blows.set(title="blow on the cover", ylabel="speed (m/s)")
        bounces.set(title="bounce before the cover", ylabel="longest way back (mm)", xlabel="needle (dm³/(s·bar))")
        times.set(title="at rest after", ylabel="time from the entry (ms)", xlabel="needle (dm³/(s·bar))")
        times.set_ylim(0.0, 600.0)
        blows.legend()
        save(figure, options.output / "Cushions.png")


def main() -> int:
    options = arguments(__doc__ or "")
    needles = np.geomspace(0.01, 1.0, 9 if options.small else 81)
    cases = [Case(mass, float(needle)) for mass in MASSES for needle in needles]
    arrivals = parallel(options, "needles", arrive, cases)
    swept = {mass: [one for one in arrivals if one.case.mass == mass] for mass in MASSES}
    area = math.pi / 4.0 * (BORE**2 - 12.0**2) * 1e-6
    for mass, own in swept.items():
        best = ideal(own)
        share = best.case.needle * 1e-8 / (area * best.entry / 2e5)
        print(
            f"{mass:4} kg, entry {best.entry:.2f} m/s: best needle {best.case.needle:.3f} dm3/(s.bar), "
            f"{share:.2f} of area*speed/(2*1 bar); at rest after {1e3 * best.time:.0f} ms, blow {best.blow:.3f} m/s"
        )
    own = swept[SHOWN]
    best = ideal(own)
    closed = min(own, key=lambda one: abs(one.case.needle - best.case.needle / 4.0))
    draw(swept, [("too far open", own[-1]), ("best", best), ("too far closed", closed)], options)
    head = [
        "mass (kg)",
        "needle (dm3/(s.bar))",
        "entry (m/s)",
        "blow (m/s)",
        "bounce (mm)",
        "rebound (mm)",
        "reversals",
        "at rest (s)",
    ]
    write_csv(options.output / "Cushions.csv", head, (
        (one.case.mass, f"{one.case.needle:.4g}", f"{one.entry:.4f}", f"{one.blow:.4f}", f"{1e3 * one.bounce:.3f}",
         f"{1e3 * one.rebound:.3f}",
         one.reversals, "" if math.isnan(one.time) else f"{one.time:.4f}")
        for one in arrivals
    ))  # fmt: skip
    print(f"figure and table: {options.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Every friction law on the crane festoon: what it costs, and what it does where friction matters.

Leaves a table (CSV and Markdown) and a figure. Per law:

- the default experiment (pull, stop, return): wall time, solver steps, events, changes of sign of the friction forces;
- creep at rest: how far a trolley gives way within a minute under a taut rope with 8 N, below the break-away force;
- break-away: how far a pulse of 0.1 s moves a trolley;
- slow towing through the elastic rope: number of slips within 20 s.

Usage: python docs/studies/festoon.py [--small]
"""

from __future__ import annotations

import csv
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
from common import Plant, arguments, parallel, plt, save
from pneumatic_servo import figures

PULSES = (5.0, 10.0, 12.0, 20.0)
"""Strengths in N; the break-away force of most laws is 11 N."""

PULSE_TIME = 0.1
SLOW = {"trolleys": 1, "spacing0": 0.999, "rope.damping": 0.0, "craneVelocity": 2e-3}
TAUT = {"trolleys": 1, "spacing0": 1.0, "craneVelocity": 2e-3}
TAUT_TIME = 2.0
"""Time in s in which the rope is stretched by 4 mm: 8 N."""

LAW = "friction.law"
MODEL = ps.Model("Festoon")

SMALL = ["None", "Stribeck", "StribeckRegularised", "LuGre"]


@dataclass
class Record:
    """Results of a law. Lengths in m."""

    law: str
    seconds: float
    steps: int
    rejected: int
    events: int
    signs: int
    creep: float
    moved: list[float]
    slips: int
    towing: np.ndarray
    """Rows of time and position of the slowly towed trolley."""


def study(law: str) -> Record:
    seconds, counters, signs = default_experiment(law)
    towing = towed(law)
    return Record(law, seconds, *counters, signs, creep(law), [moved(law, pulse) for pulse in PULSES], *towing)


def default_experiment(law: str) -> tuple[float, list[int], int]:
    """Wall time in s, steps, rejected steps and events, and changes of sign of the friction forces."""
    plant = Plant("Festoon", {LAW: law})
    step = MODEL.step
    forces = [f"trolley[{number}].frictionForce" for number in (1, 2, 3)]
    begin, seconds, signs = 0.0, 0.0, []
    for index in range(round(MODEL.stop / step)):
        plant.set({"craneVelocity": crane_velocity(index * step)})
        begin = time.perf_counter()
        plant.advance((index + 1) * step)
        seconds += time.perf_counter() - begin
        # Forces below 1 N, of a load that swings out, do not count.
        signs.append(np.sign(np.trunc(plant.get(forces))))
    counters = plant.get([f"solver.{name}" for name in ("steps", "rejectedSteps", "events")])
    return seconds, [int(count) for count in counters], changes(np.array(signs))


def crane_velocity(t: float) -> float:
    """In m/s: the crane trolley pulls for 10 s, rests, and returns."""
    return 0.25 * ((t < 10.0) - float(15.0 <= t < 25.0))


def changes(signs: np.ndarray) -> int:
    """Number of changes of sign, zeros left out."""
    total = 0
    for column in signs.T:
        own = column[column != 0.0]
        total += int(np.count_nonzero(np.diff(own)))
    return total


def creep(law: str) -> float:
    plant = Plant("Festoon", {LAW: law, **TAUT})
    plant.advance(TAUT_TIME)
    plant.set({"craneVelocity": 0.0})
    [before] = plant.get(["trolley[1].position"])
    plant.advance(TAUT_TIME + 60.0)
    return plant.get(["trolley[1].position"])[0] - before


def moved(law: str, pulse: float) -> float:
    plant = Plant("Festoon", {LAW: law, "trolleys": 1, "load.mass": 0.01, "pulseForce": pulse})
    [before] = plant.get(["trolley[1].position"])
    plant.advance(PULSE_TIME)
    plant.set({"pulseForce": 0.0})
    plant.advance(1.0)
    return plant.get(["trolley[1].position"])[0] - before


def towed(law: str) -> tuple[int, np.ndarray]:
    """Number of slips in 20 s of slow towing: times at which the trolley passes the speed of the crane."""
    plant = Plant("Festoon", {LAW: law, **SLOW})
    rows = np.empty((2000, 3))
    for index in range(len(rows)):
        plant.advance((index + 1) * 0.01)
        rows[index] = [plant.time, *plant.get(["trolley[1].position", "trolley[1].velocity"])]
    fast = rows[:, 2] > 1.5 * SLOW["craneVelocity"]
    return int(np.count_nonzero(fast[1:] & ~fast[:-1])), rows[:, :2]


def main() -> int:
    options = arguments(__doc__ or "")
    laws = SMALL if options.small else list(MODEL.parameters[LAW].items)
    records = parallel(options, "laws", study, laws)
    write(records, options.output / "Festoon")
    draw(records, options.output / "Festoon_laws.png")
    print(f"table and figure: {options.output}")
    return 0


def write(records: list[Record], file: Path) -> None:
    header = ["law", "time (s)", "steps", "rejected", "events", "sign changes", "creep (um/min)"]
    header += [f"moved by {pulse:g} N (mm)" for pulse in PULSES] + ["slips"]
    rows = [
        [r.law, f"{r.seconds:.3f}", r.steps, r.rejected, r.events, r.signs, amount(1e6 * r.creep)]
        + [amount(1e3 * length) for length in r.moved]
        + [r.slips]
        for r in records
    ]
    with file.with_suffix(".csv").open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerows([header, *rows])
    lines = [header, ["---"] + ["--:"] * (len(header) - 1), *rows]
    text = "".join("| " + " | ".join(map(str, line)) + " |\n" for line in lines)
    file.with_suffix(".md").write_text(text, encoding="utf-8")
    print(text, end="")


def amount(value: float) -> str:
    """Three digits; 0 only for exactly 0."""
    return "0" if value == 0.0 else f"{value:.3g}"


def draw(records: list[Record], file: Path) -> None:
    columns = 6
    rows = -(-len(records) // columns)
    with plt.rc_context(figures.STYLE):
        figure, grid = plt.subplots(
            rows, columns, figsize=(13, 1.9 * rows), sharex=True, sharey=True, squeeze=False, layout="constrained"
        )
        for axis, record in zip(grid.flat, records, strict=False):
            times, positions = record.towing.T
            axis.plot(times, 1e3 * (positions + SLOW["spacing0"]), color=figures.BLUE)
            axis.set_title(f"{record.law}: {record.slips} slips")
        for axis in list(grid.flat)[len(records) :]:
            axis.set_visible(False)
        figure.supxlabel("time (s)")
        figure.supylabel("position (mm)")
        figure.suptitle("a trolley towed slowly through its elastic rope", fontweight="bold")
        save(figure, file)


if __name__ == "__main__":
    sys.exit(main())

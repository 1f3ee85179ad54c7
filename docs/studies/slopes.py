"""Sensitivities of random runs, compared with differences of runs.

Each draw has a model, a friction law, an option, a course of the input, a start and a parameter; runs are made at a
tolerance of 1e-11, with more and with less of the parameter by several shares. Where the left, right and central
differences of a share agree, the sensitivities must be within a thousandth of their largest value. What is not is
printed, and a table of all is left in a folder.

Usage: python docs/studies/slopes.py [--draws 1000] [--seed 1] [--workers N] [--output FOLDER]
"""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import dataclass
from functools import partial

import numpy as np
import pneumatic_servo as ps
from common import parallel, parsed, parser
from numpy.typing import NDArray
from pneumatic_servo.files import write_csv

Array = NDArray[np.float64]
Settings = dict[str, ps.Value]

WRONG = 1e-3
"""Deviation from differences, relative to the largest of them, from which on sensitivities are wrong."""
CLOSE = 2e-4
"""The same of left and right differences from their mean, below which they agree."""
SHARES = (1e-4, 1e-5, 1e-6, 1e-7)
TIGHT: Settings = {"solver.relativeTolerance": 1e-11}
COLUMNS = ["number", "model", "law", "option", "course", "start", "parameter", "output", "verdict", "deviation",
           "largest", "time (s)", "sensitivity", "left", "right", "reason"]  # fmt: skip


@dataclass(frozen=True)
class System:
    """A model with what draws choose from."""

    stop: float
    step: float
    command: str
    """The input that moves it."""
    middle: float
    reach: float
    frequency: float
    options: tuple[Settings, ...]
    starts: tuple[Settings, ...]
    outputs: tuple[str, ...]


CYLINDER = System(
    0.3,
    1e-3,
    "valveVoltage",
    5.0,
    2.0,
    3.0,
    (
        {},
        {"thermal.model": "EnergyBalance"},
        {"valve.hysteresis": 0.0},
        {"actuation": "SwitchingValves"},
        {"actuation": "PressureRegulator"},
        {"hoseA.length": 1.0, "hoseB.length": 2.0},
        {"throttleA.C": 2e-9, "throttleB.C": 2e-9},
        {"cushion.length": 0.02},
        {"friction.direction.factor": 1.2},
        {"load.stiffness": 500.0},
        {"sensor.position.lag": 5e-3, "sensor.pressureA.sampleTime": 1.7e-3},
        {"supply.volume": 1e-3},
    ),
    ({}, {"velocity0": 0.3, "externalForce": -200.0}, {"position0": 0.45}),
    ("position", "velocity", "chamberA.pressure", "chamberA.massFlow", "frictionForce"),
)
SYSTEMS = {
    "PneumaticServoCylinder": CYLINDER,
    "DrivenSlider": System(
        0.42,
        7e-4,
        "externalForce",
        0.0,
        0.05,
        3.0,
        ({}, {"tray.velocityAmplitude": 0.2}, {"walk.stepsPerPeriod": 40}),
        ({}, {"relativeVelocity0": 0.05}),
        ("position", "velocity", "frictionForce", "walk.velocity"),
    ),
    "VibroImpact": System(
        0.4,
        1e-3,
        "externalForce",
        0.0,
        1.0,
        3.0,
        ({}, {"impact.gap": 1e-3}, {"excitation.amplitude": 12.0}),
        ({}, {"velocity0": 0.1}),
        ("position", "velocity", "internal.velocity", "frictionForce"),
    ),
    "FrictionBench": System(
        0.5,
        1e-3,
        "appliedForce",
        0.0,
        20.0,
        3.0,
        ({"bench.drive": "Free"}, {"bench.drive": "SpringPull"}),
        ({}, {"velocity0": 0.2}),
        ("position", "velocity", "frictionForce"),
    ),
}
# The cylinder has most options, and comes most often.
MODELS = ("PneumaticServoCylinder", "PneumaticServoCylinder", "DrivenSlider", "VibroImpact", "FrictionBench")
COURSES = ("sine", "steps", "ramp", "random")


@dataclass(frozen=True)
class Draw:
    """A run and the parameter that it is differentiated by."""

    number: int
    model: str
    law: str
    option: Settings
    course: str
    start: Settings
    parameter: str

    @property
    def settings(self) -> Settings:
        return {"friction.law": self.law, **self.option, **self.start, **TIGHT}

    def simulate(self, changes: Settings, by: tuple[str, ...] = ()) -> ps.Run:
        system = SYSTEMS[self.model]
        times = system.step * np.arange(round(system.stop / system.step))
        values = system.middle + system.reach * course(self.course, times, system.frequency, self.number)
        return ps.Model(self.model).simulate(
            {**self.settings, **changes},
            inputs={system.command: {"hold": (times, values)}},
            stop=system.stop,
            step=system.step,
            outputs=system.outputs,
            sensitivities=by,
        )


def course(form: str, times: Array, frequency: float, seed: int) -> Array:
    """An input within [-1, 1]."""
    if form == "sine":
        return np.sin(2.0 * np.pi * frequency * times)
    if form == "steps":
        return np.where(np.floor(4.0 * frequency * times) % 3 == 0, 0.9, -0.6)
    if form == "ramp":
        return 2.0 * ((frequency * times) % 1.0) - 1.0
    levels = np.random.default_rng(seed).uniform(-1.0, 1.0, 1 + int(10.0 * frequency * times[-1]))
    return levels[np.floor(10.0 * frequency * times).astype(int)]


def candidates(model: ps.Model, settings: Settings) -> list[str]:
    """Real parameters but those of laws that are not chosen, and of the solver."""
    law = settings["friction.law"]
    own = [
        name
        for name, it in model.parameters.items()
        if it.kind == "real" and not name.startswith("solver.") and (it.counts_for is None or it.counts_for[1] == law)
    ]
    of_law = [name for name in own if model.parameters[name].counts_for is not None]
    # Every other draw is by a parameter of the law.
    return own + of_law * max(1, len(own) // max(1, len(of_law)))


def drawn(number: int, seed: int) -> Draw:
    """The draw of a number."""
    rng = np.random.default_rng([seed, number])
    name = MODELS[rng.integers(len(MODELS))]
    model, system = ps.Model(name), SYSTEMS[name]
    laws = list(model.parameters["friction.law"].items)
    law = laws[rng.integers(len(laws))]
    option, start = (own[rng.integers(len(own))] for own in (system.options, system.starts))
    form = COURSES[rng.integers(len(COURSES))]
    names = candidates(model, {"friction.law": law, **option})
    return Draw(number, name, law, option, form, start, names[rng.integers(len(names))])


def table(draw: Draw, told: list[list[object]]) -> list[list[object]]:
    """Rows of the table of a draw: what was drawn, and what was found by each output."""
    options = (" ".join(f"{name}={value}" for name, value in own.items()) for own in (draw.option, draw.start))
    option, start = options
    own = [draw.number, draw.model, draw.law, option, draw.course, start, draw.parameter]
    return [[*own, *found] for found in told]


def differences(draw: Draw, base: ps.Run, value: float, share: float) -> dict[str, tuple[Array, Array]] | None:
    """Left and right differences by outputs; nothing where one of both values is illegal."""
    variable = ps.Model(draw.model).parameters[draw.parameter]
    by = share * (abs(value) or abs(variable.nominal or 1.0))
    sides = []
    for moved in (value - by, value + by):
        try:
            run = draw.simulate({draw.parameter: moved})
        except (ValueError, RuntimeError):
            return None
        sides.append({name: (run[name] - base[name]) / (moved - value) for name in SYSTEMS[draw.model].outputs})
    left, right = sides
    return {name: (left[name], right[name]) for name in left}


def compared(draw: Draw, output: str, found: Array, sides: list[tuple[Array, Array]], times: Array) -> list[object]:
    """The verdict on an output: the share of differences at which both sides agree best decides."""
    means = [0.5 * (left + right) for left, right in sides]
    largest = max(float(np.abs(mean).max()) for mean in means)
    if largest == 0.0 and not np.nan_to_num(found).any():
        return [output, "no effect", 0.0, 0.0, "", "", "", "", ""]
    apart = np.array([np.abs(right - left) for left, right in sides])
    best = apart.argmin(axis=0)
    rows = np.arange(len(times))
    mean, spread = np.array(means)[best, rows], apart[best, rows]
    # Differences of two shares must agree, too: one alone may lie within a single step of a sum that is rounded.
    others = np.sort(np.abs(np.array(means) - mean), axis=0)[1]
    decided = (np.maximum(spread, others) <= CLOSE * largest) & np.isfinite(found)
    if not decided.any():
        return [output, "undecided", "", largest, "", "", "", "", ""]
    deviation = np.where(decided, np.abs(found - mean), 0.0) / (largest or 1.0)
    row = int(deviation.argmax())
    left, right = (float(side[row]) for side in sides[best[row]])
    verdict = "wrong" if deviation[row] > WRONG else "right"
    return [output, verdict, float(deviation[row]), largest, float(times[row]), float(found[row]), left, right, ""]


def judged(number: int, seed: int) -> list[list[object]]:
    """The rows of the table of a draw."""
    draw = drawn(number, seed)
    outputs = SYSTEMS[draw.model].outputs
    try:
        base = draw.simulate({})
    except (ValueError, RuntimeError) as error:
        return table(draw, [["", "no run", "", "", "", "", "", "", str(error)]])
    try:
        run = draw.simulate({}, (draw.parameter,))
    except ValueError as error:
        return table(draw, [["", "refused", "", "", "", "", "", "", str(error)]])
    value = float(draw.settings.get(draw.parameter, ps.Model(draw.model).parameters[draw.parameter].default))
    sides = [found for share in SHARES if (found := differences(draw, base, value, share)) is not None]
    if len(sides) < 2:
        return table(draw, [["", "one-sided", "", "", "", "", "", "", ""]])
    told = []
    lost = run.sensitivities.lost.get(draw.parameter)
    for output in outputs:
        found = run.sensitivities.until_lost(output, draw.parameter)
        row = compared(draw, output, found, [by[output] for by in sides], run["time"])
        if row[1] != "wrong" and lost is not None:
            row[1], row[-1] = "refused", str(lost)
        told.append(row)
    return table(draw, told)


def main() -> int:
    options = parser(__doc__)
    options.add_argument("--draws", type=int, default=1000)
    options.add_argument("--seed", type=int, default=1)
    chosen = parsed(options)
    draws = parallel(chosen, "draws", partial(judged, seed=chosen.seed), range(chosen.draws))
    rows = [row for draw in draws for row in draw]
    file = chosen.output / "slopes.csv"
    write_csv(file, COLUMNS, rows)
    verdict, deviation = COLUMNS.index("verdict"), COLUMNS.index("deviation")
    for row in sorted((row for row in rows if row[verdict] == "wrong"), key=lambda row: -row[deviation]):
        print("; ".join(f"{name}: {cell}" for name, cell in zip(COLUMNS, row, strict=True) if cell != ""))
    counts = Counter(row[verdict] for row in rows)
    print(", ".join(f"{count} {name}" for name, count in counts.most_common()), f"of {len(rows)}: {file}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

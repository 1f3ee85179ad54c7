"""Experiments with signals whose velocities, accelerations and forces are known in closed form.

Parabolas and straight lines pass the smoothing as they are.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo import _native
from pneumatic_servo.identification.experiments import EXPERIMENTS, Beginning, Experiment, Options, Window
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.signals import Units

Array = NDArray[np.float64]

TIME = np.arange(501) * 2e-3
GRAVITY = 9.80665


def make(
    name: str, signals: dict[str, Array], settings: dict[str, Any], options: Options | None = None,
    units: Units | None = None, time: Array = TIME,
) -> tuple[Experiment, Window]:  # fmt: skip
    """An experiment, and the window of a whole record."""
    experiment = EXPERIMENTS[name]("Coulomb", settings, options or Options(), units or Units())
    experiment.use(["time", *signals])
    uncut = experiment.with_options(window=10.0)
    [window] = uncut.windows(Record("a", time, 0.0, signals))
    experiment.notes += uncut.notes
    return experiment, window


def guess(experiment: Experiment, windows: list[Window], values: dict[str, float]) -> dict[str, float]:
    """Starts of parameters of the machine that the data tell."""
    return experiment.native.guess([window.native for window in windows], values)


def problem(experiment: Experiment, window: Window, values: dict[str, float] | None = None) -> _native.LeastSquares:
    """A window with all parameters fixed, whose runs are exact."""
    choices = {"step": 1e-3, "scale": 1.0, "exactness": 1e-3, "most": None, "workers": 1, "is_exact": False}
    segment = (window.native, dict(window.begin.values), [], 0)
    sensors = [(1.0, 0.0, False)] * len(experiment.compared)
    return _native.LeastSquares([], experiment.native, [segment], sensors, values or {}, [], choices)


def inputs_of(experiment: Experiment, window: Window, values: dict[str, float] | None = None) -> dict[str, Array]:
    """Inputs of the run of a window at its communication points."""
    return problem(experiment, window, values).given(0, np.array([]))[1]


def start(experiment: Experiment, window: Window, values: dict[str, float] | None = None) -> dict[str, Any]:
    """Settings of the run of a window, without its measured start values."""
    settings = problem(experiment, replace(window, begin=Beginning()), values).given(0, np.array([]))[0]
    return experiment.typed(settings)


def readings(
    experiment: Experiment, window: Window, output: str, values: dict[str, float] | None = None
) -> tuple[Array, dict[str, Array]]:
    """A variable of the run of a window, and what the sensors read of it."""
    of = problem(experiment, window, values)
    [[truth]] = of.recorded(np.array([]), [output])
    [differences] = of.differences(np.array([]))
    return truth, {name: window.record.signals[name] - values for name, values in differences.items()}


def path(experiment: Experiment, window: Window) -> Array:
    """The way that a motion is prescribed, of which a run is given the ends of its steps."""
    return np.append(0.0, inputs_of(experiment, window)["prescribedPosition"][:-1])


def close(found: object, expected: object, what: str) -> None:
    assert_close(found, expected, within=1e-9, rel=1e-12, what=what, why="slopes are differences")  # type: ignore[arg-type]


POSITION, VELOCITY = 0.1 + 0.2 * TIME + 0.3 * TIME**2, 0.2 + 0.6 * TIME
FORCE, LOAD = 40.0 + 5.0 * TIME, 60.0 - 70.0 * TIME
SLOPE = {"mass": 2.0, "incline": 0.1, "gain.force": 1.5, "offset.force": 0.5, "gain.position": 2.0,
         "offset.position": 0.03, "spring": 40.0, "springRest": 0.05}  # fmt: skip


@pytest.mark.parametrize("inputs", ["held", "lines"])
def test_force_on_a_slope_with_a_spring(inputs: str) -> None:
    """The sensor of the position reads half the way."""
    signals = {"position": POSITION, "force": FORCE, "normalForce": LOAD}
    experiment, window = make("force", signals, SLOPE, Options(rated=50.0, inputs=inputs))
    weight = 2.0 * GRAVITY * np.sin(0.1)
    applied = 1.5 * (FORCE - 0.5) - weight - 40.0 * (2.0 * (POSITION - 0.03) - 0.05)
    # A load that pulls is none.
    level = np.maximum(LOAD / 50.0, 0.0)
    speed, friction, seen = experiment.forces(window, {}) or ()
    close(speed, 2.0 * VELOCITY, "speed")
    close(friction, applied - 2.0 * 1.2, "friction")
    close(seen, level, "level")
    # Without what the settings say it is what is fitted.
    fitted, plain = make("force", signals, {}, Options(rated=50.0))
    close((fitted.forces(plain, SLOPE) or ())[1], applied - 2.0 * 0.6, "friction of fitted values")
    given = inputs_of(experiment, window)
    assert given.keys() == {"appliedForce", "friction.level"}
    close(given["appliedForce"], applied, "applied force")
    assert experiment.native.has_lines is (inputs == "lines")
    close(given["friction.level"], level, "level")
    assert start(experiment, window, {"friction.coulomb.Fc": 3.0}) == {
        "mass": 2.0, "friction.coulomb.Fc": 3.0, "friction.law": "Coulomb", "bench.drive": "Free", "driveVelocity": 0.0,
    }  # fmt: skip
    assert window.begin.loose == ("position0", "velocity0")
    close([window.begin.values[name] for name in window.begin.loose], [2.0 * 0.07, 2.0 * 0.2], "begin")
    assert experiment.notes == ["a: the force is smoothed over 40 ms"] and np.all(window.used)


def test_lines_in_place_of_a_smooth_input_have_its_means() -> None:
    """Of a cubic over each step but the first and the last, where a neighbour is missing: exactly."""
    force = np.polynomial.Polynomial([5.0, 3.0, -40.0, 200.0])
    signals = {"position": POSITION, "force": force(TIME)}
    experiment, window = make("force", signals, {"mass": 2.0}, Options(inputs="smooth", smoothing=False))
    ends = inputs_of(experiment, window)["appliedForce"]
    means = np.diff(force.integ()(TIME)) / np.diff(TIME)
    close(0.5 * (ends[2:-1] + ends[1:-2]), means[1:-1], "means of the force")


def test_velocity_alone_begins_at_0_m() -> None:
    given = {"gain.velocity": -2.0, "offset.velocity": 0.1}
    experiment, window = make("force", {"velocity": VELOCITY, "force": FORCE}, {"mass": 2.0, **given})
    assert experiment.compared == ("velocity",) and window.begin.loose == ("velocity0",)
    assert window.begin.values["position0"] == 0.0
    close(window.begin.values["velocity0"], -2.0 * 0.1, "velocity")
    _, friction, level = experiment.forces(window, {}) or ()
    close(friction, FORCE - 2.0 * -2.0 * 0.6, "friction")
    assert np.all(level == 1.0) and not np.any(experiment.resting(window.record))


def course(mass: float, spring: float, offset: float, gain: float = 1.0) -> dict[str, Array]:
    """Signals of a motion that turns under dry and viscous friction, and of a sensor of the force."""
    velocity, position, load = -1.0 + 3.0 * TIME**2, 0.3 - TIME + TIME**3, 100.0 + 20.0 * TIME
    force = mass * 6.0 * TIME + 5.0 * (load / 50.0) * np.sign(velocity) + 3.0 * velocity + spring * position
    return {"velocity": velocity, "position": position, "force": force / gain + offset, "normalForce": load}


@pytest.mark.parametrize(
    ("gain", "free", "expected"),
    [
        (1.0, ["mass", "spring", "offset.force"], {"mass": 2.0, "spring": 8.0, "offset.force": 0.7, "gain.force": 1.0}),
        # Of a sensor that reads a current, 4 N for each ampere, where the mass is known.
        (4.0, ["gain.force", "spring", "offset.force"],
         {"mass": 2.0, "spring": 8.0, "offset.force": 0.7, "gain.force": 4.0}),
        # Without the mass its gain is what it began with.
        (8.0, ["gain.force", "mass", "spring"], {"mass": 0.5, "spring": 2.0, "gain.force": 2.0}),
    ],
)  # fmt: skip
def test_regression_tells_what_moves(gain: float, free: list[str], expected: dict[str, float]) -> None:
    experiment, window = make("force", course(2.0, 8.0, 0.7, gain), {"mass": 2.0}, Options(rated=50.0))
    found = guess(experiment, [window], dict.fromkeys(free, 2.0))
    assert found.keys() == expected.keys()
    # The ends of a cubic are no parabola.
    assert_close([found[name] for name in expected], list(expected.values()), rel=1e-4, what="found")
    # A sensor that reads half the way makes a spring seem half as stiff, unless its gain is known.
    signals = {**course(2.0, 8.0, 0.7, gain), "position": 0.5 * course(2.0, 8.0, 0.7)["position"]}
    experiment, window = make("force", signals, {"mass": 2.0, "gain.position": 2.0}, Options(rated=50.0))
    again = guess(experiment, [window], dict.fromkeys(free, 2.0))
    # Of a velocity that is measured the gain of the position is none.
    assert_close([again[name] for name in expected], list(expected.values()), rel=1e-4, what="found again")


def test_regression_tells_nothing_that_cannot_be() -> None:
    signals, free = course(2.0, 0.0, 0.7), dict.fromkeys(["mass", "spring", "offset.force"], 1.0)
    turned, window = make("force", {**signals, "force": -signals["force"]}, {}, Options(rated=50.0))
    assert guess(turned, [window], free).keys() <= {"offset.force", "spring"}
    for number, is_enough in ((9, False), (10, True)):
        experiment, window = make("force", signals, {}, Options(rated=50.0))
        assert bool(guess(experiment, [piece(window, 0, number)], free)) is is_enough


def piece(window: Window, first: int, last: int) -> Window:
    """A part of a window, which knows what is around it."""
    record = window.record.part(first, last)
    around = replace(window.around, begin=record.begin)
    driven = {name: values[first:last] for name, values in window.driven.items()}
    return replace(window, record=record, driven=driven, held=window.held[first:last], used=window.used[first:last],
                   around=around)  # fmt: skip


def test_seal_under_pressure() -> None:
    signals = {"position": POSITION, "force": FORCE, "pressure": 1e5 * TIME, "normalForce": LOAD}
    known = {"area": 1e-4, "friction.kappaA": 2e-6, "gain.pressure": 2.0, "offset.pressure": 3e4,
             "gain.position": -3.0, "offset.force": 1.0}  # fmt: skip
    experiment, window = make("motion", signals, known, Options(rated=50.0, play=0.0))
    way, pressure = -3.0 * (0.2 * TIME + 0.3 * TIME**2), 2.0 * (1e5 * TIME - 3e4)
    level = np.maximum(LOAD / 50.0 * (1.0 + 2e-6 * pressure), 0.0)
    assert (experiment.compared, experiment.driving) == (("force",), ("position", "pressure", "normalForce"))
    assert experiment.unknown == ("area",) and experiment.outputs == ["frictionForce"]
    given = inputs_of(experiment, window)
    assert given.keys() == {"prescribedPosition", "friction.level"}
    close(given["prescribedPosition"], np.append(way[1:], way[-1]), "position")
    close(given["friction.level"], level, "level")
    friction, read = readings(experiment, window, "frictionForce")
    assert read.keys() == {"force"} and np.ptp(friction) > 1.0
    close(read["force"], friction + 1e-4 * pressure + 1.0, "force")
    close(readings(experiment, window, "frictionForce", {"area": 0.0})[1]["force"], friction + 1.0, "friction")
    window = replace(window, held=np.arange(len(TIME)) >= 400)
    speed, found, seen = experiment.forces(window, {"offset.force": 1.0}) or ()
    # The first sample has no motion before it.
    inside = slice(1, 400)
    close(speed, -3.0 * VELOCITY[inside], "speed")
    close(found, (FORCE - 1.0 - 1e-4 * pressure)[inside], "friction")
    close(seen, level[inside], "level")
    fitted = {"area": 3e-4, "offset.force": 1.0}
    close((experiment.forces(window, fitted) or ())[1], (FORCE - 1.0 - 3e-4 * pressure)[inside], "fitted area")
    assert start(experiment, window, {"friction.coulomb.Fc": 3.0}) == {
        "friction.coulomb.Fc": 3.0, "friction.law": "Coulomb", "bench.drive": "PrescribedPosition",
        "driveVelocity": 0.0, "position0": 0.0,
    }  # fmt: skip


def test_force_without_a_pressure_is_friction() -> None:
    experiment, window = make("motion", {"position": POSITION, "force": FORCE}, {"area": 1e-4}, Options(play=0.0))
    assert experiment.unknown == () and experiment.driving == ("position",)
    friction, read = readings(experiment, window, "frictionForce")
    close(read["force"], friction, "force")
    assert np.array_equal((experiment.forces(window, {}) or ())[1], FORCE[1:])
    assert np.all((experiment.forces(window, {}) or ())[2] == 1.0)


def test_motion_by_its_velocity() -> None:
    known = {"gain.velocity": 2.0, "offset.velocity": 0.1}
    experiment, window = make("motion", {"velocity": VELOCITY, "frictionForce": FORCE}, known)
    way = 0.2 * TIME + 0.3 * TIME**2
    close(path(experiment, window), 2.0 * (way - 0.1 * TIME), "path")
    friction, read = readings(experiment, window, "frictionForce")
    close(read["frictionForce"], friction, "friction")
    assert experiment.unknown == () and experiment.notes == []
    assert set(experiment.beside) == {
        f"{what}.{signal}" for signal in ("frictionForce", "velocity") for what in ("gain", "offset", "delay")
    } | {"lag.frictionForce"}


@pytest.mark.parametrize("delay", [-0.1, 0.1])
def test_late_motion_goes_on_as_fast_beyond_its_record(delay: float) -> None:
    """At the ends as in the mean over five steps of 2 ms, where the speeds are 0.2 m/s and 0.8 m/s."""
    signals = {"position": POSITION, "force": FORCE}
    experiment, window = make("motion", signals, {"delay.position": delay}, Options(play=0.0))
    late = TIME + delay
    inside = np.clip(late, 0.0, 1.0)
    seen = 0.2 * inside + 0.3 * inside**2 + 0.203 * np.minimum(late, 0.0) + 0.797 * np.maximum(late - 1.0, 0.0)
    assert_close(path(experiment, window), seen - seen[0], within=5e-14, what="path")
    inner = path(experiment, piece(window, 300, 400))
    expected = 0.2 * (TIME[300:400] - 0.6) + 0.3 * ((TIME[300:400] + delay) ** 2 - (0.6 + delay) ** 2)
    assert_close(inner, expected, within=2e-15, what="path of a part")


def test_jitter_of_a_position_is_rest() -> None:
    """Of 5 um either way about a carriage that stands, then moves: the play is three times the noise of the sensor."""
    rng = np.random.default_rng(1)
    noise = 5e-6 * rng.uniform(-1.0, 1.0, len(TIME))
    signals = {"position": 0.1 * np.maximum(TIME - 0.5, 0.0) + noise, "frictionForce": FORCE}
    experiment, window = make("motion", signals, {})
    assert not np.any(window.used[TIME < 0.5]) and np.all(window.used[TIME > 0.51])
    [note] = experiment.notes
    play = float(note.removeprefix("a: the position is followed with a play of ").removesuffix(" um"))
    # The deviation of what is uniform; it is estimated as if it were normal.
    assert_close(play, 3.0 * 5.0 / np.sqrt(3.0), rel=0.2, what="play in um")
    still, rest = make("motion", signals, {}, Options(play=30e-6))
    assert still.notes == ["a: the position is followed with a play of 30 um"]
    assert not np.any(rest.used[TIME < 0.5])


GAS = {"position": POSITION, "velocity": VELOCITY, "chamberA.pressure": 5e5 - 1e5 * TIME,
       "chamberB.pressure": 2e5 + 5e4 * TIME, "valveVoltage": 5.0 + TIME, "supplyPressure": 6e5 + 1e4 * TIME,
       "externalForce": 3.0 + TIME}  # fmt: skip
MACHINE = {"cylinder.bore": 0.04, "cylinder.rod": 0.02, "ambientPressure": 1.1e5, "mass.moving": 3.0, "incline": 0.2,
           "wireForce": 7.0, "friction.kappaA": 1e-6, "friction.kappaB": -2e-6, "gain.chamberA.pressure": 1.1,
           "offset.externalForce": 0.5}  # fmt: skip
A = 1.1 * GAS["chamberA.pressure"]
B = GAS["chamberB.pressure"]
PUSH = np.pi * (0.02**2 * (A - B) + 0.01**2 * (B - 1.1e5))
"""Bores of 20 mm less a rod of 10 mm, each a radius."""
DEAD = 7.0 + 3.0 * GRAVITY * np.sin(0.2)
LEVEL = np.maximum(1.0 + 1e-6 * (A - 1.1e5) - 2e-6 * (B - 1.1e5), 0.0)


def bent(values: Array) -> Array:
    """Ends of lines with the means of a smooth curve."""
    bend = np.zeros_like(values)
    bend[1:-1] = np.diff(values, 2) / 12.0
    return values - bend


def mean(values: Array) -> Array:
    """Over each step, of which the last has no end."""
    return np.append(0.5 * (values[1:] + values[:-1]), values[-1])


def taken(*names: str) -> dict[str, Array]:
    return {name: GAS[name] for name in names}


def test_carriage_under_pressures() -> None:
    names = ("position", "chamberA.pressure", "chamberB.pressure", "externalForce")
    experiment, window = make("mechanical", taken(*names), MACHINE)
    assert experiment.driving == names[1:] and experiment.outputs == ["position"] == list(experiment.compared)
    assert experiment.native.length(2e-3) == 0.15 and experiment.notes == ["a: the pressures are smoothed over 40 ms"]
    given = inputs_of(experiment, window)
    assert given.keys() == {"appliedForce", "friction.level"}
    applied = PUSH - DEAD + TIME + 2.5
    close(given["appliedForce"], bent(applied), "force")
    assert experiment.native.has_lines
    close(given["friction.level"], LEVEL, "level")
    speed, friction, level = experiment.forces(window, {}) or ()
    close(speed, VELOCITY, "speed")
    close(friction, applied - 3.0 * 0.6, "friction")
    close(level, LEVEL, "level")
    settings = start(experiment, window, {"friction.coulomb.Fc": 3.0})
    assert settings == {
        "friction.coulomb.Fc": 3.0, "friction.law": "Coulomb", "bench.drive": "Free", "driveVelocity": 0.0, "mass": 3.0,
    }  # fmt: skip
    assert window.begin.loose == ("position0", "velocity0")
    close([window.begin.values[name] for name in window.begin.loose], [0.1, 0.2], "begin")
    alone, plain = make("mechanical", taken(*names[:3]), MACHINE)
    assert alone.driving == names[1:3]
    close(inputs_of(alone, plain)["appliedForce"], bent(PUSH - DEAD), "force without another")


@pytest.mark.parametrize("inputs", ["held", "lines"])
def test_whole_rig(inputs: str) -> None:
    experiment, window = make("rig", GAS, MACHINE, Options(inputs=inputs))
    assert experiment.compared == ("position", "velocity", "chamberA.pressure", "chamberB.pressure")
    assert experiment.driving == ("valveVoltage", "supplyPressure", "externalForce")
    given = inputs_of(experiment, window)
    assert set(given) == set(experiment.driving)
    for name, values in taken(*experiment.driving).items():
        truth = values - 0.5 * (name == "externalForce")
        close(given[name], truth, name)
    assert window.begin.loose == ("position0", "velocity0", "chamberA.pressure0", "chamberB.pressure0")
    # Pressures start as the line through the first five samples, of which the third is in the middle.
    begin = [0.1, 0.2, A[2], B[2]]
    close([window.begin.values[name] for name in window.begin.loose], begin, "begin")
    close((experiment.forces(window, {}) or ())[1], PUSH - DEAD + TIME + 2.5 - 3.0 * 0.6, "friction")
    # A measured velocity counts, not the slope of the position.
    close(make("rig", {**GAS, "velocity": 1.1 * VELOCITY}, {})[1].begin.values["velocity0"], 0.22, "measured velocity")
    some = make("rig", taken("valveVoltage", "position", "chamberB.pressure"), {})
    assert some[0].forces(some[1], {}) is None and "chamberA.pressure0" not in some[1].begin.values
    known = {name: value for name, value in MACHINE.items() if not name.startswith(("gain", "offset"))}
    assert start(experiment, window) == {**known, "friction.law": "Coulomb"}


def test_gas_alone_is_carried_along_the_measured_path() -> None:
    names = ("position", "valveVoltage", "chamberA.pressure", "chamberB.pressure", "supplyPressure")
    experiment, window = make("pneumatic", taken(*names), {**MACHINE, "gain.position": 2.0})
    assert experiment.compared == names[2:4] and experiment.driving == ("position", "valveVoltage", "supplyPressure")
    given = inputs_of(experiment, window)
    assert given.keys() == {"valveVoltage", "supplyPressure", "externalForce"}
    close(given["valveVoltage"], GAS["valveVoltage"], "voltage")
    # 10 t that are carried at 1.2 m/s2; at both ends half a step has no middle, and is left out.
    carried = 1e4 * 2.0 * 0.6 - mean(PUSH) + 7.0
    inner = slice(1, -2)
    assert_close(given["externalForce"][inner], carried[inner], within=1e-4, what="force")
    settings = start(experiment, window)
    close([settings.pop("position0"), settings.pop("velocity0")], [0.2, 2.0 * 0.2006], "begin")  # type: ignore[list-item]
    # A sensor that is 0.1 s late reads after 0.1 s where the carriage was at first.
    late = start(experiment, window, {"delay.position": 0.1})
    close([late["position0"], late["velocity0"]], [2.0 * 0.123, 2.0 * 0.26], "begin that is read late")
    known = {name: value for name, value in MACHINE.items() if not name.startswith(("gain", "offset"))}
    assert settings == {**known, "mass.moving": 1e4, "friction.law": "None", "incline": 0.0}
    assert window.begin.loose == ("chamberA.pressure0", "chamberB.pressure0")
    assert experiment.notes == ["a: the position is smoothed over 40 ms"] and experiment.forces(window, {}) is None


def test_sensor_reads_what_is_made_of_its_readings() -> None:
    """Gain, offset and lag: there and back."""
    known = {
        "gain.force": 3.0,
        "offset.force": -2.0,
        "lag.position": 0.05,
        "gain.position": 4.0,
        "offset.position": 0.2,
    }
    experiment, window = make("force", {"position": POSITION, "force": FORCE}, known)
    close(experiment.true("force", np.array([5.0]), {}), [21.0], "truth")
    close(experiment.true("force", np.array([5.0]), {"gain.force": 2.0, "offset.force": 1.0}), [8.0], "fitted")

    # A carriage without friction that no force moves goes on.
    still = {"mass": 1.0, "friction.coulomb.Fc": 0.0, "friction.coulomb.sigma2": 0.0, "offset.force": 0.0}
    experiment, window = make("force", {"position": POSITION, "force": 0.0 * TIME}, {**known, **still})

    def read(speed: float, **values: float) -> Array:
        going = replace(window, begin=Beginning({"position0": 0.0, "velocity0": speed}))
        fitted = {f"{name}.position": value for name, value in values.items()}
        return readings(experiment, going, "position", fitted)[1]["position"]

    # A uniform rise is read late by the lag, after a while.
    close(read(2.0)[-1], 2.0 * (1.0 - 0.05) / 4.0 + 0.2, "late")
    close(read(1.0, lag=0.0), TIME / 4.0 + 0.2, "without a lag")
    close(read(1.0, lag=0.0, gain=2.0, offset=-1.0), TIME / 2.0 - 1.0, "fitted")
    close(read(1.0, lag=0.0, delay=0.1)[50:], (TIME[50:] - 0.1) / 4.0 + 0.2, "delayed")
    plain, window = make("force", {"position": POSITION, "force": FORCE}, {"gain.position": 1.0})
    assert plain.true("position", POSITION, {}) is POSITION


@pytest.mark.parametrize(
    ("name", "signals", "settings", "units", "text"),
    [
        ("motion", ["force"], {}, {}, "experiment='motion' needs a column for position or velocity"),
        ("motion", ["velocity"], {}, {}, "experiment='motion' needs a column for frictionForce or force"),
        ("force", ["force"], {}, {}, "experiment='force' needs a column for position or velocity"),
        ("force", ["position"], {}, {}, "experiment='force' needs columns for time, force; force is missing"),
        ("force", ["position", "force"], {"incline": 0.1}, {"is_rotating": True},
         "settings='incline': a rotating machine has none; its mass is an inertia"),
        ("force", ["velocity", "force"], {"spring": 1.0}, {},
         "settings='spring': a spring needs a column for position"),
        ("force", ["velocity", "force"], {"springRest": 1.0}, {},
         "settings='springRest': a spring needs a column for position"),
        ("rig", [], {}, {},
         "experiment='rig' needs columns for time, valveVoltage, position; valveVoltage, position is missing"),
    ],
)  # fmt: skip
def test_too_little_is_refused(
    name: str, signals: list[str], settings: dict[str, Any], units: dict[str, Any], text: str
) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(text)}$"):
        EXPERIMENTS[name]("Coulomb", settings, Options(), Units(**units)).use(["time", *signals])


def test_what_may_be_free_beside_the_model_has_the_units_of_the_machine() -> None:
    sensors = {"gain.position": "1", "offset.position": "rad", "delay.position": "s", "lag.position": "s",
               "gain.force": "N.m/A", "offset.force": "A", "delay.force": "s"}  # fmt: skip
    turning = EXPERIMENTS["force"]("Coulomb", {}, Options(), Units(True, {"force": "A"}))
    turning.use(["time", "position", "force"])
    assert turning.beside == {**sensors, "spring": "N.m/rad", "springRest": "rad"}
    assert turning.unknown == ("mass", "gain.force")
    sliding = EXPERIMENTS["force"]("Coulomb", {}, Options())
    sliding.use(["time", "velocity", "force"])
    assert sliding.beside == {
        "gain.velocity": "1", "offset.velocity": "m/s", "delay.velocity": "s", "lag.velocity": "s",
        "gain.force": "1", "offset.force": "N", "delay.force": "s", "incline": "rad",
    }  # fmt: skip
    assert sliding.unknown == ("mass",)


def test_value_is_fitted_or_known_or_by_default() -> None:
    experiment = EXPERIMENTS["rig"]("Coulomb", {"mass.moving": 3, "delay.position": 0.1}, Options())
    asked = [experiment.beside_value("delay.position", values, 7.0) for values in ({"delay.position": 0.2}, {})]
    assert asked == [0.2, 0.1] and experiment.beside_value("lag.position", {}, 7.0) == 7.0


def test_carriage_rests_where_it_stays_within_its_noise() -> None:
    """It leaves after 0.5 s in steps of 0.2 mm, which are taken for steps of a converter: two of them are noise."""
    position = 0.3 + 0.1 * np.maximum(TIME - 0.5, 0.0)
    for name in ("force", "mechanical", "rig"):
        experiment, window = make(name, {**GAS, "position": position, "force": FORCE}, {})
        # Ten samples either way are looked at, of which the last is two steps off at 0.504 s.
        assert np.flatnonzero(~experiment.resting(window.record)).tolist() == list(range(243, 501))
    experiment, window = make("force", {"position": position, "force": FORCE}, {"mass": 1.0})
    # A carriage at rest does not move by an exact 0.
    assert window.begin == Beginning({"velocity0": 0.0, "position0": pytest.approx(0.3)}, ("position0",))
    _, mirrored = make("force", {"position": position[::-1], "force": FORCE}, {"mass": 1.0})
    assert mirrored.begin.loose == ("position0", "velocity0")
    close([mirrored.begin.values[name] for name in mirrored.begin.loose], [0.35, -0.1], "begin")


@pytest.mark.parametrize(("step", "window", "number"), [(2e-3, None, 7), (2e-3, 0.25, 4), (1e-2, None, 3)])
def test_windows_of_a_force_are_short_but_of_thirty_samples(step: float, window: float | None, number: int) -> None:
    """Unless a length is given: 0.15 s, or 0.3 s where samples are 10 ms apart."""
    time = np.arange(round(1.0 / step) + 1) * step
    experiment, whole = make("force", {"velocity": 0.2 + time, "force": time}, {}, Options(window=window), time=time)
    parts = experiment.windows(whole.record)
    begins = [k / number for k in range(number)]
    # At the next sample.
    records = [part.record for part in parts]
    assert_close([part.begin for part in records], begins, within=1.001 * step, what="begins", why="of samples")
    assert all(part.begin >= begin - 1e-9 for part, begin in zip(records, begins, strict=True))
    assert sum(len(part.time) for part in records) == len(time) and experiment.options.window == window


def test_late_readings_are_looked_up_in_the_whole_record() -> None:
    """A window from 0.6 s on, whose force is read 10 ms late; a pressure that is as late by what is fitted."""
    experiment, window = make("force", {"velocity": VELOCITY, "force": FORCE}, {"delay.force": 0.01, "mass": 1.0})
    part = piece(window, 300, 400)
    later = 40.0 + 5.0 * (TIME[300:400] + 0.01)

    def applied(delay: float) -> Array:
        return inputs_of(experiment, part, {"delay.force": delay})["appliedForce"]

    close(inputs_of(experiment, part)["appliedForce"], later, "force")
    close(applied(-0.02), later - 0.15, "force of what is fitted")
    assert np.array_equal(applied(0.0), part.driven["force"])
    # Beyond the end of a record there is its last reading.
    close(applied(0.5), np.minimum(40.0 + 5.0 * (TIME[300:400] + 0.5), 45.0), "end")
    assert part.fitted == 100 and replace(part, held=np.arange(100) < 30).fitted == 70


def test_model_is_given_what_it_has() -> None:
    """Settings and fitted values of it, and inputs that were not measured; neither sensors nor what is measured."""
    settings = {"supplyPressure": 6e5, "valveVoltage": 5.0, "gain.position": 2.0, "mass.moving": 1.0}
    experiment, _ = make("rig", {name: GAS[name] for name in ("valveVoltage", "position")}, settings)
    given = experiment.under_law({"mass.moving": 3.0, "delay.position": 0.1, "incline": 0.2})
    assert given == {"supplyPressure": 6e5, "mass.moving": 3.0, "incline": 0.2, "friction.law": "Coulomb"}
    assert guess(experiment, [], {}) == {} and experiment.driving == ("valveVoltage",)

"""What is left of data, by kinds of motion and in figures, of courses of which all of it is known."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from bounds import assert_close
from matplotlib.axes import Axes
from numpy.typing import NDArray
from pneumatic_servo.figures import BLUE, GREY, VERMILION
from pneumatic_servo.identification import figures
from pneumatic_servo.identification.experiments import EXPERIMENTS, Options
from pneumatic_servo.identification.figures import against, friction_map, overlay, worst_misfit
from pneumatic_servo.identification.kinds import kinds, measured_speed
from pneumatic_servo.identification.ranges import Ranges, asked_of, held_of
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.regimes import is_white, regimes
from pneumatic_servo.identification.residuals import Residuals
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.signals import Units
from pneumatic_servo.identification.steady import steady

Array = NDArray[np.float64]
ROUND = "other libraries of linear algebra round otherwise"


@dataclass
class Part:
    """A window, and what is left of its signals."""

    signals: dict[str, Array]
    left: dict[str, Array]
    step: float = 0.5
    begin: float = 0.0
    unused: tuple[int, ...] = ()

    @property
    def window(self) -> Any:
        number = len(next(iter(self.signals.values())))
        used = ~np.isin(np.arange(number), self.unused)
        record = Record("a.csv", np.arange(number) * self.step, self.begin, self.signals)
        return SimpleNamespace(record=record, used=used, held=np.zeros(number, dtype=bool))


def residuals(*parts: Part, noises: dict[str, Sensor] | None = None, units: Units | None = None) -> Residuals:
    compared = tuple(parts[0].left)
    problem = SimpleNamespace(
        windows=[part.window for part in parts], differences=lambda vectors: [[part.left for part in parts]],
        experiment=SimpleNamespace(compared=compared, units=units or Units()),
        sensors=noises or dict.fromkeys(compared, Sensor(1.0)),
    )  # fmt: skip
    return Residuals(SimpleNamespace(problem=problem, x=None))  # type: ignore[arg-type]


def test_windows_follow_each_other_and_leave_out_what_is_not_compared() -> None:
    found = residuals(
        Part({"position": np.array([1.0, 2.0, 4.0, 7.0])}, {"force": np.arange(4.0)}, unused=(0,)),
        Part({"velocity": np.array([5.0, 6.0]), "position": np.array([8.0, 9.0])}, {"force": np.array([7.0, 8.0])}),
        Part({"force": np.ones(3)}, {"force": np.ones(3)}, unused=(1,)),
    )
    for part in found.windows:
        part.record.signals["force"] = 10.0 + part.record.time
    first, second, third = found.courses("force")
    assert np.array_equal(first.difference, [np.nan, 1.0, 2.0, 3.0], equal_nan=True)
    assert (first.time.tolist(), second.time.tolist()) == ([0.0, 0.5, 1.0, 1.5], [2.0, 2.5])
    assert third.time.tolist() == [3.0, 3.5, 4.0] and second.measured.tolist() == [10.0, 10.5]
    assert found.all("force").tolist() == [1.0, 2.0, 3.0, 7.0, 8.0, 1.0, 1.0]
    # The number of the second where no position is measured, and the slope of what is.
    assert found.position.tolist() == [2.0, 4.0, 7.0, 8.0, 9.0, 0.0, 1.0]
    assert found.velocity.tolist() == [3.0, 5.0, 6.0, 5.0, 6.0, 1.0, 1.0]
    assert found.limit("force") == 1.96 / np.sqrt(7.0) and found.unit("force") == "N"


def test_correlation_is_that_within_windows() -> None:
    """Of what turns from sample to sample, about means of 3 and 5, over half of the shorter window."""
    turns = (-1.0) ** np.arange(6)
    found = residuals(
        Part({"force": turns}, {"force": np.insert(turns[:4] + 3.0, 1, 99.0)}, unused=(1,)),
        Part({"force": turns}, {"force": turns + 5.0}),
        Part({"force": np.ones(1)}, {"force": np.ones(1)}, unused=(0,)),
    )
    found.windows[0].used.resize(5, refcheck=False)
    assert_close(found.correlation("force"), [1.0, -0.8, 0.6], rel=1e-13, what="autocorrelation", why=ROUND)
    assert not found.is_white("force")
    nothing = residuals(Part({"force": np.ones(300)}, {"force": np.zeros(300)}))
    assert nothing.correlation("force").tolist() == [0.0] * 101 and nothing.is_white("force")
    noise = np.random.default_rng(1).standard_normal(2000)
    assert residuals(Part({"force": noise}, {"force": noise})).is_white("force")


def test_noise_is_that_of_the_sensor_with_its_converter() -> None:
    """Of 0.05 N beside steps of 0.1 N, which make 0.1 N/sqrt(12)."""
    noise = 0.05 * np.random.default_rng(2).standard_normal(20000)
    force = 0.1 * np.round((10.0 + noise) / 0.1)
    found = residuals(Part({"force": force}, {"force": force}))
    sensor = Sensor.of([force])
    assert_close(sensor.step, 0.1, rel=1e-9, what="step", why="found on a lattice")
    assert_close(found.noise("force"), np.sqrt(sensor.noise**2 + 0.1**2 / 12.0), rel=1e-14, what="noise")


def test_worst_is_what_lasts_in_units_of_the_noise() -> None:
    """2 N of a noise of 1 N for eleven samples, more than 0.3 m of 0.2 m; a single sample of 6 N is less."""
    quiet, force, position = np.zeros(60), np.zeros(60), np.zeros(60)
    force[30:41], force[5], position[10:30] = 2.0, 6.0, 0.3
    noises = {"force": Sensor(1.0), "position": Sensor(0.2)}
    signals = {"force": quiet, "position": quiet}
    calm = Part(signals, {"force": quiet, "position": quiet})
    worst = residuals(calm, Part(signals, {"force": force, "position": position}), noises=noises).worst()
    assert worst is not None and (worst.signal, worst.window, worst.sample) == ("force", 1, 35)
    assert_close(worst.size, 4.0, rel=1e-14, what="size")
    # What is not compared is not missed, and what is too short is all that there is.
    hidden = Part(signals, {"force": force, "position": position}, unused=tuple(range(30, 60)))
    assert_close((residuals(hidden, noises=noises).worst() or worst).size, 36.0 / 11.0, rel=1e-14, what="single")
    short = Part({"force": np.zeros(4)}, {"force": np.array([0.0, np.nan, 4.0, 0.0])})
    assert (residuals(short).worst() or worst).size <= 4.0
    assert residuals(Part(signals, {"force": quiet}, unused=tuple(range(60)))).worst() is None


def test_kinds_of_a_motion_by_hand() -> None:
    """Rest, forth, back, slowly forth, and rest, 1 s each in steps of 10 ms; 50 ms about a reversal count to it."""
    speed = np.repeat([0.0, 1.0, -1.0, 0.1, 0.0], 100)
    part = Part({"velocity": speed}, {"force": speed}, step=0.01, unused=(0,))
    problem: Any = SimpleNamespace(windows=[part.window, Part({"velocity": speed[:1]}, {}, step=0.01).window])
    problem.windows[1].record.__dict__["step"] = 0.01
    found = {name: np.flatnonzero(masks[0]).tolist() for name, masks in kinds(problem).items()}
    assert found == {
        "at rest": [*range(1, 100), *range(400, 500)],
        "at break-away": list(range(100, 106)),
        "at reversals": [*range(195, 206), *range(295, 306)],
        "in slow motion": list(range(306, 400)),
        "in fast motion": [*range(106, 195), *range(206, 295)],
    }
    assert [masks[1].tolist() for masks in kinds(problem).values()] == [[True], [False], [False], [False], [False]]


def test_speed_is_measured_or_the_slope_or_none() -> None:
    time = np.arange(30) * 0.01
    of = [{"velocity": time, "position": time}, {"position": 3.0 * time**2}, {"force": time}]
    found = [measured_speed(Record("a", time, 0.0, signals)) for signals in of]
    assert found[0] is time and found[2].tolist() == [0.0] * 30
    assert_close(found[1], 6.0 * time, within=1e-13, what="slope", why=ROUND)


def test_kinds_are_judged_one_by_one() -> None:
    """19 samples are too few to be judged, what hangs together is no noise, and what is rounded off is no fault."""
    noise = np.random.default_rng(3).standard_normal(300)
    hanging = np.where(np.arange(300) < 100, 3.0, noise)
    found = residuals(Part({"force": noise}, {"force": hanging}), noises={"force": Sensor(1.0, 5.9)})
    index = np.arange(300)
    masks = {"a": index < 100, "b": (index >= 100) & (index < 119), "c": index >= 119, "d": index >= 280}
    found.__dict__["kinds"] = {name: [mask] for name, mask in masks.items()}
    a, c, d = regimes(found, "force")
    assert (a.name, a.samples, a.rms, a.is_white) == ("a", 100, 3.0, False)
    assert (c.name, c.samples, c.is_white, d.name, d.samples) == ("c", 181, True, "d", 20)
    assert_close(c.rms, np.sqrt(np.mean(noise[119:] ** 2)), rel=1e-14, what="rms")
    found.problem.sensors = {"force": Sensor(1.0, 6.0)}  # type: ignore[misc]
    assert regimes(found, "force")[0].is_white


def test_courses_look_like_noise_or_not() -> None:
    rng = np.random.default_rng(4)
    white = rng.standard_normal(400)
    # Neighbours that share a half or a twelfth: correlations of 0.5, and of 0.08, which 20 000 samples make sure.
    assert is_white([white]) and not is_white([white[1:] + white[:-1]])
    long = rng.standard_normal(20001)
    assert is_white([long[1:] + long[:-1] / 12.0])
    assert not is_white([np.ones(50)]) and is_white([np.zeros(50)])
    # 20 pairs of neighbours are needed; courses are not neighbours of each other.
    assert is_white([np.ones(20)]) and not is_white([np.ones(21)])
    assert is_white([np.ones(1)] * 100) and is_white([np.where(np.arange(100) % 30, np.nan, 1.0)])


@pytest.mark.parametrize(
    ("signal", "value", "text"),
    [
        # A tenth of a range of 200 kPa and a twentieth of 400 kPa are the same.
        ("pressure", 4.19e5, None),
        ("pressure", 4.21e5, "pressure reaches 4.21e+05 Pa, of which up to 4e+05 Pa was fitted"),
        ("pressure", 1.81e5, None),
        ("pressure", 1.79e5, "pressure falls to 1.79e+05 Pa, of which down to 2e+05 Pa was fitted"),
        ("force", -1.041, None),
        ("force", -1.061, "force falls to -1.061 N.m, of which down to -1 N.m was fitted"),
        # Of a speed both directions count, by a tenth of both.
        ("velocity", -2.39, None),
        ("velocity", -2.41, "velocity reaches 2.41 rad/s, of which up to 2 rad/s was fitted"),
        ("position", 1e9, None),
    ],
)
def test_what_is_beyond_a_range_is_told(signal: str, value: float, text: str | None) -> None:
    limits = {"pressure": (2e5, 4e5), "force": (-1.0, -0.5), "velocity": (-2.0, 2.0)}
    ranges = Ranges(limits, Units(is_rotating=True))
    asked = {signal: np.full((4, 50), value)}
    assert ranges.beyond(asked) == ({} if text is None else {signal: text})
    # Not for single peaks.
    low, high = limits.get(signal, (0.0, 0.0))
    peak = np.full(300, 0.5 * (low + high))
    peak[:2] = value
    assert ranges.beyond({signal: peak}) == {}


def ranged(name: str, unused: tuple[int, ...] = ()) -> tuple[Any, Array]:
    """A problem of 102 samples, of which the last is held out; the sensor of the force reads half."""
    count = np.arange(102.0)
    signals = {"position": count, "velocity": count * (-1.0) ** count, "force": count - 50.0, "valveVoltage": count,
               "supplyPressure": 6e5 + count}  # fmt: skip
    experiment = EXPERIMENTS[name]("Coulomb", {"gain.force": 2.0, "offset.valveVoltage": 1.0}, Options(), Units())
    experiment.use(["time", *signals])
    window = Part(signals, {}, unused=unused).window
    window.held[-1] = True
    return SimpleNamespace(experiment=experiment, windows=[window], values=lambda x: {"offset.force": x[0]}), count


def test_ranges_are_those_of_what_is_fitted() -> None:
    """Of a bench neither where it is nor what it answers; of a speed all but the fastest of a hundred, both ways."""
    problem, _ = ranged("force", unused=(0,))
    found = Ranges.of(problem, np.array([10.0]))
    assert found.limits == {
        "force": (2.0 * (1.0 - 60.0), 2.0 * (100.0 - 60.0)), "supplyPressure": (600001.0, 600100.0),
        "valveVoltage": (0.0, 99.0), "velocity": (pytest.approx(-99.01), pytest.approx(99.01)),
    }  # fmt: skip
    assert found.units is problem.experiment.units
    held = held_of(problem, np.array([10.0]))
    assert {name: values.tolist() for name, values in held.items()} == {
        "force": [82.0], "supplyPressure": [600101.0], "valveVoltage": [100.0], "velocity": [101.0],
    }  # fmt: skip
    problem.windows[0].held[-1] = False
    assert held_of(problem, np.array([10.0])) == {}
    rig, count = ranged("rig")
    asked = asked_of(rig, np.array([0.0]))
    # A cylinder has its ends; what is measured beside it is asked, too.
    assert asked.keys() == {"position", "force", "supplyPressure", "valveVoltage", "velocity"}
    assert np.array_equal(asked["position"], count) and np.array_equal(asked["velocity"], count)


def lines(axis: Axes) -> list[Array]:
    return [np.asarray(line.get_xydata()) for line in axis.get_lines() if len(np.asarray(line.get_xdata()))]


def colours(axis: Axes) -> list[object]:
    return [line.get_color() for line in axis.get_lines()]


def labels(axis: Axes) -> list[str]:
    legend = axis.get_legend()
    assert legend is not None
    return [text.get_text() for text in legend.get_texts()]


def test_signals_are_drawn_above_what_is_left_of_them() -> None:
    """8001 samples are drawn by every second one; a position in mm, a pressure in bar."""
    time = np.arange(8001) * 0.5
    signals = {"position": np.sin(time), "chamberA.pressure": 1e5 + time}
    left = {"position": 0.1 * np.cos(time), "chamberA.pressure": np.full(8001, 50.0)}
    short = Part({name: values[:3] for name, values in signals.items()}, {name: one[:3] for name, one in left.items()})
    figure = overlay(residuals(Part(signals, left), short))
    assert [axis.get_ylabel() for axis in figure.axes] == [
        "position (mm)", "rest (mm)", "chamberA.pressure (bar)", "rest (bar)",
    ]  # fmt: skip
    assert [axis.get_xlabel() for axis in figure.axes] == ["", "", "", "time (s), records one after the other"]
    for place, (signal, factor) in enumerate((("position", 1e3), ("chamberA.pressure", 1e-5))):
        upper, lower = figure.axes[2 * place : 2 * place + 2]
        measured, fitted, again, _ = lines(upper)
        [rest, late] = lines(lower)
        assert np.array_equal(measured, np.column_stack([time, factor * signals[signal]])[::2])
        assert np.array_equal(fitted, np.column_stack([time, factor * (signals[signal] - left[signal])])[::2])
        assert np.array_equal(rest, np.column_stack([time, factor * left[signal]])[::2])
        assert again[:, 0].tolist() == late[:, 0].tolist() == [4000.5, 4001.0, 4001.5]
        assert colours(upper)[:2] == [GREY, BLUE] and set(colours(lower)) == {VERMILION}
    assert labels(figure.axes[0]) == ["measured", "fitted"] and colours(figure.axes[0])[-2:] == [GREY, BLUE]
    # One time for all, and room for each.
    assert figure.axes[0].get_shared_x_axes().joined(*figure.axes[::3])
    assert figure.get_figheight() > overlay(residuals(Part({"force": time}, {"force": time}))).get_figheight() + 1.0


def test_worst_misfit_is_drawn_with_its_surroundings() -> None:
    """Sixty samples either way, in the time of the table, with the speed there."""
    number = 200
    force = np.arange(number) * 0.1
    left = np.zeros(number)
    left[75:86] = 5.0
    part = Part({"force": force, "velocity": force**2}, {"force": left}, begin=100.0)
    figure = worst_misfit(residuals(part, units=Units(is_rotating=True)))
    assert figure is not None
    upper, lower = figure.axes
    near = slice(20, 141)
    time = 100.0 + 0.5 * np.arange(number)[near]
    measured, fitted, mark = lines(upper)
    assert np.array_equal(measured, np.column_stack([time, force[near]]))
    assert np.array_equal(fitted, np.column_stack([time, (force - left)[near]]))
    speed, below = lines(lower)
    assert np.array_equal(speed, np.column_stack([time, force[near] ** 2]))
    assert mark[:, 0].tolist() == below[:, 0].tolist() == [140.0, 140.0]
    assert (upper.get_title(), upper.get_ylabel()) == ("a.csv: worst at 140 s", "force (N.m)")
    assert (lower.get_xlabel(), lower.get_ylabel()) == ("time of the record (s)", "velocity (rad/s)")
    assert upper.get_shared_x_axes().joined(upper, lower)
    assert labels(upper) == ["measured", "fitted"]
    assert (colours(upper), colours(lower)) == ([GREY, BLUE, GREY], [VERMILION, GREY])
    first = Part({"velocity": force}, {"velocity": np.where(force < 1.1, 5.0, 0.0)})
    early = worst_misfit(residuals(first))
    assert early is not None and early.axes[1].get_ylabel() == "velocity (mm/s)"
    assert lines(early.axes[0])[0][0].tolist() == [0.0, 0.0] and len(lines(early.axes[0])[0]) == 66
    assert np.array_equal(lines(early.axes[1])[0][:, 1], 1e3 * force[:66])
    assert worst_misfit(residuals(Part({"force": force}, {"force": left}, unused=tuple(range(number))))) is None


def test_what_is_left_is_drawn_against_motion_and_lag() -> None:
    number = 8002
    force = np.random.default_rng(5).standard_normal(number)
    path, speed = np.linspace(0.0, 1.0, number), np.linspace(-0.5, 0.5, number)
    found = residuals(Part({"position": path, "velocity": speed}, {"force": force, "other": path}))
    of_speed, of_path, of_lag = against(found).axes
    for axis, course in ((of_speed, speed), (of_path, path)):
        [dots] = lines(axis)
        assert np.array_equal(dots, np.column_stack([1e3 * course, force])[::2])
        assert colours(axis) == [VERMILION] and axis.get_lines()[0].get_marker() == "."
    [correlation] = lines(of_lag)
    assert np.array_equal(correlation, np.column_stack([np.arange(101), found.correlation("force")]))
    assert [axis.get_xlabel() for axis in (of_speed, of_path, of_lag)] == [
        "velocity (mm/s)", "position (mm)", "lag (samples)",
    ]  # fmt: skip
    assert [axis.get_ylabel() for axis in (of_speed, of_path, of_lag)] == ["rest of force (N)", "", "autocorrelation"]


@pytest.mark.parametrize("has_curve", [True, False])
def test_friction_is_drawn_at_a_load_level_of_1(has_curve: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two windows, of which one tells nothing; where there is no load nothing is drawn, and of 16002 every second."""
    speed = np.linspace(-2.0, 3.0, 16005)
    level = np.where(np.arange(16005) < 3, 0.0, 2.0)
    maps = iter([None, (speed, 4.0 * speed, level)])
    problem = SimpleNamespace(
        windows=[1, 2], experiment=SimpleNamespace(forces=lambda window, values: next(maps)),
    )  # fmt: skip
    fit: Any = SimpleNamespace(problem=problem, values={}, units=Units(), law="Dahl")
    curve = (np.array([-3.0, 3.0]), np.array([-5.0, 5.0]))
    fastest: list[float] = []
    monkeypatch.setattr(figures, "steady", lambda fit, top: fastest.append(top) or (curve if has_curve else None))
    figure = friction_map(fit)
    assert figure is not None and fastest == [3.0]
    [axis] = figure.axes
    data, *law = lines(axis)
    assert np.array_equal(data, np.column_stack([1e3 * speed, 2.0 * speed])[3::2])
    assert labels(axis) == ["data", "Dahl, steady"][: 1 + has_curve]
    assert colours(axis) == [GREY, BLUE][: 1 + has_curve]
    if has_curve:
        assert law[0].tolist() == [[-3000.0, -5.0], [3000.0, 5.0]]
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("velocity (mm/s)", "friction at load level 1 (N)")
    problem.experiment.forces = lambda window, values: None
    assert friction_map(fit) is None


def test_figures_leave_the_style_of_others_alone() -> None:
    before = dict(mpl.rcParams)
    overlay(residuals(Part({"force": np.ones(3)}, {"force": np.ones(3)})))
    assert dict(mpl.rcParams) == before


def test_steady_friction_is_that_of_the_law_at_each_speed() -> None:
    """Dry and viscous; what no bench has is left out."""
    settings = {"friction.law": "Coulomb", "friction.coulomb.Fc": 7.0, "friction.coulomb.sigma2": 20.0, "valve.C": 1.0}
    fit: Any = SimpleNamespace(settings=settings)
    found = steady(fit, 2.0)
    assert found is not None
    speeds, friction = found
    half = 0.02 * 100.0 ** (np.arange(25) / 24.0)
    assert_close(speeds, [*-half[::-1], *half], rel=1e-14, what="speeds")
    assert_close(friction, 7.0 * np.sign(speeds) + 20.0 * speeds, rel=1e-9, what="friction", why="of a simulation")

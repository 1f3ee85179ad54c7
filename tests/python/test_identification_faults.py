"""Sensor faults and other curves of friction as explanations of residuals, where the explanation is known."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification import free_form, sensor_faults
from pneumatic_servo.identification.experiments import EXPERIMENTS, Experiment, Options
from pneumatic_servo.identification.free_form import FreeForm
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.sensor_faults import Doubt, doubt
from pneumatic_servo.identification.signals import Units

Array = NDArray[np.float64]

FREE, OFFSET, DELAY, OTHER = np.linalg.qr(np.random.default_rng(12).standard_normal((60, 4)))[0].T
"""Effects of the free parameter and of faults on 30 samples of position and then of velocity."""
WEIGHTS = np.repeat([2.0, 5.0], 30)


@dataclass(frozen=True)
class Straight:
    """A problem in which everything is in proportion; each fault has a trace for each unit of it."""

    experiment: Experiment
    left: Array
    traces: dict[str, Array]
    free: tuple[Any, ...] = ()
    loose: tuple[int, ...] = (1,)
    windows: tuple[Any, ...] = field(default_factory=lambda: (SimpleNamespace(fitted=30),))
    tried: ClassVar[list[dict[str, float]]] = []
    """Requests to the problem."""

    def trained(self) -> Straight:
        return self

    def by_sensor(self, of: Any, stacked: Array) -> Array:
        assert of is Sensor.weights and stacked is self.left
        return WEIGHTS

    def stacked(self, vectors: list[Array]) -> Array:
        [x] = vectors
        assert x.tolist() == [7.0, 0.0]
        self.tried.append(dict(self.experiment.held))
        none = np.zeros(60)
        return np.array([
            self.left - sum((value * self.traces.get(name, none) for name, value in self.experiment.held.items()), none)
        ])  # fmt: skip


def asked(
    left: Array, traces: dict[str, Array], monkeypatch: pytest.MonkeyPatch, noise: float = 1e-3, **settings: float
) -> Doubt | None:
    """Suspected faults under such residuals, in units of the noise."""
    known = {name.replace("__", "."): value for name, value in settings.items()}
    experiment = EXPERIMENTS["force"]("Coulomb", known, Options())
    experiment.use(["time", "position", "velocity", "force"])
    given = {name: trace / WEIGHTS for name, trace in traces.items()}
    problem = Straight(experiment, left / WEIGHTS, given)
    monkeypatch.setattr(sensor_faults, "sensitivities", lambda of, x: ((FREE / WEIGHTS)[:, None], problem.left))
    fit: Any = SimpleNamespace(problem=problem, x=np.array([7.0]), rms={"position": 1.0, "velocity": 0.0})
    residuals: Any = SimpleNamespace(noise=lambda signal: noise)
    return doubt(fit, residuals)


def test_offset_is_found_with_its_size_and_what_it_would_gain(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fault that the free parameter explains as well does not count."""
    trace = OFFSET + 4.0 * FREE
    found = asked(3.0 * trace + OTHER, {"offset.force": trace, "delay.force": DELAY}, monkeypatch, noise=0.7)
    assert found is not None and (found.name, found.unit) == ("offset.force", "N")
    assert_close(found.value, 3.0, rel=1e-13, what="offset", why="of projections")
    assert_close(found.gain, 9.0, rel=1e-13, what="gain", why="of projections")
    shares = {}
    for signal, own in (("position", slice(0, 30)), ("velocity", slice(30, 60))):
        before, after = (3.0 * OFFSET + OTHER)[own], OTHER[own]
        shares[signal] = 1.0 - (after @ after) / (before @ before)
    assert found.signal == max(shares, key=lambda signal: shares[signal])
    assert_close(found.share, max(shares.values()), rel=1e-12, what="share", why="of projections")


@pytest.mark.parametrize("size", [0.3, -0.3])
def test_delay_is_found_in_its_direction(size: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A delay may be either way; the lag of a filter is none below 0."""
    found = asked(size * DELAY, {"delay.velocity": 2.0 * DELAY}, monkeypatch)
    assert found is not None and (found.name, found.unit) == ("delay.velocity", "s")
    assert_close(found.value, 0.5 * size, rel=1e-13, what="delay", why="of projections")
    lag = asked(size * DELAY, {"lag.position": DELAY}, monkeypatch)
    assert (lag is None) is (size < 0.0)
    if lag is not None:
        assert_close(lag.value, size, rel=1e-13, what="lag", why="of projections")


def test_delays_are_tried_at_several_values(monkeypatch: pytest.MonkeyPatch) -> None:
    """Since what they do is not in proportion to them; lags only above 0, and all else by a single step."""
    Straight.tried.clear()
    asked(OTHER, {}, monkeypatch)
    times = [0.003, 0.01, 0.02, 0.04]
    tried: dict[str, list[float]] = {}
    for [(name, value)] in (held.items() for held in Straight.tried):
        tried.setdefault(name, []).append(value)
    for name, values in tried.items():
        if name.startswith("delay"):
            assert values == [*times, *(-time for time in times)], name
        elif name.startswith("lag"):
            assert values == times, name
        else:
            assert len(values) == 1, name
    signals = ("position", "velocity", "force")
    kinds = {f"{kind}.{signal}" for kind in ("gain", "offset", "delay") for signal in signals}
    assert tried.keys() == kinds | {"lag.position", "lag.velocity"}


def test_what_explains_the_most_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    found = asked(0.1 * DELAY + 2.0 * OFFSET, {"delay.force": DELAY, "offset.force": OFFSET}, monkeypatch)
    assert found is not None and found.name == "offset.force"
    # A gain is 1 without a fault; one that is 1.2 leaves a fifth of the force.
    gain = asked(0.2 * OTHER, {"gain.force": OTHER, "offset.force": OFFSET}, monkeypatch)
    assert gain is not None and (gain.name, gain.unit) == ("gain.force", "1")


@pytest.mark.parametrize(
    ("left", "settings", "noise"),
    [
        # It has no effect of its own, it is known, or it would explain too little of both signals.
        (3.0 * FREE, {}, 1e-3),
        (3.0 * OFFSET, {"offset__force": 0.0}, 1e-3),
        (OFFSET + 10.0 * OTHER, {}, 1e-3),
        # Noise of more than half of the squares leaves nothing else above half.
        (3.0 * OFFSET, {}, 0.71),
        # Nothing is left at all.
        (0.0 * OFFSET, {}, 1e-3),
    ],
)
def test_nothing_is_doubted_without_a_reason(
    left: Array, settings: dict[str, float], noise: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert asked(left, {"offset.force": OFFSET, "gain.force": FREE}, monkeypatch, noise, **settings) is None


def curves(
    left: Array, speed: Array, place: Array | None, level: Array, monkeypatch: pytest.MonkeyPatch, name: str = "motion"
) -> FreeForm | None:
    """Residuals of free curves, of two windows, none of the second fitted."""
    number = len(speed)
    held = np.arange(number) % 5 == 0
    time = np.arange(number) * 1.0
    signals = {} if place is None else {"position": place}
    record = SimpleNamespace(time=time, grid=time, signals=signals, on_grid=lambda signal: signals[signal])
    inside = ~held if name == "motion" else np.ones(number, dtype=bool)
    window = SimpleNamespace(fitted=4, used=np.ones(number, dtype=bool), held=held, record=record, driven=signals)
    law = np.array([-1e3, 1e3])
    friction = left if name == "motion" else left + level * 3.0 * speed
    experiment = SimpleNamespace(
        name=name, compared=("force",),
        forces=lambda window, values: (speed[inside], friction[inside], level[inside]) if window.fitted else 1 / 0,
    )  # fmt: skip
    problem = SimpleNamespace(experiment=experiment, windows=[SimpleNamespace(fitted=0), window])
    fit: Any = SimpleNamespace(problem=problem, values={}, units=Units(is_rotating=True))
    residuals: Any = SimpleNamespace(differences=[None, {"force": left}])
    monkeypatch.setattr(
        free_form, "steady", lambda fit, top: (law, 3.0 * law) if top == np.max(np.abs(speed)) else None
    )
    return free_form.free_form(fit, residuals)


def motion(number: int = 2000) -> tuple[Array, Array, Array]:
    speed, place = np.random.default_rng(13).uniform(-1.0, 1.0, (2, number))
    return speed, place, 2.0 + np.sin(np.arange(number))


@pytest.mark.parametrize("name", ["motion", "force"])
def test_free_curves_find_what_is_of_their_variables(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The residual is a parabola of the root of the speed, of each direction, plus load and position."""
    speed, place, level = motion()
    of_speed = np.where(speed > 0.0, 1.0 + np.sqrt(np.abs(speed)), -2.0 + 3.0 * np.abs(speed))
    of_load = of_speed * (level - 2.0)
    of_place = place**2 * np.sign(speed) + place
    constant = np.full(len(speed), 2.0)
    for left, loaded, found_by in (
        (of_speed, constant, ["velocity", "velocity and position"]),
        (of_place, constant, ["velocity and position"]),
        (of_speed, level, ["velocity", "velocity and load", "velocity, load and position"]),
        (of_speed + of_load, level, ["velocity and load", "velocity, load and position"]),
        (of_load + of_place, level, ["velocity, load and position"]),
    ):
        found = curves(left, speed, place, loaded, monkeypatch, name)
        assert found is not None and found.unit == "N.m"
        names = ["velocity", "velocity and load", "velocity, load and position"]
        assert list(found.curves) == (names if loaded is level else ["velocity", "velocity and position"])
        # A spline has a parabola; its penalty is a millionth.
        assert [one for one, rms in found.curves.items() if rms < 0.01 * found.law] == found_by
        moving = np.abs(speed) > 0.01 * np.quantile(np.abs(speed), 0.98)
        inside = moving & (np.arange(len(speed)) % 5 > 0) if name == "motion" else moving
        assert_close(
            found.law, np.sqrt(np.mean(left[inside] ** 2)), rel=1e-3, what="law", why="rest is of some samples"
        )


@pytest.mark.parametrize(("number", "is_told"), [(249, False), (250, True)])
def test_two_hundred_samples_in_motion_are_needed(number: int, is_told: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of which four of five are fitted; those at rest and without load tell nothing, however much is left there."""
    speed, place, level = motion(number)
    speed = np.copysign(0.5 + 0.5 * np.abs(speed), speed)
    found = curves(speed, speed, place, level, monkeypatch)
    assert (found is not None) is is_told
    more = [np.append(one, other) for one, other in ((speed, [1e-3] * 5 + [1.0] * 5), (place, [0.0] * 10))]
    loaded = np.append(level, [2.0] * 5 + [1e-4] * 5)
    again = curves(np.append(speed, [1e3] * 10), *more, loaded, monkeypatch)
    assert (again is None) is not is_told
    if found is not None and again is not None:
        assert_close(again.law, found.law, rel=1e-14, what="law")


def test_level_that_hardly_varies_says_nothing_of_load(monkeypatch: pytest.MonkeyPatch) -> None:
    speed, place, _ = motion()
    for share, varies in ((0.048, False), (0.052, True)):
        level = 3.0 * (1.0 + share * (-1.0) ** (np.arange(2000) // 2))
        found = curves(speed, speed, place, level, monkeypatch, "force")
        assert found is not None and ("velocity and load" in found.curves) is varies


def test_axis_without_a_position_has_no_curve_over_it(monkeypatch: pytest.MonkeyPatch) -> None:
    speed, _, level = motion()
    found = curves(np.sign(speed), speed, None, level, monkeypatch, "force")
    assert found is not None
    # A constant, each way, is all that is left of it; over velocity there is one already.
    *_, velocity, place = found.curves.values()
    assert_close(place, velocity, within=1e-6, what="rms", why="of penalties")


def test_experiment_without_friction_has_no_curves() -> None:
    window = SimpleNamespace(fitted=4)
    experiment = SimpleNamespace(name="rig", forces=lambda window, values: None)
    problem = SimpleNamespace(experiment=experiment, windows=[window])
    fit: Any = SimpleNamespace(problem=problem, values={})
    assert free_form.free_form(fit, SimpleNamespace(differences=None)) is None  # type: ignore[arg-type]

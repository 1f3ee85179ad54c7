"""Other curves of friction as explanations of residuals, where the explanation is known."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification import free_form
from pneumatic_servo.identification.free_form import FreeForm
from pneumatic_servo.identification.signals import Units

Array = NDArray[np.float64]


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
        name=name, compared=("force",), is_steady=False,
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
    experiment = SimpleNamespace(name="rig", is_steady=False, forces=lambda window, values: None)
    problem = SimpleNamespace(experiment=experiment, windows=[window])
    fit: Any = SimpleNamespace(problem=problem, values={})
    assert free_form.free_form(fit, SimpleNamespace(differences=None)) is None  # type: ignore[arg-type]

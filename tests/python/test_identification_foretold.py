"""Friction of a condition as the others predict it, by equations that it must obey whatever is fitted."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification.foretold import (
    Foretold,
    Left,
    _foretold,
    _mean_friction,
    _measured,
    _noise,
    _of_factor,
)
from pneumatic_servo.identification.sensor import Sensor
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import k0
from scipy.stats import t as student
from test_identification_conditions import PRESSURES, seal
from test_identification_force import axis
from test_identification_posterior import FC, GIVEN, SIGMA2, line

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def fitted() -> ps.Fit:
    """Coulomb and viscous friction with a noise of 0.5 N, of two records."""
    return ps.fit([line(seed)[0] for seed in range(2)], **GIVEN)


def test_mean_friction_is_that_of_the_samples_that_move(fitted: ps.Fit) -> None:
    problem, x = fitted.problem, fitted.x
    values = problem.values(x)
    speeds = np.abs(np.concatenate([np.diff(window.driven["position"]) for window in problem.windows])) / 0.01
    mean, slope = _mean_friction(problem, x)
    assert_close(mean, values[FC] + values[SIGMA2] * np.mean(speeds), rel=1e-12, what="mean")
    # Of the logarithm of Fc and of the value of sigma2: twice as much of both is twice the friction.
    assert_close(slope[0], values[FC] / mean, rel=5e-8, what="slope by Fc")
    assert_close(slope @ [1.0, x[1]], 1.0, within=1e-7, what="slope by all")


def test_factor_of_all_friction_is_that_of_all_its_parameters(fitted: ps.Fit) -> None:
    left = Left.of(fitted.problem, fitted.x)
    found = _of_factor(fitted.problem, fitted.x, left)
    assert_close(found, left.derivatives @ [1.0, fitted.x[1]], rel=1e-4, what="effect of the factor")
    half = replace(fitted.problem, scale=0.5)
    assert_close(_of_factor(half, fitted.x, left), 0.5 * found, within=5e-13, what="effect of the factor at a half")


def test_what_is_left_is_what_the_fit_leaves_in_units_of_the_noise(fitted: ps.Fit) -> None:
    left = Left.of(fitted.problem, fitted.x)
    noise = fitted.problem.sensors["frictionForce"].noise
    assert_close(left.residuals, left.rests["frictionForce"] / noise, rel=1e-14, what="residuals")
    assert_close(left.weights, 1.0 / noise, rel=1e-14, what="weights")
    assert_close(np.sqrt(np.mean(left.rests["frictionForce"] ** 2)), fitted.rms["frictionForce"], rel=1e-14, what="rms")
    assert left.basis.shape == (len(left.residuals), 0)
    # Where a fit has ended its derivatives tell nothing more.
    gain = left.derivatives.T @ left.residuals / np.linalg.norm(left.derivatives, axis=0)
    assert_close(gain, 0.0, within=1e-4, what="gain")


def test_windows_begin_as_suits_them_best() -> None:
    """Of an axis that a force moves: what a beginning could lessen is gone, of residuals and derivatives alike."""
    data = {name: axis()[name][:600] for name in ("time", "position", "force")}
    found = ps.fit(data, experiment="force", law="Coulomb", fit=["mass"], starts=0, window=0.6, progress=False)
    problem = found.problem.trained()
    x = problem.start
    left = Left.of(problem, x)
    columns = sum(problem.loose)
    assert left.basis.shape == (problem.size, columns) and columns >= 2
    assert_close(left.basis.T @ left.basis, np.eye(columns), within=1e-14, what="basis")
    assert_close(left.basis.T @ left.residuals, 0.0, within=1.5e-13, what="residuals along the basis")
    assert_close(left.basis.T @ left.derivatives, 0.0, within=4e-13, what="derivatives along the basis")
    assert_close(
        left.without(left.residuals + left.basis[:, 0]), left.residuals, within=1e-13, what="without the basis"
    )
    raw = problem.stacked([x])[0] * problem.by_sensor(Sensor.weights, problem.stacked([x])[0])
    assert_close(raw - left.residuals, left.basis @ (left.basis.T @ raw), within=7e-14, what="what is taken away")


def test_friction_with_a_viscous_part_is_measured_as_it_is() -> None:
    """Where dry friction leaves its line by half again, and viscous friction stays, that is not half of all."""
    data, true = [], []
    for number, (pressure, factor) in enumerate(zip(PRESSURES, (1.0, 1.0, 1.0, 1.5), strict=True)):
        record = seal(pressure, factor, number)
        speed = np.append(0.0, np.diff(record["position"])) / 0.02
        true.append(np.mean(np.abs(record["force"] - 4.95e-4 * record["pressure"] + 100.0 * speed)[1:]))
        data.append(record | {"force": record["force"] + 100.0 * speed})
    free = "friction.coulomb.Fc,friction.coulomb.sigma2,friction.kappaA,area"
    found = ps.fit(data, **GIVEN, fit=free, cross_validate="pressure").cross_validation
    assert found is not None
    for case, friction in zip(found.cases, true, strict=True):
        assert case.friction is not None
        assert case.friction.measured_low < friction < case.friction.measured_high
        assert_close(case.friction.measured, friction, rel=0.05, what="measured friction")


def test_prediction_says_whether_it_holds_and_tells_anything() -> None:
    told = Foretold(10.0, 8.0, 12.0, 11.0, 10.5, 11.5, 0.1)
    assert told.said("N") == "predicted 10 N [8, 12], measured 11 N [10.5, 11.5]"
    for measured, is_within in ((7.9, False), (8.0, True), (12.0, True), (12.1, False)):
        assert replace(told, measured=measured).is_within is is_within
    assert not replace(told, high=24.0).is_wide and replace(told, high=24.1).is_wide


def test_noise_beside_columns_of_any_size_is_that_of_their_regression() -> None:
    """Of independent samples: what the columns could do is none of it, be they large or small."""
    rng = np.random.default_rng(7)
    columns, rest = rng.standard_normal((400, 2)), rng.standard_normal(400)
    _, squares, *_ = np.linalg.lstsq(columns, rest)
    blocks = np.arange(400) // 4
    by_size = [_noise(columns * sizes, rest + columns @ [5.0, -3.0], blocks) for sizes in ([1.0, 1.0], [1e-3, 1e-5])]
    assert_close(by_size[1], by_size[0], rel=1e-9, what="noise by size", why="the columns have 5 digits in common")
    # By chance the stretches vary by up to a fifth more than samples do.
    assert 1.0 <= by_size[0] / (squares[0] / 400.0) < 1.2


def test_share_of_friction_is_that_of_a_regression_beside_sensors() -> None:
    """With the error of a jackknife of ten stretches, whatever a sensor's offset and the units of its column are."""
    rng = np.random.default_rng(8)
    factor, offset = np.sign(rng.standard_normal(200)), np.full(200, 1e-4)
    residuals = 0.1 * factor + 2.0 + 0.3 * rng.standard_normal(200)
    blocks = np.repeat(np.arange(10), 20)
    free = [SimpleNamespace(name=name) for name in (FC, "offset.force")]
    problem: Any = SimpleNamespace(blocks=lambda stretches: blocks, free=free)
    told = Left({}, np.ones(200), residuals, np.column_stack([factor, offset]), np.zeros((200, 0)))
    rows = np.column_stack([factor, np.ones(200)])
    whole = np.linalg.lstsq(rows, residuals)[0][0]
    without = np.array([np.linalg.lstsq(rows[blocks != k], residuals[blocks != k])[0][0] for k in range(10)])
    share, half = _measured(problem, told, factor)
    assert_close(share, whole, rel=1e-9, what="share", why="normal equations lose digits")
    error = student.ppf(0.975, 9) * np.sqrt(0.9 * np.sum((without - whole) ** 2))
    assert_close(half, error, rel=1e-9, what="half interval", why="normal equations lose digits")


@pytest.mark.parametrize("law_error", [0.05, 0.2])
def test_single_other_condition_tells_nothing_of_how_far_the_law_is_off(law_error: float) -> None:
    """Both are off by N(0, tau^2) with tau of |N(0, law_error^2)|: by sqrt(2) times a product of two normal numbers.

    The density of that product is K0(|z|)/pi.
    """
    rng = np.random.default_rng(9)
    slopes = 100.0 * np.ones((400, 1))
    told = Left({}, np.ones(400), 0.01 * rng.standard_normal(400), slopes, np.zeros((400, 0)))
    middle, low, high, spread = _foretold(told, slopes, np.arange(400) // 20, np.ones(1), [], law_error)
    end = brentq(lambda z: quad(k0, 0.0, z)[0] / np.pi - 0.475, 0.1, 10.0)
    expected = np.sqrt(2.0) * law_error * end
    # A tau below 1e-3 is not looked at, which is 2 % of them at most.
    assert_close([low, high], np.array([-expected, expected]), rel=0.01, what="ends")
    assert_close(middle, 0.0, within=1.5e-5, what="middle")
    assert np.isnan(spread)


def test_conditions_tell_how_far_the_law_is_off() -> None:
    """Of many, whose friction differs by 5 %: the spread is theirs, and the next one is off by it and by their mean."""
    rng, number = np.random.default_rng(10), 100
    off = 0.05 * rng.standard_normal(number)
    places = np.repeat(np.arange(number), 10)
    slopes = 100.0 * np.ones((10 * number, 1))
    residuals = 100.0 * off[places] + 0.01 * rng.standard_normal(10 * number)
    told = Left({}, np.ones(10 * number), residuals, slopes, np.zeros((10 * number, 0)))
    factors = np.where(places[:, None] == np.arange(number), 100.0, 0.0)
    middle, low, high, spread = _foretold(told, factors, places, np.ones(1), [], 0.2)
    deviation = np.std(off, ddof=1)
    assert_close(spread, deviation, rel=0.06, what="spread", why="the grid of spreads is 6 % wide")
    assert_close(middle, np.mean(off), within=5e-5, what="middle")
    half = student.ppf(0.975, number - 1) * deviation * np.sqrt(1.0 + 1.0 / number)
    assert_close([middle - low, high - middle], half, rel=0.02, what="halves")

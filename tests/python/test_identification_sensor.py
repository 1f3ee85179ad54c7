"""Sensors of a fit: noise, and converters that round."""

from __future__ import annotations

import numpy as np
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification.sensor import Sensor, converter
from scipy.optimize import brentq
from scipy.stats import norm

Array = NDArray[np.float64]
STEP = 0.5 / 4095


def rounded(values: Array, step: float = STEP) -> Array:
    return step * np.round(values / step)


def test_step_of_a_converter_is_found_through_decimals_and_none_where_there_is_none() -> None:
    rng = np.random.default_rng(0)
    smooth = 0.25 + 0.05 * np.sin(np.arange(0.0, 6.0, 1e-3)) + 1e-5 * rng.standard_normal(6000)
    assert_close(converter(rounded(smooth)), STEP, rel=1e-14, what="step")
    # A table with three decimals of a millimetre.
    assert_close(converter(np.round(rounded(smooth), 6)), STEP, rel=9e-6, what="step through decimals")
    assert converter(smooth) == 0.0
    assert converter(np.full(100, 0.3)) == 0.0


def test_densities_are_those_of_the_noise() -> None:
    """The normal density without a converter; with one P over a step, which under much noise is the same."""
    differences = np.linspace(-3.0, 3.0, 13) * 1e-4
    expected = norm.logpdf(differences, scale=1e-4)
    assert_close(Sensor(1e-4).log_density(differences), expected, rel=1e-14, what="log of the density")
    step = 1e-6
    found = Sensor(1e-4, step, is_coarse=True).log_density(differences)
    # The mean over a step differs from the middle by the curvature, (step / noise)^2 / 24 times at most 9 - 1.
    assert_close(found, expected, within=9.0 * 1e-4 / 24.0, what="log density over a step")


@pytest.mark.parametrize("noise", [0.08, 0.4, 1.3])
def test_slopes_are_those_of_the_residuals(noise: float) -> None:
    sensor = Sensor(noise * STEP, STEP, is_coarse=True)
    # From the middle of a step to five steps away, where the likelihood is far below the smallest number.
    differences = np.linspace(-5.0, 5.0, 401) * STEP
    by = 1e-5 * STEP
    quotient = (sensor.residuals(differences + by) - sensor.residuals(differences - by)) / (2.0 * by)
    # Rounding of the likelihood, 1e-16, comes to 1e-8 in its root where that vanishes.
    assert_close(sensor.slopes(differences), quotient, rel=5e-5, within=5e-5 / STEP, what="slopes")


@pytest.mark.parametrize("noise", [0.08, 0.4, 1.3])
def test_true_readings_tell_nothing_on_average_and_as_much_as_is_expected(noise: float) -> None:
    rng = np.random.default_rng(1)
    true = rng.uniform(0.0, 20.0 * STEP, 200_000)
    sensor = Sensor(noise * STEP, STEP, is_coarse=True)
    differences = rounded(true + noise * STEP * rng.standard_normal(len(true))) - true
    weights = sensor.weights(differences)
    told = weights * sensor.scores(differences)
    # Four standard deviations of means of this number.
    assert abs(np.mean(told)) < 4.0 * np.std(told) / np.sqrt(len(told))
    assert np.mean(told**2) == pytest.approx(np.mean(weights**2), abs=4.0 * np.std(told**2) / np.sqrt(len(told)))


def test_noise_is_found_below_the_step_that_hides_it() -> None:
    rng = np.random.default_rng(2)
    true = np.linspace(0.0, 0.01, 3000)
    differences = rounded(true + 0.08 * STEP * rng.standard_normal(len(true))) - true
    found = Sensor(STEP, STEP).with_noise_of(differences)
    assert found.is_coarse
    assert_close(found.noise, 0.08 * STEP, rel=0.1, what="noise below the step")
    fine = Sensor(STEP, STEP).with_noise_of(30.0 * STEP * rng.standard_normal(3000))
    assert not fine.is_coarse
    assert_close(fine.noise, 30.0 * STEP, rel=0.08, what="noise above the step")


def test_speed_of_a_slow_carriage_is_found_without_the_bias_of_rounding() -> None:
    """Half a step in a second: least squares of readings that are nearly all the same err, always by the same."""
    time = np.arange(0.0, 1.0, 1e-3)
    sensor = Sensor(0.08 * STEP, STEP, is_coarse=True)
    plain, ours = [], []
    for seed in range(20):
        noise = 0.08 * STEP * np.random.default_rng(seed).standard_normal(len(time))
        seen = rounded(0.3 * STEP + 0.5 * STEP * time + noise)
        plain.append(float(time @ (seen - 0.3 * STEP) / (time @ time)))
        ours.append(brentq(lambda speed, seen=seen: np.sum(
            sensor.residuals(seen - 0.3 * STEP - speed * time) * sensor.slopes(seen - 0.3 * STEP - speed * time) * time
        ), 0.1 * STEP, 2.0 * STEP))  # fmt: skip
    spread = float(np.std(ours)) / np.sqrt(len(ours))
    assert abs(np.mean(ours) - 0.5 * STEP) < 4.0 * spread
    assert abs(np.mean(plain) - 0.5 * STEP) > 20.0 * spread


@pytest.mark.parametrize("noise", [0.3, 1.5])
def test_coarse_readings_are_as_likely_as_their_ranges(noise: float) -> None:
    """By the distribution of SciPy, where its difference has digits; beyond, by the end that is next."""
    size = noise * STEP
    sensor = Sensor(size, STEP, is_coarse=True)

    def likelihood(differences: Array) -> Array:
        return np.asarray(norm.cdf((differences + 0.5 * STEP) / size) - norm.cdf((differences - 0.5 * STEP) / size))

    differences = np.linspace(-1.3, 1.3, 27) * STEP
    expected = likelihood(differences)
    assert_close(sensor.log_density(differences), np.log(expected / STEP), within=1.5e-13, what="log of the density")
    residuals = sensor.residuals(differences)
    assert np.array_equal(np.sign(residuals), np.sign(differences))
    lack = np.log(likelihood(np.zeros(1)) / expected)
    assert_close(0.5 * residuals**2, lack, within=9e-14, what="half squares")
    # Far out only the nearer end of the range tells.
    far = np.array([-80.0, 80.0]) * STEP
    tail = norm.logsf((np.abs(far) - 0.5 * STEP) / size) - np.log(likelihood(np.zeros(1)))
    assert_close(sensor.residuals(far), np.sign(far) * np.sqrt(-2.0 * tail), rel=1e-14, what="residuals far out")
    # Expected information of readings: the mean square of the derivative of their log likelihood.
    readings, by = STEP * np.arange(-30, 31), 1e-4 * STEP
    told = []
    for off in differences:
        near = off - STEP * np.round(off / STEP) + readings
        chances = likelihood(near)
        slopes = (likelihood(near + by) - likelihood(near - by)) / (2.0 * by)
        told.append(np.sqrt(np.sum(slopes[chances > 0.0] ** 2 / chances[chances > 0.0])))
    assert_close(sensor.weights(differences), np.array(told), rel=1.5e-7, what="weights")


def test_sensor_is_told_by_its_readings() -> None:
    """By the median noise of its courses, which is no less than a billionth of what it reads."""
    rng = np.random.default_rng(4)
    slow = np.sin(np.linspace(0.0, 1.0, 4000))
    courses = [slow + size * rng.standard_normal(4000) for size in (1e-3, 2e-3, 50.0)]
    found = Sensor.of(courses)
    assert_close(found.noise, 2e-3, rel=0.1, what="noise")
    assert found.step == 0.0 and not found.is_coarse
    assert_close(Sensor.of([np.full(100, -2000.0)]).noise, 2e-6, rel=1e-14, what="least noise")
    assert Sensor.of([np.zeros(100)]) == Sensor(1e-12)
    assert_close(Sensor.of([rounded(slow, 1e-3)]).step, 1e-3, rel=1e-14, what="step")


def test_fine_sensor_divides_by_its_noise() -> None:
    sensor, differences = Sensor(0.5), np.array([-1.0, 0.0, 2.0])
    assert sensor.residuals(differences).tolist() == sensor.scores(differences).tolist() == [-2.0, 0.0, 4.0]
    assert sensor.slopes(differences).tolist() == sensor.weights(differences).tolist() == [2.0] * 3
    # From two steps on noise hides a converter.
    fine = Sensor(1.0, 0.25).with_noise_of(np.array([0.5, -0.5]))
    assert fine == Sensor(0.5, 0.25) and Sensor(1.0, 0.2501).with_noise_of(np.array([0.5, -0.5])).is_coarse
    assert Sensor(1.0).with_noise_of(np.zeros(3)) == Sensor(1e-12)

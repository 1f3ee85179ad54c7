"""Numbers of a fit against closed forms: Coulomb and viscous friction on a known path are a linear regression.

The quantiles come from printed tables of Student's distribution, two-sided at 95 %.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification.intervals import Linearised, covariance, linearised
from pneumatic_servo.identification.residuals import Residuals
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.solve import sensitivities
from test_identification import RIG, RIG_COLUMNS

Array = NDArray[np.float64]

FREE = ["friction.coulomb.Fc", "friction.coulomb.sigma2"]
TRUE = np.array([7.0, 25.0])
NOISE = 0.05
STUDENT = {2: 4.3027, 3: 3.1824, 10: 2.2281, 19: 2.0930, 997: 1.9624}
"""By degrees of freedom."""


def path() -> tuple[Array, Array]:
    """Times and positions."""
    time = np.arange(0.0, 10.0, 0.01)
    return time, 0.02 * np.sin(2.0 * np.pi * 0.3 * time) + 0.004 * np.sin(2.0 * np.pi * 1.1 * time)


def regressors() -> Array:
    """Factors of Fc and sigma2; the first sample, before which nothing is known, is not compared."""
    time, position = path()
    speed = np.diff(position) / np.diff(time)
    return np.column_stack([np.sign(speed), speed])


def measured(errors: Array) -> dict[str, Array]:
    time, position = path()
    force = np.append(0.0, regressors() @ TRUE + errors)
    return {"time": time, "position": position, "frictionForce": force}


def white(seed: int, scale: float = NOISE) -> Array:
    return scale * np.random.default_rng(seed).standard_normal(len(regressors()))


def drifting(seed: int) -> Array:
    """Errors that are autocorrelated for some tenths of a second."""
    rng = np.random.default_rng(seed)
    return np.convolve(white(seed), np.ones(40) / np.sqrt(40.0), mode="same") + 1e-3 * rng.standard_normal(999)


def fitted(data: dict[str, Array] | list[dict[str, Array]], **options: object) -> ps.Fit:
    return ps.fit(data, experiment="motion", law="Coulomb", fit=FREE, play=0.0, starts=0, **options)  # type: ignore[arg-type]


def refits(matrix: Array, force: Array, groups: Array) -> Iterator[Array]:
    """The least-squares solutions without one group after the other."""
    for group in np.unique(groups):
        yield np.linalg.lstsq(matrix[groups != group], force[groups != group], rcond=None)[0]


def jackknife(matrix: Array, force: Array, groups: Array) -> Array:
    """The deviations that show in the refits."""
    whole = np.linalg.lstsq(matrix, force, rcond=None)[0]
    moves = np.array(list(refits(matrix, force, groups))) - whole
    return np.sqrt(np.sum(moves**2, axis=0) * (len(moves) - 1) / len(moves))


def regression(matrix: Array, force: Array) -> tuple[Array, Array, Array]:
    """Solution, deviations by the noise that remains, and correlation."""
    found, squares, *_ = np.linalg.lstsq(matrix, force, rcond=None)
    spread = squares[0] / len(force) * np.linalg.inv(matrix.T @ matrix)
    deviation = np.sqrt(np.diag(spread))
    return found, deviation, spread / np.outer(deviation, deviation)


def halves(found: ps.Fit) -> Array:
    """Half intervals in SI units; the logarithm of Fc is what is free."""
    level, viscous = (found.parameters[name] for name in FREE)
    assert_close(level.high / level.value, level.value / level.low, rel=1e-14, what="symmetry of the logarithm")
    rounding = "the ends, of 30 N.s/m, are rounded"
    assert_close(viscous.high - viscous.value, viscous.value - viscous.low, within=2e-14, what="symmetry", why=rounding)
    return np.array([level.value * np.log(level.high / level.value), viscous.high - viscous.value])


BLOCKS = np.arange(999) // 50
"""Twenty stretches of time."""


@pytest.mark.parametrize(("errors", "is_white"), [(white(1), True), (drifting(2), False)])
def test_intervals_are_those_of_linear_regression(errors: Array, is_white: bool) -> None:
    data = measured(errors)
    found = fitted(data)
    matrix, force = regressors(), data["frictionForce"][1:]
    solution, deviation, correlation = regression(matrix, force)
    assert_close([found.values[name] for name in FREE], solution, rel=2e-9, what="values")
    alone, together = STUDENT[997] * deviation, STUDENT[19] * jackknife(matrix, force, BLOCKS)
    assert np.all(alone > together) if is_white else np.all(together > 2.0 * alone), "each of both ways is met"
    assert_close(halves(found), np.maximum(alone, together), rel=1e-4, what="half intervals")
    assert_close(found.certainty.correlation, correlation, within=2e-12, what="correlation")


def test_records_that_disagree_widen_the_intervals() -> None:
    """Four records whose Fc differs by twenty times what the noise makes of it."""
    shifts = [-0.05, 0.02, 0.06, -0.03]
    data = [measured(white(seed) + shift * regressors()[:, 0]) for seed, shift in enumerate(shifts)]
    found = fitted(data)
    matrix = np.tile(regressors(), (4, 1))
    force = np.concatenate([one["frictionForce"][1:] for one in data])
    deviation = jackknife(matrix, force, np.repeat(np.arange(4), 999))
    assert_close(halves(found)[0], STUDENT[3] * deviation[0], rel=1e-4, what="half interval of Fc")


def test_deviation_of_a_mean_is_that_of_textbooks() -> None:
    """With one unknown all three ways are ``s/sqrt(n)``, with n groups of a sample each for the jackknife."""
    scores = np.array([1.2, -0.7, 0.4, -1.9, 0.3, 0.9, -0.2, 1.1, -1.4, 0.8, -0.5])
    count = len(scores)
    ones, none = np.ones((count, 1)), np.zeros(count, dtype=np.int64)
    spread, factors = covariance(Linearised(ones, scores, none, none))
    # By themselves they are believed to have variance 1.
    assert_close(spread[0, 0], 1.0 / count, rel=1e-14, what="variance")
    assert_close(factors[0], STUDENT[10], rel=1e-4, what="quantile", why="the table has five digits")
    centred = 3.0 * (scores - scores.mean())
    spread, factors = covariance(Linearised(ones, centred, np.arange(count), none))
    assert_close(spread[0, 0], centred.var(ddof=1) / count, rel=1e-14, what="variance by blocks")
    assert_close(factors[0], STUDENT[10], rel=1e-4, what="quantile by blocks", why="the table has five digits")
    of_three = np.arange(count) % 3
    _, factors = covariance(Linearised(ones, 30.0 * (of_three - 1.0), none, of_three))
    assert_close(factors[0], STUDENT[2], rel=1e-4, what="quantile by records", why="the table has five digits")


def test_profile_of_a_parabola_ends_where_the_interval_does() -> None:
    data = measured(white(1))
    plain, profile = halves(fitted(data)), halves_of_profile(fitted(data, intervals="profile"))
    # Six halvings find an end to a sixty-fourth.
    assert_close(profile, plain, rel=1.0 / 64.0 + 1e-3, what="half intervals")


def halves_of_profile(found: ps.Fit) -> Array:
    level, viscous = (found.parameters[name] for name in FREE)
    return np.array([0.5 * level.value * np.log(level.high / level.low), 0.5 * (viscous.high - viscous.low)])


@pytest.mark.parametrize(("groups", "is_wider"), [(2, False), (3, True)])
def test_blocks_of_time_count_from_two_more_than_parameters_on(groups: int, is_wider: bool) -> None:
    """The mean of blocks that do not agree: without the block of the mean m it moves by m / (groups - 1)."""
    each = 50
    blocks = np.repeat(np.arange(groups), each)
    means = np.linspace(-3.0, 3.0, groups)
    number = groups * each
    spread, factors = covariance(Linearised(np.ones((number, 1)), means[blocks], blocks, np.zeros(number, dtype=int)))
    if is_wider:
        moves = means / (groups - 1)
        expected = STUDENT[2] * np.sqrt((groups - 1) / groups * np.sum(moves**2))
    else:
        # Of 99 degrees of freedom, by the printed table.
        expected = 1.9842 / np.sqrt(number)
    assert_close(factors[0] * np.sqrt(spread[0, 0]), expected, rel=2e-5, what="half", why="digits of the table")


def test_bootstrap_has_the_quantiles_of_refits_to_drawn_blocks() -> None:
    data = measured(white(3))
    found = fitted(data)
    number = 5000
    low, high, *_ = found.problem.native.certainty(found.x, "bootstrap", 4, number)
    matrix, force = regressors(), data["frictionForce"][1:]
    parts = [(matrix[block == BLOCKS], force[block == BLOCKS]) for block in range(20)]
    squares = np.array([rows.T @ rows for rows, _ in parts])
    slopes = np.array([rows.T @ values for rows, values in parts])
    drawn = np.random.default_rng(5).integers(0, 20, (number, 20))
    refits = np.linalg.solve(squares[drawn].sum(axis=1), slopes[drawn].sum(axis=1)[..., None])[..., 0]
    ends = np.quantile(refits, [0.025, 0.975], axis=0)
    for column, free in enumerate(found.problem.free):
        # This number of samples gives an end to 1 % of the width; two such ends are compared.
        width = ends[1, column] - ends[0, column]
        assert_close(low[column], ends[0, column], within=0.04 * width, what=f"low {free.name}")
        assert_close(high[column], ends[1, column], within=0.04 * width, what=f"high {free.name}")


def test_beginnings_of_windows_widen_the_intervals_as_they_do_in_the_whole_problem() -> None:
    """The covariance of the parameters is their block of the covariance of parameters and start values."""
    found = ps.fit(RIG, experiment="pneumatic", law="None", fit=["valve.deadZone", "valve.C"], columns=RIG_COLUMNS,
                   settings={"supplyPressure": 6e5}, starts=0, segment=0.6)  # fmt: skip
    problem = found.problem
    begins = sum(problem.loose)
    assert begins == 2 * len(problem.windows) > 2
    x = np.append(found.x, np.zeros(begins))
    slopes, differences = sensitivities(problem, x)
    whole = slopes * problem.by_sensor(Sensor.weights, differences)[:, None]
    joint = np.linalg.inv(whole.T @ whole)[:2, :2]
    alone = np.linalg.inv(whole[:, :2].T @ whole[:, :2])
    assert np.all(np.diag(joint) > 1.01 * np.diag(alone)), "the beginnings matter"
    assert_close(linearised(problem, x).white, joint, rel=1e-9, what="covariance", why="rounding of inverses")


def test_akaike_is_that_of_the_regression() -> None:
    """``n ln(RSS/n) + 2 k``."""
    data = measured(white(6))
    found = fitted(data)
    _, squares, *_ = np.linalg.lstsq(regressors(), data["frictionForce"][1:], rcond=None)
    assert_close(found.aic, 999 * np.log(squares[0] / 999) + 2 * 2, within=4e-7, what="AIC")


def test_akaike_adds_up_over_the_signals() -> None:
    found = ps.fit(RIG, experiment="pneumatic", law="None", fit=["valve.deadZone", "valve.C"], columns=RIG_COLUMNS,
                   settings={"supplyPressure": 6e5}, starts=0)  # fmt: skip
    left = Residuals(found)
    assert left.signals == ("chamberA.pressure", "chamberB.pressure")
    terms = [len(rest) * np.log(np.mean(rest**2)) for rest in map(left.all, left.signals)]
    assert_close(found.aic, sum(terms) + 2 * 2, rel=1e-14, what="AIC")

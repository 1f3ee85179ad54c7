"""The statistics behind intervals and verdicts, on numbers of which the answer is known in closed form."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import arviz
import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification.condition_prediction import (
    SegmentResiduals,
    _likelihood,
    _measured,
    _noise,
    _predicted,
    _quantile,
    _Seen,
)
from pneumatic_servo.identification.evidence import evidence
from pneumatic_servo.identification.recorder import LONG, clipped
from pneumatic_servo.identification.sampling import FREEDOM, Proposal, _r_hat
from scipy.linalg import null_space
from scipy.stats import multivariate_normal, multivariate_t, norm
from scipy.stats import t as student

Array = NDArray[np.float64]


def left(residuals: Array, derivatives: Array) -> SegmentResiduals:
    """Residuals of windows, in units of the noise."""
    return SegmentResiduals({}, np.ones(len(residuals)), residuals, derivatives, np.zeros((len(residuals), 0)))


@pytest.mark.parametrize("level", [0.025, 0.5, 0.975])
def test_quantile_of_a_mixture_has_the_level_below_it(level: float) -> None:
    shares, means, deviations = np.array([0.3, 0.7]), np.array([-1.0, 2.0]), np.array([0.5, 0.1])
    found = _quantile(shares, means, deviations, level)
    assert_close(shares @ norm(means, deviations).cdf(found), level, within=1e-14, what="level")


def test_information_of_conditions_is_that_of_weighted_least_squares() -> None:
    """Of two conditions with an error of their own each; nothing else is known of the parameters."""
    rng = np.random.default_rng(2)
    slopes, residuals = rng.standard_normal((2, 3, 2)), rng.standard_normal((2, 3))
    seen = [_Seen(residuals[k], slopes[k], size) for k, size in enumerate((4.0, 25.0))]
    rows, noise = slopes.reshape(6, 2), 0.5
    # Residuals that the parameters cannot change have the likelihood of the remainder.
    beside = null_space(rows.T)
    differences = []
    for tau in (0.1, 0.3):
        whole, right, likely = _likelihood(seen, tau, noise)
        variances = np.repeat([tau**2 * 4.0 + noise, tau**2 * 25.0 + noise], 3)
        weighted = np.linalg.lstsq(rows / np.sqrt(variances)[:, None], residuals.ravel() / np.sqrt(variances))[0]
        # The least that is known beforehand, 1e-9, moves them by as much.
        assert_close(np.linalg.solve(whole, right), weighted, within=1e-8, what="parameters", why="bound by design")
        spread = beside.T @ np.diag(variances) @ beside
        density = multivariate_normal(np.zeros(4), spread).logpdf(beside.T @ residuals.ravel())
        differences.append(likely - float(density))
    # But for a constant.
    assert_close(differences[1], differences[0], within=1e-9, what="logarithm of the likelihood")


def test_residuals_that_hang_together_count_as_fewer() -> None:
    """In pairs they double the variance of a mean; where neighbours cancel, it is no less than for white noise."""
    columns, blocks = np.ones((8, 1)), np.repeat(np.arange(4), 2)
    pairs, turns = np.array([1.0, 1.0, -1.0, -1.0] * 2), np.array([1.0, -1.0] * 4)
    assert_close(_noise(columns, pairs, blocks), 2.0, rel=1e-14, what="in pairs")
    assert_close(_noise(columns, turns + 5.0, blocks), 1.0, rel=1e-14, what="in turns")


def test_friction_is_measured_with_the_error_of_a_mean_of_stretches() -> None:
    """With friction of 1 everywhere, its share is the mean, and omitted stretches give the error of their means."""
    residuals = np.random.default_rng(3).standard_normal(40)
    blocks = np.repeat(np.arange(10), 4)
    problem: Any = SimpleNamespace(blocks=lambda stretches: blocks // (10 // stretches), free=[])
    share, half = _measured(problem, left(residuals, np.zeros((40, 0))), np.ones(40))
    means = residuals.reshape(10, 4).mean(axis=1)
    assert_close(share, np.mean(residuals), rel=1e-14, what="share")
    error = student.ppf(0.975, 9) * np.std(means, ddof=1) / np.sqrt(10.0)
    assert_close(half, error, rel=1e-14, what="half interval")
    # Two stretches are enough for one degree of freedom.
    halves: Any = SimpleNamespace(blocks=lambda stretches: np.repeat([0, 1], 20), free=[])
    _, half = _measured(halves, left(residuals, np.zeros((40, 0))), np.ones(40))
    apart = np.mean(residuals[:20]) - np.mean(residuals[20:])
    assert_close(half, student.ppf(0.975, 1) * abs(apart) / 2.0, rel=1e-14, what="half interval of two")
    alone: Any = SimpleNamespace(blocks=lambda stretches: np.zeros(40, dtype=int), free=[])
    assert _measured(alone, left(residuals, np.zeros((40, 0))), np.ones(40))[1] == np.inf


@pytest.mark.parametrize(("apart", "is_distinguished"), [(1e-5, True), (0.1, False)])
def test_error_of_a_law_is_distinguished_only_by_conditions_that_it_cannot_follow(
    apart: float, is_distinguished: bool
) -> None:
    """Two parameters follow two conditions, if they do not change both alike but for a part in 100 000."""
    rng = np.random.default_rng(4)
    slopes = np.column_stack([np.ones(200), np.repeat([0.0, apart], 100)])
    factors = np.column_stack([np.repeat([1.0, 0.0], 100), np.repeat([0.0, 1.0], 100)])
    stretches = np.repeat(np.arange(20), 10)
    found = left(0.01 * rng.standard_normal(200), slopes)
    *_, spread = _predicted(found, factors, stretches, np.array([1.0, 0.0]), [], 0.2)
    assert bool(np.isfinite(spread)) is is_distinguished


def preferred(differences: Array, monkeypatch: pytest.MonkeyPatch) -> ps.identification.evidence.Evidence:
    """Evidence between two laws whose predictions of each stretch differ by given amounts."""
    predicted = [np.zeros_like(differences), -differences]
    monkeypatch.setattr(
        "pneumatic_servo.identification.evidence._left_out", lambda fit, *_: (predicted[fit.place], np.zeros(1))
    )
    fits: Any = [SimpleNamespace(law=law, place=place, rms={"position": 1.0}) for place, law in enumerate("AB")]
    return evidence(fits)


@pytest.mark.parametrize(("mean", "is_distinguished"), [(2.6, False), (2.8, True)])
def test_laws_are_told_apart_by_the_t_of_their_stretches(
    mean: float, is_distinguished: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Five stretches, so that 95 % are 2.776 errors of the mean, where four were 3.18, and six 2.57."""
    about = np.array([-2.0, -1.0, 0.0, 1.0, 2.0]) * np.sqrt(2.0)
    _, second = preferred(about + mean, monkeypatch).laws
    # Their sum has the root of five times the deviation of one, which is the root of five.
    assert_close(second.error, 5.0, rel=1e-14, what="error")
    assert_close(second.difference, 5.0 * mean, rel=1e-14, what="difference")
    assert second.is_distinguished is is_distinguished


@pytest.mark.parametrize(("difference", "is_distinguished"), [(3.9, False), (4.1, True)])
def test_small_difference_is_none_however_sure_it_is(
    difference: float, is_distinguished: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert preferred(np.full(10, 0.1 * difference), monkeypatch).laws[1].is_distinguished is is_distinguished


def test_chains_have_the_r_hat_of_arviz() -> None:
    """Of chains with a trend, whose halves differ."""
    rng = np.random.default_rng(5)
    chains = rng.standard_normal((3, 100)) + np.linspace(0.0, 1.0, 100) + 0.3 * np.arange(3)[:, None]
    assert_close(_r_hat(chains), float(arviz.rhat(chains, method="split")), rel=1e-14, what="R-hat")
    assert _r_hat(np.ones((2, 10))) == np.inf


def test_proposals_are_weighed_by_the_t_that_they_come_from() -> None:
    middle, scatter = np.array([1.0, -2.0]), np.array([[2.0, 0.0], [0.5, 0.1]])
    places = np.array([[1.5, -1.8], [0.0, -2.5], [1.0, -2.0]])
    proposed, correction = Proposal(middle, scatter)(places, np.random.RandomState(1))
    density = multivariate_t(middle, scatter @ scatter.T, df=FREEDOM).logpdf
    assert proposed.shape == (3, 2) and len(np.unique(proposed)) == 6
    assert_close(correction, density(places) - density(proposed), within=2e-14, what="correction")


@pytest.mark.parametrize(("stays", "is_clipped"), [(LONG - 1, False), (LONG, True)])
def test_signal_is_clipped_from_eight_readings_at_its_end(stays: int, is_clipped: bool) -> None:
    noisy = np.random.default_rng(6).uniform(-1.0, 1.0, 100)
    noisy[40 : 40 + stays] = 2.0
    assert list(clipped(noisy)) == [(2.0, stays)] * is_clipped

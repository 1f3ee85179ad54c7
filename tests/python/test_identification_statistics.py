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
from pneumatic_servo.identification.evidence import evidence
from pneumatic_servo.identification.sampling import FREEDOM, Proposal, _r_hat
from scipy.stats import multivariate_t
from shared import faults

Array = NDArray[np.float64]


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


@pytest.mark.parametrize(("stays", "is_clipped"), [(7, False), (8, True)])
def test_signal_is_clipped_from_eight_readings_at_its_end(stays: int, is_clipped: bool) -> None:
    noisy = np.random.default_rng(6).uniform(-1.0, 1.0, 100)
    noisy[40 : 40 + stays] = 2.0
    assert [f"stays at 2 Pa, the end of what it reads, for {stays} samples" in text
            for text in faults(chamberA__pressure=noisy)] == [True] * is_clipped  # fmt: skip

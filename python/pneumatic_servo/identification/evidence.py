"""Evidence of the data for several laws, and whether it distinguishes them.

The expected log predictive density (elpd) of each law is found by leaving out one stretch of time after the other, not
one sample, since neighbouring samples tell much the same. None is fitted anew: draws about the solution are weighted as
if the stretch had not been seen, and the largest weights are smoothed by a Pareto distribution (A. Vehtari, A. Gelman
and J. Gabry, "Practical Bayesian model evaluation using leave-one-out cross-validation and WAIC", Statistics and
Computing, 2017). Draws are from a Student t about the solution, weighted to the posterior (M. Magnusson et al.,
"Bayesian leave-one-out cross-validation for large data", ICML, 2019). What windows begin with is kept as it was fitted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp
from scipy.stats import t as student

from pneumatic_servo.checks import whole_number
from pneumatic_servo.files import write_csv
from pneumatic_servo.identification.compression import triangle
from pneumatic_servo.identification.intervals import LEVEL, RANK
from pneumatic_servo.identification.posterior import arviz_of
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.result import Fit
from pneumatic_servo.identification.sampling import Proposal
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.solve import jacobian
from pneumatic_servo.names import tell_renamed

Array = NDArray[np.float64]

BLOCKS = 20
"""Blocks of time that count as independent."""
CHUNK = 50
"""Draws that are simulated at once."""
FEWEST_BLOCKS = 5
"""The fewest segments for a standard error."""
DOUBTFUL = 0.7
"""Shapes of the Pareto distribution above which a segment has too much influence for the weights."""
SMALL = 4.0
"""Differences of the elpd below this are small, however sure they are."""
COLUMNS = ["law", "elpd", "difference", "standard error", "distinguished from the first", "largest k-hat"]


@dataclass(frozen=True)
class Preference:
    """Evidence of the data for one law.

    Attributes
    ----------
    law : str
        The law.
    elpd : float
        Expected log predictive density: sum over the segments of the log density of their data, predicted from the
        others.
    difference, error : float
        Difference of the elpd from that of the first law, and its standard error, from the scatter among segments.
    is_distinguished : bool
        Whether the data distinguish the law from the first: by more than the 95 % interval of the difference, and by
        more than 4.
    shapes : ndarray of shape (segments,)
        Shapes k of the Pareto distributions; above 0.7 the elpd of the segment is unreliable.
    """

    law: str
    elpd: float
    difference: float
    error: float
    is_distinguished: bool
    shapes: Array

    @property
    def is_told(self) -> bool:
        """The earlier name of `is_distinguished`."""
        tell_renamed("is_told", "is_distinguished")
        return self.is_distinguished


@dataclass(frozen=True)
class Evidence:
    """Evidence of the data for several laws, the best predicting first.

    Examples
    --------
    >>> import numpy as np
    >>> import pneumatic_servo as ps
    >>> t, rng = np.arange(0.0, 1.0, 0.02), np.random.default_rng(0)
    >>> data = {"time": t, "position": 0.01 * np.sin(6.0 * t),
    ...         "frictionForce": 7.0 * np.sign(np.cos(6.0 * t)) + 0.1 * rng.standard_normal(len(t))}
    >>> ranking = ps.compare_fits(data, ["Coulomb", "Dahl"], experiment="motion", starts=0, progress=False)
    >>> found = ranking.evidence(number=200)
    >>> found.laws[0].difference, found.laws[1].elpd <= found.laws[0].elpd
    (0.0, True)
    """

    laws: tuple[Preference, ...]

    @property
    def not_distinguished(self) -> tuple[str, ...]:
        """Laws that the data do not distinguish from the first."""
        return tuple(one.law for one in self.laws[1:] if not one.is_distinguished)

    @property
    def untold(self) -> tuple[str, ...]:
        """The earlier name of `not_distinguished`."""
        tell_renamed("untold", "not_distinguished")
        return self.not_distinguished

    @property
    def doubtful(self) -> dict[str, int]:
        """Numbers of segments with a shape above 0.7, by law; laws without any are omitted."""
        return {one.law: int(np.sum(one.shapes > DOUBTFUL)) for one in self.laws if np.any(one.shapes > DOUBTFUL)}

    def rows(self) -> list[tuple[str, float, float, float, bool, float]]:
        """Return the table; its columns are `COLUMNS`."""
        return [
            (one.law, one.elpd, one.difference, one.error, one.is_distinguished, float(np.max(one.shapes)))
            for one in self.laws
        ]

    def to_csv(self, file: str | Path) -> None:
        """Write the table."""
        write_csv(Path(file), COLUMNS, self.rows())

    def __repr__(self) -> str:
        lines = [f"{'law':20}{'elpd':>14}{'less by':>12}{'+-':>10}{'k-hat':>8}"]
        lines += [
            f"{law:20}{elpd:14.1f}{less:12.1f}{error:10.1f}{shape:8.2f}"
            for law, elpd, less, error, _, shape in self.rows()
        ]
        first = self.laws[0].law
        if self.not_distinguished:
            lines.append(f"the data do not distinguish {first} from {', '.join(self.not_distinguished)}")
        elif len(self.laws) > 1:
            lines.append(f"the data speak for {first}")
        lines += [
            f"the elpd of {law} is unreliable: {count} segments have too much influence; use validation data"
            for law, count in self.doubtful.items()
        ]
        return "\n".join(lines)


def evidence(fits: Sequence[Fit], number: int = 1000, seed: int = 0) -> Evidence:
    """Return the evidence of the data for fits to them; see `Ranking.evidence`."""
    psislw = arviz_of().psislw
    whole_number("number", number, least=100)
    whole_number("seed", seed, least=0)
    lost = next((found for found in fits if not np.all(np.isfinite(list(found.rms.values())))), None)
    if lost is not None:
        raise ValueError(f"{lost.law}: its fitted values cannot be simulated, so that it predicts nothing")
    found = [_left_out(one, number, seed, psislw) for one in fits]
    order = sorted(range(len(fits)), key=lambda place: -float(np.sum(found[place][0])))
    best = found[order[0]][0]
    factor = float(student.ppf(0.5 + 0.5 * LEVEL, len(best) - 1))
    laws = []
    for place in order:
        elpd, shapes = found[place]
        less = best - elpd
        error = float(np.sqrt(len(less)) * np.std(less, ddof=1))
        difference = float(np.sum(less))
        is_distinguished = difference > max(SMALL, factor * error)
        laws.append(Preference(fits[place].law, float(np.sum(elpd)), difference, error, is_distinguished, shapes))
    return Evidence(tuple(laws))


def _left_out(fit: Fit, number: int, seed: int, psislw: object) -> tuple[Array, Array]:
    """Return the elpd of each stretch when it is left out, and the shapes of the weights."""
    problem = fit.problem.trained()
    count = len(problem.free)
    labels = problem.blocks(BLOCKS)
    blocks = int(labels.max()) + 1
    if blocks < FEWEST_BLOCKS:
        raise ValueError(
            f"{blocks} stretches of time are too few to leave one out; at least {FEWEST_BLOCKS} are needed"
        )
    middle = fit.x[:count]
    slopes = jacobian(problem, np.concatenate([middle, np.zeros(sum(problem.loose))]))[:, :count]
    pull = np.diag(problem.pull[:count])
    scatter = np.asarray(np.linalg.pinv(triangle(np.vstack([slopes, pull])), rcond=RANK))
    proposal = Proposal(middle, scatter)
    vectors, correction = proposal(np.tile(middle, (number, 1)), np.random.RandomState(seed))
    low, high = (bound[:count] for bound in problem.bounds)
    inside = np.all((low <= vectors) & (vectors <= high), axis=1)
    vectors, correction = vectors[inside], correction[inside]
    densities = np.concatenate([
        _by_block(problem, vectors[first : first + CHUNK], labels, blocks) for first in range(0, len(vectors), CHUNK)
    ])  # fmt: skip
    alive = np.all(np.isfinite(densities), axis=1)
    densities = densities[alive]
    priors = np.array([-0.5 * float(np.sum(problem.pulls(x)[:count] ** 2)) for x in vectors[alive]])
    # The correction is, but for a constant, minus the logarithm of the density that was drawn from.
    whole = densities.sum(axis=1) + priors + correction[alive]
    weights, shapes = psislw((whole[:, None] - densities).T)  # type: ignore[operator]
    return np.asarray(logsumexp(np.asarray(weights) + densities.T, axis=1)), np.atleast_1d(np.asarray(shapes))


def _by_block(problem: Problem, vectors: Array, labels: NDArray[np.int64], blocks: int) -> Array:
    """Return the logarithm of the density of the measurements, of shape (vectors, blocks)."""
    rows = []
    for differences in problem.stacked(list(vectors)):
        each = problem.by_sensor(Sensor.log_density, differences)
        rows.append(np.bincount(labels, weights=each, minlength=blocks))
    return np.array(rows)

"""The sampler that draws from the posterior of a fit.

The likelihood counts the residuals in units of the noise. Priors are flat between the bounds, but for the weak
springs that a fit has, too. What windows begin with is integrated out, as the intervals do: along the derivatives at
the solution, since it errs by no more than the noise. Autocorrelated residuals tell less than their number: about
the solution each parameter is stretched as its interval is, as the curvature adjustment of a composite likelihood does
(M. Ribatet, D. Cooley and A. C. Davison, "Bayesian inference from composite likelihoods", Statistica Sinica, 2012).

The sampler is emcee (D. Foreman-Mackey et al., "emcee: The MCMC Hammer", PASP, 2013). Most moves propose from a
Student t about the solution, which follows the posterior closely; the others are its stretch moves, which know nothing
of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from pneumatic_servo.errors import MissingPackage
from pneumatic_servo.identification.compression import triangle
from pneumatic_servo.identification.intervals import LEVEL, RANK, covariance, linearised
from pneumatic_servo.identification.posterior import ENOUGH, Posterior
from pneumatic_servo.identification.problem import FAILED, Problem
from pneumatic_servo.identification.ranges import Ranges
from pneumatic_servo.identification.solve import jacobian
from pneumatic_servo.identification.watch import Watch
from pneumatic_servo.tasks import cancel

Array = NDArray[np.float64]

CHAINS_PER_PARAMETER, FEWEST_CHAINS = 4, 20
"""Walkers of the sampler: an even number of them, more than twice the parameters."""
BURN_IN = 50
"""Steps that are not kept."""
STEPS = 100
"""Steps between looks at how many of the draws count as independent."""
MOST_STEPS = 2000
"""Steps after which no more are made."""
FREEDOM = 5.0
"""Degrees of freedom of the proposal, a t distribution: its tails are heavier than the target's."""
SHARE = 0.8
"""Share of the moves that propose from it."""


def emcee_of() -> Any:
    """Return emcee, or say how to get it."""
    try:
        import emcee
    except ImportError as error:
        raise MissingPackage("emcee", "posterior") from error
    return emcee


@dataclass(frozen=True)
class Density:
    """The logarithm of the posterior of the free parameters; it can be sent to other processes.

    Attributes
    ----------
    problem : Problem
        Fitted problem.
    x : ndarray
        Its solution, with what windows begin with.
    stretch : ndarray of shape (parameters,)
        Ratio of each interval to the one for independent residuals.
    basis : ndarray of shape (samples, beginnings)
        Directions in which residuals move with what windows begin with.
    """

    problem: Problem
    x: Array
    stretch: Array
    basis: Array

    def __call__(self, vectors: Sequence[Array]) -> Array:
        """Return it for vectors of the free parameters."""
        count = len(self.stretch)
        low, high = (bound[:count] for bound in self.problem.bounds)
        found = np.full(len(vectors), -np.inf)
        inside = [index for index, x in enumerate(vectors) if np.all((low <= x) & (x <= high))]
        whole = []
        for index in inside:
            x = self.x.copy()
            x[:count] += (vectors[index] - self.x[:count]) / self.stretch
            whole.append(x)
        if not whole:
            return found
        for index, x, residuals in zip(inside, whole, self.problem.residuals(whole), strict=True):
            if np.any(np.abs(residuals) >= FAILED):
                continue
            along = self.basis.T @ residuals
            pulls = self.problem.pulls(x)[:count]
            found[index] = -0.5 * float(residuals @ residuals - along @ along + pulls @ pulls)
        return found


def density(problem: Problem, x: Array) -> tuple[Density, Array]:
    """Return the posterior about a solution, and the covariance that a normal one would have."""
    count = len(problem.free)
    spread, factors = covariance(linearised(problem, x))
    slopes = jacobian(problem, x)
    own, begins = slopes[:, :count], slopes[:, count:]
    basis = np.linalg.qr(begins)[0] if begins.shape[1] else begins
    rest = np.vstack([own - basis @ (basis.T @ own), np.diag(problem.pull[:count])])
    inverse = np.linalg.pinv(triangle(rest), rcond=RANK)
    white = inverse @ inverse.T
    # Relative to the ends of a normal distribution: intervals of few blocks come from a t distribution.
    ratios = np.diag(spread) / np.maximum(np.diag(white), 1e-300)
    stretch = np.maximum(np.sqrt(ratios) * factors / ndtri(0.5 + 0.5 * LEVEL), 1.0)
    return Density(problem, x, stretch, basis), white * np.outer(stretch, stretch)


def sample(problem: Problem, x: Array, seed: int, executor: Executor | None, watch: Watch) -> Posterior:
    """Draw from the posterior about a solution."""
    emcee = emcee_of()
    target, wide = density(problem, x)
    count = len(problem.free)
    own = x[:count]
    scatter = _root(wide)
    rng = np.random.RandomState(seed)
    chains = max(FEWEST_CHAINS, CHAINS_PER_PARAMETER * count)
    moves = [(emcee.moves.MHMove(Proposal(own, scatter)), SHARE), (emcee.moves.StretchMove(), 1.0 - SHARE)]
    ask = target if executor is None else _By(executor, target)
    sampler = emcee.EnsembleSampler(chains, count, ask, moves=moves, vectorize=True)
    first = _inside(problem, own + rng.standard_normal((chains, count)) @ scatter.T, own)
    state = emcee.State(first, random_state=rng.get_state())
    state = sampler.run_mcmc(state, BURN_IN)
    sampler.reset()
    made, effective = 0, np.zeros(count)
    while made < MOST_STEPS and np.min(effective) < ENOUGH:
        state = sampler.run_mcmc(state, STEPS)
        made += STEPS
        effective = made * chains / np.maximum(sampler.get_autocorr_time(quiet=True, tol=0), 1.0)
        watch.done(f"{made} steps of {chains} chains, {np.min(effective):.0f} draws count as independent")
    inner = np.swapaxes(sampler.get_chain(), 0, 1)
    draws = {
        free.name: np.exp(inner[..., k]) if free.is_logarithmic else inner[..., k] * free.scale
        for k, free in enumerate(problem.free)
    }
    names = list(draws)
    table = problem.experiment.table
    known = {name: value for name, value in problem.experiment.settings.items() if name in table.variables}
    return Posterior(
        draws, {free.name: free.unit for free in problem.free}, sampler.get_log_prob().T,
        dict(zip(names, effective.tolist(), strict=True)),
        {name: _r_hat(inner[..., k]) for k, name in enumerate(names)},
        float(np.mean(sampler.acceptance_fraction)), table.name, {"friction.law": problem.experiment.law, **known},
        Ranges.of(problem, x),
    )  # fmt: skip


@dataclass(frozen=True)
class Proposal:
    """Proposes from a t about the solution, independent of the present place.

    Attributes
    ----------
    middle : ndarray of shape (parameters,)
        The solution.
    scatter : ndarray of shape (parameters, parameters)
        Root of the covariance.
    """

    middle: Array
    scatter: Array

    def __call__(self, places: Array, rng: np.random.RandomState) -> tuple[Array, Array]:
        """Return as many places, and the logarithms of the density here over that there."""
        number, count = places.shape
        normal = rng.standard_normal((number, count))
        size = np.sqrt(FREEDOM / rng.chisquare(FREEDOM, number))
        proposed = self.middle + (size[:, None] * normal) @ self.scatter.T
        return proposed, self._log(places) - self._log(proposed)

    def _log(self, places: Array) -> Array:
        count = len(self.middle)
        normal = np.linalg.solve(self.scatter, (places - self.middle).T)
        return np.asarray(-0.5 * (FREEDOM + count) * np.log1p(np.sum(normal**2, axis=0) / FREEDOM))


class _By:
    """Lets an executor look at vectors, in as many pieces on each, so that the bits do not depend on it."""

    PIECES = 8

    def __init__(self, executor: Executor, target: Density) -> None:
        self._executor, self._target = executor, target

    def __call__(self, vectors: Array) -> Array:
        pieces = [piece for piece in np.array_split(vectors, self.PIECES) if len(piece)]
        tasks = [self._executor.submit(self._target, list(piece)) for piece in pieces]
        try:
            return np.concatenate([task.result() for task in tasks])
        finally:
            cancel(tasks)


def _root(matrix: Array) -> Array:
    """Return a root of a covariance; directions that the data do not tell are given one magnitude."""
    values, vectors = np.linalg.eigh(matrix)
    known = (values > 1e-16) & np.isfinite(values)
    return np.asarray(vectors * np.sqrt(np.where(known, values, 1.0)))


def _inside(problem: Problem, places: Array, middle: Array) -> Array:
    """Return starts within the bounds: those beyond are drawn half the way back until they are."""
    low, high = (bound[: len(middle)] for bound in problem.bounds)
    for _ in range(60):
        beyond = np.any((places < low) | (places > high), axis=1)
        if not np.any(beyond):
            break
        places[beyond] = middle + 0.5 * (places[beyond] - middle)
    return places


def _r_hat(chains: Array) -> float:
    """Return the R-hat of chains, of shape (chains, draws), each split into halves."""
    half = chains.shape[1] // 2
    parts = np.concatenate([chains[:, :half], chains[:, half : 2 * half]])
    within = float(np.mean(np.var(parts, axis=1, ddof=1)))
    between = float(np.var(np.mean(parts, axis=1), ddof=1))
    return float(np.sqrt((half - 1) / half + between / within)) if within > 0.0 else np.inf

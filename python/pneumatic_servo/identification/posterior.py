"""Draws from the posterior of a fit, and what they predict.

The likelihood is that of the residuals in units of the noise. Priors are flat between the bounds, but for the weak
springs that a fit has, too. What windows begin with is integrated out, as the intervals do: along the derivatives at
the solution, since it errs by no more than the noise. Residuals that hang together tell less than their number: about
the solution each parameter is stretched as its interval is, as the curvature adjustment of a composite likelihood does
(M. Ribatet, D. Cooley and A. C. Davison, "Bayesian inference from composite likelihoods", Statistica Sinica, 2012).

The sampler is emcee (D. Foreman-Mackey et al., "emcee: The MCMC Hammer", PASP, 2013). Most moves propose from a
Student t about the solution, which follows the posterior closely; the others are its stretch moves, which know nothing
of it.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.special import ndtri

from pneumatic_servo.checks import whole_number
from pneumatic_servo.errors import MissingPackage, warn
from pneumatic_servo.figures import BLUE, STYLE, WIDTH, Drawing
from pneumatic_servo.files import write_csv
from pneumatic_servo.identification.compression import triangle
from pneumatic_servo.identification.intervals import LEVEL, RANK, covariance, linearised
from pneumatic_servo.identification.problem import FAILED, Problem
from pneumatic_servo.identification.ranges import Ranges
from pneumatic_servo.identification.solve import jacobian
from pneumatic_servo.identification.watch import Watch
from pneumatic_servo.model import Model
from pneumatic_servo.run import Runs
from pneumatic_servo.tasks import cancel
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]

CHAINS_PER_PARAMETER, FEWEST_CHAINS = 4, 20
"""Walkers of the sampler: an even number of them, more than twice the parameters."""
BURN_IN = 50
"""Steps that are not kept."""
STEPS = 100
"""Steps between looks at how many of the draws count as independent."""
MOST_STEPS = 2000
"""Steps after which no more are made."""
ENOUGH = 1000.0
"""Independent draws of each parameter at which the sampler stops: they tell the ends of an interval to a tenth."""
FREEDOM = 5.0
"""Degrees of freedom of the t that is proposed from: tails heavier than those of what it follows."""
SHARE = 0.8
"""Share of the moves that propose from it."""
MIXED = 1.05
"""Chains whose R-hat is above this have not come to the same end."""


@dataclass(frozen=True)
class Posterior:
    """Draws from the posterior.

    Attributes
    ----------
    draws : dict
        Values of each free parameter in SI units, of shape (chains, draws).
    units : dict
        SI units.
    log_density : ndarray of shape (chains, draws)
        Logarithm of the posterior, but for a constant.
    effective : dict
        How many of the draws of each parameter count as independent.
    r_hat : dict
        Between-chain against within-chain spread of the split chains (A. Gelman et al., Bayesian Data Analysis, 2013):
        1 where the chains have come to the same end.
    acceptance : float
        Share of the proposals that were taken.
    model : str
        Name of the model that the draws are for.
    settings : dict
        What all runs of it share: the law and known parameters.
    ranges : Ranges
        From where to where the data went that the posterior is of.
    """

    draws: dict[str, Array]
    units: dict[str, str]
    log_density: Array
    effective: dict[str, float]
    r_hat: dict[str, float]
    acceptance: float
    model: str
    settings: dict[str, Value]
    ranges: Ranges

    @property
    def converged(self) -> bool:
        """Whether the chains have come to the same end, with enough draws that count as independent."""
        return all(value < MIXED for value in self.r_hat.values()) and min(self.effective.values()) >= ENOUGH

    def interval(self, name: str, level: float = LEVEL) -> tuple[float, float]:
        """Return the ends between which the middle share ``level`` of the draws of a parameter lies."""
        if name not in self.draws:
            raise KeyError(f"{name} is not free in this fit; there are {', '.join(self.draws)}")
        _check_level(level)
        low, high = np.quantile(self.draws[name], [0.5 - 0.5 * level, 0.5 + 0.5 * level])
        return float(low), float(high)

    def to_inference_data(self) -> Any:
        """Return the draws as an ``arviz.InferenceData``: ``posterior``, and ``sample_stats`` with ``lp``.

        Raises
        ------
        MissingPackage
            Without ArviZ.
        """
        arviz = arviz_of()
        return arviz.from_dict(posterior=self.draws, sample_stats={"lp": self.log_density})

    def to_csv(self, file: str | Path) -> None:
        """Write the draws: chain, draw, and a column for each parameter in SI units."""
        chains, draws = np.indices(self.log_density.shape)
        columns = [chains.ravel().tolist(), draws.ravel().tolist()]
        columns += [values.ravel().tolist() for values in self.draws.values()]
        write_csv(Path(file), ["chain", "draw", *self.draws], zip(*columns, strict=True))

    def settings_of(self, number: int = 200) -> dict[str, Array]:
        """Return so many draws, evenly spread over chains and steps, as parameters for `Model.simulate_many`.

        What is of sensors or a test bench, and none of the model's, is left out.
        """
        whole_number("number", number, least=1)
        table = Model(self.model)
        # Steps first: neighbours of one step are of different chains, whose draws have the least in common.
        flat = {name: values.T.ravel() for name, values in self.draws.items() if name in table.variables}
        total = self.log_density.size
        if number > total:
            raise ValueError(f"number = {number} is refused: there are {total} draws")
        places = np.linspace(0, total - 1, number).round().astype(int)
        return {name: values[places] for name, values in flat.items()}

    def predict(self, *, number: int = 200, common: Mapping[str, Any] | None = None, **options: Any) -> Band:
        """Run the model once for each of so many draws: a band around a prediction.

        Parameters
        ----------
        number : int
            Number of draws.
        common : mapping, optional
            What is set besides in all runs; in place of a known parameter of the fit where both are given.
        **options
            As for `Model.simulate_many`: inputs, stop, step, outputs, executor, progress and so on.

        Returns
        -------
        Band

        Warns
        -----
        PlantWarning
            Where inputs or runs leave the range of the data, so that the band is one of an extrapolation.
        """
        shared = {**self.settings, **(common or {})}
        drawn = self.settings_of(number)
        for name in drawn:
            if name in (common or {}):
                raise ValueError(f"common {name} is refused: it is drawn from the posterior")
        band = Band(Model(self.model).simulate_many(drawn, common=shared, **options))
        for text in self.ranges.beyond(_asked(band.runs, options.get("inputs") or {})).values():
            warn(f"this prediction is an extrapolation: {text}")
        return band

    def __repr__(self) -> str:
        chains, draws = self.log_density.shape
        width = max(len(name) for name in self.draws)
        lines = [f"posterior: {chains} chains of {draws} draws, {'converged' if self.converged else 'not converged'}"]
        for name, values in self.draws.items():
            low, high = self.interval(name)
            lines.append(
                f"  {name:{width}}  {np.mean(values):.6g} [{low:.6g}, {high:.6g}] {self.units[name]}"
                f"  R-hat {self.r_hat[name]:.3f}, {self.effective[name]:.0f} independent draws"
            )
        return "\n".join(lines)


@dataclass(frozen=True)
class Band:
    """Runs under draws from a posterior: how sure a prediction is.

    Attributes
    ----------
    runs : Runs
        A run for each draw.
    """

    runs: Runs

    def of(self, name: str, level: float = LEVEL) -> tuple[Array, Array, Array]:
        """Return lower end, median and upper end of a variable at each time."""
        _check_level(level)
        low, middle, high = np.quantile(self.runs[name], [0.5 - 0.5 * level, 0.5, 0.5 + 0.5 * level], axis=0)
        return low, middle, high

    def to_csv(self, file: str | Path, level: float = LEVEL) -> None:
        """Write the table: time, and for each variable NAME.low, NAME and NAME.high, in SI units."""
        names, columns = ["time"], [np.asarray(self.runs.time)]
        for name in self.runs.variables:
            names += [f"{name}.low", name, f"{name}.high"]
            columns += self.of(name, level)
        write_csv(Path(file), names, np.column_stack(columns).tolist())

    def plot(self, *names: str, level: float = LEVEL) -> Figure:
        """Draw the band of each variable over time, with its median."""
        shown = names or tuple(self.runs.variables)
        variables = self.runs.variables
        with mpl.rc_context(STYLE):
            figure = Drawing(figsize=(WIDTH, 0.6 + 1.9 * len(shown)), layout="constrained")
            axes = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
            for axis, name in zip(axes, shown, strict=True):
                unit = variables[name].shown
                low, middle, high = (unit.factor * course + unit.offset for course in self.of(name, level))
                axis.fill_between(
                    self.runs.time, low, high, color=BLUE, alpha=0.3, lw=0, label=f"{100 * level:g} % of draws"
                )
                axis.plot(self.runs.time, middle, color=BLUE, lw=1.0, label="median")
                axis.set_ylabel(f"{name} ({unit.name})" if unit.name else name)
            axes[0].legend(ncols=2, loc="best")
            axes[-1].set_xlabel("time (s)")
        return figure


def _check_level(level: float) -> None:
    if not 0.0 < level < 1.0:
        raise ValueError(f"level = {level} is refused: it must be between 0 and 1")


def _asked(runs: Runs, inputs: Mapping[str, Any]) -> dict[str, Array]:
    """Return what runs were asked: inputs that were given as numbers, and the courses that were recorded."""
    found = {name: np.asarray(given, dtype=np.float64) for name, given in inputs.items() if _is_number(given)}
    found |= {name: np.asarray(runs[name]) for name in runs.variables}
    if "position" in found and "velocity" not in found:
        found["velocity"] = np.gradient(found["position"], runs.time, axis=1)
    return found


def _is_number(given: Any) -> bool:
    return isinstance(given, int | float) and not isinstance(given, bool)


def emcee_of() -> Any:
    """Return emcee, or say how to get it."""
    try:
        import emcee
    except ImportError as error:
        raise MissingPackage("emcee", "posterior") from error
    return emcee


def arviz_of() -> Any:
    """Return ArviZ, or say how to get it; its notice of the day about its next version is none of a fit's."""
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "\nArviZ is undergoing a major refactor", FutureWarning)
            import arviz
    except ImportError as error:
        raise MissingPackage("ArviZ", "posterior") from error
    return arviz


@dataclass(frozen=True)
class Density:
    """The logarithm of the posterior of the free parameters; it can be sent to other processes.

    Attributes
    ----------
    problem : Problem
        What was fitted.
    x : ndarray
        Its solution, with what windows begin with.
    stretch : ndarray of shape (parameters,)
        How much wider than that of independent residuals each interval is.
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
    # In units of what the ends of a normal distribution would be: intervals of few blocks are those of a t.
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
    """Proposes from a t about the solution, whatever the present place is.

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

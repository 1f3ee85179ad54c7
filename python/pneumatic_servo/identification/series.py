"""One machine over months: changing and constant parameters.

Every record is fitted alone first. From there all are fitted together, by Gauss-Newton steps in which shared parameters
have one value and each record has its own of what may change, and of what its windows begin with.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.special import ndtri
from scipy.stats import chi2

from pneumatic_servo import checks
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.figures import BLUE, GREY, HEIGHT, STYLE, VERMILION, WIDTH, Drawing
from pneumatic_servo.files import write_csv
from pneumatic_servo.identification.fitted import Estimate
from pneumatic_servo.identification.fitting import fit
from pneumatic_servo.identification.intervals import LEVEL, Linearised, covariance, linearised
from pneumatic_servo.identification.parameters import Free, split
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.result import Fit
from pneumatic_servo.identification.solve import jacobian
from pneumatic_servo.identification.ties import is_expression
from pneumatic_servo.run_errors import Interrupted

Array = NDArray[np.float64]

ROUNDS = 20
"""Steps of the joint fit at most."""
ENDED = 1e-7
"""Relative change of the cost at which it ends."""
HALVINGS = 8
"""Halvings of a step that does not lower the cost."""
TAKEN = ("columns", "encoding", "settings", "seed", "starts", "rated", "width", "play", "segment", "window", "inputs",
         "workers", "executor", "cluster", "progress")  # fmt: skip
"""Options of a fit that one of a series has, too."""
COLUMNS = ["record", "parameter", "value", "low", "high", "unit", "moves", "p"]


@dataclass(frozen=True)
class Series:
    """Moving parameters of a machine.

    Attributes
    ----------
    labels : tuple
        Names of the records: dates, numbers or texts.
    converged : bool
        Whether the joint fit converged.
    shared : dict
        Estimates of what all records share.
    changing : dict
        For each parameter that may change its estimates, one per record.
    p : dict
        For each of these how likely it is that the estimates differ as much though nothing moves; NaN where the fit
        has not converged.
    moves : dict
        Whether each moves: whether p is below 5 % over the number of them, so that in 95 of 100 series in which
        nothing moves none is said to.
    doubtful : dict
        Shared parameters that differ among the records, with how likely that is if they are the same.
    rms : list of dict
        Root mean square of measured minus simulated by signal, of each record.
    fits : tuple of Fit
        The fits to the single records.

    Examples
    --------
    >>> import numpy as np
    >>> import pneumatic_servo as ps
    >>> t = np.arange(0.0, 1.0, 0.02)
    >>> noise = 0.1 * np.random.default_rng(0).standard_normal(len(t))
    >>> data = {"time": t, "position": 0.01 * np.sin(6.0 * t), "frictionForce": 7.0 * np.sign(np.cos(6.0 * t)) + noise}
    >>> later = {**data, "frictionForce": 1.2 * data["frictionForce"]}
    >>> found = ps.fit_series({"May": data, "June": later}, experiment="motion", law="Coulomb",
    ...                       changing="friction.coulomb.Fc", starts=0, progress=False)
    >>> found.moves
    {'friction.coulomb.Fc': True}
    >>> may, june = found.changing["friction.coulomb.Fc"]
    >>> 1.1 < june.value / may.value < 1.3
    True
    """

    labels: tuple[Any, ...]
    converged: bool
    shared: dict[str, Estimate]
    changing: dict[str, tuple[Estimate, ...]]
    p: dict[str, float]
    moves: dict[str, bool]
    doubtful: dict[str, float]
    rms: tuple[dict[str, float], ...]
    fits: tuple[Fit, ...]

    def rows(self) -> list[tuple[str, str, float, float, float, str, bool, float]]:
        """Return the table; its columns are `COLUMNS`."""
        return [
            (str(label), name, one.value, one.low, one.high, one.unit, self.moves[name], self.p[name])
            for name, course in self.changing.items()
            for label, one in zip(self.labels, course, strict=True)
        ]

    def to_csv(self, file: str | Path) -> None:
        """Write the table of changing parameters."""
        write_csv(Path(file), COLUMNS, self.rows())

    def plot(self) -> Figure:
        """Draw changing parameters over the records, with 95 % intervals; moving ones are red."""
        places, is_text = _places(self.labels)
        with mpl.rc_context(STYLE):
            figure = Drawing(figsize=(WIDTH, 0.8 + HEIGHT * len(self.changing)), layout="constrained")
            axes = figure.subplots(len(self.changing), 1, sharex=True, squeeze=False)[:, 0]
            for axis, (name, course) in zip(axes, self.changing.items(), strict=True):
                value, low, high = (np.array([getattr(one, end) for one in course]) for end in ("value", "low", "high"))
                colour = VERMILION if self.moves[name] else BLUE
                axis.errorbar(places, value, [value - low, high - value], fmt="o", ms=4, capsize=3, color=colour)
                axis.axhline(value[0], color=GREY, lw=0.8, ls="--")
                unit = "" if course[0].unit == "1" else f" ({course[0].unit})"
                axis.set_ylabel(f"{name.rpartition('.')[2]}{unit}")
                axis.set_title(f"{name}: {'moves' if self.moves[name] else 'does not move'}", loc="left")
            if is_text:
                axes[-1].set_xticks(places, [str(label) for label in self.labels])
            axes[-1].set_xlabel("record; dashed: the first")
        return figure

    def __repr__(self) -> str:
        lines = [
            f"{self.fits[0].law}, {len(self.labels)} records: {'converged' if self.converged else 'not converged'}"
        ]
        width = max(len(name) for name in (*self.shared, *self.changing))
        lines += [f"  {name:{width}}  {one}, shared" for name, one in self.shared.items()]
        for name, course in self.changing.items():
            verdict = "moves" if self.moves[name] else "does not move"
            verdict = (
                f"{verdict} (p = {self.p[name]:.2g})" if self.converged else "not known, since the search has not ended"
            )
            lines.append(f"  {name:{width}}  {verdict}")
            lines += [f"    {label}: {one}" for label, one in zip(self.labels, course, strict=True)]
        lines += [
            f"  {name} is shared, but differs among the records (p = {value:.2g}): let it change"
            for name, value in self.doubtful.items()
        ]
        return "\n".join(lines)


def fit_series(
    records: Mapping[Any, Any] | Sequence[Any],
    *,
    experiment: str,
    law: str,
    changing: str | Sequence[str],
    shared: str | Sequence[str] = (),
    **options: Any,
) -> Series:
    """Fit one machine to records of different days.

    Parameters
    ----------
    records : mapping or sequence
        Data of each day by what it is called, a date, a number or a text; each as for `fit`.
    experiment, law : str
        As for `fit`.
    changing, shared : str or sequence of str
        What has a value for each record, and what has the same in all: ``NAME[=start][:low:high]`` as for `fit`; what
        an expression ties to others follows them in each record, whichever of both it is given with.
    **options
        As for `fit`: columns, encoding, settings, seed, starts, rated, width, play, segment, inputs, workers, executor,
        cluster and progress.

    Returns
    -------
    Series

    Raises
    ------
    ValueError
        As `fit`, and for fewer than two records.
    Interrupted
        On Ctrl-C; its ``finished`` is a list of the fits to single records until then.

    Examples
    --------
    >>> import numpy as np
    >>> import pneumatic_servo as ps
    >>> t = np.arange(0.0, 4.0, 0.01)
    >>> x, rng = 0.01 * np.sin(6.0 * t), np.random.default_rng(0)
    >>> def friction(month):
    ...     return (6.0 + month) * np.sign(np.cos(6.0 * t)) + 0.1 * rng.standard_normal(len(t))
    >>> days = {f"2026-0{month}-01": {"time": t, "position": x, "frictionForce": friction(month)} for month in (1, 2)}
    >>> found = ps.fit_series(days, experiment="motion", law="Coulomb", changing="friction.coulomb.Fc",
    ...                       settings={"friction.coulomb.sigma2": 0.0}, play=0.0, progress=False)
    >>> found.moves
    {'friction.coulomb.Fc': True}
    """
    wrong = next((name for name in options if name not in TAKEN), None)
    if wrong is not None:
        raise TypeError(f"fit_series has no option {wrong}; there are {', '.join(TAKEN)}")
    if isinstance(records, (str, Path)) or not isinstance(records, (Mapping, Sequence)):
        raise TypeError(f"records must be a mapping or a sequence of data, not {type(records).__name__}")
    given = dict(records) if isinstance(records, Mapping) else dict(enumerate(records, start=1))
    if len(given) < 2:
        raise ValueError(f"{len(given)} record is refused: a series has at least two")
    own, common = (
        split(words) if isinstance(words, str) else checks.names(name, words)
        for name, words in (("changing", changing), ("shared", shared))
    )
    if not own:
        raise ValueError(f"{quoted('changing')}: name what may change")
    fits: list[Fit] = []
    try:
        for label, data in given.items():
            fits.append(_alone(label, data, [*common, *own], experiment, law, options))
        estimated = [word for word in common if not is_expression(word.partition("=")[2], quoted("shared", word))]
        return _together(tuple(given), fits, len(estimated))
    except KeyboardInterrupt:
        interrupted = Interrupted("interrupted")
        interrupted.finished = fits
        raise interrupted from None


def _alone(label: Any, data: Any, free: list[str], experiment: str, law: str, options: Mapping[str, Any]) -> Fit:
    try:
        return fit(data, experiment=experiment, law=law, fit=free, **options)
    except ValueError as error:
        raise ValueError(f"record {label}: {error}") from error


def _together(labels: tuple[Any, ...], fits: Sequence[Fit], common: int) -> Series:
    problems = [found.problem.trained() for found in fits]
    free = problems[0].free
    vectors, converged = _joint(problems, [found.x for found in fits], common)
    linear = _linearised(problems, vectors, common)
    spread, factors = covariance(linear)
    deviations = np.sqrt(np.diag(spread))
    halves = factors * deviations
    changing, p = {}, {}
    first, own = vectors[0], len(free) - common
    for place in range(own):
        name = free[common + place].name
        index = common + place + own * np.arange(len(fits))
        inner = np.array([x[common + place] for x in vectors])
        changing[name] = tuple(
            _estimate(free[common + place], value, half) for value, half in zip(inner, halves[index], strict=True)
        )
        p[name] = _constant(inner, _widened(spread, factors)[np.ix_(index, index)])
    is_ended = converged and all(found.converged for found in fits)
    if not is_ended:
        # Where a search has stopped says nothing of what moves.
        p = dict.fromkeys(p, float("nan"))
    return Series(
        labels, is_ended,
        {one.name: _estimate(one, first[k], halves[k]) for k, one in enumerate(free[:common])}, changing, p,
        {name: is_ended and value < (1.0 - LEVEL) / own for name, value in p.items()},
        _doubtful(fits, free[:common], first),
        tuple(problem.rms(x) for problem, x in zip(problems, vectors, strict=True)), tuple(fits),
    )  # fmt: skip


def _joint(problems: Sequence[Problem], alone: Sequence[Array], common: int) -> tuple[list[Array], bool]:
    """Return the vectors of all records, whose first parameters are shared, and whether they are the best."""
    vectors = [np.concatenate([x, np.zeros(sum(one.loose))]) for one, x in zip(problems, alone, strict=True)]
    middle = np.mean([x[:common] for x in vectors], axis=0)
    for x in vectors:
        x[:common] = middle
    cost = _cost(problems, vectors, common)
    for _ in range(ROUNDS):
        moves = _moves(problems, vectors, common)
        share = 1.0
        for _ in range(HALVINGS):
            trial = [_within(one, x + share * move) for one, x, move in zip(problems, vectors, moves, strict=True)]
            lower = _cost(problems, trial, common)
            if lower < cost:
                break
            share *= 0.5
        else:
            return vectors, True
        has_ended = cost - lower < ENDED * cost
        vectors, cost = trial, lower
        if has_ended:
            return vectors, True
    return vectors, False


def _residuals(problem: Problem, x: Array, common: int, records: int) -> Array:
    """Return the residuals of a record; priors of shared parameters count once in all records together."""
    [found] = problem.residuals([x])
    return np.concatenate([found, _weights(x, common, records) * problem.pulls(x)])


def _weights(x: Array, common: int, records: int) -> Array:
    return np.where(np.arange(len(x)) < common, records**-0.5, 1.0)


def _cost(problems: Sequence[Problem], vectors: Sequence[Array], common: int) -> float:
    parts = [_residuals(one, x, common, len(problems)) for one, x in zip(problems, vectors, strict=True)]
    return float(sum(part @ part for part in parts))


def _moves(problems: Sequence[Problem], vectors: Sequence[Array], common: int) -> list[Array]:
    """Return a Gauss-Newton step: the shared parameters first, then each record's own in response."""
    information, slope, parts = np.zeros((common, common)), np.zeros(common), []
    for problem, x in zip(problems, vectors, strict=True):
        residuals = _residuals(problem, x, common, len(problems))
        pulls = np.diag(_weights(x, common, len(problems)) * problem.pull)
        slopes = np.vstack([jacobian(problem, x), pulls])
        basis, triangle = np.linalg.qr(slopes[:, common:])
        rest = slopes[:, :common] - basis @ (basis.T @ slopes[:, :common])
        information += rest.T @ rest
        slope += rest.T @ residuals
        parts.append((residuals, slopes, basis, triangle))
    step = -np.linalg.pinv(information, hermitian=True) @ slope
    return [
        np.concatenate([step, -np.linalg.pinv(triangle) @ (basis.T @ (residuals + slopes[:, :common] @ step))])
        for residuals, slopes, basis, triangle in parts
    ]


def _within(problem: Problem, x: Array) -> Array:
    low, high = problem.bounds
    return np.asarray(np.clip(x, low, high))


def _linearised(problems: Sequence[Problem], vectors: Sequence[Array], common: int) -> Linearised:
    """Return all records about the solution: columns of shared parameters, then of each record's own."""
    parts = [linearised(problem, x) for problem, x in zip(problems, vectors, strict=True)]
    own = parts[0].derivatives.shape[1] - common
    rows, blocks, before = [], [], 0
    for number, part in enumerate(parts):
        wide = np.zeros((len(part.derivatives), common + own * len(parts)))
        wide[:, :common] = part.derivatives[:, :common]
        wide[:, common + own * number : common + own * (number + 1)] = part.derivatives[:, common:]
        rows.append(wide)
        blocks.append(part.blocks + before)
        before = int(blocks[-1].max()) + 1
    scores = np.concatenate([part.scores for part in parts])
    # No record can be left out, since each has parameters of its own.
    return Linearised(np.vstack(rows), scores, np.concatenate(blocks), np.zeros(len(scores), dtype=np.int64))


def _widened(spread: Array, factors: Array) -> Array:
    """Return the covariance of normal errors with the same intervals."""
    wide = factors / ndtri(0.5 + 0.5 * LEVEL)
    return np.asarray(spread * np.outer(wide, wide))


def _constant(values: Array, spread: Array) -> float:
    """Return the p-value of differences among values, given the covariance of their errors."""
    differences = np.eye(len(values))[1:] - np.eye(len(values))[0]
    moved = differences @ values
    statistic = moved @ np.linalg.pinv(differences @ spread @ differences.T, hermitian=True) @ moved
    return float(chi2.sf(float(statistic), len(values) - 1))


def _doubtful(fits: Sequence[Fit], shared: Sequence[Free], x: Array) -> dict[str, float]:
    """Return shared parameters of which the fits to single records differ too much from the joint one."""
    found = {}
    for place, one in enumerate(shared):
        statistic, freedom = 0.0, -1
        for alone in fits:
            estimate = alone.parameters[one.name]
            half = one.inner(estimate.high) - float(alone.x[place]) if np.isfinite(estimate.high) else np.inf
            if one.name not in alone.not_identifiable and 0.0 < half < np.inf:
                statistic += ((float(alone.x[place]) - float(x[place])) * ndtri(0.5 + 0.5 * LEVEL) / half) ** 2
                freedom += 1
        if freedom > 0 and (p := float(chi2.sf(statistic, freedom))) < (1.0 - LEVEL) / len(shared):
            found[one.name] = p
    return found


def _estimate(free: Free, inner: float, half: float) -> Estimate:
    with np.errstate(over="ignore"):
        low, high = ((np.exp(end) if free.is_logarithmic else end * free.scale) for end in (inner - half, inner + half))
    return Estimate(free.outer(float(inner)), float(low), float(high), free.unit)


def _places(labels: Sequence[Any]) -> tuple[list[Any], bool]:
    """Return where records stand in a figure, and whether their labels are texts: dates and numbers are not."""
    if all(isinstance(label, (int, float, date)) for label in labels):
        return list(labels), False
    try:
        return [date.fromisoformat(str(label)) for label in labels], False
    except ValueError:
        return list(range(1, len(labels) + 1)), True

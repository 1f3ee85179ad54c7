"""One machine over months: changing and constant parameters.

Every record is fitted alone first. From there the crate `fit` fits all together.
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

from pneumatic_servo import _native, checks
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.figures import BLUE, GREY, HEIGHT, STYLE, VERMILION, WIDTH, Drawing
from pneumatic_servo.files import write_csv
from pneumatic_servo.identification.fitted import Estimate
from pneumatic_servo.identification.fitting import fit
from pneumatic_servo.identification.intervals import LEVEL
from pneumatic_servo.identification.parameters import Free, split
from pneumatic_servo.identification.result import Fit
from pneumatic_servo.identification.ties import is_expression
from pneumatic_servo.run_errors import Interrupted

Array = NDArray[np.float64]

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
    vectors, converged, halves, told = _native.joint(
        [problem.native for problem in problems], [found.x for found in fits], common
    )
    changing, p = {}, {}
    first, own = vectors[0], len(free) - common
    for place, one in enumerate(free[common:]):
        changing[one.name] = tuple(
            _estimate(one, float(x[common + place]), halves[common + place + own * record])
            for record, x in enumerate(vectors)
        )
        p[one.name] = told[place]
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

"""Several laws held against the same data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pneumatic_servo.argument_names import quoted
from pneumatic_servo.checks import names
from pneumatic_servo.files import write_csv
from pneumatic_servo.identification.discrimination import Telling, telling
from pneumatic_servo.identification.evidence import Evidence, evidence
from pneumatic_servo.identification.experiments import EXPERIMENTS, Options
from pneumatic_servo.identification.fitting import Data, fit, make_experiment
from pneumatic_servo.identification.parameters import named_by, unit_of, usual, words_of
from pneumatic_servo.identification.result import Fit
from pneumatic_servo.identification.signals import told_units
from pneumatic_servo.run import table
from pneumatic_servo.run_errors import Interrupted

COLUMNS = ["law", "converged", "free", "rms", "validation rms", "AIC"]


@dataclass(frozen=True)
class Ranking:
    """Fits of several laws, the best first: by the residual of the validation data, or by AIC without any.

    Attributes
    ----------
    fits : tuple of Fit
        A fit for each law.

    Examples
    --------
    >>> import numpy as np
    >>> import pneumatic_servo as ps
    >>> t = np.arange(0.0, 1.0, 0.02)
    >>> noise = 0.1 * np.random.default_rng(0).standard_normal(len(t))
    >>> data = {"time": t, "position": 0.01 * np.sin(6.0 * t), "frictionForce": 7.0 * np.sign(np.cos(6.0 * t)) + noise}
    >>> found = ps.compare_fits(data, ["Coulomb", "Dahl"], experiment="motion", starts=0, progress=False)
    >>> found.best.aic <= found["Dahl"].aic
    True
    """

    fits: tuple[Fit, ...]

    def __getitem__(self, law: str) -> Fit:
        """Return the fit of a law."""
        if all(found.law != law for found in self.fits):
            raise KeyError(f"{law} was not fitted; there are {', '.join(found.law for found in self.fits)}")
        return next(found for found in self.fits if found.law == law)

    @property
    def best(self) -> Fit:
        """The first."""
        return self.fits[0]

    def rows(self) -> list[tuple[str, bool, int, float, float | None, float]]:
        """Return the table; its columns are `COLUMNS`. Residuals are relative to the first law's."""
        return [
            (found.law, found.converged, len(found.problem.free), _total(found, self.fits[0], held=False),
             _total(found, self.fits[0], held=True) if found.validation_rms else None, found.aic)
            for found in self.fits
        ]  # fmt: skip

    def evidence(self, number: int = 1000, seed: int = 0) -> Evidence:
        """Return the evidence for each law, and whether the data distinguish it from the best.

        Stretches of time are left out by Pareto-smoothed weights of draws; see `Evidence`.

        Parameters
        ----------
        number, seed : int
            Number of draws for each law, each of them a run, and their seed.

        Raises
        ------
        MissingPackage
            Without ArviZ.
        ValueError
            For a law whose fitted values cannot be simulated, and for records too short to be cut.
        """
        return evidence(self.fits, number, seed)

    def telling(self, first: str, second: str, **options: Any) -> Telling:
        """Return experiments that discriminate two of the laws, the best first.

        Parameters
        ----------
        first, second : str
            The simulated law, with its fitted values, and the law that is fitted to it.
        **options
            As for `plan`: noise, duration, step, stroke, progress.
        """
        return telling(self[first], self[second], **options)

    def to_csv(self, file: str | Path) -> None:
        """Write the table."""
        write_csv(Path(file), COLUMNS, self.rows())

    def _repr_html_(self) -> str:
        rows = (
            [law, str(converged), str(free), f"{rms:.4g}", "" if held is None else f"{held:.4g}", f"{aic:.1f}"]
            for law, converged, free, rms, held, aic in self.rows()
        )
        return table(COLUMNS, rows)

    def _ipython_key_completions_(self) -> list[str]:
        return [found.law for found in self.fits]

    def __repr__(self) -> str:
        signals = list(self.fits[0].rms)
        head = f"{'law':20}{'free':>5}" + "".join(f"{'rms ' + name:>24}{'validation':>14}" for name in signals)
        lines = [head + f"{'AIC':>14}"]
        for found in self.fits:
            pairs = "".join(
                f"{found.rms[name]:24.6g}{found.validation_rms.get(name, float('nan')):14.6g}" for name in signals
            )
            lines.append(f"{found.law:20}{len(found.problem.free):5}{pairs}{found.aic:14.1f}")
        return "\n".join(lines)


def compare_fits(
    data: Data | Sequence[Data],
    laws: Sequence[str],
    *,
    experiment: str,
    fit_of: Mapping[str, str | Sequence[str]] | None = None,
    settings_of: Mapping[str, Mapping[str, Any]] | None = None,
    **options: Any,
) -> Ranking:
    """Fit several laws to the same data.

    Parameters
    ----------
    data, experiment, **options
        As for `fit`; what is given as ``fit`` is free besides the parameters of each law.
    laws : sequence of str
        Friction laws.
    fit_of, settings_of : mapping, optional
        Estimated and fixed parameters of single laws, by law; by default the usual parameters of each are estimated.

    Returns
    -------
    Ranking

    Raises
    ------
    ValueError
        As `fit`.
    Interrupted
        On Ctrl-C; its ``finished`` is a ranking of the laws that were fitted until then, or None.

    Examples
    --------
    >>> import numpy as np
    >>> import pneumatic_servo as ps
    >>> t = np.arange(0.0, 2.0, 1e-3)
    >>> data = {"time": t, "position": 1e-3 * np.sin(6.0 * t), "frictionForce": 7.0 * np.sign(np.cos(6.0 * t))}
    >>> found = ps.compare_fits(data, ["Coulomb", "Dahl"], experiment="motion", starts=0, progress=False)
    >>> sorted(one.law for one in found.fits)
    ['Coulomb', 'Dahl']
    """
    laws = names("laws", laws)
    if not laws:
        raise ValueError(f"{quoted('laws')}: name at least one law")
    if not all(laws):
        raise ValueError(f"{quoted('laws', ','.join(laws))}: a law between the commas is empty")
    twice = next((law for law in laws if laws.count(law) > 1), None)
    if twice is not None:
        raise ValueError(f"{quoted('laws')}: {twice} is given twice")
    for argument, given in (("fit_of", fit_of), ("settings_of", settings_of)):
        other = next((law for law in given or () if law not in laws), None)
        if other is not None:
            raise ValueError(f"{argument}: {other} is not among the laws that are fitted: {', '.join(laws)}")
    common = options.pop("fit", ())
    shared = _shared(options.pop("settings", None), experiment, laws[0])
    fits: list[Fit] = []
    try:
        for law in laws:
            of_others = _of_others(law, laws, experiment)
            own = {name: value for name, value in shared.items() if name not in of_others}
            own |= (settings_of or {}).get(law, {})
            free = _free(law, own, (fit_of or {}).get(law, ()), common, experiment, of_others)
            fits.append(fit(data, experiment=experiment, law=law, fit=free, settings=own, **options))
    except KeyboardInterrupt as error:
        unfinished = getattr(error, "finished", None)
        fits += [unfinished] if isinstance(unfinished, Fit) else []
        interrupted = Interrupted("interrupted")
        interrupted.finished = _ranking(fits) if fits else None
        raise interrupted from None
    return _ranking(fits)


def _shared(settings: Any, experiment: str, law: str) -> dict[str, Any]:
    """Return settings for all laws, from a mapping or an SSV file."""
    if isinstance(settings, Mapping):
        return dict(settings)
    return dict(make_experiment(experiment, law, settings, Options()).settings)


def _ranking(fits: list[Fit]) -> Ranking:
    first = next((found for found in fits if not math.isnan(_total(found, found, held=False))), fits[0])
    by_error = bool(first.validation_rms)
    fits.sort(key=lambda found: _last_if_nan(_total(found, first, held=True) if by_error else found.aic))
    return Ranking(tuple(fits))


def _free(
    law: str,
    settings: Mapping[str, Any],
    own: str | Sequence[str],
    common: str | Sequence[str],
    experiment: str,
    of_others: AbstractSet[str] = frozenset(),
) -> list[str]:
    """Return the estimated parameters of a law: its own and the shared ones.

    What is named for all laws, say with bounds, counts instead of the same by default.
    """
    table = make_experiment(experiment, law, settings, Options(), told_units(experiment, [], settings)).table
    words = [words_of(given, lambda name: unit_of(table, name)) for given in (own, common)]
    named = {named_by(word) for word in words[1]}
    chosen = words[0] or [name for name in usual(experiment, law, table, settings) if name not in named]
    return [word for word in [*chosen, *words[1]] if named_by(word) not in {*settings, *of_others}]


def _of_others(law: str, laws: Sequence[str], experiment: str) -> set[str]:
    """Return the parameters of the other laws that are fitted, which have no effect under this one."""
    if experiment not in EXPERIMENTS:
        return set()
    others = {("friction.law", other) for other in laws if other != law}
    variables = EXPERIMENTS[experiment](law, {}, Options()).table.variables
    return {name for name, variable in variables.items() if variable.counts_for in others}


def _last_if_nan(value: float) -> float:
    """Return the sort key; a law whose fitted values cannot be simulated comes last."""
    return math.inf if math.isnan(value) else value


def _total(found: Fit, first: Fit, *, held: bool) -> float:
    """Root mean square over the signals, each relative to the residual of the first law."""
    rms, reference = (found.validation_rms, first.validation_rms) if held else (found.rms, first.rms)
    squares = [(rms[name] / max(reference[name], 1e-300)) ** 2 for name in reference]
    return float((sum(squares) / max(1, len(squares))) ** 0.5)

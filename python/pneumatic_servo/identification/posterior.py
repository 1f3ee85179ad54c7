"""Samples of the posterior of a fit, and their predictions; `sampling` makes them."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.checks import whole_number
from pneumatic_servo.errors import MissingPackage, warn
from pneumatic_servo.files import write_csv
from pneumatic_servo.identification.band import Band, check_level
from pneumatic_servo.identification.intervals import LEVEL
from pneumatic_servo.identification.ranges import Ranges
from pneumatic_servo.model import Model
from pneumatic_servo.run import Runs
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]

ENOUGH = 1000.0
"""Independent draws of each parameter at which the sampler stops: they tell the ends of an interval to a tenth."""
MIXED = 1.05
"""Chains whose R-hat is above this have not come to the same end."""


@dataclass(frozen=True)
class Posterior:
    """Samples of the posterior.

    Attributes
    ----------
    draws : dict
        Values of each free parameter in SI units, of shape (chains, draws).
    units : dict
        SI units.
    log_density : ndarray of shape (chains, draws)
        Logarithm of the posterior, but for a constant.
    effective : dict
        Effective number of samples of each parameter.
    r_hat : dict
        Between-chain against within-chain spread of the split chains (A. Gelman et al., Bayesian Data Analysis, 2013):
        1 where the chains have converged to the same distribution.
    acceptance : float
        Share of the proposals that were taken.
    model : str
        Name of the model that the draws are for.
    settings : dict
        Common settings of its runs: the law and fixed parameters.
    ranges : Ranges
        From where to where the data went that the posterior is of.

    Examples
    --------
    >>> import numpy as np
    >>> import pneumatic_servo as ps
    >>> t = np.arange(0.0, 1.0, 0.02)
    >>> noise = 0.1 * np.random.default_rng(0).standard_normal(len(t))
    >>> data = {"time": t, "position": 0.01 * np.sin(6.0 * t), "frictionForce": 7.0 * np.sign(np.cos(6.0 * t)) + noise}
    >>> found = ps.fit(data, experiment="motion", law="Coulomb", starts=0, posterior=True, progress=False)
    >>> low, high = found.posterior.interval("friction.coulomb.Fc")
    >>> low < 7.0 < high
    True
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
        """Whether the chains have converged to one distribution, with enough effectively independent samples."""
        return all(value < MIXED for value in self.r_hat.values()) and min(self.effective.values()) >= ENOUGH

    def interval(self, name: str, level: float = LEVEL) -> tuple[float, float]:
        """Return the bounds of the middle share ``level`` of the samples of a parameter."""
        if name not in self.draws:
            raise KeyError(f"{name} is not free in this fit; there are {', '.join(self.draws)}")
        check_level(level)
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
        """Return a number of samples, evenly spread over chains and steps, as parameters for `Model.simulate_many`.

        Parameters of sensors or of a test bench, which the model lacks, are omitted.
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
        """Run the model once for each of a number of samples: a band around a prediction.

        Parameters
        ----------
        number : int
            Number of draws.
        common : mapping, optional
            Settings of all runs; they replace fixed parameters of the fit.
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
        band = Band(Model(self.model).simulate_many(drawn, common=shared, **options), self.ranges.units)
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


def _asked(runs: Runs, inputs: Mapping[str, Any]) -> dict[str, Array]:
    """Return the inputs of the runs: constant ones, and recorded courses."""
    found = {name: np.asarray(given, dtype=np.float64) for name, given in inputs.items() if _is_number(given)}
    found |= {name: np.asarray(runs[name]) for name in runs.variables}
    if "position" in found and "velocity" not in found:
        found["velocity"] = np.gradient(found["position"], runs.time, axis=1)
    return found


def _is_number(given: Any) -> bool:
    return isinstance(given, int | float) and not isinstance(given, bool)


def arviz_of() -> Any:
    """Return ArviZ, or say how to get it; its notice of the day about its next version is none of a fit's."""
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "\nArviZ is undergoing a major refactor", FutureWarning)
            import arviz
    except ImportError as error:
        raise MissingPackage("ArviZ", "posterior") from error
    return arviz

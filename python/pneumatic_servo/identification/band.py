"""Prediction bands: runs with samples of the posterior."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pneumatic_servo.figures import BLUE, STYLE, WIDTH, Drawing
from pneumatic_servo.files import write_csv
from pneumatic_servo.identification.intervals import LEVEL
from pneumatic_servo.identification.signals import SLIDING, Units
from pneumatic_servo.run import Runs
from pneumatic_servo.variables import Unit

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Band:
    """Runs under draws from a posterior: how sure a prediction is.

    Attributes
    ----------
    runs : Runs
        A run for each draw.
    units : Units
        The units of the fit.

    Examples
    --------
    >>> import numpy as np
    >>> import pneumatic_servo as ps
    >>> t = np.arange(0.0, 1.0, 0.02)
    >>> noise = 0.1 * np.random.default_rng(0).standard_normal(len(t))
    >>> data = {"time": t, "position": 0.01 * np.sin(6.0 * t), "frictionForce": 7.0 * np.sign(np.cos(6.0 * t)) + noise}
    >>> found = ps.fit(data, experiment="motion", law="Coulomb", starts=0, posterior=True, progress=False)
    >>> band = found.posterior.predict(number=20, stop=0.1, step=1e-2)
    >>> low, middle, high = band.of(next(iter(band.runs.variables)))
    >>> bool(np.all(low <= middle) and np.all(middle <= high))
    True
    """

    runs: Runs
    units: Units = SLIDING

    def of(self, name: str, level: float = LEVEL) -> tuple[Array, Array, Array]:
        """Return lower end, median and upper end of a variable at each time."""
        check_level(level)
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
                # Values of rotating machines are shown in the SI unit: 1000 mm would be 1000 mrad.
                if (own := self.units.of(variables[name].unit)) != variables[name].unit:
                    unit = Unit(own)
                low, middle, high = (unit.factor * course + unit.offset for course in self.of(name, level))
                axis.fill_between(
                    self.runs.time, low, high, color=BLUE, alpha=0.3, lw=0, label=f"{100 * level:g} % of draws"
                )
                axis.plot(self.runs.time, middle, color=BLUE, lw=1.0, label="median")
                axis.set_ylabel(f"{name} ({unit.name})" if unit.name else name)
            axes[0].legend(ncols=2, loc="best")
            axes[-1].set_xlabel("time (s)")
        return figure


def check_level(level: float) -> None:
    """Refuse a share that is none."""
    if not 0.0 < level < 1.0:
        raise ValueError(f"level = {level} is refused: it must be between 0 and 1")

"""Results of a fit."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from pneumatic_servo import checks
from pneumatic_servo.files import check_ending, whole
from pneumatic_servo.identification.causes import Cause, causes
from pneumatic_servo.identification.fitted import Estimate, Fitted
from pneumatic_servo.identification.free_form import FreeForm, free_form
from pneumatic_servo.identification.problem import TOLERANCE
from pneumatic_servo.identification.ranges import Ranges
from pneumatic_servo.identification.residuals import Residuals
from pneumatic_servo.identification.verdict import Verdict, verdict
from pneumatic_servo.model import Model
from pneumatic_servo.names import did_you_mean, renamed, tell_renamed
from pneumatic_servo.run import Run, table
from pneumatic_servo.run_errors import SimulationError
from pneumatic_servo.ssv import ssv

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Fit(Fitted):
    """A fitted model.

    Attributes
    ----------
    converged : bool
        Whether the search converged.
    law : str
        Friction law.
    parameters : dict
        Estimates by name.
    rms, validation_rms : dict
        Root mean square of measured minus simulated by signal, of the fitted and of the validation data.
    not_identifiable : dict
        Parameters that the data do not determine, and why.
    notes : tuple of str
        Treatment of the data.
    x : ndarray of shape (free,)
        The free parameters as the search sees them, logarithms or values in units of their scale, and no SI units:
        those are `values`.
    posterior : Posterior or None
        Draws from the posterior, where they were asked for.
    cross_validation : CrossValidation or None
        Each operating condition as the others predict it, where that was asked for.

    Examples
    --------
    >>> import numpy as np
    >>> import pneumatic_servo as ps
    >>> t = np.arange(0.0, 1.0, 0.02)
    >>> noise = 0.1 * np.random.default_rng(0).standard_normal(len(t))
    >>> data = {"time": t, "position": 0.01 * np.sin(6.0 * t), "frictionForce": 7.0 * np.sign(np.cos(6.0 * t)) + noise}
    >>> found = ps.fit(data, experiment="motion", law="Coulomb", starts=0, progress=False)
    >>> found.converged, found["friction.coulomb.Fc"].unit
    (True, 'N')
    >>> run = ps.Model().simulate(found.settings, stop=0.1)
    >>> found.rms["frictionForce"] < 0.2
    True
    """

    @property
    def params(self) -> dict[str, Estimate]:
        """Estimates by name, each with value, low, high and unit: the same as `parameters`."""
        return self.parameters

    def __getitem__(self, name: str) -> Estimate:
        """Return the estimate of a parameter; ``float`` makes its value of it."""
        if name not in self.parameters:
            raise KeyError(
                f"there is no fitted parameter {name}{did_you_mean(name, self.parameters)}; there are "
                f"{', '.join(self.parameters)}"
            )
        return self.parameters[name]

    @property
    def beside(self) -> list[str]:
        """Fitted values that belong to sensors or a test bench, not to the model."""
        return [name for name in self.parameters if name not in self.problem.experiment.table.variables]

    @cached_property
    def verdict(self) -> Verdict:
        """Verdict on the fit: ``light`` is green, yellow or red, ``text`` says why, ``findings`` one by one."""
        return verdict(self, self._residuals, self.ranges, self.free_form, self.causes)

    @cached_property
    def _residuals(self) -> Residuals:
        return Residuals(self)

    @cached_property
    def free_form(self) -> FreeForm | None:
        """Residual of a free curve of friction in place of the law; None where friction is not identifiable."""
        return free_form(self, self._residuals)

    @cached_property
    def causes(self) -> tuple[Cause, ...]:
        """Explanations of much of the residuals, the best first: at most one fixed setting and one sensor."""
        return causes(self, self._residuals)

    @property
    def doubt(self) -> Cause | None:
        """The gain, offset, delay or lag of a sensor among the causes."""
        return next((cause for cause in self.causes if cause.is_sensor), None)

    @property
    def suspect(self) -> Cause | None:
        """The fixed setting, the thermal model or the clock among the causes."""
        return next((cause for cause in self.causes if not cause.is_sensor), None)

    @cached_property
    def ranges(self) -> Ranges:
        """From where to where the fitted samples go: the rest is extrapolation."""
        return Ranges.of(self.problem, self.x)

    def beyond(self, asked: Mapping[str, ArrayLike]) -> tuple[str, ...]:
        """Return statements about quantities that lie outside the range of the fitted data.

        Parameters
        ----------
        asked : mapping
            Values or courses of measured signals, and ``velocity``, in SI units.

        Raises
        ------
        ValueError
            For a name that is no signal of this fit.
        """
        for signal in asked:
            if signal not in self.ranges.limits:
                raise ValueError(f"asked {signal}: this fit knows the ranges of {', '.join(self.ranges.limits)}")
        return tuple(self.ranges.beyond(asked).values())

    @property
    def hold_out_rms(self) -> dict[str, float]:
        """The earlier name of `validation_rms`."""
        tell_renamed("hold_out_rms", "validation_rms")
        return self.validation_rms

    @property
    def undetermined(self) -> dict[str, str]:
        """The earlier name of `not_identifiable`."""
        tell_renamed("undetermined", "not_identifiable")
        return self.not_identifiable

    def plot(self) -> Figure:
        """Draw measured and fitted signals over each other, and residuals, as a figure of Matplotlib."""
        from pneumatic_servo.identification.figures import overlay

        return overlay(self._residuals)

    @renamed(window="segment")
    def simulate(self, segment: int = 0, *, outputs: Sequence[str] | None = None) -> Run:
        """Make the run of a fitted stretch of data again, bit for bit as the fit compares it.

        It begins with the fitted position, velocity and pressures of this stretch, and its inputs run between
        samples as in the fit. ``Model.simulate(found)`` has the fitted parameters and the start of the first
        stretch.

        Parameters
        ----------
        segment : int
            Number of the segment: a record is one, unless it has gaps or is cut by ``segment=`` of the fit; segments of
            validation data are counted, too. ``found.problem.windows`` has what was measured in each.
        outputs : sequence of str, optional
            Variables to record; by default the inputs and all outputs of the model that the fit runs.

        Returns
        -------
        Run
            Its time begins with the stretch; `Run.settings` has all that the run was given.

        Raises
        ------
        ValueError
            For a stretch or a variable that there is not.
        SimulationError
            When the solver cannot go on.
        """
        problem, model = self.problem, self.problem.experiment.simulated
        if problem.experiment.is_steady:
            raise ValueError(
                "simulate is refused: points have no course over time; Model.simulate(found.settings, ...) makes a run "
                "of the fitted law"
            )
        count = len(problem.windows)
        if not 0 <= checks.whole_number("segment", segment, least=0) < count:
            raise ValueError(f"segment = {segment} is refused: the data have {count} stretches, numbered from 0")
        settings, inputs = problem.native.given(segment, self.x)
        record = problem.windows[segment].record
        runs = model._run_many(
            [problem.experiment.typed(settings)],
            common={"solver.relativeTolerance": problem.exactness * TOLERANCE},
            inputs={name: (record.grid, course[None, :]) for name, course in inputs.items()},
            stop=(len(record.grid) - 1) * record.step,
            step=record.step,
            outputs=list(model._recorded(outputs, inputs)),
            lines=problem.experiment.native.has_lines,
        )
        if runs.failures:
            error = SimulationError(runs.failures[0])
            error.finished = runs[0]
            raise error
        run = runs[0]
        run.has_lines = problem.experiment.native.has_lines
        return run

    def as_dict(self) -> dict[str, Any]:
        """Return what is written as JSON."""
        return {
            "converged": self.converged,
            "parameters": {
                name: {"value": _finite(e.value), "low": _finite(e.low), "high": _finite(e.high), "unit": e.unit}
                for name, e in self.parameters.items()
            },
            "rms": {signal: _finite(rms) for signal, rms in self.rms.items()},
            "validation_rms": {signal: _finite(rms) for signal, rms in self.validation_rms.items()},
            "not_identifiable": list(self.not_identifiable),
            "law": self.law,
            "ranges": {signal: [low, high] for signal, (low, high) in self.ranges.limits.items()},
            **({} if self.cross_validation is None else {"crossValidation": self.cross_validation.as_list()}),
            "verdict": {"light": self.verdict.light, "text": self.verdict.text},
            # The names of these two until the next release.
            "hold_out_rms": {signal: _finite(rms) for signal, rms in self.validation_rms.items()},
            "undetermined": list(self.not_identifiable),
        }

    def to_json(self, file: str | Path) -> None:
        """Write values and intervals; the file appears as a whole or not at all.

        What is not finite, as the end of an interval may be, is null.
        """
        check_ending(Path(file), ".json")
        text = json.dumps(self.as_dict(), indent=2, allow_nan=False) + "\n"
        with whole(Path(file)) as part:
            part.write_text(text, encoding="utf-8")

    def to_ssv(self, file: str | Path) -> None:
        """Write the settings as a set of values that tools load into the FMU.

        Units in it are the FMU's; of a rotating machine the description says how to read them.
        """
        check_ending(Path(file), ".ssv", ".xml")
        model = self.problem.experiment.table
        described = ", ".join(filter(None, [f"Fitted parameters of {model.name}", self.units.told]))
        text = ssv(Path(file).stem, described, model, self.settings)
        with whole(Path(file)) as part:
            part.write_text(text, encoding="utf-8")

    def to_fmu(
        self,
        file: str | Path,
        *,
        preset: str = "all",
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
        parameters: Sequence[str] | None = None,
        name: str | None = None,
        default_experiment: Mapping[str, object] | None = None,
        source: str | Path | None = None,
        beside: bool = False,
    ) -> list[Path]:
        """Write the fitted machine as an FMU of its own; its documentation page shows the fit.

        The arguments are those of `export_fmu`. Values are those of `settings`: the run begins as the first segment.

        Raises
        ------
        ValueError
            For a wrong name or value, or an input that the machine needs and that is left out.
        """
        from pneumatic_servo.export import write
        from pneumatic_servo.identification.report import sections

        path, model = Path(file), self.problem.experiment.table
        return write(
            path, Model(model.name), self.settings, preset, (inputs, outputs, parameters), name, default_experiment,
            source, beside, sections(self, self._residuals, self.verdict),
        )  # fmt: skip

    def to_report(self, file: str | Path) -> None:
        """Write a page with tables and figures, in one file."""
        check_ending(Path(file), ".html", ".htm")
        from pneumatic_servo.identification.report import page

        text = page(self, self._residuals, self.verdict, self.free_form)
        with whole(Path(file)) as part:
            part.write_text(text, encoding="utf-8")

    def __repr__(self) -> str:
        width = max((len(name) for name in self.parameters), default=4)
        lines = [f"{self.law}: {'converged' if self.converged else 'not converged'}"]
        lines += [f"  {name:{width}}  {estimate}" for name, estimate in self.parameters.items()]
        for title, rms in (("rms", self.rms), ("validation rms", self.validation_rms)):
            lines += [
                f"  {title} of {signal}: {value:.6g} {self.units.of_signal(signal)}" for signal, value in rms.items()
            ]
        lines += [f"  not identifiable: {name}: {reason}" for name, reason in self.not_identifiable.items()]
        lines += [f"  note: {note}" for note in self.notes]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        rows = (
            [name, f"{e.value:.6g}", f"{e.low:.6g}", f"{e.high:.6g}", e.unit] for name, e in self.parameters.items()
        )
        left = ([signal, f"{rms:.6g}", self.units.of_signal(signal)] for signal, rms in self.rms.items())
        verdict = "converged" if self.converged else "not converged"
        notes = "".join(f"<li>{escape(note)}</li>" for note in self.notes)
        return (
            f"<p><b>{escape(self.law)}</b>: {verdict}</p>"
            + table(["parameter", "value", "low", "high", "unit"], rows)
            + table(["signal", "rms", "unit"], left)
            + (f"<ul>{notes}</ul>" if notes else "")
        )


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None

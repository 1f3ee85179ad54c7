"""The call that fits a model to measured data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pneumatic_servo import checks
from pneumatic_servo.identification.experiments import EXPERIMENTS, Experiment, Options
from pneumatic_servo.identification.guess import started
from pneumatic_servo.identification.intervals import Certainty, certainty
from pneumatic_servo.identification.parameters import Free, parse, split, usual
from pneumatic_servo.identification.problem import FAILED, Problem
from pneumatic_servo.identification.records import Record, load
from pneumatic_servo.identification.result import Estimate, Fit
from pneumatic_servo.identification.solve import ROUGH, Solution, Tell, refine, solve
from pneumatic_servo.identification.table import SIGNALS, Column, columns_of
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]
Data = str | Path | Mapping[str, ArrayLike]
ROUNDS = 4
"""How often sensors and parameters are fitted in turn."""
SAME = 0.03
"""Relative change of the noise that no longer matters."""
INPUTS = ("held", "lines")
LOSSES = ("linear", "soft_l1", "huber", "cauchy")


def fit(
    data: Data | Sequence[Data],
    *,
    experiment: str,
    law: str,
    fit: str | Sequence[str] = (),
    columns: str | Mapping[str, str] | None = None,
    settings: Mapping[str, Value] | None = None,
    hold_out: float = 0.0,
    hold_out_data: Data | Sequence[Data] = (),
    seed: int = 0,
    starts: int = 32,
    rated: float = 1.0,
    width: float = 0.04,
    play: float | None = None,
    window: float | None = None,
    inputs: str = "held",
    loss: str = "linear",
    intervals: str = "jacobian",
    workers: int | None = None,
    cluster: Any = None,
    progress: Tell | None = None,
) -> Fit:
    """Fit parameters of a model to measured data.

    Parameters
    ----------
    data : path, mapping of arrays, or a sequence of them
        Tables, or signals by name in SI units with ``time`` among them.
    experiment : str
        ``motion``: the motion is prescribed, a force is compared. ``mechanical``: pressures are given, the position
        is compared. ``pneumatic``: position and voltage are given, the pressures are compared. ``rig``: the voltage is
        given, position and pressures are compared.
    law : str
        Friction law.
    fit : str or sequence of str
        What is free: ``NAME[=start][:low:high]``; by default forces, stiffnesses and velocities of the law. Names are
        those of the model, ``offset.SIGNAL``, ``delay.SIGNAL``, and for ``motion`` ``area`` and ``friction.kappaA``.
    columns : str or mapping, optional
        ``SIGNAL=column[unit],...``; needed for tables.
    settings : mapping, optional
        Parameters that are known.
    hold_out : float
        Share of each record, at its end, that is not fitted but predicted.
    hold_out_data : path, mapping of arrays, or a sequence of them
        Data that are predicted as a whole.
    seed, starts : int
        Seed of the random starts, and their number; a start from the data is always among them.
    rated : float
        Normal force in N at which the load level is 1.
    width, play, window, inputs : float or str
        See `Options`.
    loss : str
        Loss function of ``scipy.optimize.least_squares``.
    intervals : str
        ``jacobian``, ``profile`` or ``bootstrap``.
    workers : int, optional
        Threads; by default one per core.
    cluster : dask.distributed.Client, optional
        Where the starts are simulated and refined instead of here.
    progress : callable, optional
        Is told what is being done.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        For data and options that cannot be used; the message says which.
    """
    options = Options(
        rated=_positive("rated", rated), width=_positive("width", width),
        play=None if play is None else _not_negative("play", play),
        window=None if window is None else _positive("window", window), inputs=inputs,
    )  # fmt: skip
    for name, number in (("starts", starts), ("seed", seed)):
        _not_negative(name, number)
        checks.whole_number(name, number, least=0)
    if workers is not None:
        checks.whole_number("workers", workers, least=1)
    if not 0.0 <= hold_out < 1.0:
        raise ValueError(f"--hold-out {hold_out}: it must be at least 0 and below 1")
    if inputs not in INPUTS:
        raise ValueError(f"--inputs {inputs}: it must be {' or '.join(INPUTS)}")
    if loss not in LOSSES:
        raise ValueError(f"loss = {loss}: it must be one of {', '.join(LOSSES)}")
    if intervals not in ("jacobian", "profile", "bootstrap"):
        raise ValueError(f"intervals = {intervals}: it must be jacobian, profile or bootstrap")
    kind = make_experiment(experiment, law, settings or {}, options)
    read = columns_of(columns) if columns is not None else {}
    records, notes = _load(kind, _listed(data), read)
    extra = _load(kind, _listed(hold_out_data), read)[0] if hold_out_data else []
    free = free_parameters(kind, fit)
    problem = replace(Problem.of(kind, records, free, hold_out, extra), workers=workers)
    _check_size(problem)
    problem = started(problem)
    fitted = problem.trained()
    _check_start(fitted)
    best, _ = solve(fitted, starts, seed, loss, cluster, progress)
    fitted, best = _with_likely_sensors(fitted, best, loss, progress)
    if progress is not None:
        progress("intervals")
    sure = certainty(fitted, best.x, intervals, seed)
    problem = problem.seen_by(fitted.sensors).begun(fitted, best.x)
    x = best.x[: len(problem.free)]
    return _result(problem, x, best.converged, best.message, sure, [*notes, *dict.fromkeys(kind.notes)])


def make_experiment(name: str, law: str, settings: Mapping[str, Value], options: Options) -> Experiment:
    """Return the experiment of a name."""
    if name not in EXPERIMENTS:
        raise ValueError(f"--experiment {name}: it must be one of {', '.join(EXPERIMENTS)}")
    experiment = EXPERIMENTS[name](law, settings, options)
    laws = experiment.table.parameters["friction.law"].items
    if law not in laws:
        raise ValueError(f"--law {law}: there is no such law; there are {', '.join(laws)}")
    if settings.get("friction.law", law) != law:
        raise ValueError(f"--law {law}: the law is given twice, by --set as {settings['friction.law']}")
    special = {"area", "friction.kappaA"} if name == "motion" else set()
    for setting in settings:
        if setting not in special and setting not in experiment.table.variables:
            raise ValueError(f"--set {setting}: there is no such parameter of {experiment.table.name}")
    return experiment


def free_parameters(experiment: Experiment, given: str | Sequence[str]) -> list[Free]:
    """Return what is free."""
    words = split(given) if isinstance(given, str) else checks.names("fit", given)
    if not words:
        every = [*usual(experiment.law, experiment.table, experiment.settings), *experiment.unknown]
        words = [name for name in every if name not in experiment.settings]
    free = [parse(word, experiment.table, experiment.compared) for word in words]
    names = [parameter.name for parameter in free]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"--fit: {name} is given twice")
        if name in experiment.settings:
            raise ValueError(f"--fit {name}: it is also among the known values of --set")
    if not free:
        raise ValueError("--fit: nothing is free")
    missing = next((name for name in experiment.unknown if name not in {*names, *experiment.settings}), None)
    if missing is not None:
        raise ValueError(f"--fit: {missing} has no default; it must be free, or known by --set {missing}=...")
    return free


def _listed(data: Data | Sequence[Data]) -> list[Data]:
    return [data] if isinstance(data, str | Path | Mapping) else list(data)


def _load(
    experiment: Experiment, data: Sequence[Data], columns: Mapping[str, Column]
) -> tuple[list[Record], list[str]]:
    if not data:
        raise ValueError("there are no data")
    if any(not isinstance(source, Mapping) for source in data) and not columns:
        raise ValueError("--columns is missing: it says which column is which signal")
    arrays: list[str | Path | Mapping[str, Array]] = []
    for source in data:
        if isinstance(source, Mapping):
            unknown = next((name for name in source if name not in SIGNALS), None)
            if unknown is not None:
                raise ValueError(f"there is no signal {unknown}; there are {', '.join(SIGNALS)}")
            arrays.append({name: np.asarray(values, dtype=float) for name, values in source.items()})
        else:
            arrays.append(source)
    measured = [set(source) if isinstance(source, Mapping) else set(columns) for source in arrays]
    experiment.use(set.intersection(*measured))
    return load(arrays, columns)


def _check_size(problem: Problem) -> None:
    rests = [bool(np.all(problem.experiment.resting(window.record))) for window in problem.windows]
    if "position" in problem.experiment.compared and all(rests):
        raise ValueError("all at rest: the position never leaves its noise")
    if not any(window.fitted for window in problem.windows):
        raise ValueError("all at rest: no sample moves beyond the noise of the position")
    samples = sum(window.fitted for window in problem.windows)
    count = samples * len(problem.experiment.compared)
    if count < 5 * len(problem.free):
        raise ValueError(f"too short: {count} samples to compare for {len(problem.free)} free parameters")


def _check_start(problem: Problem) -> None:
    """Refuse a start that cannot be simulated at all, with the model's own words."""
    problem.refusals.clear()
    if np.all(np.abs(problem.residuals([problem.start])) == FAILED) and problem.refusals:
        raise ValueError(f"the start values cannot be simulated: {problem.refusals[0]}")


def _with_likely_sensors(problem: Problem, best: Solution, loss: str, tell: Tell | None) -> tuple[Problem, Solution]:
    """Weigh the signals by what remains of them, and fit anew, until both agree.

    A signal that the model misses must not drown the others, and a converter is only known once the rest is.
    """
    for _ in range(ROUNDS):
        before = problem.sensors
        problem = problem.seen_by(problem.likely_sensors(best.x))
        changes = [abs(np.log(after.noise / before[signal].noise)) for signal, after in problem.sensors.items()]
        if max(changes) < SAME:
            break
        best = refine(problem, best.x, loss, tell, ROUGH)
    return problem, refine(problem, best.x, loss, tell)


def _result(problem: Problem, x: Array, converged: bool, message: str, sure: Certainty, notes: Sequence[str]) -> Fit:
    values = problem.values(x)
    parameters = {
        free.name: Estimate(values[free.name], float(sure.low[place]), float(sure.high[place]), free.unit)
        for place, free in enumerate(problem.free)
    }
    rms = problem.rms(x)
    if not all(np.isfinite(value) for value in rms.values()):
        converged, message = False, f"the fitted values cannot be simulated: {next(iter(problem.refusals), '')}"
    return Fit(
        converged=converged, law=problem.experiment.law, parameters=parameters, rms=rms,
        hold_out_rms=problem.rms(x, held=True), undetermined=sure.reasons, aic=_aic(problem, x), notes=tuple(notes),
        problem=problem, x=x, certainty=sure, message=message,
    )  # fmt: skip


def _aic(problem: Problem, x: Array) -> float:
    """Akaike's criterion for normal residuals of each signal."""
    number = sum(window.fitted for window in problem.windows)
    rms = problem.rms(x)
    return float(sum(2.0 * number * np.log(max(value, 1e-300)) for value in rms.values()) + 2.0 * len(x))


def _not_negative(name: str, value: float) -> float:
    if not value >= 0.0 or not np.isfinite(value):
        raise ValueError(f"--{name} {value}: it must not be negative")
    return value


def _positive(name: str, value: float) -> float:
    if not value > 0.0 or not np.isfinite(value):
        raise ValueError(f"--{name} {value}: it must be positive")
    return value

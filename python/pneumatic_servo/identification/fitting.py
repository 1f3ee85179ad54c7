"""The call that fits a model to measured data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import checks, effects, values
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.chosen_columns import Column, columns_of
from pneumatic_servo.errors import warn
from pneumatic_servo.identification.conditions import Condition, conditions
from pneumatic_servo.identification.cross_validation import USUAL
from pneumatic_servo.identification.cross_validation import cross_validate as cross_validate_by
from pneumatic_servo.identification.experiments import EXPERIMENTS, INPUTS, REQUIRED, Experiment, Options
from pneumatic_servo.identification.fitted import Estimate
from pneumatic_servo.identification.intervals import Certainty, certainty
from pneumatic_servo.identification.parameters import Free, auxiliary, named_by, parse, split, unit_of, usual, words_of
from pneumatic_servo.identification.plausibility import (
    assumed,
    check_known_pressures,
    checked,
    compare,
    judged,
    recorded,
)
from pneumatic_servo.identification.problem import Problem, check_jac, tell_underivable
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.result import Fit
from pneumatic_servo.identification.sampling import emcee_of, sample
from pneumatic_servo.identification.signals import SIGNALS, SLIDING, Units, starts_of, told_units
from pneumatic_servo.identification.solve import Solution, search
from pneumatic_servo.identification.table import Measured, listed, measured
from pneumatic_servo.identification.ties import Tie, is_expression
from pneumatic_servo.identification.watch import Told, Watch, told
from pneumatic_servo.model import Model, Parameters
from pneumatic_servo.names import did_you_mean, renamed
from pneumatic_servo.run_errors import Interrupted
from pneumatic_servo.units import has_unit
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]
Data = Any
"""A file, a DataFrame, a run, or a mapping of arrays."""
OF_SENSORS = {
    f"{kind}.{signal}": unit
    for signal, own in SIGNALS.items() if signal != "time"
    for kind, unit in (("gain", "1"), ("offset", own), ("delay", "s"), ("lag", "s"))
}  # fmt: skip
"""Known properties of sensors, with their SI units."""
OF_BENCH = {
    "motion": {"area": "m2", "friction.kappaA": "1/Pa", "friction.direction.factor": "1"},
    "points": {"area": "m2", "friction.kappaA": "1/Pa", "friction.direction.factor": "1"},
    "force": {"incline": "rad", "spring": "N/m", "springRest": "m", "friction.direction.factor": "1"},
}
"""Properties of a test bench that its model does not have."""
LEAST, LEAST_POINTS = 5, 2
"""Samples, and points of steady motions of their own, for each parameter."""
MOST_LAW_ERROR = 2.0
"""A law that is expected to be off by more says nothing."""
LOSSES = ("linear", "soft_l1", "huber", "cauchy")


@renamed(hold_out="validation", hold_out_data="validation_data", window="segment")
def fit(
    data: Data | Sequence[Data],
    *,
    experiment: str,
    law: str,
    fit: str | Sequence[str] | Mapping[str, Any] = (),
    columns: str | Mapping[str, str] | None = None,
    encoding: str | None = None,
    settings: Parameters | None = None,
    validation: float = 0.0,
    validation_data: Data | Sequence[Data] = (),
    seed: int = 0,
    starts: int = 32,
    rated: float = 1.0,
    width: float = 0.04,
    play: float | None = None,
    segment: float | None = None,
    inputs: str | None = None,
    smoothing: bool | None = None,
    loss: str = "linear",
    intervals: str = "jacobian",
    jac: str = "differences",
    posterior: bool = False,
    cross_validate: str | Sequence[str] = (),
    law_error: float = USUAL,
    workers: int | None = None,
    executor: Executor | None = None,
    cluster: Any = None,
    progress: Told = True,
) -> Fit:
    """Fit parameters of a model to measured data.

    Parameters
    ----------
    data : path, DataFrame, Run, mapping of arrays, or a sequence of them
        Tables in files (CSV, Parquet, MATLAB) or of pandas, runs, or signals by name in SI units with ``time`` among
        them.
    experiment : str
        ``motion``: the motion is prescribed, a force is compared. ``points``: velocity and load of each row are given
        without ``time``, the force of steady sliding is compared. ``force``: a force is given that moves a free mass,
        position or velocity or both are compared. ``mechanical``: pressures are given, the position
        is compared. ``pneumatic``: position and voltage are given, the pressures are compared. ``rig``: the voltage is
        given, position and pressures are compared.
    law : str
        Friction law.
    fit : str, sequence of str or mapping
        Estimated parameters: ``NAME[=start][:low:high]``, ``{NAME: start}`` or ``{NAME: (start, low, high)}``, where
        None is the usual start; by default forces, stiffnesses and velocities of the law. An expression in place of a
        start ties a parameter to others in SI units, ``friction.stribeck.Fs=1.2*friction.stribeck.Fc``; a name that
        only expressions use, ``ratio=1.2:1:3``, is a free number. Names are
        parameters of the model, ``gain.SIGNAL``, ``offset.SIGNAL`` and ``delay.SIGNAL`` of signals that are compared or
        drive the model (what is true is ``gain * (reading - offset)``, read so much later), ``lag.SIGNAL`` of those
        compared (the time constant of a filter of first order), for ``motion`` ``area``, ``friction.kappaA`` and
        ``friction.direction.factor``, for ``force`` the latter, ``incline``, ``spring`` and ``springRest``.
    columns : str or mapping, optional
        ``SIGNAL=column[unit],...``, or the same as a mapping; a column as it stands in the table, ``"Zeit [s]"``, or
        without its unit, and with a minus before it for the opposite sign. By default the columns that have the names
        of signals, in the units that stand behind them.
    encoding : str, optional
        Encoding of files of text; by default UTF-8, UTF-16 with a byte order mark, or Windows-1252.
    settings : mapping or path, optional
        Parameters that are known, with units as for `Model.simulate`, or an SSV file of them. Others have
        the model's defaults, which a note lists.
    validation : float
        Share of each record, at its end, that is validation data: not fitted but predicted.
    validation_data : path, mapping of arrays, or a sequence of them
        Data that are predicted as a whole.
    seed, starts : int
        Seed of the random starts, and their number; a start from the data is always among them.
    rated : float
        Normal force in N at which the load factor is 1.
    width, play, segment, inputs : float or str
        See `Options`; ``segment`` is its ``window``. ``inputs`` are held by ``hold``, as those of `Model.simulate`.
    smoothing : bool, optional
        Whether measured forces and pressures that move a mass are smoothed over ``width``; by default the one
        with the smaller residual, which a note states.
    loss : str
        Loss function of ``scipy.optimize.least_squares``.
    intervals : str
        ``jacobian``, ``profile`` or ``bootstrap``.
    jac : str
        Source of the derivatives of residuals: ``differences`` of runs, or the ``exact`` sensitivities of one.
        Where a run has no derivative with respect to a parameter, differences are used for it, with a warning.
    posterior : bool
        Whether to sample the posterior, too: see `Posterior`. It needs emcee, and takes thousands of runs.
    cross_validate : str or sequence of str
        What is left out and predicted, one condition after the other: ``record``, ``pressure``, ``load``,
        ``amplitude``, ``speed``, ``supplyPressure``, or several of them; see `CrossValidation`. A record is cut at gaps
        only, so that each stretch has one pressure.
    law_error : float
        Standard deviation, as a share, of what friction is expected to differ by from any law between these conditions,
        before the data tell; see `CrossValidation`.
    workers : int, optional
        Threads; by default one per core.
    executor : concurrent.futures.Executor, optional
        Where the starts are simulated and refined instead of here: a ``ProcessPoolExecutor``, ``client.get_executor()``
        of a Dask cluster, or any other. The bits are the same on each.
    cluster : dask.distributed.Client, optional
        The same by a client of Dask.
    progress : bool or callable
        Whether to show progress and the best residual so far on a terminal, or a function that is called with them as
        a text.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        For data and options that cannot be used; the message says which, and what may be right.
    Interrupted
        On Ctrl-C; its ``finished`` is the best fit until then, or None.

    Warns
    -----
    PlantWarning
        For likely mistakes: an assumed supply pressure, a residual as large as the signal.

    Notes
    -----
    Parameters that are not identifiable are in ``not_identifiable`` of the fit; where the start values show it,
    they are named at once, with the progress. Where a model does not describe the data, the search ends as soon as it
    gains little: after eight steps that lower the cost by less than a fiftieth together. A run that takes twenty
    times the solver steps of the first is given up, and counts as worse than any other.

    Examples
    --------
    >>> import numpy as np
    >>> import pneumatic_servo as ps
    >>> t = np.arange(0.0, 2.0, 1e-3)
    >>> x = 1e-3 * np.sin(6.0 * t)
    >>> force = 7.0 * np.sign(np.cos(6.0 * t)) + 0.01 * np.random.default_rng(0).standard_normal(len(t))
    >>> found = ps.fit({"time": t, "position": x, "frictionForce": force}, experiment="motion", law="Coulomb",
    ...                fit="friction.coulomb.Fc", settings={"friction.coulomb.sigma2": 0.0}, progress=False)
    >>> round(found.values["friction.coulomb.Fc"], 1)
    7.0
    """
    watch = Watch(f"fit {law}")
    with told(progress, watch):
        return _fit(
            data, experiment=experiment, law=law, fit=fit, columns=columns, encoding=encoding, settings=settings,
            validation=validation, validation_data=validation_data, seed=seed, starts=starts, rated=rated, width=width,
            play=play, segment=segment, inputs=inputs, smoothing=smoothing, loss=loss, intervals=intervals, jac=jac,
            posterior=posterior,
            cross_validate=cross_validate, law_error=law_error, workers=workers,
            executor=executor if cluster is None else _executor_of(cluster), watch=watch,
        )  # fmt: skip


def _executor_of(cluster: Any) -> Executor:
    if not hasattr(cluster, "get_executor"):
        raise TypeError(f"cluster={cluster!r} is refused: it must be a dask.distributed.Client")
    executor: Executor = cluster.get_executor()
    return executor


def _fit(
    data: Any, *, experiment: str, law: str, fit: str | Sequence[str] | Mapping[str, Any],
    columns: str | Mapping[str, str] | None,
    encoding: str | None, settings: Parameters | None, validation: float, validation_data: Any, seed: int, starts: int,
    rated: float, width: float, play: float | None, segment: float | None, inputs: str | None,
    smoothing: bool | None, loss: str,
    intervals: str, jac: str, posterior: bool, cross_validate: str | Sequence[str], law_error: float,
    workers: int | None, executor: Executor | None, watch: Watch,
) -> Fit:  # fmt: skip
    inputs = "held" if inputs == "hold" else inputs
    options = Options(
        rated=_positive("rated", values.number_in("N", "rated", rated)),
        width=_positive("width", values.seconds("width", width)),
        play=None if play is None else _not_negative("play", values.number_in("m", "play", play)),
        window=None if segment is None else _positive("segment", values.seconds("segment", segment)), inputs=inputs,
        smoothing=smoothing,
    )  # fmt: skip
    for name, number in (("starts", starts), ("seed", seed)):
        _not_negative(name, number)
        checks.whole_number(name, number, least=0)
    if _positive("law_error", law_error) > MOST_LAW_ERROR:
        raise ValueError(
            f"{quoted('law_error', law_error)}: it is a share of at most {MOST_LAW_ERROR:g}; did you mean "
            f"{0.01 * law_error:g}?"
        )
    checks.submits("executor", executor)
    if workers is not None:
        checks.whole_number("workers", workers, least=1)
    if not values.is_number(validation) or not 0.0 <= validation < 1.0:
        raise ValueError(f"{quoted('validation', validation)}: it must be at least 0 and below 1")
    if inputs is not None and inputs not in INPUTS:
        raise ValueError(f"{quoted('inputs', inputs)}: it must be one of hold, {', '.join(INPUTS[1:])}")
    if smoothing not in (None, True, False):
        raise ValueError(f"{quoted('smoothing', smoothing)}: it must be True, False or None")
    if loss not in LOSSES:
        raise ValueError(f"{quoted('loss', loss)}: it must be one of {', '.join(LOSSES)}")
    if intervals not in ("jacobian", "profile", "bootstrap"):
        raise ValueError(f"{quoted('intervals', intervals)}: it must be jacobian, profile or bootstrap")
    check_jac(jac)
    if posterior:
        if loss != "linear":
            raise ValueError(f"{quoted('posterior')}: the loss {loss} is none of a likelihood; use linear")
        emcee_of()
    check_names(experiment, law)
    table, beside = EXPERIMENTS[experiment](law, {}, Options()).table, units_beside(experiment, SLIDING)
    fit = words_of(fit, lambda name: beside.get(name) or unit_of(table, name))
    required = REQUIRED[experiment]
    read = columns_of(columns, SIGNALS, has_time="time" in required) if columns is not None else None
    sources = _read(data, read, encoding, required)
    is_extra = isinstance(validation_data, Mapping) or hasattr(validation_data, "iloc") or bool(validation_data)
    extra_sources = _read(validation_data, read, encoding, required) if is_extra else []
    _tell_twice(sources, extra_sources)
    kind = make_experiment(
        experiment, law, settings, options, _units(experiment, sources + extra_sources, settings, fit)
    )
    effects.tell(kind.table, {**_of_model(kind), "friction.law": law}, kind.settings)
    records, notes = _load(kind, sources, loss)
    extra = _load(kind, extra_sources, loss)[0] if is_extra else []
    _check_sensors(kind)
    check_known_pressures(kind)
    free = free_parameters(kind, fit)
    problem = replace(Problem.of(kind, records, free, validation, extra), workers=workers, jac=jac)
    _check_size(problem)
    compare(kind, [*records, *extra])
    _conditions(problem.trained(), records, cross_validate)
    notes += assumed(problem.experiment, [*(one.name for one in free), *(one.name for one in kind.ties)])
    reached = search(problem, records, validation, extra, starts, seed, loss, executor, watch)
    if reached is None:
        raise Interrupted("interrupted")
    problem, fitted, best, is_interrupted = reached
    if best is None or is_interrupted:
        raise _interrupted(problem, fitted, best, [*notes, *watch.still_hidden()])
    groups = _conditions(fitted, records, cross_validate)
    try:
        watch.stage("intervals")
        sure = certainty(fitted, best.x, intervals, seed)
    except KeyboardInterrupt:
        raise _interrupted(problem, fitted, best, [*notes, *watch.still_hidden()]) from None
    notes += watch.still_hidden(sure.reasons)
    tell_underivable(fitted)
    found = _finished(problem, fitted, best, sure, [*notes, *dict.fromkeys(problem.experiment.notes)])
    try:
        if groups:
            watch.stage("cross-validation")
            found = replace(found, cross_validation=cross_validate_by(fitted, best.x, groups, loss, law_error, watch))
        if posterior:
            found = _with_posterior(found, fitted, best.x, seed, executor, watch)
    except KeyboardInterrupt:
        interrupted = Interrupted("interrupted")
        interrupted.finished = found
        raise interrupted from None
    return found


def _conditions(problem: Problem, records: list[Record], quantities: str | Sequence[str]) -> list[Condition]:
    words = split(quantities) if isinstance(quantities, str) else checks.names("cross_validate", quantities)
    return [group for quantity in dict.fromkeys(words) for group in conditions(problem, records, quantity)]


def _with_posterior(found: Fit, fitted: Problem, x: Array, seed: int, executor: Executor | None, watch: Watch) -> Fit:
    """Return a fit with draws from its posterior."""
    watch.stage("posterior")
    if found.not_identifiable:
        watch.say(f"the posterior of {', '.join(found.not_identifiable)} is hardly more than its bounds")
    return replace(found, posterior=sample(fitted, x, seed, executor, watch))


def _finished(problem: Problem, fitted: Problem, best: Solution, sure: Certainty, notes: Sequence[str]) -> Fit:
    problem = problem.seen_by(fitted.sensors).begun(fitted, best.x)
    found = _result(problem, best.x[: len(problem.free)], best.converged, best.message, sure, notes)
    judged(problem.experiment, problem.measured(), found.rms)
    return found


def _interrupted(problem: Problem, fitted: Problem, best: Solution | None, notes: Sequence[str]) -> Interrupted:
    """Return an interrupt with the best fit until then, if there is one."""
    interrupted = Interrupted("interrupted")
    if best is not None:
        sure = certainty(fitted, best.x)
        x = best.x[: len(problem.free)]
        problem = problem.begun(fitted, best.x)
        interrupted.finished = _result(problem, x, False, "it was interrupted", sure, notes)
    return interrupted


def _units(experiment: str, sources: Sequence[Measured], settings: Parameters | None, words: Sequence[str]) -> Units:
    """Return the units of the machine, as far as anybody wrote one."""
    stated = [(signal, si, where) for source in sources for signal, (si, where) in source.stated.items()]
    given = dict(settings) if isinstance(settings, Mapping) else {}
    given |= {f"{quoted('fit')}: {name}": text for name, text in starts_of(words)}
    return told_units(experiment, stated, given)


def check_names(name: str, law: str) -> None:
    """Refuse an experiment or a law that there is not."""
    if name not in EXPERIMENTS:
        raise ValueError(
            f"{quoted('experiment', name)}: it must be one of {', '.join(EXPERIMENTS)}"
            f"{did_you_mean(str(name), EXPERIMENTS)}"
        )
    if not isinstance(law, str | int):
        raise ValueError(f"{quoted('law', law)}: it must be the name of one law; compare_fits fits several")
    laws = EXPERIMENTS[name](law, {}, Options()).table.parameters["friction.law"].items
    if law not in laws:
        hint = did_you_mean(str(law), laws)
        raise ValueError(f"{quoted('law', law)}: there is no such law{hint}; there are {', '.join(laws)}")


def make_experiment(
    name: str, law: str, settings: Parameters | None, options: Options, units: Units = SLIDING
) -> Experiment:
    """Return the experiment of a name."""
    check_names(name, law)
    kind = EXPERIMENTS[name]
    table = kind(law, {}, options).table
    known = _known(name, table, settings, units)
    if known.get("friction.law", law) != law:
        raise ValueError(
            f"{quoted('law', law)}: the law is given twice, by {quoted('settings')} as {known['friction.law']}"
        )
    beside = {key: value for key, value in known.items() if key not in table.variables}
    own = {key: value for key, value in known.items() if key in table.variables}
    return kind(law, {**table._fitted(own), **beside}, options, units)


def _check_sensors(experiment: Experiment) -> None:
    """Refuse settings of a sensor that has no part in the experiment."""
    for name in experiment.settings:
        if name in OF_SENSORS and name not in experiment.beside:
            there = ", ".join(dict.fromkeys(known.partition(".")[2] for known in experiment.beside if "." in known))
            raise ValueError(f"{quoted('settings', name)}: only sensors of {there} have a part in this experiment")


def _known(name: str, table: Model, settings: Parameters | None, units: Units) -> dict[str, Value]:
    """Return known parameters in SI units; a test bench's are not in its model."""
    if settings is None or not isinstance(settings, Mapping):
        return table._settings(settings, "settings")
    special = units_beside(name, units)
    own = {key: value for key, value in settings.items() if key not in special}
    for key in own:
        if key not in table.variables:
            hint = did_you_mean(str(key), table.variables)
            raise ValueError(f"{quoted('settings', key)}: there is no such parameter of {table.name}{hint}")
        unit = table.variables[key].unit
        if units.of(unit) != unit and has_unit(own[key]):
            own[key] = values.number_in(units.of(unit), key, own[key])
    beside = {key: values.number_in(special[key], key, value) for key, value in settings.items() if key in special}
    return {**table._settings(own, "settings"), **beside}


def units_beside(name: str, units: Units) -> dict[str, str]:
    """Return other quantities than parameters of the model that may be fixed, with SI units."""
    own = {f"gain.{signal}": units.of_gain(signal) for signal in SIGNALS if signal != "time"}
    own |= {f"offset.{signal}": units.of_signal(signal) for signal in SIGNALS if signal != "time"}
    return {**OF_SENSORS, **own, **{key: units.of(unit) for key, unit in OF_BENCH.get(name, {}).items()}}


def _of_model(experiment: Experiment) -> dict[str, Value]:
    """Return the settings of the model; an experiment has some of its own beside them: the gain of a force, an area."""
    return {name: value for name, value in experiment.settings.items() if name in experiment.table.variables}


def free_parameters(experiment: Experiment, given: str | Sequence[str] | Mapping[str, Any]) -> list[Free]:
    """Return the estimated parameters."""
    words = words_of(given, lambda name: unit_of(experiment.table, name))
    if not words:
        every = [*usual(experiment.name, experiment.law, experiment.table, experiment.settings), *experiment.unknown]
        words = [name for name in every if name not in experiment.settings]
    tied = [word for word in words if is_expression(word.partition("=")[2], quoted("fit", word))]
    ties = [_tie(word, experiment) for word in tied]
    needed = {name for tie in ties for name in tie.names}
    free = [
        auxiliary(word)
        if (name := named_by(word)) in needed
        and name not in experiment.table.variables
        and name not in experiment.beside
        else parse(word, experiment)
        for word in words
        if word not in tied
    ]
    _check_ties(ties, [parameter.name for parameter in free], experiment)
    experiment.ties = tuple(ties)
    names = [*(one.name for one in free), *(one.name for one in ties)]
    settings = {**_of_model(experiment), "friction.law": experiment.law}
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"{quoted('fit')}: {name} is given twice")
        need = effects.reason_for(experiment.table, settings, name)
        if need:
            raise ValueError(f"{quoted('fit', name)}: it has no effect here, since it counts only with {need}")
        if name in experiment.settings:
            raise ValueError(f"{quoted('fit', name)}: it is also among the known values of {quoted('settings')}")
    if not free:
        raise ValueError(f"{quoted('fit')}: nothing is free")
    missing = next((name for name in experiment.unknown if name not in {*names, *experiment.settings}), None)
    if missing is not None:
        raise ValueError(
            f"{quoted('fit')}: {missing} has no default; it must be free, or fixed by {quoted('settings')}"
        )
    return free


def _tie(word: str, experiment: Experiment) -> Tie:
    """Read `NAME=expression`."""
    name, _, text = word.partition("=")
    own = parse(name, experiment)
    return Tie(own.name, own.unit, text.strip())


def _check_ties(ties: Sequence[Tie], free: Sequence[str], experiment: Experiment) -> None:
    """Refuse expressions of what has no value, or gets one by a later expression only."""
    every, known = {tie.name for tie in ties}, {*free, *experiment.settings}
    for tie in ties:
        where = quoted("fit", f"{tie.name}={tie.text}")
        for name in tie.names:
            variable = experiment.table.variables.get(name)
            has_default = variable is not None and isinstance(variable.default, float | int) and name not in every
            if name not in known and not has_default:
                later = "; its own expression comes later" if name in every else did_you_mean(name, [*known, *every])
                later = "; an expression cannot stand for itself" if name == tie.name else later
                raise ValueError(f"{where}: there is no parameter {name}{later}")
        known.add(tie.name)


def _read(
    data: Any, columns: Mapping[str, Column] | None, encoding: str | None, required: Sequence[str]
) -> list[Measured]:
    sources = listed(data)
    if not len(sources):
        raise ValueError("there are no data")
    return [
        measured(number, source, columns, encoding, required=required) for number, source in enumerate(sources, start=1)
    ]


def _tell_twice(sources: Sequence[Measured], extra: Sequence[Measured]) -> None:
    """Warn of a record that is given twice: it would count twice, or be predicted by itself."""
    for place, source in enumerate(sources):
        first = next((one for one in sources[:place] if _is_same(one, source)), None)
        if first is not None:
            warn(f"{source.name} has the samples of {first.name}: they count twice, and intervals are too narrow")
    for source in extra:
        first = next((one for one in sources if _is_same(one, source)), None)
        if first is not None:
            warn(
                f"validation_data: {source.name} has the samples of {first.name}, which is fitted: it predicts nothing"
            )


def _is_same(one: Measured, other: Measured) -> bool:
    return one.signals.keys() == other.signals.keys() and all(
        np.array_equal(samples, other.signals[signal]) for signal, samples in one.signals.items()
    )


def _load(experiment: Experiment, sources: list[Measured], loss: str) -> tuple[list[Record], list[str]]:
    experiment.use(set.intersection(*(set(source.signals) for source in sources)))
    records, notes = experiment.records(sources)
    sources, mended = checked(experiment, sources, loss)
    if experiment.is_steady:
        return records, notes
    if mended:
        records, notes = experiment.records(sources)
    return records, [*mended, *(note for source in sources for note in recorded(experiment, source)), *notes]


def _check_size(problem: Problem) -> None:
    rests = [bool(np.all(problem.experiment.resting(window.record))) for window in problem.windows]
    if "position" in problem.experiment.compared and all(rests):
        raise ValueError("all at rest: the position never leaves its noise")
    if not any(window.fitted for window in problem.windows):
        raise ValueError("all at rest: no sample moves beyond the noise of the position")
    for signal, course in problem.measured().items():
        if np.ptp(course) == 0.0:
            still = f"{signal} = {course[0]:g} {problem.experiment.units.of_signal(signal)} all the time"
            raise ValueError(
                f"{problem.windows[0].record.name}: {still}, so that nothing can be learned of it; is it the right "
                "column?"
            )
    samples = sum(window.fitted for window in problem.windows)
    count = samples * len(problem.experiment.compared)
    if count < (LEAST_POINTS if problem.experiment.is_steady else LEAST) * len(problem.free):
        raise ValueError(f"too short: {count} samples to compare for {len(problem.free)} free parameters")


def _result(problem: Problem, x: Array, converged: bool, message: str, sure: Certainty, notes: Sequence[str]) -> Fit:
    values = problem.values(x)
    parameters = {
        free.name: Estimate(values[free.name], float(sure.low[place]), float(sure.high[place]), free.unit)
        for place, free in enumerate(problem.free)
    }
    rms = problem.rms(x)
    if not all(np.isfinite(value) for value in rms.values()):
        why = problem.native.refusal(x)
        converged, message = False, f"the fitted values cannot be simulated: {why}"
    parameters |= sure.ties
    return Fit(
        converged=converged, law=problem.experiment.law, parameters=parameters, rms=rms,
        validation_rms=problem.rms(x, held=True), not_identifiable=sure.reasons, aic=_aic(problem, x),
        notes=tuple(notes), problem=problem, x=x, certainty=sure, message=message,
    )  # fmt: skip


def _aic(problem: Problem, x: Array) -> float:
    """Akaike's criterion for normal residuals of each signal."""
    number = sum(window.fitted for window in problem.windows)
    rms = problem.rms(x)
    return float(sum(2.0 * number * np.log(max(value, 1e-300)) for value in rms.values()) + 2.0 * len(x))


def _not_negative(name: str, value: float) -> float:
    if not value >= 0.0 or not np.isfinite(value):
        raise ValueError(f"{quoted(name, value)}: it must not be negative")
    return value


def _positive(name: str, value: float) -> float:
    if not value > 0.0 or not np.isfinite(value):
        raise ValueError(f"{quoted(name, value)}: it must be positive")
    return value

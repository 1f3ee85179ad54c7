"""Plausibility of data: units, sample interval, outliers, assumptions, residuals of a fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from pneumatic_servo.argument_names import quoted
from pneumatic_servo.errors import warn
from pneumatic_servo.identification.experiments import OF_CYLINDER, Experiment
from pneumatic_servo.identification.parameters import DAMPING_SPEED
from pneumatic_servo.identification.signals import SIGNALS, Units
from pneumatic_servo.identification.smoothing import noise
from pneumatic_servo.identification.table import Measured
from pneumatic_servo.plant_warnings import warn_saturation
from pneumatic_servo.units import scale

Array = NDArray[np.float64]

SLOW, TOO_SLOW = 0.1, 0.5
"""Intervals of samples in s between which a carriage does much that nobody sees, or all of it."""
TOO_FAST = 1e-6
"""An interval in s that no rig has."""
NEIGHBOURS = 5
"""Samples whose median tells what one of them should be."""
AWAY = 20.0
"""Standard deviations of the noise beyond which a sample is an outlier."""
HALF = 0.5
"""And by more than this share of the range of the others."""
LEAP = 3.0
"""Ratio of a leap to the step before it."""
SHOWN = 5
"""Outliers that are named."""
EMPTY = 2e4
"""No chamber has less, in Pa absolute."""
HIGHEST = 1e8
"""Nor more."""
BEYOND = 3.0
"""Largest ratio of a chamber's pressure to the supply's, even when compressed."""
UNITS, LEAST, MOST = ("Pa", "kPa", "mbar", "bar", "psi", "MPa"), 0.3, 1.5
"""Units that pressures are taken for each other in, and shares of the supply between which one is likely."""
BADLY = 0.5
"""A model that leaves more than this share of a signal's spread does not describe it."""


def checked(experiment: Experiment, data: Sequence[Measured], loss: str) -> tuple[list[Measured], list[str]]:
    """Refuse data that cannot be meant; return them with notes on what was mended.

    Raises
    ------
    ValueError
        For samples far apart, values that no cylinder has, and single samples far off all others; it names signal,
        column, range and what may be right. Under a robust loss such samples are bridged, and a note tells.
    """
    found, notes = [], []
    for source in data:
        _check_interval(experiment, source)
        without, told = _without_outliers(source, loss, experiment.units)
        notes += told
        _check_ranges(experiment, without)
        found.append(without)
    return found, notes


def assumed(experiment: Experiment, free: Sequence[str]) -> list[str]:
    """Return notes on what nobody gave; of a supply pressure that is only assumed a warning tells."""
    known = {*experiment.settings, *free, *experiment.signals}
    table = experiment.table
    if experiment.name in ("rig", "pneumatic") and "supplyPressure" not in known:
        supply = table.variables["supplyPressure"].default
        assert isinstance(supply, float)
        warn(
            f"supplyPressure = {supply:g} Pa is assumed, since it was neither measured nor given; give it by "
            f"{quoted('settings')}, for example supplyPressure = 6 bar"
        )
    # Its default is another form of the law than the first publication's.
    law = (DAMPING_SPEED,) if experiment.law == "LuGre" and experiment.name != "pneumatic" else ()
    names = [name for name in (*experiment.native.machine, *law) if name not in {*known, "supplyPressure"}]
    if not names:
        return []
    values = ", ".join(f"{name} = {table.variables[name].default:g} {table.variables[name].unit}" for name in names)
    return [f"not given, so that the default counts: {values}"]


def judged(experiment: Experiment, measured: Mapping[str, Array], rms: Mapping[str, float]) -> None:
    """Warn of signals whose residual is about as large as they are."""
    for signal, values in measured.items():
        spread = float(np.std(values))
        if np.isfinite(rms.get(signal, np.nan)) and rms[signal] > BADLY * spread > 0.0:
            unit = experiment.units.of_signal(signal)
            warn(
                f"the fitted model does not describe {signal}: RMS residual {rms[signal]:.4g} {unit} of a signal that "
                f"varies by {spread:.4g} {unit} rms; check units, signs, assumed values and estimated parameters"
            )


def _check_interval(experiment: Experiment, source: Measured) -> None:
    intervals = np.diff(source.signals["time"])
    usual = float(np.median(intervals)) if len(intervals) else 1e-3
    what = f"{source.name}: time ({source.written.get('time', 'in s')}): samples are {usual:.4g} s apart"
    if usual < TOO_FAST:
        raise ValueError(f"{what}, which no rig does; is the unit right? time=...[s] or [ms] says it")
    is_of_cylinder = experiment.name in OF_CYLINDER
    if usual <= (SLOW if is_of_cylinder else TOO_SLOW):
        return
    hint = f"{what}, too far to see the carriage start and stop; is it in ms? then write time=...[ms]"
    # A test bench may creep.
    if is_of_cylinder and usual > TOO_SLOW:
        raise ValueError(hint)
    warn(hint)


def _check_ranges(experiment: Experiment, source: Measured) -> None:
    for signal, readings in source.signals.items():
        values = readings if signal == "time" else experiment.true(signal, readings, {})
        low, high = float(np.min(values)), float(np.max(values))
        if signal == "position":
            _check_position(experiment, source, low, high)
        elif signal in ("chamberA.pressure", "chamberB.pressure", "supplyPressure"):
            _check_pressure(source, signal, low, high)
            if signal != "supplyPressure":
                _check_below_supply(experiment, source, signal, high)
        elif signal == "valveVoltage" and experiment.name in OF_CYLINDER:
            _check_voltage(experiment, source, low, high)


def _told(source: Measured, signal: str, low: float, high: float) -> str:
    column = f" (column {source.written[signal]})" if signal in source.written else ""
    return f"{source.name}: {signal}{column} is from {low:.5g} to {high:.5g} {SIGNALS[signal]}"


def _check_position(experiment: Experiment, source: Measured, low: float, high: float) -> None:
    told = _told(source, "position", low, high)
    mm = f"in mm it would be {1e-3 * low:.5g} to {1e-3 * high:.5g} m: write position=...[mm]"
    if experiment.name not in ("rig", "pneumatic"):
        if high - low > 10.0 and not experiment.units.is_rotating:
            raise ValueError(f"{told}; {mm}")
        return
    stroke = experiment.value("cylinder.stroke", {})
    margin = 0.02 * stroke + 1e-3
    if low >= -margin and high <= stroke + margin:
        return
    if high <= margin and -low <= stroke + margin and low < -margin:
        raise ValueError(f"{told}, below the retracted end; is its sign turned? then write position=-column")
    is_default = "" if "cylinder.stroke" in experiment.settings else ", which is its default"
    fits = 1e-3 * low >= -margin and 1e-3 * high <= stroke + margin
    raise ValueError(
        f"{told}, but cylinder.stroke = {stroke:g} m{is_default}; "
        + (mm if fits and high > 1.0 else "give the stroke, and count the position from the retracted end")
    )


def _check_voltage(experiment: Experiment, source: Measured, low: float, high: float) -> None:
    """Warn of voltages beyond the range of the valve, and say what they look like."""
    names = ("gain.valveVoltage", "offset.valveVoltage")
    if any(name in experiment.settings for name in names):
        warn_saturation(experiment.table.variables["valveVoltage"], low, high)
        return
    told = f"{_told(source, 'valveVoltage', low, high)}, but the valve takes 0 to 10 V and saturates beyond"
    if high > 1000.0:
        warn(f"{told}; are these mV? then write valveVoltage=...[mV]")
    elif high > 20.0:
        warn(f"{told}; is it in percent? then {quoted('settings', {'gain.valveVoltage': 0.1})} makes volts of it")
    elif low < -0.5 and high < 5.5:
        warn(f"{told}; does it count from the middle? then {quoted('settings', {'offset.valveVoltage': -5})} moves it")
    else:
        warn_saturation(experiment.table.variables["valveVoltage"], low, high)


def check_known_pressures(experiment: Experiment) -> None:
    """Refuse a supply that nobody has, in Pa."""
    supply = experiment.settings.get("supplyPressure")
    if experiment.name in OF_CYLINDER and supply is not None and float(supply) < EMPTY:
        raise ValueError(
            f"{quoted('settings', {'supplyPressure': supply})}: pressures are absolute and in Pa; did you mean "
            f"{supply:g} bar, which is {1e5 * float(supply):g} Pa?"
        )


def _check_pressure(source: Measured, signal: str, low: float, high: float) -> None:
    if low >= EMPTY and high <= HIGHEST:
        return
    told = f"{_told(source, signal, low, high)}, but pressures are absolute"
    if high > HIGHEST:
        raise ValueError(f"{told} and below {HIGHEST:g} Pa; is the unit right?")
    if high < 50.0:
        gauge = "barg" if low < 0.3 else "bar"
        raise ValueError(f"{told}; are these bar? then write {signal}=...[{gauge}]; barg counts from the atmosphere")
    if high < 5000.0:
        gauge = "kPag" if low < 30.0 else "kPa"
        raise ValueError(f"{told}; are these kPa? then write {signal}=...[{gauge}]; kPag counts from the atmosphere")
    raise ValueError(
        f"{told}; do these count from the atmosphere? then write [barg] or [kPag] behind the column, or add 101325 Pa"
    )


def _check_below_supply(experiment: Experiment, source: Measured, signal: str, high: float) -> None:
    """Refuse a chamber far above its supply, and say which unit would be right."""
    supply = experiment.settings.get("supplyPressure")
    if "supplyPressure" in source.signals:
        supply = float(np.max(source.signals["supplyPressure"]))
    if experiment.name not in OF_CYLINDER or supply is None or not EMPTY < float(supply) < high / BEYOND:
        return
    row = int(np.argmax(source.signals[signal]))
    unit = source.written.get(signal, "").rpartition(" in ")[2] or "Pa"
    times, offset = scale(unit, "Pa", signal)
    number = (high - offset) / times
    likely = [
        f"[{other}] makes {1e-5 * pressure:.3g} bar of it"
        for other in UNITS
        if other != unit
        and LEAST * float(supply) < (pressure := number * scale(other, "Pa", signal)[0]) < MOST * float(supply)
    ]
    raise ValueError(
        f"{source.where(signal, row)}: {signal} = {number:.5g} {unit} at {source.signals['time'][row]:.6g} s, which is "
        f"{1e-5 * high:.4g} bar, {high / float(supply):.3g} times the supply of {1e-5 * float(supply):.3g} bar; is the "
        f"unit right? {' or '.join(likely) or 'No usual unit brings it below the supply'}"
    )


def _without_outliers(source: Measured, loss: str, units: Units) -> tuple[Measured, list[str]]:
    signals, notes = dict(source.signals), []
    for signal, values in source.signals.items():
        # A voltage may well be a pulse of one sample.
        if signal in ("time", "valveVoltage"):
            continue
        wrong, usual = outliers(values)
        if not len(wrong):
            continue
        first = [
            f"{source.where(signal, int(row))} = {values[row]:g} {units.of_signal(signal)}" for row in wrong[:SHOWN]
        ]
        more = f" and {len(wrong) - SHOWN} more" if len(wrong) > SHOWN else ""
        told = f"{source.name}: {signal} is far off all samples around it at {', '.join(first)}{more}"
        if loss == "linear":
            raise ValueError(f"{told}; correct or remove the sample, or use a robust loss, {quoted('loss', 'soft_l1')}")
        notes.append(f"{told}; it is bridged")
        bridged = values.copy()
        bridged[wrong] = usual[wrong]
        signals[signal] = bridged
    return replace(source, signals=signals), notes


def outliers(values: Array) -> tuple[NDArray[np.int64], Array]:
    """Return which samples are far off those around them, and the medians of those.

    One or two samples that go far beyond what the signal does otherwise: a lost word of a converter, a comma at the
    wrong place. Steps and peaks that last are none. What is beside the first sample and the last is not known, so that
    a leap there may be a step.
    """
    if len(values) < 4 * NEIGHBOURS:
        return np.zeros(0, dtype=np.int64), values
    usual = np.asarray(median_filter(values, size=NEIGHBOURS, mode="nearest"))
    low, high = np.quantile(usual, [0.01, 0.99])
    limit = max(AWAY * noise(values), HALF * float(high - low))
    if limit <= 0.0:
        return np.zeros(0, dtype=np.int64), usual
    # A peak that is climbed to over some samples was measured, however short it is.
    far = np.flatnonzero(np.abs(values - usual) > limit)
    runs = np.split(far, np.flatnonzero(np.diff(far) > 1) + 1) if len(far) else []
    wrong = [
        run for run in runs if _leaps(values, int(run[0]), limit) and _leaps(values[::-1], -1 - int(run[-1]), limit)
    ]
    return np.concatenate([*wrong, np.zeros(0, dtype=np.int64)]), usual


def _leaps(values: Array, first: int, limit: float) -> bool:
    """Whether a signal leaps to a sample, by far more than it moved before; it is not the first."""
    first %= len(values)
    steps = np.abs(np.diff(values[max(first - 2, 0) : first + 1]))
    return bool(steps[-1] > max(limit, LEAP * float(steps[0] if len(steps) > 1 else 0.0)))

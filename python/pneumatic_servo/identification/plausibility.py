"""Plausibility of data: units, signs, sample interval, outliers, assumptions, residuals of a fit.

The crate `fit` finds what is wrong with a record, for the page as well; here are the words for its remedies.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.errors import warn
from pneumatic_servo.identification.experiments import Experiment
from pneumatic_servo.identification.parameters import DAMPING_SPEED
from pneumatic_servo.identification.records import Record, plain
from pneumatic_servo.identification.signals import SIGNALS
from pneumatic_servo.identification.table import Measured

Array = NDArray[np.float64]

BADLY = 0.5
"""A model that leaves more than this share of a signal's spread does not describe it."""
GAUGE = "[barg], [kPag] and [Pag] count from the atmosphere"


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
        signals = dict(source.signals)
        columns, units = dict(source.written), _units(experiment)
        given = {signal: plain(values) for signal, values in signals.items()}
        for finding in experiment.native.findings(source.name, given, columns, units, source.where):
            text, remedies, _ = finding
            if loss != "linear" and remedies and remedies[0][0] == "remove":
                _, (signal,), _, _, rows = remedies[0]
                notes.append(f"{text}; it is bridged")
                signals[signal] = signals[signal].copy()
                signals[signal][rows] = outliers(given[signal])[1][rows]
            else:
                _tell(finding)
        found.append(replace(source, signals=signals))
    return found, notes


def recorded(experiment: Experiment, source: Measured) -> list[str]:
    """Warn of likely effects of a recorder on a table; return notes of harmless ones.

    Warns
    -----
    PlantWarning
        For readings that stop at an end, positions that leap, and rows that are repeated.
    """
    given = {signal: plain(values) for signal, values in source.signals.items()}
    found, notes = experiment.native.recorder(source.name, given, _units(experiment), source.where)
    for finding in found:
        _tell(finding)
    return notes


def compare(experiment: Experiment, records: Iterable[Record]) -> None:
    """Refuse a velocity that is not the slope of its position, and warn of signs and chambers that are likely wrong."""
    for finding in experiment.native.contradictions([record.numbers for record in records], _units(experiment)):
        _tell(finding)


def check_known_pressures(experiment: Experiment) -> None:
    """Refuse a supply that nobody has, in Pa."""
    finding = experiment.native.doubtful_supply()
    if finding is not None:
        text, remedies, is_refused = finding
        _tell((f"{quoted('settings', 'supplyPressure')}: {text}", remedies, is_refused))


def outliers(values: Array) -> tuple[NDArray[np.int64], Array]:
    """Return which samples are far off those around them, and the medians of those.

    One or two samples that go far beyond what the signal does otherwise: a lost word of a converter, a comma at the
    wrong place. Steps and peaks that last are none.
    """
    return _native.outliers(plain(values))


def _units(experiment: Experiment) -> dict[str, str]:
    return {signal: experiment.units.of_signal(signal) for signal in SIGNALS if signal != "time"}


def _tell(finding: _native.Finding) -> None:
    """Refuse or warn, with the remedies in words of the call."""
    text, remedies, is_refused = finding
    ways = list(_ways(remedies, is_refused))
    if ways:
        text += f"{' then' if text.endswith('?') else ';'} {', or '.join(ways)}"
    if any(unit.endswith("g") for _, _, unit, _, _ in remedies):
        text += f"; {GAUGE}"
    if is_refused:
        raise ValueError(text)
    warn(text)


def _ways(remedies: Sequence[_native.Remedy], is_refused: bool) -> Iterable[str]:
    units = [(signals[0], unit) for kind, signals, unit, _, _ in remedies if kind == "unit"]
    if units:
        yield f"write {units[0][0]}=...{' or '.join(f'[{unit}]' for _, unit in units)}"
    for kind, signals, _, values, _ in remedies:
        if kind == "turn":
            yield f"write {signals[0]}=-column"
        elif kind == "swap":
            yield f"exchange the columns of {' and '.join(signals)}"
        elif kind == "set":
            whole = {name: int(value) if value.is_integer() else value for name, value in values}
            yield f"give {quoted('settings', whole)}"
        elif kind == "remove":
            robust = f"correct or remove the sample, or use a robust loss, {quoted('loss', 'soft_l1')}"
            yield robust if is_refused else "leave these rows out"


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
    acts = experiment.name != "pneumatic" and not experiment.is_steady
    law = (DAMPING_SPEED,) if experiment.law == "LuGre" and acts else ()
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

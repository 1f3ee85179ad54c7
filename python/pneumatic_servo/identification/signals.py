"""Signals that can be measured, and their units in a fit."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pneumatic_servo import _native
from pneumatic_servo.units import NUMBER, scale, units_of

SIGNALS = dict(_native.SIGNALS)
"""Signals and their SI units. `pressure` of a test bench is above ambient; the chambers' are absolute, as everywhere
in the model."""

ROTATING = dict(_native.ROTATING)
"""Units of a rotating machine in place of a sliding one's; equations and numbers are the same."""

GAINS = {(to, read): unit for to, read, unit in _native.GAINS}
"""The unit of a gain that makes a force or a torque of a reading."""


@dataclass(frozen=True)
class Units:
    """The units of a fit.

    Attributes
    ----------
    is_rotating : bool
        Whether the machine rotates: its force is a torque, its mass an inertia, its position an angle.
    readings : dict
        SI units of signals that are read in another unit than the machine's, as the current of a motor.
    """

    is_rotating: bool = False
    readings: Mapping[str, str] = field(default_factory=dict)

    def of(self, unit: str) -> str:
        """Return a unit of the model, or its counterpart of a rotating machine."""
        return ROTATING.get(unit, unit) if self.is_rotating else unit

    def of_signal(self, signal: str) -> str:
        """Return the SI unit of the readings of a signal."""
        # The force that loads a bearing is one in N.
        own = SIGNALS[signal] if signal == "normalForce" else self.of(SIGNALS[signal])
        return self.readings.get(signal, own)

    def of_gain(self, signal: str) -> str:
        """Return the unit of the gain of a reading."""
        return GAINS.get((self.of(SIGNALS[signal]), self.of_signal(signal)), "1")

    @property
    def told(self) -> str:
        """Note on the units of the model, for people; nothing for a machine that slides."""
        return "of a rotating machine: read N.m for N, kg.m2 for kg, rad for m" if self.is_rotating else ""


SLIDING = Units()


def si_of(signal: str, unit: str, where: str) -> str:
    """Return the SI unit that a unit of a signal is converted to; `where` begins the message of an error."""
    try:
        return _native.si_of(signal, unit)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def told_units(experiment: str, stated: Sequence[tuple[str, str, str]], given: Mapping[str, Any]) -> Units:
    """Return the units of a fit, from those that were written.

    Parameters
    ----------
    experiment : str
        Name of the experiment.
    stated : sequence of tuple of str
        Signal, SI unit, and where it was written, for each column with a unit.
    given : mapping
        Values by name, of which those with a unit of a rotating machine tell that it is one.

    Raises
    ------
    ValueError
        If one is written for a machine that slides and another for one that rotates.
    """
    other = {signal: si for signal, si, _ in stated if si != SIGNALS[signal]}
    if experiment != "force":
        for signal, si, where in stated:
            if si != SIGNALS[signal]:
                raise ValueError(
                    f"{where}: {signal} is in {si}, which only the experiment force takes; {experiment} takes "
                    f"{', '.join(units_of(SIGNALS[signal]))}"
                )
        return SLIDING
    motion = [one for one in stated if one[0] in ("position", "velocity")]
    turning = [one for one in motion if one[0] in other]
    sliding = [one for one in motion if one[0] not in other]
    if turning and sliding:
        (first, unit, _), (second, another, where) = turning[0], sliding[0]
        raise ValueError(
            f"{where}: {second} is in {another}, but {first} in {unit}: a machine slides or it rotates; which is it?"
        )
    words = [name for name, value in given.items() if _is_of_rotation(value)]
    if words and sliding:
        raise ValueError(
            f"{words[0]} = {given[words[0]]} is of a rotating machine, but {sliding[0][0]} is in {sliding[0][1]}; "
            "which is it?"
        )
    is_rotating = bool(turning or words or (other.get("force") == "N.m" and not sliding))
    forces = sorted({si for signal, si, _ in stated if signal == "force"})
    if len(forces) > 1:
        raise ValueError(f"force is in {' and in '.join(forces)} in different records; which is it?")
    own = Units(is_rotating)
    return Units(is_rotating, {"force": forces[0]} if forces and forces[0] != own.of_signal("force") else {})


def _is_of_rotation(value: Any) -> bool:
    """Tell whether a value is written in a unit that only a rotating machine has."""
    unit = ""
    if isinstance(value, str):
        match = NUMBER.fullmatch(value)
        unit = match[2] if match else ""
    elif isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], str):
        unit = value[1]
    # An angle may be an incline.
    for si in ROTATING.values():
        if unit and si != "rad":
            try:
                scale(unit, si, "")
            except ValueError:
                continue
            return True
    return False


def starts_of(words: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield names with their starts and bounds as they are written, of words NAME[=start][:low:high]."""
    for word in words:
        name, *texts = re.split("[:=]", word)
        for text in texts:
            yield name.strip(), text

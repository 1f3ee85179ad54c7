"""Values as SSV, the format of SSP for sets of parameters."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

from pneumatic_servo import _native
from pneumatic_servo.model_description import ModelDescription
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.numerals import finite
from pneumatic_servo.units import to_si
from pneumatic_servo.variables import Value

COMMON = "http://ssp-standard.org/SSP1/SystemStructureCommon"
VALUES = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
LINEAR = {"factor": "1", "offset": "0"}
"""Base units of a unit, with defaults of omitted ones."""


def ssv(name: str, text: str, model: ModelDescription, settings: Mapping[str, Value]) -> str:
    """Return settings of a model, parameters or inputs, described by a text; numbers are in the variables' SI units."""
    return _native.ssv(_native.Model(model.name), name, text, list(settings.items()))


def read_ssv(
    file: str | os.PathLike[str], model: ModelDescription | str = "PneumaticServoCylinder"
) -> dict[str, Value]:
    """Return the values of an SSV file, as `Fit.to_ssv` and ``pneumatic-servo configure`` write them.

    Wherever parameters are taken, the name of such a file is, too.

    Parameters
    ----------
    file : path
        The file.
    model : Model or str
        The model that has the variables.

    Returns
    -------
    dict
        Values by name, in SI units; items of enumerations by name.

    Raises
    ------
    ValueError
        If the file is no SSV, or has a variable or value that the model cannot have; the message names it.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> from pathlib import Path
    >>> sheet = ps.DataSheet(bore=32, rod=12, stroke=200, mass=5, qn=700)
    >>> sheet.to_ssv("machine.ssv")
    >>> ps.read_ssv("machine.ssv")["cylinder.bore"]
    0.032
    >>> Path("machine.ssv").unlink()
    """
    path = Path(file)
    model = ModelDescription(model) if isinstance(model, str) else model
    try:
        root = ElementTree.fromstring(path.read_bytes())
    except ElementTree.ParseError as error:
        raise ValueError(f"{path}: it is no XML: {error}") from None
    if root.tag != f"{{{VALUES}}}ParameterSet":
        raise ValueError(f"{path}: it is no SSV, since it begins with {root.tag}")
    units = {unit.get("name"): unit for unit in root.iter(f"{{{COMMON}}}Unit")}
    values: dict[str, Value] = {}
    for parameter in root.iter(f"{{{VALUES}}}Parameter"):
        name = parameter.get("name", "")
        where = f"{path}: {name}"
        if name not in model.variables:
            raise ValueError(f"{where}: {model.name} has no such variable{did_you_mean(name, model.variables)}")
        if name in values:
            raise ValueError(f"{where} is there twice")
        element = next(iter(parameter), None)
        if element is None or element.get("value") is None:
            raise ValueError(f"{where}: it has no value")
        values[name] = _value(model, name, element, units, where)
    return values


def _value(
    model: ModelDescription,
    name: str,
    element: ElementTree.Element,
    units: Mapping[str | None, ElementTree.Element],
    where: str,
) -> Value:
    kind, text = element.tag.rpartition("}")[2], element.get("value", "")
    if kind == "Enumeration":
        return text
    if kind == "Boolean":
        if text not in ("true", "false", "0", "1"):
            raise ValueError(f"{where}: {text!r} is neither true nor false")
        return text in ("true", "1")
    number = finite(text, where)
    unit = element.get("unit")
    if unit is not None and unit != model.variables[name].unit:
        base = units[unit].find(f"{{{COMMON}}}BaseUnit") if unit in units else None
        if base is None:
            return to_si(number, unit, model.variables[name].unit, where)
        factor, offset = (
            finite(base.get(key, default), f"{where}: {key} of {unit}") for key, default in LINEAR.items()
        )
        return finite(repr(factor * number + offset), where)
    return number

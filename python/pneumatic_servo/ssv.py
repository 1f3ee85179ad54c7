"""Values as SSV, the format of SSP for sets of parameters."""

from __future__ import annotations

from collections.abc import Mapping
from xml.sax.saxutils import quoteattr

from pneumatic_servo.model import Model
from pneumatic_servo.variables import Value

COMMON = "http://ssp-standard.org/SSP1/SystemStructureCommon"
VALUES = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"


def ssv(name: str, text: str, model: Model, settings: Mapping[str, Value]) -> str:
    """Return settings of a model, parameters or inputs, described by a text; numbers are in the variables' SI units."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<ssv:ParameterSet xmlns:ssc="{COMMON}" xmlns:ssv="{VALUES}" version="1.0" name={quoteattr(name)}',
        f'    description={quoteattr(text)} generationTool="pneumatic-servo">',
        "  <ssv:Parameters>",
    ]
    for variable, value in settings.items():
        lines.append(f"    <ssv:Parameter name={quoteattr(variable)}>{_typed(model, variable, value)}</ssv:Parameter>")
    return "\n".join([*lines, "  </ssv:Parameters>", "</ssv:ParameterSet>", ""])


def _typed(model: Model, name: str, value: Value) -> str:
    kind = model.variables[name].kind
    if kind == "enumeration":
        return f"<ssv:Enumeration value={quoteattr(str(value))}/>"
    if kind == "boolean":
        return f'<ssv:Boolean value="{str(bool(value)).lower()}"/>'
    if kind == "integer":
        return f'<ssv:Integer value="{int(value)}"/>'
    return f'<ssv:Real value="{float(value)!r}"/>'

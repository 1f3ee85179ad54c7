"""Defaults that give way: they follow the given values where both would not fit together.

A machine of 0.5 kg cannot carry the default carriage of 0.75 kg. The plant refuses that, in an FMU as here; here the
carriage then follows the moving mass, and a warning says so. What fits stays as it is, so that a run that an FMU can
make has the same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from pneumatic_servo.errors import Refused, warn
from pneumatic_servo.variables import Value, Variables

MOST = 8
"""As many defaults as may give way: three levels of friction, and the others."""


def fitted(variables: Variables, given: Mapping[str, Value], start: Callable[[Mapping[str, Value]], object],
           tell: Callable[[str], object] = warn) -> dict[str, Value]:  # fmt: skip
    """Return the given values with those that follow them where their defaults do not fit; `start` tries.

    Raises
    ------
    Refused
        When what was given is refused, or a default that follows nothing.
    """
    values = dict(given)
    for _ in range(MOST):
        try:
            start(values)
        except Refused as refused:
            name = refused.variable
            leader = _leader(variables, name)
            if name in given or leader is None or leader not in given:
                raise
            values[name] = _following(variables, name, leader, given)
            unit = variables[name].unit
            tell(
                f"{name} = {values[name]:g} {unit}: it was not given, and its default, {refused.value:g} {unit}, does "
                f"not fit {leader} = {given[leader]:g} {variables[leader].unit}, which it follows; give it to choose"
                " otherwise"
            )
        else:
            break
    return values


def is_in_doubt(variables: Variables, given: Mapping[str, Value]) -> bool:
    """Tell whether a default may have to give way, without trying."""
    return not variables.leaders.isdisjoint(given)


def followers(
    variables: Variables, given: Mapping[str, Value], settings: Mapping[str, Value]
) -> dict[str, tuple[str, float]]:
    """Return by the name of each default that gave way the parameter that it follows, and its derivative by that."""
    found = {}
    for name in settings:
        leader = None if name in given else _leader(variables, name)
        if leader is not None and leader in given:
            found[name] = (leader, _following(variables, name, leader, {leader: 1.0}))
    return found


def _leader(variables: Variables, name: str) -> str | None:
    follows = variables[name].follows if name in variables else None
    return follows[0] if follows else None


def _following(variables: Variables, name: str, leader: str, given: Mapping[str, Value]) -> float:
    value = float(given[leader])
    if variables[name].follows != (leader, True):
        return value
    own, other = variables[name].default, variables[leader].default
    assert isinstance(own, float)
    assert isinstance(other, float)
    return value * own / other

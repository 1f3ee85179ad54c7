"""Defaults that give way: they follow the given values where both would not fit together.

A machine of 0.5 kg cannot carry the default carriage of 0.75 kg. The plant refuses that, in an FMU as here; here the
carriage then follows the moving mass, and a warning says so. What fits stays as it is, so that a run that an FMU can
make has the same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from pneumatic_servo.errors import Refused, warn
from pneumatic_servo.variables import Value, Variables

WHOLE = {"mass.carriage": "mass.moving"}
"""Parameters that take the whole value of another."""
IN_PROPORTION = {"position0": "cylinder.stroke"}
"""Parameters in proportion to the defaults; so are the levels of sliding friction, to static friction."""
MOST = 8
"""As many defaults as may give way: three levels of friction, and the others."""


def leader_of(variables: Variables, name: str) -> str | None:
    """Return the parameter that another follows, if it follows one."""
    follower = variables.get(name)
    if follower is not None and follower.meaning == "Coulomb friction":
        of_law = (own for own in variables.values() if own.counts_for == follower.counts_for)
        return next((own.name for own in of_law if own.meaning == "static friction"), None)
    return WHOLE.get(name) or IN_PROPORTION.get(name)


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
            leader = leader_of(variables, name)
            if name not in variables or name in given or leader is None or leader not in given:
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
    known = (name for name in given if name in variables)
    return any(name in LEADERS or variables[name].meaning == "static friction" for name in known)


LEADERS = {*WHOLE.values(), *IN_PROPORTION.values()}


def followers(
    variables: Variables, given: Mapping[str, Value], settings: Mapping[str, Value]
) -> dict[str, tuple[str, float]]:
    """Return by the name of each default that gave way the parameter that it follows, and its derivative by that."""
    found = {}
    for name in settings:
        leader = None if name in given else leader_of(variables, name)
        if leader is not None and leader in given:
            found[name] = (leader, _following(variables, name, leader, {leader: 1.0}))
    return found


def _following(variables: Variables, name: str, leader: str, given: Mapping[str, Value]) -> float:
    value = float(given[leader])
    if name in WHOLE:
        return value
    own, other = variables[name].default, variables[leader].default
    assert isinstance(own, float)
    assert isinstance(other, float)
    return value * own / other

"""Variables without effect beside others: of another law or actuator, or of an option that is off.

The table of the model states the conditions; here the warnings follow from them, for one run or for many.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache

from pneumatic_servo import _native
from pneumatic_servo.bundled import parameter_sets
from pneumatic_servo.errors import warn
from pneumatic_servo.gases import GASES, gas
from pneumatic_servo.model_description import ModelDescription
from pneumatic_servo.variables import Value, Variable, Variables

LAW = "friction.law"
MOST = 4
"""Names that a warning lists."""


def tell(
    model: ModelDescription, settings: Mapping[str, Value], new: Iterable[str] | None = None, where: str = ""
) -> None:
    """Warn of given values without effect; of all settings, or of those that are new among them."""
    tell_runs(model, [settings], new, where)


def tell_runs(
    model: ModelDescription, runs: Sequence[Mapping[str, Value]], new: Iterable[str] | None = None, where: str = ""
) -> None:
    """Warn of values that are given for runs, and count in none of them."""
    variables = model.variables
    chosen = dict.fromkeys(name for settings in runs for name in settings) if new is None else dict.fromkeys(new)
    suspects = [name for name in chosen if name in variables and variables[name].role in ("fixed", "tunable", "input")]
    suspects = [name for name in suspects if any(own.get(name, variables[name].default) != variables[name].default
                                                 for own in runs)]  # fmt: skip
    lost = _lacking(model, runs, suspects)
    given = {name for own in runs for name in own}
    stated = [name for name in lost if _is_stated_for_all(variables, name, given)]
    if stated:
        _tell_law(variables, {str(own.get(LAW, variables[LAW].default)) for own in runs}, stated, where)
    others = [name for name in lost if name not in stated and not _is_of_a_set(name, runs)]
    _tell_lost({name: lost[name] for name in others}, where)
    _tell_doubts(model, runs, [name for name in chosen if name not in lost], where)


def _tell_doubts(
    model: ModelDescription, runs: Sequence[Mapping[str, Value]], names: Iterable[str], where: str
) -> None:  # fmt: skip
    """Warn of the first legal value of each parameter that is hardly meant, but for those of named sets."""
    for name in names:
        variable = model.parameters.get(name)
        if variable is None or variable.plausible is None:
            continue
        values = (float(own[name]) for own in runs if name in own and own[name] != variable.default)
        told = next((told for value in values if (told := model._native.doubt(name, value))), "")
        if told and not _is_of_a_set(name, runs):
            warn(f"{where}{told}")


def tell_notices(
    model: ModelDescription, noticed: Iterable[tuple[str, float, str]], given: Mapping[str, object], where: str = ""
) -> None:
    """Pass the warnings of the plant on: variable, value and remark; not for a default that is given, and so meant."""
    for name, value, remark in noticed:
        variable = model.variables.get(name)
        if variable is not None and name in given and value == variable.default:
            continue
        unit = "" if variable is None or variable.unit == "1" else f" {variable.unit}"
        warn(f"{where}{name} = {value:g}{unit}: {remark}{model._native.meant(name, value)}")


def tell_inputs(
    model: ModelDescription, runs: Sequence[Mapping[str, Value]], ranges: Mapping[str, tuple[float, float]]
) -> None:
    """Warn of inputs that leave their defaults and have no effect in any run, by their least and largest values."""
    inputs = model.inputs
    moved = [n for n, (low, high) in ranges.items() if n in inputs and not low == high == inputs[n].default]
    _tell_lost(_lacking(model, runs, moved))


def tell_outputs(
    model: ModelDescription, runs: Sequence[Mapping[str, Value]], outputs: Iterable[str] | None
) -> None:  # fmt: skip
    """Warn of outputs that are asked for by name and stay 0 in all runs, because an option is off."""
    asked = [name for name in outputs or () if name in model.outputs]
    _tell_lost(_lacking(model, runs, asked), are_outputs=True)


def _lacking(
    model: ModelDescription, runs: Sequence[Mapping[str, Value]], names: Iterable[str]
) -> dict[str, str]:  # fmt: skip
    """Return the variables that count in no run, with the condition that the first one lacks."""
    found = dict.fromkeys((name for name in names if model.variables[name].is_conditional), "")
    for settings in runs:
        if not found:
            break
        lacks = model._native.lacks(list(settings.items()), list(found))
        found = {name: before or lack for (name, before), lack in zip(found.items(), lacks, strict=True) if lack}
    return found if runs else {}


def _tell_lost(lost: Mapping[str, str], where: str = "", *, are_outputs: bool = False) -> None:
    for lack in dict.fromkeys(lost.values()):
        names = [name for name, own in lost.items() if own == lack]
        warn(where + _native.idle_warning(names, lack, are_outputs))


def _is_of_a_set(name: str, runs: Sequence[Mapping[str, Value]]) -> bool:
    """Tell whether runs have the value of a named set of parameters, and all else that the set states.

    A set describes a whole rig, whose other valve or law a run may well leave aside, or a gas.
    """
    return all(
        any(values.get(name, ...) == own.get(name) and values.keys() <= own.keys() for values in _sets())
        for own in runs if name in own
    )  # fmt: skip


@cache
def _sets() -> tuple[Mapping[str, Value], ...]:
    gases = [gas(name) for name in GASES]
    try:
        return (*gases, *parameter_sets().values())
    except FileNotFoundError:
        # A package that was built without FMUs has no rigs.
        return tuple(gases)


def reason_for(model: ModelDescription, settings: Mapping[str, Value], name: str) -> str:
    """Return the condition that a variable lacks to count; nothing if it counts."""
    return _lacking(model, [settings], [name] if name in model.variables else []).get(name, "")


def tell_by(model: ModelDescription, settings: Mapping[str, Value], names: Iterable[str]) -> None:
    """Warn of parameters by which is differentiated, and that have no effect: all is 0 then."""
    for name in names:
        need = reason_for(model, settings, name)
        if need:
            warn(f"sensitivities: {name} has no effect here, since it counts only with {need}: all by it are 0")


def tell_laws(variables: Variables, laws: Sequence[str], settings: Mapping[str, Value]) -> None:
    """Warn of parameters of one compared law, while the others keep their defaults."""
    for name in settings:
        variable = variables.get(name)
        if variable is None or variable.counts_for is None or variable.meaning not in LEVELS:
            continue
        kind, law = variable.counts_for
        keep = [
            own for other in laws if other != law for own in of_law(variables, other, variable.meaning)
            if own.name not in settings and own.default != settings[name]
        ]  # fmt: skip
        if kind == LAW and law in laws and keep:
            kept = ", ".join(f"{own.name} = {_shown(own, own.default)}" for own in keep[:MOST])
            more = f" and {len(keep) - MOST} more" if len(keep) > MOST else ""
            warn(
                f"{name} = {_shown(variable, settings[name])} counts for {law} alone; the others keep {kept}{more}: "
                f"the runs differ by their {variable.meaning}, not only by their laws"
            )


def unlike(variables: Variables, laws: Sequence[str], settings: Mapping[str, Value]) -> list[str]:
    """Return in which levels of friction laws are unlike: where their values differ, and where one has none."""
    told = []
    for meaning in LEVELS:
        levels: dict[str, list[str]] = {}
        for law in laws:
            own = [v for v in of_law(variables, law, meaning) if v.unit in ("N", "N.s/m", "N.m", "N.m.s/rad")]
            values = " and ".join(dict.fromkeys(_shown(v, settings.get(v.name, v.default)) for v in own))
            levels.setdefault(values or "no such parameter", []).append(law)
        if len(levels) > 1:
            told.append(f"{meaning}: " + "; ".join(f"{', '.join(of)} {value}" for value, of in levels.items()))
    return told


LEVELS = ("static friction", "Coulomb friction", "viscous friction")
"""Meanings by which laws are alike, so that a difference in them looks like one between laws."""


def _shown(variable: Variable, value: Value | None) -> str:
    number = f"{value:g}" if isinstance(value, int | float) else str(value)
    return number if variable.unit == "1" else f"{number} {variable.unit}"


def of_law(variables: Variables, law: str, meaning: str | None) -> list[Variable]:
    """Return the parameters of a law that have a meaning."""
    return [own for own in variables.values() if own.counts_for == (LAW, law) and own.meaning == meaning]


def _is_stated_for_all(variables: Variables, name: str, given: Iterable[str]) -> bool:
    """Tell whether a meaning is stated for all laws that have it, as data sheets state it."""
    variable = variables[name]
    meaning = _level(variable)
    if variable.counts_for is None or variable.counts_for[0] != LAW or meaning not in LEVELS:
        return False
    stated = set(given)
    return all(
        own.name in stated or "[" in own.name
        for own in variables.values()
        if own.meaning == meaning and own.counts_for is not None and own.counts_for[0] == LAW
    )


def _level(variable: Variable) -> str:
    """Return the level of friction that a parameter states; an excess states static friction."""
    return "static friction" if variable.meaning == "static excess" else str(variable.meaning)


def _tell_law(variables: Variables, laws: Iterable[str], names: Sequence[str], where: str) -> None:
    """Warn of a law that has none of the levels that are stated for all that have them."""
    stated = {_level(variables[name]) for name in names}
    for law in sorted(laws):
        own = [variable for variable in variables.values() if variable.counts_for == (LAW, law)]
        # A law without parameters is no friction, which is meant.
        if own and not any(_level(variable) in stated for variable in own):
            levels = " and ".join(sorted(stated))
            warn(f"{where}{LAW} = {law}: it has no {levels}, so that what is given of it does not reach this law")

"""Parameters without effect beside others: of another law or actuator, or of an option that is off."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from pneumatic_servo.bundled import parameter_sets
from pneumatic_servo.errors import warn
from pneumatic_servo.gases import GASES, gas
from pneumatic_servo.variables import Value, Variable, Variables

LAW = "friction.law"
MOST = 4
"""Names that a warning lists."""

Fact = Callable[[Mapping[str, Value]], bool]


@dataclass(frozen=True)
class Need:
    """Conditions under which parameters have an effect, as a function of all values and as a text."""

    names: re.Pattern[str]
    counts: Fact
    text: str


def _is(name: str, *items: str) -> Fact:
    return lambda values: values.get(name, items[0]) in items


def _is_not_zero(*names: str) -> Fact:
    return lambda values: any(float(values.get(name, 1.0)) != 0.0 for name in names)


COMMANDS = {
    **dict.fromkeys(("ProportionalValve", "PressureRegulator", "OneVoltage"), "voltage"),
    **dict.fromkeys(("TwoValves", "TwoRegulators", "EachValve"), "voltages"),
    "EachCoil": "coils",
}
"""Kind of the inputs that command an actuator, or switching valves."""


def _is_commanded_by(kind: str) -> Fact:
    def fact(values: Mapping[str, Value]) -> bool:
        actuation = values.get("actuation", "ProportionalValve")
        by = values.get("switching.command", "OneVoltage") if actuation == "SwitchingValves" else actuation
        # An actuator of one's own gets all commands.
        return COMMANDS.get(str(by), kind) == kind

    return fact


def _need(names: str, counts: Fact, text: str) -> Need:
    return Need(re.compile(names), counts, text)


NEEDS = [
    _need(r"thermal\.exponent", _is("thermal.model", "Polytropic", "PolytropicServo"),
          "thermal.model = Polytropic or PolytropicServo"),
    _need(r"thermal\.heatTransfer", _is("thermal.model", "EnergyBalance"), "thermal.model = EnergyBalance"),
    _need(r"valve\.table[AB]\..*", _is("valve.characteristic", "Table"), "valve.characteristic = Table"),
    _need(r"valve\.deadZone", _is("valve.characteristic", "Linear"), "valve.characteristic = Linear"),
    _need(r"hoseA\.diameter", _is_not_zero("hoseA.length", "throttleA.C", "quickExhaustA.C", "cushion.length"),
          "hoseA.length, throttleA.C, quickExhaustA.C or cushion.length above 0"),
    _need(r"hoseB\.diameter", _is_not_zero("hoseB.length", "throttleB.C", "quickExhaustB.C", "cushion.length"),
          "hoseB.length, throttleB.C, quickExhaustB.C or cushion.length above 0"),
    _need(r"sensor\.endHysteresis", _is_not_zero("sensor.endDistance[1]", "sensor.endDistance[2]"),
          "sensor.endDistance[1] or sensor.endDistance[2] above 0"),
    _need(r"throttle\.direction", _is_not_zero("throttleA.C", "throttleB.C"), "throttleA.C or throttleB.C above 0"),
    _need(r"throttle\.(free|b)",
          _is_not_zero("throttleA.C", "throttleB.C", "quickExhaustA.C", "quickExhaustB.C", "cushion.length"),
          "throttleA.C, throttleB.C, quickExhaustA.C, quickExhaustB.C or cushion.length above 0"),
    _need(r"quickExhaust\.(opening|b)", _is_not_zero("quickExhaustA.C", "quickExhaustB.C"),
          "quickExhaustA.C or quickExhaustB.C above 0"),
    _need(r"cushion\.C", _is_not_zero("cushion.length"), "cushion.length above 0"),
    _need(r"supply\.[Cb]", _is_not_zero("supply.volume"), "supply.volume above 0"),
    _need(r"leakage\.b", _is_not_zero("chamberA.leakage", "chamberB.leakage"),
          "chamberA.leakage or chamberB.leakage above 0"),
    _need(r"gas\.viscosity",
          _is_not_zero("hoseA.length", "throttleA.C", "quickExhaustA.C", "hoseB.length", "throttleB.C",
                       "quickExhaustB.C", "cushion.length", "piston.leakage"),
          "piston.leakage or a hose, throttle, quick exhaust valve or cushion"),
    _need(r"load\.rest", _is_not_zero("load.stiffness"), "load.stiffness above 0"),
    _need(r"friction\.position\.period", _is_not_zero("friction.position.amplitude"),
          "friction.position.amplitude above 0"),
    _need(r"chamberA\.(pressure0|leakage)", lambda values: not values.get("chamberA.open", False),
          "chamberA.open = false"),
    _need(r"chamberB\.(pressure0|leakage)", lambda values: not values.get("chamberB.open", False),
          "chamberB.open = false"),
    _need(r"position0|velocity0|mass\.moving|incline",
          lambda values: values.get("motion") != "Imposed" or float(values.get("coupling.compliance", 0.0)) != 0.0,
          "motion = Free or coupling.compliance above 0"),
    _need(r"mass\.carriage", _is("motion", "Free"), "motion = Free"),
    _need(r"solver\.step", lambda values: values.get("solver.scheme", "Adaptive") != "Adaptive",
          "a solver.scheme of fixed steps"),
    _need(r"solver\.relativeTolerance", _is("solver.scheme", "Adaptive"), "solver.scheme = Adaptive"),
]  # fmt: skip
"""Options of the cylinder, as the texts of its variables state them; laws and actuators are in the table itself."""

DRIVEN = [
    _need(r"imposed(Position|Velocity)", _is("motion", "Imposed"), "motion = Imposed"),
    _need(r"valveVoltage", _is_commanded_by("voltage"),
          "one voltage for both chambers; TwoValves, TwoRegulators and switching.command = EachValve take "
          "valveVoltageA and valveVoltageB, EachCoil takes coil[1] to coil[4]"),
    _need(r"valveVoltage[AB]", _is_commanded_by("voltages"),
          "actuation = TwoValves or TwoRegulators, or SwitchingValves with switching.command = EachValve"),
    _need(r"coil\[[1-4]\]", _is_commanded_by("coils"),
          "actuation = SwitchingValves and switching.command = EachCoil"),
    _need(r"supply\.(massFlow|consumed|consumedVolume)", lambda values: bool(values.get("consumption.enabled", False)),
          "consumption.enabled = true"),
    *(_need(rf"sensor\.end\[{end}\]", _is_not_zero(f"sensor.endDistance[{end}]"), f"sensor.endDistance[{end}] above 0")
      for end in (1, 2)),
]  # fmt: skip
"""The same for inputs, and for outputs, which are 0 without."""

READ = "is 0 throughout", "are 0 throughout"
IDLE = "has no effect", "have no effect"

ELEMENT = re.compile(r"(.+\.)[A-Za-z0-9]+\[(\d+)\]")


def tell(
    variables: Variables, settings: Mapping[str, Value], new: Iterable[str] | None = None, where: str = ""
) -> None:
    """Warn of given values without effect; of all settings, or of those that are new among them."""
    tell_runs(variables, [settings], new, where)


def tell_runs(
    variables: Variables, runs: Sequence[Mapping[str, Value]], new: Iterable[str] | None = None, where: str = ""
) -> None:
    """Warn of values that are given for runs, and count in none of them."""
    if not runs:
        return
    chosen = dict.fromkeys(name for settings in runs for name in settings) if new is None else dict.fromkeys(new)
    suspects = [name for name in chosen if name in variables and variables[name].role in ("fixed", "tunable", "input")]
    suspects = [
        name for name in suspects
        if any(name in own and own[name] != variables[name].default for own in runs) and _may_fail(variables[name])
    ]  # fmt: skip
    if not suspects:
        return
    # Thousands of runs of a study differ in few options.
    every = list({_options(variables, own): _complete(variables, own) for own in runs}.values())
    given = {name for own in runs for name in own}
    lost: dict[str, list[str]] = {}
    stated: list[str] = []
    for name in suspects:
        reasons = [_missing(variables, own, variables[name]) for own in every]
        if all(reasons) and _is_stated_for_all(variables, name, given):
            stated.append(name)
        elif all(reasons):
            lost.setdefault(reasons[0], []).append(name)
    if lost:
        of_sets = {name for name in suspects if _is_of_a_set(name, runs)}
        lost = {reason: kept for reason, names in lost.items() if (kept := [n for n in names if n not in of_sets])}
    if stated:
        _tell_law(variables, {str(own.get(LAW)) for own in every}, stated, where)
    _tell_lost(lost, where, IDLE)


def tell_inputs(
    variables: Variables, runs: Sequence[Mapping[str, Value]], ranges: Mapping[str, tuple[float, float]]
) -> None:
    """Warn of inputs that leave their defaults and have no effect in any run, by their least and largest values."""
    moved = [n for n, (low, high) in ranges.items() if n in variables and not low == high == variables[n].default]
    _tell_lost(_lacking(variables, runs, moved), "", IDLE)


def tell_outputs(variables: Variables, runs: Sequence[Mapping[str, Value]], outputs: Iterable[str] | None) -> None:
    """Warn of outputs that are asked for by name and stay 0 in all runs, because an option is off."""
    asked = [name for name in outputs or () if name in variables and variables[name].role == "output"]
    _tell_lost(_lacking(variables, runs, asked), "", READ)


def _lacking(
    variables: Variables, runs: Sequence[Mapping[str, Value]], names: Iterable[str]
) -> dict[str, list[str]]:  # fmt: skip
    """Return the variables that count in no run, by the condition that the first one lacks."""
    lost: dict[str, list[str]] = {}
    for name in names:
        needs = [reason_for(variables, own, name) for own in runs] if _may_fail(variables[name]) else []
        if needs and all(needs):
            lost.setdefault(needs[0], []).append(name)
    return lost


def _tell_lost(lost: Mapping[str, Sequence[str]], where: str, verbs: tuple[str, str]) -> None:
    for reason, names in lost.items():
        shown = ", ".join(names[:MOST]) + (f" and {len(names) - MOST} more" if len(names) > MOST else "")
        verb, pronoun = (verbs[0], "it counts") if len(names) == 1 else (verbs[1], "they count")
        warn(f"{where}{shown} {verb}: {pronoun} only with {reason}")


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


def reason_for(variables: Variables, settings: Mapping[str, Value], name: str) -> str:
    """Return the condition that a parameter lacks to count; nothing if it counts."""
    variable = variables.get(name)
    return "" if variable is None else _missing(variables, _complete(variables, settings), variable)


def tell_by(variables: Variables, settings: Mapping[str, Value], names: Iterable[str]) -> None:
    """Warn of parameters by which is differentiated, and that have no effect: all is 0 then."""
    for name in names:
        need = reason_for(variables, settings, name)
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


def _may_fail(variable: Variable) -> bool:
    """Tell whether a parameter counts under conditions only."""
    return variable.counts_for is not None or _need_of(variable) is not None


def _need_of(variable: Variable) -> Need | None:
    needs = NEEDS if variable.role in ("fixed", "tunable") else DRIVEN
    return next((need for need in needs if need.names.fullmatch(variable.name)), None)


def _options(variables: Variables, settings: Mapping[str, Value]) -> tuple[tuple[str, object], ...]:
    """Return the variables of the conditions."""
    kinds = ("enumeration", "integer", "boolean")
    discrete = (n for n in settings if n.endswith("Number") or (n in variables and variables[n].kind in kinds))
    switches = ((name, settings[name] != 0.0) for name in SWITCHES if name in settings)
    return (*((name, settings[name]) for name in discrete), *switches)


SWITCHES = {
    "hoseA.length", "hoseB.length", "throttleA.C", "throttleB.C", "cushion.length", "supply.volume", "load.stiffness",
    "quickExhaustA.C", "quickExhaustB.C", "friction.position.amplitude", "chamberA.leakage", "chamberB.leakage",
    "coupling.compliance", "sensor.endDistance[1]", "sensor.endDistance[2]", "piston.leakage",
}  # fmt: skip
"""Real parameters that switch options off by being 0."""


def _complete(variables: Variables, settings: Mapping[str, Value]) -> dict[str, Value]:
    """Return the values of all that is given or has a default, items of enumerations by their names."""
    values = {v.name: v.default for v in variables.values() if v.default is not None} | dict(settings)
    for name, value in settings.items():
        if name.endswith("Number"):
            values[name.removesuffix("Number")] = value
    for name, value in values.items():
        variable = variables.get(name)
        if variable is not None and variable.kind == "enumeration" and not isinstance(value, str):
            values[name] = next((item for item, number in variable.ids.items() if number == value), value)
    return values


def _missing(variables: Variables, values: Mapping[str, Value], variable: Variable) -> str:
    if variable.counts_for is not None:
        name, item = variable.counts_for
        if values.get(name) != item:
            present = values.get(name)
            return f"{name} = {item}, and here it is {present}"
    need = _need_of(variable)
    if need is not None and not need.counts(values):
        return need.text
    return _beyond(variables, values, variable)


def _beyond(variables: Variables, values: Mapping[str, Value], variable: Variable) -> str:
    """Return the number of elements that an element beyond it needs."""
    match = ELEMENT.fullmatch(variable.name)
    if match is None:
        return ""
    number = next((f"{match[1]}{own}" for own in ("N", "points") if f"{match[1]}{own}" in variables), None)
    if number is None or not (match[1].startswith("friction.") or number.endswith("points")):
        return ""
    if variable.text.startswith(("Coefficient of the displacement", "Coefficient of the past")):
        return ""
    return f"{number} of at least {match[2]}" if int(match[2]) > float(values.get(number, 1e9)) else ""

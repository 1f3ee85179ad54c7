"""The public arguments of the package and its command line, as they are found by looking."""

from __future__ import annotations

import argparse
import inspect
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any, NamedTuple

import pneumatic_servo as ps
from pneumatic_servo import envs, identification
from pneumatic_servo.cli import parser

MODULES: tuple[ModuleType, ...] = (ps, identification, envs)
MADE = {
    "Band", "Comparison", "CrossValidation", "Crossing", "Estimate", "Evidence", "Fit", "Gradient", "Linearisation",
    "MissingPackage", "NoDerivative", "Plan", "Posterior", "Ranking", "Refused", "Run", "Runs", "SavedState",
    "Sensitivities", "Series", "Simulation", "Telling", "Transition", "Unit", "Variable", "Variables",
}  # fmt: skip
"""Classes that the package makes and users only read: what they are made from is no argument of anybody's."""
INNER = {"Comparison.of_begun", "Refused.with_unit", "Runs.of", "Task.in_si", "Variable.of"}
"""Made public for the package itself."""


class Argument(NamedTuple):
    """An argument of a function: its name in the table, who owns the function under which name, and the parameter."""

    key: str
    owner: Any
    function: str
    parameter: inspect.Parameter


def arguments() -> Iterator[Argument]:
    """Yield the arguments of all functions and methods."""
    seen: set[int] = set()
    for module in MODULES:
        for name in module.__all__:
            thing = getattr(module, name)
            if id(thing) in seen:
                continue
            seen.add(id(thing))
            if inspect.isfunction(thing):
                yield from _of(name, module, name, thing)
            elif inspect.isclass(thing):
                for method, function in _methods(thing).items():
                    if method in ("__init__", "__call__") and name not in MADE:
                        yield from _of(name, thing, method, function)
                    elif not method.startswith("_") and f"{name}.{method}" not in INNER:
                        plain = getattr(function, "__func__", function)
                        if inspect.isfunction(plain):
                            yield from _of(f"{name}.{method}", thing, method, plain)


def _methods(thing: type) -> dict[str, Any]:
    """What a class has of its own, and from classes of the package that it alone shows."""
    shown = {id(getattr(module, name)) for module in MODULES for name in module.__all__} - {id(thing)}
    hidden = [base for base in thing.__mro__ if base.__module__.startswith("pneumatic_servo") and id(base) not in shown]
    return {name: function for base in reversed(hidden) for name, function in vars(base).items()}


def _of(prefix: str, owner: Any, name: str, function: Callable[..., Any]) -> Iterator[Argument]:
    for parameter in inspect.signature(function).parameters.values():
        if parameter.name not in ("self", "cls"):
            yield Argument(f"{prefix}.{parameter.name}", owner, name, parameter)


def options() -> Iterator[tuple[str, argparse.ArgumentParser, argparse.Action]]:
    """Yield the options of all commands: name in the table, parser of the command, option."""
    [commands] = [action for action in parser()._actions if isinstance(action, argparse._SubParsersAction)]
    for command, own in commands.choices.items():
        for action in own._actions:
            if action.dest != "help":
                yield f"{command} {action.option_strings[0] if action.option_strings else action.dest}", own, action

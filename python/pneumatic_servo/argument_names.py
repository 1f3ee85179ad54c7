"""Names of arguments in messages: of Python, or options of the command line."""

from __future__ import annotations

from collections.abc import Mapping
from contextvars import ContextVar

ON_COMMAND_LINE: ContextVar[bool] = ContextVar("on the command line", default=False)
OPTIONS = {"settings": "set"}
"""Options that have another name than the argument."""


def quoted(argument: str, given: object = None) -> str:
    """Return an argument with its value: ``law='Lugre'``, or ``--law Lugre`` on the command line.

    Several things are given by their names: ``settings={'friction.law': 'Dahl'}``, or ``--set friction.law=Dahl``.
    """
    if ON_COMMAND_LINE.get():
        if isinstance(given, Mapping):
            given = ",".join(f"{name}={value}" for name, value in given.items())
        option = f"--{OPTIONS.get(argument, argument).replace('_', '-')}"
        return option if given is None else f"{option} {given}"
    return argument if given is None else f"{argument}={given!r}"

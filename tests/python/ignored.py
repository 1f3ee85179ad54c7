"""Takes the arguments of `arguments.toml` away one after the other, and says which tests do not notice.

Usage: python tests/python/ignored.py [BEGINNING ...], for example `fit.` or "configure --": only such arguments. Those
without a default cannot be taken away. It takes some minutes, and is no part of the tests.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import inspect
import io
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest.mock import patch

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "packaging" / "python")]
os.environ.setdefault("MPLBACKEND", "Agg")

import pytest  # noqa: E402
from public import MODULES, Argument, arguments, options  # noqa: E402
from test_arguments import ENTRIES  # noqa: E402

VARIABLE = {inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD}


def has_default(argument: Argument) -> bool:
    parameter = argument.parameter
    return parameter.kind in VARIABLE or parameter.default is not inspect.Parameter.empty


@contextlib.contextmanager
def without(argument: Argument) -> Iterator[None]:
    """Let a function see the default of an argument, whatever it is given."""
    stored = vars(argument.owner).get(argument.function)
    original = getattr(argument.owner, argument.function)
    signature = inspect.signature(original if stored is None else getattr(stored, "__func__", stored))

    @functools.wraps(original)
    def ignoring(*given: Any, **named: Any) -> Any:
        bound = signature.bind(*given, **named)
        bound.arguments.pop(argument.parameter.name, None)
        return original(*bound.args, **bound.kwargs)

    places = [argument.owner] if inspect.isclass(argument.owner) else [
        module for module in [*MODULES, *(sys.modules[f"pneumatic_servo.{name}"] for name in ("identification.laws",))]
        if vars(module).get(argument.function) is original or module is argument.owner
    ]  # fmt: skip
    with contextlib.ExitStack() as stack:
        for place in places:
            stack.enter_context(patch.object(place, argument.function, ignoring))
        yield


@contextlib.contextmanager
def without_option(own: argparse.ArgumentParser, action: argparse.Action) -> Iterator[None]:
    """Let a command see the default of an option."""
    parse = argparse.ArgumentParser.parse_known_args

    def ignoring(parser: argparse.ArgumentParser, *given: Any, **named: Any) -> Any:
        found, rest = parse(parser, *given, **named)
        if parser.prog == own.prog:
            setattr(found, action.dest, action.default)
        return found, rest

    with patch.object(argparse.ArgumentParser, "parse_known_args", ignoring):
        yield


def is_noticed(test: str) -> bool:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        code = pytest.main(["-q", "-x", "-p", "no:cacheprovider", "-c", str(HERE / "pytest.ini"), str(HERE / test)])
    if code not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        raise SystemExit(f"{test} cannot be run: pytest ends with {code!r}")
    return code == pytest.ExitCode.TESTS_FAILED


def main(beginnings: list[str]) -> int:
    taken = [(one.key, without(one)) for one in arguments() if has_default(one)]
    taken += [(key, without_option(own, one)) for key, own, one in options() if not one.required and one.option_strings]
    missed, number = [], 0
    for key, ignoring in taken:
        test = ENTRIES[key]
        if test.startswith("none: ") or (beginnings and not key.startswith(tuple(beginnings))):
            continue
        number += 1
        with ignoring:
            noticed = is_noticed(test)
        print(f"{'noticed' if noticed else 'MISSED '}  {key}: {test}", flush=True)
        if not noticed:
            missed.append(key)
    print(f"{number} arguments were ignored, {number - len(missed)} of them noticed")
    return 1 if missed else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))

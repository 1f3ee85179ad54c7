"""Show the variables of a model, with units, ranges and defaults.

With words, only the variables that have all of them in name or text.
"""

from __future__ import annotations

import argparse

from pneumatic_servo.cli.common import model_of
from pneumatic_servo.variables import Variables

NAME = "variables"


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("words", nargs="*", help="words to look for, for example `friction lugre`")
    parser.add_argument("--model", default="PneumaticServoCylinder", help="default: PneumaticServoCylinder")


def run(options: argparse.Namespace) -> None:
    """Print the variables."""
    model = model_of(options)
    found = False
    for title, variables in [("inputs", model.inputs), ("parameters", model.parameters), ("outputs", model.outputs)]:
        chosen = variables.matching(" ".join(options.words)) if options.words else variables
        if chosen:
            _show(title, chosen)
            found = True
    if not found:
        raise ValueError(f"no variable of {model.name} has the words {' '.join(options.words)}")


def _show(title: str, variables: Variables) -> None:
    print(f"{title}:")
    for variable in variables.values():
        print(f"  {variable}")

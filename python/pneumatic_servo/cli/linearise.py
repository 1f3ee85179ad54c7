"""Linearise the plant at an operating point and print A, B, C and D.

States and inputs that are not given are chosen so that nothing else moves. While a set-valued law sticks the plant
does not react, and within the play of the valve's hysteresis the valve does not: give a velocity, and
valve.hysteresis=0.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from pneumatic_servo.cli.common import add_model, check_outputs, merged, model_of, of_law, settings_of
from pneumatic_servo.files import write
from pneumatic_servo.linear import Linearisation

NAME = "linearise"


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_model(parser)
    parser.add_argument("--law", help="friction law (default: Stribeck)")
    parser.add_argument("--at", default="", metavar="NAME=VALUE,...", help="states, inputs and parameters, in SI units")
    parser.add_argument("--inputs", default="valveVoltage", metavar="NAME,...", help="default: valveVoltage")
    parser.add_argument("--outputs", default="position,velocity", metavar="NAME,...", help="default: position,velocity")
    parser.add_argument("--no-trim", action="store_true", help="take states and inputs as a run starts with them")
    parser.add_argument("--scaled", action="store_true", help="in units of nominal values instead of SI units")
    parser.add_argument("--out", type=Path, metavar="NPZ", help="file of NumPy to write, with the matrices and names")


def run(options: argparse.Namespace) -> None:
    """Linearise."""
    check_outputs(options.out)
    model = model_of(options)
    point = settings_of(model, list(filter(None, options.at.split(","))), "--at")
    at = merged(merged(settings_of(model, options.set), point, "--at"), of_law(options.law), "--law")
    found = model.linearise(
        at, inputs=options.inputs.split(","), outputs=options.outputs.split(","), trim=not options.no_trim
    )
    if options.scaled:
        found = found.scaled()
    if options.out is not None:
        write(options.out, lambda file: _save(found, file))
    print(found)


def _save(found: Linearisation, file: Path) -> None:
    import numpy as np

    with file.open("wb") as stream:
        np.savez(
            stream,
            A=found.A,
            B=found.B,
            C=found.C,
            D=found.D,
            x=found.x,
            u=found.u,
            y=found.y,
            states=np.array(found.states),
            inputs=np.array(found.inputs),
            outputs=np.array(found.outputs),
        )

"""Run one experiment under several friction laws.

Prints a table; the first law is the one the others are compared with. After Ctrl-C nothing is written.
"""

from __future__ import annotations

import argparse

from pneumatic_servo.cli.common import (
    add_experiment,
    check_figure,
    check_outputs,
    check_table,
    last_point,
    model_of,
    read_inputs,
    settings_of,
)
from pneumatic_servo.files import write

NAME = "compare"


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_experiment(parser)
    parser.add_argument(
        "--laws", required=True, metavar="LAW,...", help="friction laws, for example Stribeck,LuGre,GMS"
    )


def run(options: argparse.Namespace) -> None:
    """Compare."""
    check_outputs(options.out, options.plot, inputs=[options.csv])
    check_table(options.out)
    check_figure(options.plot)
    model = model_of(options)
    settings = settings_of(model, options.set)
    inputs, last = read_inputs(model, options.csv)
    stop = last_point(last, options.step) if options.stop is None else options.stop
    done = model.compare(options.laws.split(","), settings, inputs=inputs, stop=stop, step=options.step)
    if options.out is not None:
        done.to_csv(options.out)
    if options.plot is not None:
        write(options.plot, lambda file: done.plot().savefig(file))
    print(done)

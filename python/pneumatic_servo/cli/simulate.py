"""Run one experiment, with inputs from a table.

The value of each input at a communication point is held over the step that begins there. Results are written as a
whole or not at all; after Ctrl-C, or when the solver cannot go on, those up to then are.
"""

from __future__ import annotations

import argparse

from pneumatic_servo.cli.common import (
    add_experiment,
    check_figure,
    check_outputs,
    check_table,
    last_point,
    merged,
    model_of,
    of_law,
    read_inputs,
    settings_of,
)
from pneumatic_servo.files import write
from pneumatic_servo.run import Run
from pneumatic_servo.run_errors import Interrupted, SimulationError

NAME = "simulate"


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_experiment(parser)
    parser.add_argument("--law", help="friction law (default: Stribeck)")
    parser.add_argument("--outputs", metavar="NAME,...", help="variables to record (default: inputs and all outputs)")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="record every N steps (default: 1)")


def run(options: argparse.Namespace) -> None:
    """Simulate."""
    check_outputs(options.out, options.plot, inputs=[options.csv])
    check_table(options.out)
    check_figure(options.plot)
    model = model_of(options)
    settings = merged(settings_of(model, options.set), of_law(options.law), "--law")
    inputs, last = read_inputs(model, options.csv)
    stop = last_point(last, options.step) if options.stop is None else options.stop
    outputs = options.outputs.split(",") if options.outputs else None
    try:
        done = model.simulate(
            settings,
            inputs=inputs,
            stop=stop,
            step=options.step,
            outputs=outputs,
            every=options.every,
            progress=True,
        )
    except (Interrupted, SimulationError) as error:
        if isinstance(error.finished, Run) and len(error.finished):
            _leave(options, error.finished)
        raise
    _leave(options, done)


def _leave(options: argparse.Namespace, done: Run) -> None:
    if options.out is not None:
        done.to_csv(options.out)
    if options.plot is not None:
        write(options.plot, lambda file: done.plot().savefig(file))
    for name in done.variables:
        values = done[name]
        print(f"{name:24} {values.min():14.6g} to {values.max():14.6g} {done.variables[name].unit}")
    print(f"{len(done)} rows to {done.time[-1]:g} s")

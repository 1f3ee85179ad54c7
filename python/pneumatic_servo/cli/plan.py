"""Propose an excitation for a fit, and predict the intervals.

Candidates are simulated with the start values of the free parameters; the one with the largest Fisher information is
proposed, with the intervals to expect from usual sensors (10 um, 0.5 kPa; a force: 0.05 N).

example:
  pneumatic-servo plan --law Stribeck --fit friction.stribeck.Fs,friction.stribeck.Fc,valve.deadZone --out plan.csv
"""

from __future__ import annotations

import argparse
from pathlib import Path

from pneumatic_servo.cli.common import check_outputs
from pneumatic_servo.cli.fit import identification, known
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.units import written

NAME = "plan"


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--experiment", default="rig", choices=("rig", "motion"), help="default: rig")
    parser.add_argument("--law", required=True, help="friction law")
    parser.add_argument("--fit", default="", metavar="NAME[=start],...", help="what is to be determined")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE,...", help="known parameters")
    parser.add_argument("--noise", default="", metavar="SIGNAL=VALUE[unit],...", help="standard deviations of sensors")
    parser.add_argument("--duration", type=float, default=10.0, metavar="S", help="default: 10 s")
    parser.add_argument("--step", type=float, default=1e-3, metavar="S", help="interval of the samples (default: 1 ms)")
    parser.add_argument("--stroke", type=float, default=0.05, metavar="M", help="largest amplitude (default: 0.05 m)")
    parser.add_argument("--out", type=Path, metavar="CSV", help="table of the proposed input")


def run(options: argparse.Namespace) -> None:
    """Plan."""
    check_outputs(options.out)
    found = identification().plan(
        law=options.law, fit=options.fit, experiment=options.experiment,
        settings=known(options.experiment, options.set), noise=noises(options.noise),
        duration=options.duration, step=options.step, stroke=options.stroke,
    )  # fmt: skip
    if options.out is not None:
        found.to_csv(options.out)
    print(found)


def noises(text: str) -> dict[str, float]:
    """Read standard deviations, given as `SIGNAL=VALUE[unit]`."""
    from pneumatic_servo.identification.planning import NOISE
    from pneumatic_servo.identification.signals import SIGNALS

    found = {}
    for word in filter(None, text.split(",")):
        signal, _, value = word.partition("=")
        number, _, unit = value.rstrip("]").partition("[")
        if signal not in NOISE:
            hint = did_you_mean(signal, NOISE)
            raise ValueError(f"--noise {word}: there is no signal {signal}{hint}; there are {', '.join(NOISE)}")
        given = f"{number} {unit}" if unit else number
        size = written(given, SIGNALS[signal], f"--noise {word}", is_bare_allowed=True)
        if not size > 0.0:
            raise ValueError(f"--noise {word}: it must be positive")
        found[signal] = size
    return found

r"""Fit one machine to records of different days, and name the parameters that change.

What changes has a value for each record, what is shared has the same in all. Records are called as their files, so that
names like 2026-01-15.csv are dates.

example:
  pneumatic-servo series 2026-01-15.csv 2026-04-15.csv 2026-07-15.csv --experiment rig --law Stribeck \
      --changing friction.stribeck.Fs,friction.stribeck.Fc --shared friction.stribeck.vs,valve.C \
      --columns "time=t,valveVoltage=u,position=x[mm]" --out wear.csv --plot wear.png
"""

from __future__ import annotations

import argparse
from pathlib import Path

from pneumatic_servo.cli.common import check_outputs
from pneumatic_servo.cli.fit import EXPERIMENTS, add_search, identification, known
from pneumatic_servo.errors import NotConverged
from pneumatic_servo.files import write

NAME = "series"


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("csv", nargs="+", type=Path, help="measured tables, one for each day")
    parser.add_argument("--experiment", required=True, choices=EXPERIMENTS, help="as for fit")
    parser.add_argument("--law", required=True, help="friction law")
    parser.add_argument("--changing", required=True, metavar="NAME[=start][:low:high],...", help="what may change")
    parser.add_argument("--shared", default="", metavar="NAME[=start][:low:high],...", help="what all records share")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE,...", help="known parameters")
    parser.add_argument("--columns", metavar="SIGNAL=column[unit],...", help="as for fit")
    add_search(parser)
    parser.add_argument("--out", type=Path, metavar="CSV", help="table of what may change")
    parser.add_argument("--plot", type=Path, metavar="PNG", help="figure of what may change")


def run(options: argparse.Namespace) -> None:
    """Fit all records."""
    fitting = identification()
    check_outputs(options.out, options.plot, inputs=options.csv)
    labels = [file.stem for file in options.csv]
    twice = next((label for label in labels if labels.count(label) > 1), None)
    if twice is not None:
        raise ValueError(f"{twice}: two files have this name, by which records are called")
    found = fitting.fit_series(
        dict(zip(labels, options.csv, strict=True)), experiment=options.experiment, law=options.law,
        changing=options.changing, shared=options.shared, settings=known(options.experiment, options.set),
        columns=options.columns, encoding=options.encoding, seed=options.seed, starts=options.starts,
        rated=options.rated, segment=options.segment, play=options.play,
    )  # fmt: skip
    if options.out is not None:
        found.to_csv(options.out)
    if options.plot is not None:
        write(options.plot, lambda file: found.plot().savefig(file))
    print(found)
    if not found.converged:
        raise NotConverged("the fit has not converged")

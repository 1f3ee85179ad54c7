"""Turn the numbers of data sheets into parameters, with formula, standard and assumptions.

Lengths are in mm, masses in kg, pressures in bar above ambient, or they have a unit: ``--bore "1.25 in" --supply "87
psig" --qn "25 SCFM"``. The set is printed, checked by starting a run with it,
and written as SSV, which tools that know SSP read.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from pneumatic_servo.cli.common import check_outputs
from pneumatic_servo.data_sheet import DataSheet, kept_table, table
from pneumatic_servo.model import Model
from pneumatic_servo.units import has_unit

NAME = "configure"


def number(text: str) -> float | str:
    """Return a number, or a text with a unit, which the sheet understands."""
    try:
        return float(text)
    except ValueError:
        if has_unit(text):
            return text
        raise argparse.ArgumentTypeError(f"{text!r} is no number, and no number with a unit") from None


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--bore", type=number, required=True, metavar="MM")
    parser.add_argument("--rod", type=number, default=0.0, metavar="MM", help="default: 0, rodless")
    parser.add_argument("--rod-a", type=number, default=0.0, metavar="MM", help="a second rod through chamber A")
    parser.add_argument("--stroke", type=number, required=True, metavar="MM")
    parser.add_argument("--mass", type=number, required=True, metavar="KG", help="all that moves")
    flow = parser.add_mutually_exclusive_group(required=True)
    flow.add_argument("--qn", type=number, metavar="L/MIN", help="nominal flow (ANR) from 6 to 5 bar above ambient")
    flow.add_argument("--kv", type=number, metavar="M3/H", help="flow of water at 1 bar")
    flow.add_argument("--cv", type=number, metavar="GAL/MIN", help="flow of water in US gallons at 1 psi")
    flow.add_argument("-C", type=number, dest="conductance", metavar="DM3/(S.BAR)", help="sonic conductance")
    flow.add_argument("--area", type=number, metavar="MM2", help="effective area of the open valve")
    parser.add_argument(
        "-b",
        type=number,
        dest="critical_ratio",
        metavar="B",
        help="critical pressure ratio (default: 0.3; 0.528 with an area)",
    )
    parser.add_argument("--hysteresis", type=number, metavar="PERCENT", help="of the valve, of its whole range")
    parser.add_argument("--response", type=number, metavar="MS", help="of the valve, from 10 to 90 %% of a step")
    parser.add_argument("--hose", metavar="DxL", help="inner diameter and length, for example 4x1500")
    parser.add_argument(
        "--clearance", type=number, default=5.0, metavar="MM", help="of bore, as dead volume (default: 5)"
    )
    parser.add_argument(
        "--min-pressure", type=number, metavar="BAR", help="at which the unloaded piston starts to move"
    )
    parser.add_argument("--supply", type=number, metavar="BAR")
    parser.add_argument(
        "--spring", type=number, nargs=2, metavar="N", help="force of a return spring, retracted and extended"
    )
    parser.add_argument(
        "--leak", type=number, nargs=2, metavar=("L/MIN", "BAR"), help="leakage (ANR) of each chamber at a pressure"
    )
    parser.add_argument(
        "--cushion", type=number, nargs=2, metavar=("MM", "DM3/(S.BAR)"), help="length, and conductance of the needle"
    )
    parser.add_argument("--bumper", type=number, metavar="N/MM", help="stiffness of the stops at both ends")
    parser.add_argument(
        "--rebound", type=number, nargs=2, metavar=("PERCENT", "M/S"), help="resilience of the stops in a blow"
    )
    parser.add_argument("--out", type=Path, metavar="SSV", help="file to write")


def run(options: argparse.Namespace) -> None:
    """Print the parameters, and write them."""
    check_outputs(options.out)
    known = DataSheet.__dataclass_fields__
    sheet = DataSheet(**{name: value for name, value in vars(options).items() if name in known})
    entries = list(sheet.entries())
    model = Model()
    # Whether they fit together is for the model to say.
    model.start(sheet.settings)
    print(table(entries, lambda name: model.variables[name].unit))
    print(kept_table(sheet, lambda name: model.variables[name].unit))
    if options.out is not None:
        sheet.to_ssv(options.out)

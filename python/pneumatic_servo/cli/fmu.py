"""Write the FMUs that come with the package, and the drive as SSP."""

from __future__ import annotations

import argparse
from pathlib import Path

from pneumatic_servo.bundled import fmus

NAME = "fmu"


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--out", type=Path, default=Path(), metavar="FOLDER", help="default: where you are")


def run(options: argparse.Namespace) -> None:
    """Write the files."""
    for file in fmus(options.out):
        print(file)

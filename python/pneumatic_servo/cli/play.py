"""Open the playground: the plant, live in your browser."""

from __future__ import annotations

import argparse

from pneumatic_servo.playground import play

NAME = "play"


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--show-file", action="store_true", help="only say which file the page is")


def run(options: argparse.Namespace) -> None:
    """Open the page, and say where it is in case there is no browser."""
    print(play(browser=not options.show_file))

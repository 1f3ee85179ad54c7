"""The command line `pneumatic-servo`.

Exit codes: 0 done, 1 a run could not go on or a fit did not converge, 2 something given is wrong, 130 interrupted,
141 what it printed was not read to its end.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import warnings
from collections.abc import Sequence

from pneumatic_servo.argument_names import ON_COMMAND_LINE
from pneumatic_servo.cli import compare, configure, fit, fmu, linearise, plan, play, series, simulate, variables
from pneumatic_servo.errors import MissingPackage, NotConverged, PlantWarning
from pneumatic_servo.files import is_standard_output
from pneumatic_servo.run_errors import SimulationError

COMMANDS = [simulate, compare, linearise, configure, fit, series, plan, variables, fmu, play]
"""Each has `NAME`, `add(parser)` and `run(options)`; its docstring is its help."""

EPILOG = r"""examples:
  pneumatic-servo variables valve                 what can be set, with units, ranges and defaults
  pneumatic-servo simulate my.csv --law LuGre --set valve.C=5e-9 --out run.csv --plot run.png
  pneumatic-servo compare my.csv --laws Stribeck,LuGre,GMS --out laws.csv --plot laws.png
  pneumatic-servo linearise --at velocity=0.05,valve.hysteresis=0
  pneumatic-servo configure --bore 32 --rod 12 --stroke 200 --mass 5 --qn 700 --hose 4x1500 --out my.ssv
  pneumatic-servo fit rig.csv --experiment rig --law Stribeck --fit valve.deadZone,friction.stribeck.Fc \
      --columns time=t,valveVoltage=u,position=x[mm] --out rig.ssv --report rig.html
  pneumatic-servo series 2026-01-15.csv 2026-07-15.csv --experiment rig --law Stribeck \
      --changing friction.stribeck.Fc --shared valve.C --columns time=t,valveVoltage=u,position=x[mm] --plot wear.png
  pneumatic-servo plan --law Stribeck --fit valve.deadZone,friction.stribeck.Fc
  pneumatic-servo fmu --set rig.ssv --name Axis7 --preset minimal --out axis7.fmu
  pneumatic-servo fmu --out .                     the FMUs of all models, as they are released
  pneumatic-servo play                            the plant, live in your browser

my.csv has a column `time` in s and one per input, named as the input and in its SI unit, or with its unit:
  time,valveVoltage,supplyPressure[bar]
  0,5,6
  0.5,6.5,6
Columns of outputs are ignored, so that what `simulate --out` wrote can be simulated again. Values of parameters may
have a unit, too: --set "supplyPressure=6 bar"; a file of them stands for all that it has: --set my.ssv.

exit codes: 0 done, 1 a run could not go on or a fit did not converge, 2 something given is wrong, 130 interrupted,
141 what it printed was not read to its end"""


def parser() -> argparse.ArgumentParser:
    """Return the parser of all commands."""
    parser = argparse.ArgumentParser(
        prog="pneumatic-servo",
        description="Simulates a friction-loaded pneumatic servo cylinder, compares friction laws, linearises.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {version()}")
    commands = parser.add_subparsers(metavar="command", required=True)
    for command in COMMANDS:
        text = (command.__doc__ or "").strip()
        own = commands.add_parser(
            command.NAME,
            help=text.partition("\n")[0],
            description=text,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        command.add(own)
        own.set_defaults(run=command.run)
    return parser


def version() -> str:
    """Return the version of the package."""
    import pneumatic_servo

    return pneumatic_servo.__version__


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    options = parser().parse_args(arguments)
    word = ON_COMMAND_LINE.set(True)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always", PlantWarning)
            warnings.showwarning = _show
            # A table that goes to the standard output is alone there.
            tables = is_standard_output(getattr(options, "out", None))
            with contextlib.redirect_stdout(sys.stderr) if tables else contextlib.nullcontext():
                options.run(options)
        sys.stdout.flush()
    except BrokenPipeError:
        return _unread()
    except (SimulationError, NotConverged) as error:
        return _fail(error, 1)
    except (ValueError, OSError, MissingPackage) as error:
        return _fail(error, 2)
    except MemoryError as error:
        return _fail(str(error) or "this does not fit into memory", 2)
    except KeyboardInterrupt as error:
        return _fail(str(error) or "interrupted", 130)
    finally:
        ON_COMMAND_LINE.reset(word)
    return 0


def _show(message: Warning | str, *_: object, **__: object) -> None:
    """Tell a warning as one line."""
    print(f"warning: {message}", file=sys.stderr)


def _unread() -> int:
    """End quietly, as programs in a pipe do whose reader has seen enough, for example `head`."""
    # The remaining output goes nowhere; Python would complain of it at its end.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 141


def _fail(error: object, code: int) -> int:
    print(f"error: {error}", file=sys.stderr)
    return code

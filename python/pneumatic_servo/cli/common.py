"""Options, values on the command line and tables of inputs that the commands share."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pneumatic_servo import values
from pneumatic_servo.files import check_place
from pneumatic_servo.inputs import Inputs, of_table
from pneumatic_servo.model import Model
from pneumatic_servo.ssv import read_ssv
from pneumatic_servo.tables import read_table
from pneumatic_servo.units import written
from pneumatic_servo.variables import Value, Variable


class Renamed(argparse.Action):
    """An option that has an earlier name, too."""

    def __call__(
        self, parser: argparse.ArgumentParser, options: argparse.Namespace, given: Any, name: str | None = None
    ) -> None:
        """Take the value, and name the option that replaces this one."""
        new = self.option_strings[0]
        if name is not None and name != new and name in self.option_strings:
            print(
                f"warning: {name} is now called {new}; the earlier name works until the next release", file=sys.stderr
            )
        setattr(options, self.dest, given)


def add_experiment(parser: argparse.ArgumentParser) -> None:
    """Add the options of the experiment."""
    parser.add_argument(
        "csv", type=Path, help="inputs: a column `time` in s, and one per input in its SI unit or with it"
    )
    add_model(parser)
    parser.add_argument("--stop", type=float, metavar="S", help="end in s (default: the last time of the table)")
    parser.add_argument(
        "--step", type=float, default=1e-3, metavar="S", help="communication step in s (default: 0.001)"
    )
    parser.add_argument("--out", type=Path, metavar="CSV", help="table to write")
    parser.add_argument("--plot", type=Path, metavar="PNG", help="figure to write; the ending says in which format")


def add_model(parser: argparse.ArgumentParser) -> None:
    """Add the model and its parameters."""
    parser.add_argument("--model", default="PneumaticServoCylinder", help="default: PneumaticServoCylinder")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE,...",
        help="parameters and start values of inputs, in SI units or with a unit, or a file of them, my.ssv",
    )


def model_of(options: argparse.Namespace) -> Model:
    """Return the model that was asked for."""
    return Model(options.model)


def settings_of(model: Model, given: list[str], option: str = "--set") -> dict[str, Value]:
    """Read values that are given as `NAME=VALUE`."""
    settings: dict[str, Value] = {}
    for word in words_of(given):
        if word.lower().endswith(".ssv") and "=" not in word:
            settings = merged(settings, read_ssv(word, model), f"{option} {word}")
            continue
        name, equals, text = word.partition("=")
        if not equals:
            raise ValueError(f"{option} {word}: it must be NAME=VALUE, or a file *.ssv")
        if name in settings:
            raise ValueError(f"{option} {word}: {name} is given twice")
        try:
            variable = model.variables[name]
        except KeyError as error:
            raise ValueError(f"{option} {word}: {error.args[0]}") from None
        settings[name] = _value(variable, text, f"{option} {word}")
    return settings


def words_of(given: Sequence[str]) -> list[str]:
    """Return the values of several options, each with commas or without."""
    return [word.strip() for option in given for word in option.split(",") if word.strip()]


def merged(settings: Mapping[str, Value], more: Mapping[str, Value], option: str) -> dict[str, Value]:
    """Return settings of two options together; common settings must be the same."""
    for name, value in more.items():
        if settings.get(name, value) != value:
            raise ValueError(f"{option}: {name} is given twice, as {settings[name]} and as {value}")
    return {**settings, **more}


def of_law(law: str | None) -> dict[str, Value]:
    """Return the setting of `--law`."""
    return {} if law is None else {"friction.law": law}


def _value(variable: Variable, text: str, place: str) -> Value:
    if variable.kind == "enumeration":
        return text
    if variable.kind == "boolean":
        if text not in ("true", "false"):
            raise ValueError(f"{place}: it must be true or false")
        return text == "true"
    if variable.kind != "real":
        try:
            return float(text)
        except ValueError:
            raise ValueError(f"{place}: {text} is no number") from None
    number = written(text, variable.unit, place, is_bare_allowed=True)
    values.check_range(variable, number)
    return number


def read_inputs(model: Model, file: Path) -> tuple[Inputs, float]:
    """Read a table of inputs; return them, and the last time in s.

    Errors name file, line, column, variable and value.
    """
    return of_table(model.variables, read_table(file))


def last_point(last: float, step: float) -> float:
    """Return the last communication point that is not after a time, in s."""
    if not step > 0.0:
        raise ValueError(f"--step {step}: it must be positive")
    return math.floor(last / step + 1e-6) * step


def check_outputs(*outputs: Path | None, inputs: Sequence[Path] = ()) -> None:
    """Refuse files that could not be written, or that the work is read from, before the work."""
    given = [file for file in outputs if file is not None]
    for number, file in enumerate(given):
        check_place(file)
        if any(_is_same(file, source) for source in inputs):
            raise ValueError(f"{file}: it is read from, and would be overwritten; name another file to write")
        if any(_is_same(file, other) for other in given[:number]):
            raise ValueError(f"{file}: it is named twice among the files to write")


def check_table(file: Path | None) -> None:
    """Refuse a table with the file ending of a figure."""
    if file is not None and file.suffix.lower() in (".png", ".svg", ".pdf", ".jpg", ".jpeg"):
        raise ValueError(f"--out {file}: it is a table; --plot {file} writes a figure")


def check_figure(file: Path | None) -> None:
    """Refuse a figure whose ending names no format, before the work."""
    if file is None:
        return
    # Here, since it takes longer to load than everything else that the command line needs.
    from matplotlib.backend_bases import FigureCanvasBase

    formats = sorted(FigureCanvasBase.get_supported_filetypes())
    if file.suffix.lower().removeprefix(".") not in formats:
        raise ValueError(
            f"--plot {file}: the ending {file.suffix!r} names no format of figures; "
            f"it must be one of {', '.join(formats)}"
        )


def _is_same(file: Path, other: Path) -> bool:
    """Tell whether two names mean one file, also through links."""
    if file.exists() and other.exists():
        return file.samefile(other)
    return file.resolve() == other.resolve()

"""What the commands share: options, values on the command line, and tables of inputs."""

from __future__ import annotations

import argparse
import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from pneumatic_servo.files import check_place, opened
from pneumatic_servo.inputs import Inputs
from pneumatic_servo.model import Model
from pneumatic_servo.numerals import finite
from pneumatic_servo.variables import Value, Variable, Variables


def add_experiment(parser: argparse.ArgumentParser) -> None:
    """Add what says which experiment is run."""
    parser.add_argument("csv", type=Path, help="inputs: a column `time` in s, and one per input in its SI unit")
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
        metavar="NAME=VALUE",
        help="a parameter or the start value of an input, in SI units; may be given several times",
    )


def model_of(options: argparse.Namespace) -> Model:
    """Return the model that was asked for."""
    return Model(options.model)


def settings_of(model: Model, given: list[str], option: str = "--set") -> dict[str, Value]:
    """Read values that are given as `NAME=VALUE`."""
    settings: dict[str, Value] = {}
    for word in given:
        name, equals, text = word.partition("=")
        if not equals:
            raise ValueError(f"{option} {word}: it must be NAME=VALUE")
        if name in settings:
            raise ValueError(f"{option} {word}: {name} is given twice")
        try:
            variable = model.variables[name]
        except KeyError as error:
            raise ValueError(f"{option} {word}: {error.args[0]}") from None
        settings[name] = _value(variable, text, f"{option} {word}")
    return settings


def merged(settings: Mapping[str, Value], more: Mapping[str, Value], option: str) -> dict[str, Value]:
    """Return settings of two options together; what both give must be the same."""
    for name, value in more.items():
        if settings.get(name, value) != value:
            raise ValueError(f"{option}: {name} is given twice, as {settings[name]} and as {value}")
    return {**settings, **more}


def of_law(law: str | None) -> dict[str, Value]:
    """Return what `--law` sets."""
    return {} if law is None else {"friction.law": law}


def _value(variable: Variable, text: str, place: str) -> Value:
    if variable.kind == "enumeration":
        return text
    if variable.kind == "boolean":
        if text not in ("true", "false"):
            raise ValueError(f"{place}: it must be true or false")
        return text == "true"
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{place}: {text} is no number in {variable.unit}") from None


def read_inputs(model: Model, file: Path) -> tuple[Inputs, float]:
    """Read a table of inputs; return them, and the last time in s.

    Errors name file, line, column, variable and value.
    """
    with opened(file) as stream:
        reader = csv.reader(stream)
        header = [name.strip() for name in next(reader, [])]
        _check_header(model.inputs, header, file)
        columns: list[list[float]] = [[] for _ in header]
        for cells in reader:
            if cells:
                _read_line(model.inputs, header, cells, columns, f"{file}:{reader.line_num}")
    times = columns[header.index("time")]
    if not times:
        raise ValueError(f"{file}: there are no rows below the header")
    if times[0] > 0.0:
        raise ValueError(f"{file}: the first time is {times[0]} s; a run starts at 0 s")
    inputs: Mapping[str, tuple[np.ndarray, np.ndarray]] = {
        name: (np.array(times), np.array(column))
        for name, column in zip(header, columns, strict=True)
        if name != "time"
    }
    return inputs, times[-1]


def _check_header(inputs: Variables, header: list[str], file: Path) -> None:
    place = f"{file}:1"
    if "time" not in header:
        raise ValueError(f"{place}: there is no column `time`, only {', '.join(header) or 'an empty line'}")
    for number, name in enumerate(header, start=1):
        if name != "time" and name not in inputs:
            raise ValueError(f"{place}, column {number}: {name} is not an input; the inputs are {', '.join(inputs)}")
        if header.index(name) != number - 1:
            raise ValueError(f"{place}, column {number}: {name} is there twice")


def _read_line(inputs: Variables, header: list[str], cells: list[str], columns: list[list[float]], place: str) -> None:
    if len(cells) != len(header):
        raise ValueError(f"{place}: {len(cells)} values, but the header has {len(header)} columns")
    for number, (name, cell, column) in enumerate(zip(header, cells, columns, strict=True), start=1):
        where = f"{place}, column {number} ({name})"
        value = finite(cell, where)
        if name == "time":
            if column and value < column[-1]:
                raise ValueError(f"{where}: time falls from {column[-1]} s to {value} s")
        else:
            _check_range(inputs[name], value, where)
        column.append(value)


def _check_range(variable: Variable, value: float, where: str) -> None:
    below = variable.minimum is not None and value < variable.minimum
    above = variable.maximum is not None and value > variable.maximum
    if below or above:
        raise ValueError(f"{where}: {value} {variable.unit} is refused: it must be {variable.range}")


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

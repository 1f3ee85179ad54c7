"""Write a configured machine as an FMU, or the FMUs that come with the package.

With --out axis7.fmu the FMU starts with the values of --set and has only the variables that are kept. With --out
drive.ssp it is the plant with its controller; names begin with plant. and controller. then. Without options
the FMUs of all models, and the drive as SSP, are copied to a folder.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from pneumatic_servo.bundled import fmus
from pneumatic_servo.cli.common import add_model, check_outputs, model_of, settings_of, words_of
from pneumatic_servo.export import DRIVE, PRESETS, export_drive, export_fmu
from pneumatic_servo.model import Model
from pneumatic_servo.variables import Value

NAME = "fmu"


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_model(parser)
    parser.add_argument("--name", metavar="NAME", help="of the machine (default: that of the file)")
    parser.add_argument(
        "--preset", choices=PRESETS, help="variables that stay: all (default), those that count, or the fewest"
    )
    for kind in ("inputs", "outputs", "parameters"):
        parser.add_argument(f"--{kind}", action="append", metavar="NAME,...", help=f"{kind} that stay")
    parser.add_argument("--stop", type=float, metavar="S", help="end of the default experiment in s")
    parser.add_argument("--step", type=float, metavar="S", help="its communication step in s")
    parser.add_argument("--source", type=Path, metavar="FMU", help="the FMU to start from (default: of the package)")
    parser.add_argument("--beside", action="store_true", help="write JSON, Modelica and MATLAB beside it")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path(),
        metavar="FMU",
        help="axis7.fmu, drive.ssp, or a folder (default: where you are)",
    )


def run(options: argparse.Namespace) -> None:
    """Write the files."""
    if options.out.suffix == ".ssp":
        check_outputs(options.out)
        print(export_drive(options.out, of_drive(options.set), name=options.name, source=options.source))
        return
    if options.out.suffix != ".fmu":
        asked = ("set", "name", "preset", "inputs", "outputs", "parameters", "stop", "step", "source", "beside")
        given = [f"--{name}" for name in asked if getattr(options, name)]
        if given:
            raise ValueError(f"{given[0]} is of a machine of your own: give --out a file, such as axis7.fmu")
        for file in fmus(options.out):
            print(file)
        return
    check_outputs(options.out)
    kept = {
        kind: None if given is None else words_of(given)
        for kind, given in (("inputs", options.inputs), ("outputs", options.outputs),
                            ("parameters", options.parameters))
    }  # fmt: skip
    experiment = {key: value for key in ("stop", "step") if (value := getattr(options, key)) is not None}
    written = export_fmu(
        options.out, settings_of(model_of(options), options.set), model=options.model, name=options.name,
        preset=options.preset or PRESETS[0], default_experiment=experiment, source=options.source,
        beside=options.beside, **kept,
    )  # fmt: skip
    for file in written:
        print(file)


def of_drive(given: list[str]) -> dict[str, Value]:
    """Read values of the components of the drive."""
    settings: dict[str, Value] = {}
    for component, model in DRIVE.items():
        own = [word.removeprefix(f"{component}.") for word in words_of(given) if word.startswith(f"{component}.")]
        found = settings_of(Model(model), own, f"--set {component}.")
        settings |= {f"{component}.{name}": value for name, value in found.items()}
    for word in words_of(given):
        if word.partition(".")[0] not in DRIVE:
            raise ValueError(f"--set {word}: the name must begin with {' or '.join(f'{one}.' for one in DRIVE)}")
    return settings

r"""Fit parameters of a model to measured data.

Experiments: motion (a seal or a tribometer: position given, force compared), points (a table of a seal bench without
time: velocity and load given, force of steady sliding compared), force (an axis that a measured force moves: position
or velocity compared), mechanical (pressures given, position compared), pneumatic (position and voltage given,
pressures compared), rig (voltage given, position and pressures compared). The exit code is 0
only if the fit has converged.

example:
  pneumatic-servo fit rig.csv --experiment rig --law Stribeck \
      --fit friction.stribeck.Fs,friction.stribeck.Fc,valve.deadZone=0.05:0:0.2 \
      --columns "time=t,valveVoltage=u,position=x[mm],chamberA.pressure=pa[bar],chamberB.pressure=pb[bar]" \
      --validation 0.3 --out rig.ssv --json rig.json --report rig.html
"""

from __future__ import annotations

import argparse
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from pneumatic_servo import _native
from pneumatic_servo.cli.common import Renamed, check_outputs, settings_of, words_of
from pneumatic_servo.errors import MissingPackage, NotConverged
from pneumatic_servo.model import Model
from pneumatic_servo.units import has_unit, written
from pneumatic_servo.variables import Value

NAME = "fit"
EXPERIMENTS = {name: table for name, _, table, _ in _native.experiments()}
"""Experiments, and the models with the known and fitted parameters of each."""


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("csv", nargs="+", type=Path, help="measured tables")
    parser.add_argument("--experiment", required=True, choices=EXPERIMENTS, help="what was given, what is compared")
    parser.add_argument(
        "--law",
        required=True,
        help="friction law; several, with commas, are compared, each with its own parameters free besides --fit",
    )
    parser.add_argument(
        "--fit", default="", metavar="NAME[=start][:low:high],...",
        help="free parameters, gain., offset., delay. or lag.SIGNAL, area, incline, spring (default: the law's)",
    )  # fmt: skip
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE,...",
        help="known parameters, in SI units or with a unit, or a file of them, my.ssv",
    )
    parser.add_argument(
        "--columns", metavar="SIGNAL=column[unit],...",
        help="what the columns are (default: those that have the names of signals)",
    )  # fmt: skip
    parser.add_argument(
        "--validation", "--hold-out", type=float, default=0.0, metavar="FRACTION", action=Renamed,
        help="share at the end to predict",
    )  # fmt: skip
    add_search(parser)
    parser.add_argument("--width", type=float, default=0.04, metavar="S", help="width of smoothing (default: 0.04 s)")
    parser.add_argument(
        "--inputs",
        metavar="hold|lines|smooth",
        help="inputs between samples: held, lines or a smooth curve (default: hold, but of forces what fits)",
    )
    parser.add_argument("--loss", default="linear", help="linear, soft_l1, huber or cauchy (default: linear)")
    parser.add_argument("--intervals", default="jacobian", help="jacobian, profile or bootstrap (default: jacobian)")
    parser.add_argument("--evidence", action="store_true", help="whether the data distinguish the laws (needs ArviZ)")
    parser.add_argument("--posterior", type=Path, metavar="CSV", help="samples of the posterior (needs emcee)")
    parser.add_argument(
        "--cross-validate", default="", metavar="QUANTITY,...",
        help="predict each condition from the others: record, pressure, load, amplitude, speed, supplyPressure",
    )  # fmt: skip
    parser.add_argument(
        "--law-error", type=float, default=0.2, metavar="SHARE",
        help="expected relative deviation of friction from any law between these conditions (default: 0.2)",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="SSV", help="values that tools load into the FMU")
    parser.add_argument("--json", type=Path, metavar="JSON", help="values with their intervals")
    parser.add_argument("--report", type=Path, metavar="HTML", help="page with tables and figures")


def add_search(parser: argparse.ArgumentParser) -> None:
    """Add the options of every fit: starts of the search, and errors of sensors."""
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the random starts (default: 0)")
    parser.add_argument("--starts", type=int, default=32, metavar="N", help="number of random starts (default: 32)")
    parser.add_argument("--rated", type=float, default=1.0, metavar="N", help="normal force in N of load factor 1")
    parser.add_argument("--encoding", metavar="NAME", help="of the tables (default: UTF-8, else Windows-1252)")
    parser.add_argument(
        "--segment", "--window", type=float, metavar="S", action=Renamed,
        help="start anew from what is measured every S seconds",
    )  # fmt: skip
    parser.add_argument("--play", type=float, metavar="M", help="backlash in m that filters the jitter at rest")


def run(options: argparse.Namespace) -> None:
    """Fit."""
    fitting = identification()
    check_outputs(options.out, options.json, options.report, options.posterior, inputs=options.csv)
    common = {
        "experiment": options.experiment, "fit": options.fit, "columns": options.columns,
        "encoding": options.encoding,
        "settings": known(options.experiment, options.set), "validation": options.validation, "seed": options.seed,
        "starts": options.starts, "rated": options.rated, "segment": options.segment, "play": options.play,
        "width": options.width, "inputs": options.inputs, "loss": options.loss, "intervals": options.intervals,
        "posterior": options.posterior is not None, "cross_validate": options.cross_validate,
        "law_error": options.law_error, "progress": True,
    }  # fmt: skip
    laws = options.law.split(",")
    if options.evidence and len(laws) < 2:
        raise ValueError("--evidence compares laws: name several by --law")
    if len(laws) > 1:
        ranking = fitting.compare_fits(options.csv, laws, **common)
        found = ranking.best
        print(ranking)
        if options.evidence:
            print(ranking.evidence(seed=options.seed))
    else:
        found = fitting.fit(options.csv, law=laws[0], **common)
    if options.out is not None:
        found.to_ssv(options.out)
        if found.beside:
            model = found.problem.experiment.table.name
            print(
                f"note: {options.out} is without {', '.join(found.beside)}, which {model} does not have",
                file=sys.stderr,
            )
    if options.json is not None:
        found.to_json(options.json)
    if options.report is not None:
        found.to_report(options.report)
    if found.posterior is not None:
        found.posterior.to_csv(options.posterior)
        print(found.posterior)
    if found.cross_validation is not None:
        print(found.cross_validation)
    for name, reason in found.not_identifiable.items():
        print(f"warning: {name} is not identifiable: {reason}", file=sys.stderr)
    print(found)
    print(f"verdict: {found.verdict}")
    if not found.converged:
        raise NotConverged(f"the fit has not converged: {found.message}")


def known(experiment: str, given: list[str]) -> dict[str, Value]:
    """Read known parameters, several to an option; also of sensors, and of a bench beyond its model.

    For the experiment `force` values with a unit stay as they are written: of a machine that rotates it is another.
    """
    fitting = import_module("pneumatic_servo.identification.fitting")
    signals = import_module("pneumatic_servo.identification.signals")
    beside = fitting.units_beside(experiment, signals.SLIDING)
    special: dict[str, Any] = {}
    others = []
    for word in words_of(given):
        name, equals, text = word.partition("=")
        if equals and experiment == "force" and has_unit(text):
            special[name] = text
        elif equals and name in beside:
            special[name] = written(text, beside[name], f"--set {word}", is_bare_allowed=True)
        else:
            others.append(word)
    model = Model(EXPERIMENTS[experiment])
    return {**settings_of(model, others), **special}


def identification() -> ModuleType:
    """Return the part of the package that needs SciPy."""
    try:
        return import_module("pneumatic_servo.identification")
    except ImportError as error:
        raise MissingPackage("SciPy", "identification") from error

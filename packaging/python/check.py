"""Validates FMUs with FMPy, and terminals, parameter sets and SSPs against its schemas; any finding is an error."""

from __future__ import annotations

import argparse
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import fmpy
from fmpy.ssp import ssd
from fmpy.validation import validate_fmu
from lark import Lark
from lxml import etree

SSP = Path(ssd.__file__).parent / "schema"
SYSTEM, VALUES = SSP / "SystemStructureDescription.xsd", SSP / "SystemStructureParameterValues.xsd"
TERMINALS = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
NAMESPACE = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"

PARSE = Lark.parse
WELL_FORMED: dict[tuple[str, str], object] = {}


def parse_once(parser: Lark, text: str) -> object:
    """As `Lark.parse`, which takes nearly all the time of FMPy; models and versions of FMI share their names."""
    key = parser.source_grammar, text
    if key not in WELL_FORMED:
        WELL_FORMED[key] = PARSE(parser, text)
    return WELL_FORMED[key]


def main() -> int:
    Lark.parse = parse_once  # type: ignore[method-assign]
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="an .fmu, .ssp or .ssv")
    return 1 if sum([check(file) for file in parser.parse_args().files]) else 0


def check(file: Path) -> int:
    """Prints what is wrong with a file, and returns how much that is."""
    findings = errors(etree.parse(file).getroot(), VALUES) if file.suffix == ".ssv" else invalid_contents(file)
    for finding in findings:
        print(f"{file.name}: {finding}", file=sys.stderr)
    print(f"{file.name}: {len(findings)} findings", flush=True)
    return len(findings)


def invalid_contents(file: Path) -> list[str]:
    """Errors within an archive."""
    rules = validate_fmu(str(file)) if file.suffix == ".fmu" else invalid_systems(file)
    return [*rules, *invalid_terminals(file), *invalid_sets(file)]


def invalid_terminals(file: Path) -> list[str]:
    """Errors of the terminals inside: against the schema, and missing variables."""
    findings = []
    for name, tree in trees(file, "terminalsAndIcons.xml"):
        findings += [f"{name}: {error}" for error in errors(tree, TERMINALS)]
        known = {variable.name for variable in fmpy.read_model_description(str(file)).modelVariables}
        members = [member.get("variableName") for member in tree.iter("TerminalMemberVariable")]
        findings += [f"{name}: there is no variable {member}" for member in members if member not in known]
    return findings


def invalid_systems(file: Path) -> list[str]:
    """Errors of the system descriptions inside."""
    return [f"{name}: {error}" for name, tree in trees(file, ".ssd") for error in errors(tree, SYSTEM)]


def invalid_sets(file: Path) -> list[str]:
    """Errors of the parameter sets inside, also in system descriptions."""
    sets = list(trees(file, ".ssv"))
    sets += [(name, found) for name, tree in trees(file, ".ssd") for found in tree.iter(f"{{{NAMESPACE}}}ParameterSet")]
    return [f"{name}: {error}" for name, tree in sets for error in errors(tree, VALUES)]


def trees(file: Path, suffix: str) -> Iterator[tuple[str, etree._Element]]:
    with zipfile.ZipFile(file) as archive:
        for name in archive.namelist():
            if name.endswith(suffix):
                yield name, etree.fromstring(archive.read(name))


def errors(tree: etree._Element, schema: Path) -> list[str]:
    validator = etree.XMLSchema(file=str(schema))
    validator.validate(etree.ElementTree(tree))
    return [f"line {error.line}: {error.message}" for error in validator.error_log]


if __name__ == "__main__":
    sys.exit(main())

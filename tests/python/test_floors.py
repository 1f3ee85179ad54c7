"""The files of the package stand on floors: none takes something from a file that takes something from it."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Set
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "python" / "pneumatic_servo"


def modules(package: Path) -> dict[str, Path]:
    """Return the files of a package by the names of their modules, the compiled one by what is said of it."""
    files = [*package.rglob("*.py"), *package.rglob("*.pyi")]
    return {".".join(file.relative_to(package.parent).with_suffix("").parts).removesuffix(".__init__"): file
            for file in files}  # fmt: skip


def imported(file: Path, known: Set[str]) -> Iterator[str]:
    """Yield the modules that a file imports, wherever it does: also inside functions, and for types only."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        match node:
            case ast.Import(names):
                yield from (name.name for name in names if name.name in known)
            case ast.ImportFrom(module, names, 0):
                # An imported name is one of the package's modules, or an object of the package itself.
                asked = [(f"{module}.{name.name}", str(module)) for name in names]
                yield from (one if one in known else own for one, own in asked if {one, own} & known)
            case ast.ImportFrom():
                raise AssertionError(f"{file}:{node.lineno}: an import whose module is not named in full")
            case ast.Call(args=[ast.Constant(str(name)), *_]) if name in known:
                yield name


def circle(package: Path) -> list[str]:
    """Return modules of a package of which each imports the next, and the last the first; none if there are no such."""
    files = modules(package)
    # A sorter is told from what each is made: of a circle it names each behind what it imports.
    graph = {name: {*imported(file, files.keys())} for name, file in files.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1][::-1]
    return []


def test_no_files_import_each_other() -> None:
    assert len(modules(PACKAGE)) > 90
    assert not circle(PACKAGE)

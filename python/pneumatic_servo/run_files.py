"""Files of a run for MATLAB, Simulink and Modelica."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.errors import MissingPackage
from pneumatic_servo.files import check_ending, whole

Array = NDArray[np.float64]


def write_mat(file: Path, columns: Mapping[str, Array]) -> None:
    """Write columns as variables of MATLAB: ``chamberA.pressure`` is a field of the structure ``chamberA``."""
    check_ending(file, ".mat")
    try:
        from scipy.io import savemat
    except ImportError as error:
        raise MissingPackage("SciPy", "identification") from error
    variables = structures(columns)
    with whole(file) as part, part.open("wb") as stream:
        savemat(stream, variables, long_field_names=True, oned_as="column")


def structures(columns: Mapping[str, Array]) -> dict[str, Any]:
    """Return columns by name, those with dots in structures; an element ``k[1]`` is ``k_1``."""
    found: dict[str, Any] = {}
    for name, column in columns.items():
        *groups, last = re.sub(r"\[(\d+)\]", r"_\1", name).split(".")
        own = found
        for group in groups:
            own = own.setdefault(group, {})
            if not isinstance(own, dict):
                raise ValueError(f"{name} is a field of {group}, which is itself a column: record one of both")
        if last in own:
            raise ValueError(f"{name} has fields, which are columns themselves: record one of both")
        own[last] = column
    return found


def write_combi_table(file: Path, columns: Mapping[str, Array], name: str) -> None:
    """Write columns as a table of text that Modelica's ``CombiTimeTable`` reads; the first one is the time."""
    check_ending(file, ".txt", ".csv")
    if not re.fullmatch(r"[A-Za-z_]\w*", name):
        raise ValueError(f"name={name!r} is refused: Modelica names a table by letters, digits and underscores")
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    length = len(next(iter(columns.values())))
    head = f"#1\ndouble {name}({length},{len(columns)}) # {', '.join(columns)}\n"
    with whole(file) as part, part.open("w", newline="\n", encoding="utf-8") as stream:
        stream.write(head)
        stream.writelines(" ".join(map(repr, row)) + "\n" for row in rows)

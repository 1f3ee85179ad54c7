"""A corpus of small tables: each is read as it is meant, or refused with line, column and remedy."""

from __future__ import annotations

import gzip
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pneumatic_servo.tables import read_table

CORPUS: dict[str, dict[str, Any]] = json.loads(
    (Path(__file__).parents[1] / "tables/corpus.json").read_text(encoding="utf-8")
)
RIGHT = {name: case for name, case in CORPUS.items() if "refused" not in case}
WRONG = {name: case for name, case in CORPUS.items() if "refused" in case}


def written(folder: Path, case: dict[str, Any]) -> Path:
    text, encoding = case["text"], case.get("encoding", "utf8")
    file = folder / case["file"]
    file.write_bytes(gzip.compress(text.encode()) if encoding == "gzip" else
                     text.encode({"utf8": "utf-8", "utf16le": "utf-16-le", "latin1": "latin-1"}[encoding]))  # fmt: skip
    return file


def at(file: Path, place: dict[str, Any]) -> str:
    """Return the beginning of a message about a place, as a pattern."""
    line = "" if place["line"] is None else f":{place['line']}"
    column = "" if place["column"] is None else rf", column {place['column']} \(.*\)"
    return f"^{re.escape(str(file))}{line}{column}: .*{re.escape(place['words'])}"


@pytest.mark.parametrize("name", RIGHT)
def test_table_is_read_as_it_is_meant(tmp_path: Path, name: str) -> None:
    case = RIGHT[name]
    file = written(tmp_path, case)
    table = read_table(file)
    assert (table.names, table.units) == (case["names"], case["units"])
    np.testing.assert_array_equal(table.values.T, np.array(case["columns"], dtype=float))
    assert table.gaps == set(case.get("gaps", []))
    assert table.clocks == {int(place): clock for place, clock in case.get("clocks", {}).items()}
    if "lines" in case:
        assert (table.first, table.lines.tolist()) == (case["first"], case["lines"])
    faults = {place: fault for place, fault in table.faults.items() if place not in table.gaps}
    if "fault" not in case:
        assert not faults
        return
    fault = case["fault"]
    assert list(faults) == [fault["column"]]
    assert re.match(at(file, {**fault, "column": fault["column"] + 1}), faults[fault["column"]])


@pytest.mark.parametrize("name", WRONG)
def test_table_that_is_wrong_is_refused_with_its_place_and_a_remedy(tmp_path: Path, name: str) -> None:
    case = WRONG[name]
    file, place = written(tmp_path, case), case["refused"]
    with pytest.raises(ValueError, match=at(file, place)):
        read_table(file).in_si((place["column"] or 1) - 1, "s", "s")

"""The tutorial, run as a notebook: its cells check what they show, and its texts say no number that is not there."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

TUTORIALS = Path(__file__).parents[2] / "docs" / "tutorial"
QUANTITY = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?) (mm/s|m/s|mm|ms|m|s|V|N|bar|Pa|Hz|kg|%)(?!\w)")
SI = {"mm/s": 1e-3, "mm": 1e-3, "ms": 1e-3, "bar": 1e5, "%": 1e-2}
LITERAL = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")


def executed(name: str, folder: Path) -> Any:
    notebook = nbformat.read(TUTORIALS / name, as_version=4)
    client = NotebookClient(notebook, timeout=300, iopub_timeout=60, resources={"metadata": {"path": str(folder)}})
    client.raise_on_iopub_timeout = True
    client.execute()
    return notebook


@pytest.fixture(scope="module")
def notebook(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return executed("tutorial.ipynb", tmp_path_factory.mktemp("tutorial"))


def pictures(notebook: Any) -> int:
    shown = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    return sum("image/png" in output.get("data", {}) for output in shown)


def test_tutorial_runs_and_shows_figures(notebook: Any) -> None:
    assert pictures(notebook) == 3


def test_step_responses_lead_to_an_observer(tmp_path: Path) -> None:
    """Its cells check that the right law is consistent, and the wrong one is not."""
    notebook = executed("observer.ipynb", tmp_path)
    assert pictures(notebook) == 2 and list(unfounded(notebook.cells)) == []
    printed = "".join(output.get("text", "") for cell in notebook.cells for output in cell.get("outputs", []))
    found = re.findall(r"= ([\d.e-]+) .*the machine has ([\d.e-]+)", printed)
    assert len(found) == 4 and all(float(one) == pytest.approx(float(true), rel=0.02) for one, true in found)


def unfounded(cells: Any) -> Iterator[str]:
    """Yield quantities in texts that no cell of the same section prints or is given."""
    sections: list[tuple[list[str], str, str]] = [([], "", "")]
    for cell in cells:
        texts, code, printed = sections[-1]
        if cell.cell_type == "markdown":
            before, *after = re.split(r"(?m)^(?=## )", cell.source)
            texts.append(before)
            sections += [([section], "", "") for section in after]
        else:
            told = "".join(output.get("text", "") for output in cell.outputs)
            sections[-1] = (texts, code + cell.source, printed + told)
    for texts, code, printed in sections:
        given = {float(number) for number in LITERAL.findall(code)}
        seen = {match[0] for match in QUANTITY.finditer(printed)}
        for match in QUANTITY.finditer("\n".join(texts)):
            number, unit = float(match[1]), match[2]
            if match[0] not in seen and not given & {number, round(SI.get(unit, 1.0) * number, 12)}:
                yield match[0]


def test_texts_say_no_quantity_that_no_cell_has(notebook: Any) -> None:
    """Numbers in sentences are printed beside them, to the digit, or are given to a cell."""
    assert list(unfounded(notebook.cells)) == []


def test_quantity_that_a_figure_contradicts_is_found(notebook: Any) -> None:
    other = nbformat.from_dict(notebook)
    for cell in other.cells:
        cell.source = cell.source.replace("307.7 mm", "298.2 mm")
    assert list(unfounded(other.cells)) == ["298.2 mm"]

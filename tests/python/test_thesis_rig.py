"""The parameter set of the thesis's rig against what the thesis tells, as docs/identification/validation.md has it."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_set_rig_does_what_the_page_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs/studies"))
    from common import parameter_set
    from thesis_rig import COLUMNS, SET, Rig, facts

    found = [list(fact.row) for fact in facts(Rig(parameter_set(SET)))]
    with (ROOT / "docs" / "identification" / "thesis_rig.csv").open(encoding="utf-8", newline="") as stream:
        assert list(csv.reader(stream)) == [COLUMNS, *found]
    page = (ROOT / "docs" / "identification" / "validation.md").read_text(encoding="utf-8")
    lines = [f"| {' | '.join(row)} |" for row in [COLUMNS, *found]]
    assert "\n".join([lines[0], "|---" * len(COLUMNS) + "|", *lines[1:]]) in page

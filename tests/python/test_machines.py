"""The table of machines: each row starts as it is written, runs, and is not what the defaults do."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest

PAGE = Path(__file__).parents[2] / "docs" / "machines.md"
SETTING = re.compile(r"`([A-Za-z0-9.\[\]]+)` = ([^,|]+)")
DEFAULT = "5/3 proportional valve (servo valve)"


def rows() -> dict[str, dict[str, object]]:
    """The settings of each machine, as the table has them."""
    found = {}
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        settings = SETTING.findall(line)
        if line.startswith("|") and settings:
            found[cells[0]] = {name: value_of(text.split(" or ")[0].strip()) for name, text in settings}
    return found


def value_of(text: str) -> object:
    """A number, a switch, an item, or a text with a unit."""
    if text in ("true", "false"):
        return text == "true"
    try:
        return float(text)
    except ValueError:
        return text


ROWS = rows()


def test_page_has_its_table() -> None:
    assert len(ROWS) > 20


@pytest.mark.parametrize("machine", ROWS)
def test_machine_runs_and_is_another_one(machine: str) -> None:
    settings = ROWS[machine]
    is_commanded = any(name.startswith(("valveVoltage", "coil")) for name in settings)
    inputs = {} if is_commanded else {"valveVoltage": {"hold": ([0.0, 0.2, 0.5], [7.0, 3.0, 3.0])}}
    model = ps.Model()
    with warnings.catch_warnings():
        # A row says all that its machine needs in order to count.
        warnings.simplefilter("error", ps.PlantWarning)
        run = model.simulate(settings, inputs=inputs, stop=0.5, step=1e-3)  # type: ignore[arg-type]
    default = model.simulate(inputs=inputs, stop=0.5, step=1e-3)
    shown = ["position", "chamberA.pressure", "sensor.position.reading", "sensor.end[1]", "supply.consumed"]
    differs = any(not np.array_equal(run[name], default[name]) for name in shown)
    assert differs == (machine != DEFAULT)

"""Faults of recorders and tables, each named with its time, row and value; the data are made by formulas."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest
from named_mistakes import record
from numpy.typing import NDArray
from pneumatic_servo.identification.fitted import Estimate
from shared import faults

Array = NDArray[np.float64]


def said(data: dict[str, Array], **options: object) -> list[str]:
    """Warnings, or refusals, before a fit."""
    given = {"experiment": "rig", "law": "Coulomb", "settings": {"supplyPressure": 6e5}, "starts": 0,
             "fit": "friction.coulomb.Fc", "progress": False, **options}  # fmt: skip
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            ps.fit(data, **given)  # type: ignore[arg-type]
        except ValueError as error:
            return [str(error)]
    return [str(one.message) for one in caught]


@pytest.mark.parametrize(("factor", "unit"), [(100.0, "kPa"), (14.5038, "psi")])
def test_pressure_far_above_the_supply_is_refused_with_the_likely_unit(factor: float, unit: str) -> None:
    data = record()
    row = int(np.argmax(data["chamberA.pressure"]))
    [text] = said({**data, "chamberA.pressure": factor * data["chamberA.pressure"]})
    assert f"at {data['time'][row]:.6g} s" in text and "times the supply of 6 bar" in text and "unit" in text


def test_unit_of_a_table_is_named(tmp_path: Path) -> None:
    """A converter of kPa, recorded under a name without a unit and read as bar."""
    data = record()
    file = tmp_path / "rig.csv"
    columns = [data[name] for name in ("time", "valveVoltage", "position")]
    rows = zip(*columns, 1e-3 * data["chamberA.pressure"], 1e-5 * data["chamberB.pressure"], strict=True)
    file.write_text(
        "t,u,x,pa,pb\n" + "".join(",".join(f"{v:.9g}" for v in row) + "\n" for row in rows), encoding="utf-8"
    )
    names = "time=t,valveVoltage=u,position=x,chamberA.pressure=pa[bar],chamberB.pressure=pb[bar]"
    [text] = said(file, columns=names)  # type: ignore[arg-type]
    assert "chamberA.pressure=...[kPa]" in text and re.search(r"rig\.csv:\d+", text)


@pytest.mark.parametrize("dropped", [3, 4, 6])
def test_dropped_samples_at_speed_are_named_with_their_time(dropped: int) -> None:
    """Time counts on, and the position leaps by 3 to 6 mm where its neighbours make 0.8 mm."""
    time = np.arange(0.0, 2.0, 1e-3)
    position = 0.25 + 0.2 * np.sin(4.0 * time) + 1e-5 * np.random.default_rng(0).standard_normal(len(time))
    kept = np.delete(np.arange(len(time)), slice(801, 801 + dropped))
    [text] = faults(time=time[: len(kept)], position=position[kept])
    assert text.startswith("row 801 of position: position leaps by") and "at 0.801 s, as no mass does" in text
    assert not faults(time=time, position=position)


def test_clipped_position_is_named_and_an_end_stop_is_not() -> None:
    """Behind the end of its range a carriage goes on; from an end stop it has to speed up first."""
    time = np.arange(0.0, 3.0, 1e-3)
    position = 0.25 + 0.2 * np.sin(4.0 * time)
    [text] = faults(position=np.minimum(position, 0.42))
    assert f"position stays at 0.42 m, the end of what it reads, for {np.sum(position >= 0.42)} samples" in text
    assert not faults(position=position)
    # Against a stop at 0.42 m, where it rests for 0.3 s, and away from it with 5 m/s2.
    into = np.minimum(0.1 + 0.4 * time[:1200], 0.42)
    away = 0.42 - np.minimum(2.5 * time[:400] ** 2, 0.3)
    assert not faults(position=np.concatenate([into, away]))


def test_clipped_position_is_warned_of_with_its_time_and_row() -> None:
    data = record()
    data["position"] = np.maximum(data["position"], 0.08)
    first = int(np.flatnonzero(data["position"] == 0.08)[0])
    texts = [text for text in said(data) if "clipped" in text]
    assert texts and f"from {data['time'][first]:.6g} s (record 1, sample {first} of position)" in texts[0]


def test_shift_of_more_than_half_a_second_is_no_finding() -> None:
    """A search that leads nowhere leaves residuals that a line through an absurd delay explains."""
    data = record()
    data["position"] = 0.25 + 0.1 * np.sin(data["time"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = ps.fit(
            data, experiment="rig", law="Coulomb", settings={"supplyPressure": 6e5}, starts=0, progress=False,
            fit="friction.coulomb.Fc,valve.deadZone",
        )  # fmt: skip
    if found.doubt is not None and found.doubt.name.startswith(("delay", "lag")):
        assert isinstance(found.doubt.estimate, Estimate) and abs(found.doubt.estimate.value) <= 0.5

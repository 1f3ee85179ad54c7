"""Data that cannot be what they are taken for, and the forms in which people have them."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas
import pneumatic_servo as ps
import pytest
from numpy.typing import NDArray
from pneumatic_servo.identification.plausibility import outliers
from test_identification import bench

Array = NDArray[np.float64]

QUICK = {"experiment": "motion", "law": "Coulomb", "play": 0.0, "starts": 0, "progress": False}


def second_of_a_rig() -> ps.Run:
    """Voltage, position and pressures of a swing by 2 V."""
    time = np.arange(0, 1, 1e-3)
    return ps.Model().simulate(
        {"supplyPressure": 6e5}, inputs={"valveVoltage": (time, 5 + 2 * np.sin(6 * time))}, stop=1.0, step=1e-3,
        outputs=["valveVoltage", "position", "chamberA.pressure", "chamberB.pressure"],
    )  # fmt: skip


@pytest.fixture(scope="module")
def rig() -> ps.Run:
    return second_of_a_rig()


def signals(rig: ps.Run) -> dict[str, Array]:
    return {"time": rig.time, **{name: rig[name].copy() for name in rig.variables}}


def scaled(name: str, factor: float, offset: float = 0.0) -> Callable[[dict[str, Array]], None]:
    def change(data: dict[str, Array]) -> None:
        data[name] = factor * data[name] + offset

    return change


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (scaled("time", 1e3), ["time", "samples are 1 s apart", "[ms]"]),
        (scaled("time", 1e-6), ["time", "samples are 1e-9 s apart"]),
        (scaled("position", 1e3), ["position is from", "cylinder.stroke = 0.5 m", "write position=...[mm]"]),
        (scaled("position", 1.0, 0.4), ["position is from", "cylinder.stroke = 0.5 m, which is its default"]),
        (scaled("chamberA.pressure", 1e-5), ["chamberA.pressure is from", "Pa", "absolute", "bar"]),
        (scaled("chamberA.pressure", 1e-3), ["chamberA.pressure is from", "kPa"]),
        (scaled("chamberB.pressure", 1.0, -101325.0), ["chamberB.pressure is from", "from the atmosphere", "[barg]"]),
        (scaled("chamberB.pressure", 1e5), ["chamberB.pressure is from", "is the unit right"]),
    ],
)
def test_unit_that_cannot_be_meant_is_refused(
    rig: ps.Run, change: Callable[[dict[str, Array]], None], words: list[str]
) -> None:
    data = signals(rig)
    change(data)
    with pytest.raises(ValueError, match=re.escape(words[0])) as caught:
        ps.fit(data, experiment="rig", law="Stribeck", starts=0, progress=False)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_outlier_is_named_with_its_line_or_bridged(tmp_path: Path) -> None:
    data = bench()
    expected = ps.fit(data, loss="soft_l1", **QUICK).values
    frame = pandas.DataFrame(data)
    frame.loc[200, "position"] = 99.999
    frame.to_csv(tmp_path / "rig.csv", index=False)
    with pytest.raises(ValueError, match=r"rig\.csv:202, column 2 \(position\) = 99\.999 m; .* loss='soft_l1'"):
        ps.fit(tmp_path / "rig.csv", **QUICK)
    found = ps.fit(tmp_path / "rig.csv", loss="soft_l1", **QUICK)
    assert any("99.999" in note and "bridged" in note for note in found.notes)
    assert found.values["friction.coulomb.Fc"] == pytest.approx(expected["friction.coulomb.Fc"], rel=0.02)


def test_peak_that_is_climbed_to_is_no_outlier() -> None:
    """The break-away of a seal, after which its motion was cut from the record: 14 N above all that follows."""
    climb = [149.2, 149.2, 149.3, 150.1, 152.0, 155.6, 159.9, 165.3, 170.0]
    values = np.array([*climb, *([156.0, 155.9] * 20)])
    assert outliers(values)[0].tolist() == []
    values[30:32] = 999.99
    assert outliers(values)[0].tolist() == [30, 31]


def test_model_that_misses_a_signal_is_told() -> None:
    data = bench()
    data["frictionForce"] = -data["frictionForce"]
    with (
        pytest.warns(ps.PlantWarning, match="frictionForce works against friction"),
        pytest.warns(ps.PlantWarning, match=r"does not describe frictionForce: RMS residual .* N of"),
    ):
        ps.fit(data, **QUICK)


@pytest.mark.parametrize("form", ["DataFrame", "index", "mapping", "renamed", "file"])
def test_fit_takes_what_people_have(tmp_path: Path, form: str) -> None:
    data = bench()
    expected = ps.fit(data, **QUICK).values
    frame = pandas.DataFrame(data)
    columns: dict[str, str] | None = None
    given: object = frame
    if form == "index":
        given = frame.set_index("time")
    elif form == "mapping":
        given, columns = {"t": data["time"], "x": 1e3 * data["position"], "f": data["frictionForce"]}, {}
    elif form == "renamed":
        given, columns = frame.rename(columns={"time": "t", "position": "x", "frictionForce": "f"}), {}
        given["x"] *= 1e3
    elif form == "file":
        frame.to_csv(tmp_path / "a.csv", index=False)
        given = tmp_path / "a.csv"
    if columns is not None:
        columns = {"time": "t", "position": "x[mm]", "frictionForce": "f"}
    found = ps.fit(given, columns=columns, **QUICK)
    assert found.values == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: ps.fit({"t": [0.0]}, **QUICK), ["there is no signal t", "`columns` says which"]),
        (lambda: ps.fit(bench(), **{**QUICK, "law": "Coulom"}), ["law='Coulom'", "did you mean Coulomb"]),
        (lambda: ps.fit(bench(), settings={"mas": 1}, **QUICK), ["settings='mas'", "did you mean mass"]),
        (
            lambda: ps.fit(bench(), columns="time=t,positon=x", **QUICK),
            ["columns='positon=x'", "mean position"],
        ),
        (lambda: ps.plan(law="LuGre", noise={"position": 10}), ["noise of position = 10 m", "0.01 m", "10 um"]),
        (lambda: ps.plan(law="LuGre", noise={"posi": 1e-5}), ["no signal posi", "did you mean position"]),
        (lambda: ps.DataSheet(bore=0.032, stroke=200, mass=5, qn=700), ["bore = 0.032 mm", "in m?", "32 mm"]),
        (
            lambda: ps.DataSheet(bore=32, stroke=200, mass=5, qn=700, supply=600_000),
            ["supply = 600000 bar", "in Pa?", "6 bar"],
        ),
    ],
)
def test_refusal_speaks_of_arguments_and_of_what_is_right(call: Callable[[], object], words: list[str]) -> None:
    with pytest.raises(ValueError, match=re.escape(words[0])) as caught:
        call()
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_start_from_data_stays_below_a_static_friction_that_is_not_free(rig: ps.Run) -> None:
    """Of a run in one line: 24 N of pressure force were refused beside the default of 11 N."""
    found = ps.fit(rig, experiment="rig", law="Stribeck", fit="friction.stribeck.Fc", starts=0, progress=False,
                   settings={"supplyPressure": "6 bar"})  # fmt: skip
    default = ps.Model().parameters["friction.stribeck.Fc"].default
    assert found.values["friction.stribeck.Fc"] == pytest.approx(default, rel=0.01)

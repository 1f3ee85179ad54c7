"""Measured tables: which column is which signal, units, signs and the places that errors name, word by word."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pneumatic_servo as ps
import pytest
from pneumatic_servo.chosen_columns import Column, columns_of
from pneumatic_servo.identification.signals import SIGNALS as KNOWN
from pneumatic_servo.identification.table import Measured, listed, measured

SIGNALS = (
    "time, position, velocity, frictionForce, force, normalForce, pressure, valveVoltage, supplyPressure, "
    "externalForce, chamberA.pressure, chamberB.pressure"
)


def test_columns_are_read_with_units_and_signs() -> None:
    found = columns_of(" time=t, position = -x[mm] ,,force=F N", KNOWN)
    assert found == {
        "time": Column("t", None), "position": Column("x", "mm", turned=True), "force": Column("F N", None),
    }  # fmt: skip
    assert columns_of({"time": "t", "position": "-x[mm]", "force": "F N"}, KNOWN) == found


def refused(text: str) -> Any:
    return pytest.raises(ValueError, match=f"^{re.escape(text)}$")


DATA: dict[str, Any] = {"time": [0.0, 1.0, 2.0], "x": [1.0, 2.0, 4.0], "p": [0.0, 1.0, 2.0]}


def read(source: Any, columns: str | None = None) -> Measured:
    return measured(3, source, None if columns is None else columns_of(columns, KNOWN))


def values(found: Measured) -> dict[str, list[float]]:
    return {name: np.asarray(column).tolist() for name, column in found.signals.items()}


@pytest.mark.parametrize("kind", ["mapping", "frame"])
def test_arrays_are_in_si_units_with_the_sign_that_is_ours(kind: str) -> None:
    source = DATA if kind == "mapping" else pandas.DataFrame(DATA)
    found = read(source, "time=time[ms],position=-x[mm],pressure=p[barg]")
    assert values(found) == {
        "time": [0.0, 0.001, 0.002], "position": [-0.001, -0.002, -0.004],
        "pressure": [0.0, 1e5, 2e5],
    }  # fmt: skip
    assert found.name == "record 3"
    if kind == "mapping":
        assert found.where("position", 2) == "record 3, sample 2 of x"
        assert found.stated == {
            "time": ("s", "columns='time=time[ms]'"), "position": ("m", "columns='position=x[mm]'"),
            "pressure": ("Pa", "columns='pressure=p[barg]'"),
        }  # fmt: skip
        assert found.written == {}
    else:
        assert found.where("position", 2) == "record 3:2, column 2 (x)"
        assert found.written == {"time": ("time", "ms"), "position": ("x", "mm"), "pressure": ("p", "barg")}
        assert found.stated["position"] == ("m", "record 3:0, column 2 (x)")


def test_mapping_by_the_names_of_signals_needs_no_columns() -> None:
    given = {"time": [0, 1], "position": [3, 4], "chamberA.pressure": [5, 6]}
    for columns in (None, "time=t,position=x"):
        found = read(given, columns)
        assert values(found) == {name: [float(one) for one in column] for name, column in given.items()}
        assert found.where("position", 1) == "record 3, sample 1 of position" and not found.stated
    # Columns that are all present count under any name.
    other = read({"time": [0, 1], "force": [5, 6], "position": [3, 4]}, "time=time,position=force")
    assert values(other) == {"time": [0.0, 1.0], "position": [5.0, 6.0]}


def test_what_is_no_number_is_named() -> None:
    with pytest.raises(ValueError, match=r"^position is refused: it must be numbers; could not convert string"):
        read({"time": [0], "position": ["a"]})
    with pytest.raises(ValueError, match=r"^x is refused: it must be numbers; "):
        read({"t": [0], "x": [object()]}, "time=t,position=x")


@pytest.mark.parametrize(
    ("source", "columns", "text"),
    [
        ({"t": [0]}, None,
         f"there is no signal t; did you mean time?; there are {SIGNALS}; `columns` says which of the arrays is which "
         "signal"),
        (DATA, "time=tme", "columns: there is no array tme for time; did you mean time?; there are time, x, p"),
        (DATA, "time=time[mm]",
         "columns='time=time[mm]': the unit mm is refused; it must be one of s, ms, us, ns, min, h, d"),
        (pandas.DataFrame({"time": DATA["time"], "b": DATA["x"]}), None, None),
        (pandas.DataFrame({"a": [0.0], "b": [1.0]}), None,
         "record 3:0: there is no column `time`, only a, b; columns says which column is which signal, for example "
         "time=t,position=x[mm]"),
        (pandas.DataFrame(DATA), "time=time,position=y",
         "record 3:0: there is no column y for position; there are time, x, p"),
        (pandas.DataFrame({"time": [0.0, 2.0, 2.0]}), None,
         "record 3:2, column time: time must rise, but 2 s follows 2 s"),
        (pandas.DataFrame({"t": [0.0, 2.0, 1.0]}), "time=t[ms]",
         "record 3:2, column t: time must rise, but 1 ms follows 2 ms"),
        (pandas.DataFrame({"time [min]": [3.0, 2.0]}), None,
         "record 3:1, column time: time must rise, but 2 min follows 3 min"),
        (pandas.DataFrame({"time": []}), None, "record 3: there are no rows below the header"),
        (pandas.DataFrame({"time": [0.0], "x [V]": [1.0]}), "time=time,position=x",
         "record 3:0, column 2 (x): the unit V is refused; it must be one of m, cm, mm, um, nm, in, ft, or for "
         "the experiment force of rad, mrad, deg; readings in V need a calibration, such as 4..20 mA = 0..10 bar; "
         "columns says which it is, position=x[m]"),
        (pandas.DataFrame({"time": [0.0], "x [deg]": [1.0]}), "time=time,position=x[m]",
         "record 3:0, column 2 (x): the table says deg, columns m; which is it?"),
    ],
)  # fmt: skip
def test_table_that_is_refused_says_where(source: Any, columns: str | None, text: str | None) -> None:
    if text is None:
        assert values(read(source)) == {"time": DATA["time"]}
        return
    with refused(text):
        read(source, columns)


def test_columns_of_usual_names_are_taken_where_none_has_the_name_of_a_signal() -> None:
    """In English and German, which a warning tells; a column that is named as a signal leaves the others alone."""
    frame = pandas.DataFrame(
        {"Zeit [ms]": [0.0, 1.0], "Weg [mm]": [1.0, 2.0], "v_mm/s": [5.0, 6.0], "note": [0.0, 0.0]}
    )
    with pytest.warns(UserWarning, match=r"Zeit \[ms\] for time, Weg \[mm\] for position, v_mm/s for velocity"):
        found = read(frame)
    assert values(found) == {"time": [0.0, 0.001], "position": [0.001, 0.002], "velocity": [0.005, 0.006]}
    named = pandas.DataFrame({"time": [0.0, 1.0], "position": [1.0, 2.0], "F": [5.0, 6.0]})
    assert values(read(named)).keys() == {"time", "position"}


def test_units_are_those_that_are_given_or_written() -> None:
    """A file, with its lines; what was written in a unit says where."""
    frame = pandas.DataFrame({
        "time [ms]": [0.0, 1.0], "position (mm)": [1.0, 2.0], "velocity": [3.0, 4.0], "force [A]": [5.0, 6.0],
        "pressure [A]": [2e5, 3e5],
    })  # fmt: skip
    found = read(frame)
    assert values(found) == {
        "time": [0.0, 0.001], "position": [0.001, 0.002], "velocity": [3.0, 4.0], "force": [5.0, 6.0],
        # The pressure of chamber A.
        "pressure": [2e5, 3e5],
    }  # fmt: skip
    assert found.written == {"time": ("time", "ms"), "position": ("position", "mm"), "velocity": ("velocity", "m/s"),
                             "force": ("force", "A"), "pressure": ("pressure", "Pa")}  # fmt: skip
    assert found.stated == {
        "time": ("s", "record 3:0, column 1 (time)"), "position": ("m", "record 3:0, column 2 (position)"),
        "force": ("A", "record 3:0, column 4 (force)"),
    }  # fmt: skip
    # Two names of the same unit agree.
    same = read(pandas.DataFrame({"time [ms]": [0.0, 1.0]}), "time=time[ms]")
    assert values(same) == {"time": [0.0, 0.001]} and same.written == {"time": ("time", "ms")}


def test_file_is_named_with_its_lines(tmp_path: Path) -> None:
    file = tmp_path / "rig.csv"
    file.write_text("# a remark\nt,x\n\n0,1\n1,2\n", encoding="utf-8")
    found = read(file, "time=t,position=x[mm]")
    assert found.name == "rig.csv" and found.where("position", 1) == f"{file}:5, column 2 (x)"
    assert found.stated == {"position": ("m", f"{file}:2, column 2 (x)")}
    assert values(read(str(file), "time=t,position=x[mm]")) == values(found)
    file.write_text("t,x\n", encoding="utf-8")
    with refused(f"{file}: there are no rows below the header"):
        read(file, "time=t")


@pytest.fixture(scope="module")
def run() -> ps.Run:
    voltage = (np.arange(4) * 1e-3, [5.0, 6.0, 7.0, 8.0])
    outputs = ["valveVoltage", "position", "frictionForce", "velocity"]
    return ps.Model().simulate({}, inputs={"valveVoltage": voltage}, stop=3e-3, step=1e-3, outputs=outputs)


@pytest.mark.parametrize("form", ["run", "frame"])
def test_run_has_its_inputs_as_they_act_from_each_row_on(run: ps.Run, form: str) -> None:
    """A run records what was in force up to a row; a table of measurements has what is from there on."""
    found = read(run if form == "run" else run.to_pandas())
    held = run["valveVoltage"]
    assert found.signals["valveVoltage"].tolist() == [*held[1:], held[-1]] == [5.0, 6.0, 7.0, 7.0]
    for name in ("position", "velocity", "frictionForce"):
        assert np.array_equal(found.signals[name], run[name])
    assert np.array_equal(found.signals["time"], run.time) and found.name == "record 3"
    if form == "run":
        assert found.where("position", 2) == "record 3, sample 2 of position"
    else:
        plain = pandas.DataFrame({"time": run.time, "valveVoltage": held})
        assert np.array_equal(read(plain).signals["valveVoltage"], held)


def test_single_source_is_a_list_of_one(run: ps.Run) -> None:
    frame = pandas.DataFrame(DATA)
    for one in ("a.csv", Path("a.csv"), DATA, run, 3, frame):
        [found] = listed(one)
        assert found is one
    assert listed((DATA, "b.csv")) == [DATA, "b.csv"] and listed(iter("ab")) == ["a", "b"]

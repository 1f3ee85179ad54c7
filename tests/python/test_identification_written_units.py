"""Units as laboratories write them: none is read as another one without a word."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from pneumatic_servo import _native
from pneumatic_servo.chosen_columns import columns_of
from pneumatic_servo.errors import PlantWarning
from pneumatic_servo.identification.signals import SIGNALS
from pneumatic_servo.identification.table import measured
from pneumatic_servo.tables import read_text

TIME = np.arange(0.0, 1.0, 0.01)
ATMOSPHERE = 101325.0


def of(header: str, values: Any, columns: str | None = None) -> Any:
    given = None if columns is None else columns_of(columns, SIGNALS)
    return measured(1, {"time": TIME, header: values}, given).signals


@pytest.mark.parametrize("unit", ["barg", "bar(g)", "bar (g)", "kPag", "psig", "psi(g)"])
def test_gauge_unit_of_a_pressure_above_ambient_has_no_offset(unit: str) -> None:
    """`pressure` of a bench counts above ambient, the pressure of a chamber from vacuum."""
    one = {"b": 1e5, "k": 1e3, "p": 6894.757293168361}[unit[0]]
    bench = of(f"pressure [{unit}]", np.full(len(TIME), 3.0))["pressure"]
    chamber = of(f"chamberA.pressure [{unit}]", np.full(len(TIME), 3.0))["chamberA.pressure"]
    assert bench == pytest.approx(3.0 * one, rel=1e-14)
    assert chamber == pytest.approx(3.0 * one + ATMOSPHERE, rel=1e-14)


@pytest.mark.parametrize(
    ("header", "factor"),
    [
        ("force [daN]", 10.0), ("force [kp]", 9.80665), ("force (kgf)", 9.80665), ("velocity [cm/s]", 1e-2),
        ("velocity [km/h]", 1 / 3.6), ("velocity / m/min", 1 / 60), ("position [inch]", 0.0254),
        ("force [KN]", None), ("force [lbs]", None), ("force (lbs)", None),
        ("chamberA.pressure [Bar]", None), ("chamberA.pressure (Bar)", None), ("position [foo]", None),
    ],
)  # fmt: skip
def test_unit_is_converted_or_refused_by_name(header: str, factor: float | None) -> None:
    signal, unit = re.split(r" [\[(/] ?", header.rstrip("])"))
    if factor is not None:
        assert of(header, np.ones(len(TIME)))[signal] == pytest.approx(factor, rel=1e-14)
        return
    for columns in (None, f"time=time,{signal}={header}"):
        with pytest.raises(ValueError, match=re.escape(f"the unit {unit} is refused")) as refused:
            of(header, np.ones(len(TIME)), columns)
    near = {"KN": "kN", "lbs": "lbf", "Bar": "bar"}.get(unit)
    assert near is None or f"did you mean {near}?" in str(refused.value)


def test_unit_of_columns_counts_and_is_told() -> None:
    """Gauge readings in a column that says bar: the user says barg."""
    with pytest.warns(PlantWarning, match="the table says bar, .*barg, which counts"):
        found = of("p_A [bar]", np.full(len(TIME), 3.0), "time=time,chamberA.pressure=p_A[barg]")
    assert found["chamberA.pressure"] == pytest.approx(3e5 + ATMOSPHERE)
    with pytest.warns(PlantWarning, match="which counts"):
        found = of("F [KN]", np.ones(len(TIME)), "time=time,force=F[kN]")
    assert found["force"] == pytest.approx(1e3)


def test_names_keep_what_is_no_unit() -> None:
    """A word, an element, a chamber, a ratio and a number are none."""
    header = ["Position (left)", "friction.gms.alpha[1]", "F/x", "reading (2)", "x_KN"]
    assert _native.names_and_units(header) == (header, [None] * len(header))


class Quantity:
    """Stands for quantities of packages: `unit` names the attribute of the unit, `value` that of the numbers."""

    def __init__(self, numbers: Any, factor: float, unit: str, value: str) -> None:
        self._numbers, self._factor = np.asarray(numbers), factor
        setattr(self, unit, "mm/s")
        setattr(self, value, self._numbers)
        self._names = unit, value

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        return np.asarray(self._numbers, dtype=dtype)

    def to(self, unit: str) -> Quantity:
        assert unit in ("m/s", "N")
        return Quantity(self._factor * self._numbers, 1.0, *self._names)


@pytest.mark.parametrize("names", [("units", "magnitude"), ("unit", "value"), ("units", "value")])
def test_quantities_of_any_package_are_converted(names: tuple[str, str]) -> None:
    speed = Quantity([10.0, 50.0, 200.0], 1e-3, *names)
    force = Quantity([0.008, 0.009, 0.010], 1e3, *names)
    table = ps.friction_table(speed, force)
    assert table == ps.friction_table([0.01, 0.05, 0.2], [8.0, 9.0, 10.0])
    assert ps.friction_table({"velocity": speed, "force": force}) == table
    whole = Quantity(np.full(len(TIME), 0.1), 1e3, *names)
    assert of("force", whole)["force"] == pytest.approx(100.0)
    one = Quantity(0.1, 1e3, *names)
    run = ps.Model("FrictionBench").simulate(inputs={"appliedForce": one}, stop=0.01, outputs=["appliedForce"])
    assert run["appliedForce"][-1] == pytest.approx(100.0)


@pytest.mark.parametrize(
    ("rows", "value"),
    [
        ("0.000;101,131\n0.001;101,132\n", None),
        ("0.5;1,250\n0.6;0,5\n", None),
        ("0,0;601.325\n0,5;601.326\n", None),
        ("0,5;999,9\n1,5;1.014\n", None),
        ("0,000;101,131\n0,001;101,132\n", 101.131),
        ("0.001;0,5\n0.002;0,6\n", 0.5),
        ("0,1;0.5\n0,2;1.125\n", 0.5),
        ("1;2\n" * 30 + "31;2,5\n", 2.0),
    ],
)
def test_commas_that_may_separate_thousands_are_refused(tmp_path: Path, rows: str, value: float | None) -> None:
    file = tmp_path / "record.csv"
    file.write_text("t;p\n" + rows)
    if value is not None:
        assert read_text(file).values[0, 1] == value
        return
    with pytest.raises(ValueError, match="thousands") as refused:
        read_text(file)
    assert "column 1 (t)" in str(refused.value) and "column 2 (p)" in str(refused.value)


@pytest.mark.parametrize("rows", ["0;601,325\n1;601,326\n", '0,"1,234"\n1,"1,235"\n'])
def test_marks_that_nothing_explains_are_refused(tmp_path: Path, rows: str) -> None:
    file = tmp_path / "record.csv"
    file.write_text(("t,p\n" if '"' in rows else "t;p\n") + rows)
    with pytest.raises(ValueError, match=r"record.csv:2, column 2 \(p\).*no other number tells; write a decimal point"):
        read_text(file)


@pytest.mark.parametrize(("mark", "separator"), [(".", ";"), (".", ","), (",", ";")])
def test_column_with_marks_before_thousands_alone_is_refused(tmp_path: Path, mark: str, separator: str) -> None:
    """Numbers below 1000 have none; a 0 tells nothing."""
    file = tmp_path / "record.csv"

    def rows(*cells: str) -> str:
        return "".join(f"0{mark}5{separator}{cell}\n" for cell in cells)

    file.write_text(f"t{separator}p\n" + rows("998", "999", f"1{mark}000", f"1{mark}001"))
    with pytest.raises(ValueError, match=r"the mark of '1.000' may separate thousands, since '998' .*has none"):
        read_text(file).in_si(1, "N", "N")
    file.write_text(f"t{separator}p\n" + rows("0", "0", f"1{mark}125", f"1{mark}250"))
    assert read_text(file).in_si(1, "N", "N")[-1] == 1.25
    file.write_text(f"t{separator}p\n" + rows("999", f"1{mark}000", f"1{mark}5"))
    assert read_text(file).in_si(1, "N", "N")[-1] == 1.5


def test_letters_in_brackets_are_units_but_for_chambers(tmp_path: Path) -> None:
    file = tmp_path / "record.csv"
    for unit, near in (("H", "h"), ("v", "V")):
        file.write_text(f"x [{unit}],F [N]\n0,1\n1,2\n")
        table = read_text(file)
        assert (table.names[0], table.units[0]) == ("x", unit)
        with pytest.raises(ValueError, match=f"the unit {unit} is refused; did you mean {near}"):
            table.in_si(0, unit, "s" if near == "h" else "V")
    file.write_text("p [B],F [N]\n0,1\n1,2\n")
    assert read_text(file).names[0] == "p [B]"


@pytest.mark.parametrize(
    ("written", "own"),
    [
        ("bar\u00fc", "barg"),
        ("bar(\u00fc)", "barg"),
        ("r/min", "rpm"),
        ("U/min", "rpm"),
        ("msec", "ms"),
        ("Volts", "V"),
    ],
)
def test_spellings_of_units_are_known(tmp_path: Path, written: str, own: str) -> None:
    file = tmp_path / "record.csv"
    file.write_text(f"x [{written}],F [N]\n0,1\n1,2\n", encoding="utf-8")
    si = {"barg": "Pa", "rpm": "rad/s", "ms": "s", "V": "V"}[own]
    table = read_text(file)
    unit = table.units[0]
    assert unit is not None and table.in_si(0, unit, si).tolist() == table.in_si(0, own, si).tolist()


def test_row_of_units_above_the_names_counts(tmp_path: Path) -> None:
    file = tmp_path / "record.csv"
    file.write_text("Model,M1\n,ms,r/min,%\n,Time,Motor speed,Torque\n0,0.000,100,5\n1,0.888,110,6\n")
    table = read_text(file)
    assert table.names[1:] == ["Time", "Motor speed", "Torque"]
    assert table.units == [None, "ms", "r/min", "%"] and table.in_si(1, "ms", "s")[1] == 0.888e-3

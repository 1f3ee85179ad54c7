"""Tables of pandas made from runs and comparisons."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pneumatic_servo as ps
import pytest
from pneumatic_servo.comparison import COLUMNS
from pneumatic_servo.tables import of_frame, read_table, table_of
from reading import check

OUTPUTS = ["position", "chamberA.pressure", "sticking"]


@pytest.fixture(scope="module")
def run() -> ps.Run:
    return ps.Model().simulate(inputs={"valveVoltage": 6.5}, stop=0.2, step=1e-3, outputs=OUTPUTS, every=10)


@pytest.fixture(scope="module")
def comparison() -> ps.Comparison:
    laws = ["Stribeck", "LuGre"]
    return ps.Model().compare(laws, inputs={"valveVoltage": 6.5}, stop=0.2, step=1e-3, progress=False)


def test_run_is_a_table_over_time(run: ps.Run) -> None:
    table = run.to_pandas()
    assert table.index.name == "time" and list(table.columns) == OUTPUTS
    assert table.index.to_numpy().tobytes() == run.time.tobytes() and len(table) == 21
    for name in OUTPUTS:
        assert table[name].to_numpy().tobytes() == run[name].tobytes(), name
    # Numbers, with which pandas computes.
    assert set(table.dtypes) == {np.dtype(float)}
    assert table["position"].diff().max() > 0.0


def test_comparison_is_a_table_of_laws(comparison: ps.Comparison) -> None:
    table = comparison.to_pandas()
    assert table.index.name == "law" and list(table.index) == ["Stribeck", "LuGre"]
    assert list(table.columns) == COLUMNS[1:]
    for law, *facts in comparison.rows():
        assert table.loc[law].tolist() == facts
    assert isinstance(table, pd.DataFrame) and table["travel (m)"].min() > 0.0


@pytest.mark.parametrize("of", ["run", "comparison"])
def test_missing_pandas_is_named(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest, of: str) -> None:
    to_pandas: Callable[[], object] = request.getfixturevalue(of).to_pandas
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ps.MissingPackage, match=r"this needs pandas: pip install 'pneumatic-servo\[pandas\]'"):
        to_pandas()


def test_dates_are_seconds_from_the_first() -> None:
    times = pd.to_datetime(["2026-01-31 23:59:59.5", "2026-02-01 00:00:00.0", "2026-02-01 00:01:00.25"])
    for given in (times, times - times[0]):
        table = of_frame(pd.DataFrame({"time": given, "x": [1.0, 2.0, 3.0]}), Path("a"))
        assert table.values[:, 0].tolist() == [0.0, 0.5, 60.75]


def test_milliseconds_are_the_seconds_that_they_are_written_as() -> None:
    """Divided by 1000, since 0.001 times 9 is 0.009000000000000001."""
    table = of_frame(pd.DataFrame({"time [ms]": range(1000)}), Path("a"))
    assert table.in_si(0, "ms", "s").tolist() == [float(f"{k}e-3") for k in range(1000)]
    # Columns in SI units stay as they were.
    assert table.in_si(0, "s", "s").tolist() == list(range(1000))


def test_fault_beside_decimal_commas_is_named_and_no_comma(tmp_path: Path) -> None:
    file = tmp_path / "data.csv"
    file.write_text("time;valveVoltage\n0,5;1,5\n1,0;low\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"data\.csv:3, column 2 \(valveVoltage\): 'low' is no number$"):
        read_table(file).in_si(1, "V", "V")
    file.write_text("time;valveVoltage\n0,5;1,5\n1,0;2,25\n", encoding="utf-8")
    assert read_table(file).values.tolist() == [[0.5, 1.5], [1.0, 2.25]]


def test_number_that_is_not_finite_is_named_by_its_place(tmp_path: Path) -> None:
    file = tmp_path / "data.parquet"
    pd.DataFrame({"t": [0.0, 0.1, 0.2], "x": [1.0, 2.0, np.inf]}).to_parquet(file)
    with pytest.raises(ValueError, match=r"data\.parquet:2, column 2 \(x\): inf is not finite"):
        read_table(file).in_si(1, "m", "m")


KEPT = sorted((Path(__file__).parents[2] / "tests/fuzz/kept" / "readers").iterdir())


@pytest.mark.parametrize("kept", KEPT, ids=lambda kept: kept.name)
def test_file_that_a_fuzzer_has_kept_is_read_or_refused(kept: Path, tmp_path: Path) -> None:
    check(kept.read_bytes(), tmp_path)


def test_units_of_variables_of_xarray_count() -> None:
    xarray = pytest.importorskip("xarray")
    time = np.arange(5) * 0.001
    data = xarray.Dataset({"F": ("t", 1.2 + time, {"units": "kN"})}, {"t": ("t", time, {"units": "s"})})
    for source in (data, data["F"]):
        table = table_of(source, "data")
        assert table is not None
        assert dict(zip(table.names, table.units, strict=True)) == {"t": "s", "F": "kN"}


def test_arrays_of_other_shapes_are_named_and_hurt_no_others(tmp_path: Path) -> None:
    file, time = tmp_path / "data.npz", np.arange(3.0)
    np.savez(file, t=time, u=5.0, m=np.zeros((3, 2)))
    table = read_table(file)
    assert table.in_si(0, "s", "s").tolist() == time.tolist()
    with pytest.raises(ValueError, match=r"column 2 \(u\): it has 1 values, others have 3"):
        table.in_si(1, "V", "V")
    with pytest.raises(ValueError, match=r"column 3 \(m\): it has the shape \(3, 2\); a column is a vector"):
        table.in_si(2, "m", "m")
    np.savez(file, np.column_stack([time, 2.0 * time]))
    assert read_table(file).names == ["1", "2"]
    for name, content in (("a.npz", b"PK damaged"), ("a.npy", b"damaged")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(ValueError, match=f"{name}: it is damaged, or has Python objects"):
            read_table(tmp_path / name)


def test_matrix_beside_other_variables_of_matlab_is_columns(tmp_path: Path) -> None:
    savemat = pytest.importorskip("scipy.io").savemat
    file, matrix = tmp_path / "data.mat", np.arange(10.0).reshape(5, 2)
    savemat(file, {"data": matrix, "name": "abc"})
    assert read_table(file).names == ["1", "2"]
    savemat(file, {"data": matrix, "u": np.arange(5.0)})
    table = read_table(file)
    assert sorted(table.names) == ["data 1", "data 2", "u"]
    assert table.values[:, table.names.index("data 2")].tolist() == matrix[:, 1].tolist()

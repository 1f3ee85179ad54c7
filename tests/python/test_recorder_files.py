"""Files as recorders, oscilloscopes and other programs write them: all give the same signals."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from pneumatic_servo.chosen_columns import columns_of
from pneumatic_servo.identification.signals import SIGNALS as KNOWN
from pneumatic_servo.identification.table import measured
from pneumatic_servo.tables import read_table
from scipy.io import savemat

Array = NDArray[np.float64]
TIME = np.round(np.arange(0.0, 0.05, 1e-3), 6)
POSITION = np.round(0.1 + 0.02 * np.sin(60.0 * TIME), 6)
FORCE = np.round(7.0 * np.cos(60.0 * TIME), 4)
SIGNALS = {"time": TIME, "position": POSITION, "frictionForce": FORCE}


def signals_of(source: Any, columns: str | None) -> dict[str, Array]:
    return dict(measured(1, source, None if columns is None else columns_of(columns, KNOWN)).signals)


def holds(source: Any, columns: str | None = None) -> None:
    """Whether a source has the three signals."""
    found = signals_of(source, columns)
    assert found.keys() == SIGNALS.keys()
    for name, values in SIGNALS.items():
        np.testing.assert_allclose(found[name], values, rtol=1e-12, atol=1e-12, err_msg=name)


def text(file: Path, lines: list[str]) -> Path:
    file.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return file


ROWS = list(zip(TIME, POSITION, FORCE, strict=True))


def labview(
    x_columns: str, separator: str = "\t", decimal: str = ".", segments: int = 1, comment: bool = True
) -> list[str]:
    """Lines as LabVIEW writes them; where times are no column, X0 and Delta_X tell them."""
    name = {"\t": "Tab", ",": "Comma"}[separator]
    head = [["LabVIEW Measurement"], ["Writer_Version", "2"], ["Reader_Version", "2"], ["Separator", name],
            ["Decimal_Separator", decimal], ["Multi_Headings", "Yes" if segments > 1 else "No"],
            ["X_Columns", x_columns], ["Time_Pref", "Relative"], ["***End_of_Header***"], []]  # fmt: skip
    lines = list(head)
    for part in np.array_split(np.arange(len(TIME)), segments):
        begin = f"{TIME[part[0]]:.6f}"
        lines += [["Channels", "2", ""], ["Samples", *[str(len(part))] * 2], ["Y_Unit_Label", "mm", "N"],
                  ["X0", begin, begin], ["Delta_X", "0.001", "0.001"], ["***End_of_Header***"]]  # fmt: skip
        names = {"No": ["X_Value", "pos", "F"], "One": ["X_Value", "pos", "F"],
                 "Multi": ["X_Value", "pos", "X_Value", "F"]}[x_columns]  # fmt: skip
        lines.append([*names, *(["Comment"] if comment else [])])
        for t, x, force in (ROWS[k] for k in part):
            cells = {"No": ["", f"{1e3 * x:.6f}", str(force)], "One": [f"{t:.6f}", f"{1e3 * x:.6f}", str(force)],
                     "Multi": [f"{t:.6f}", f"{1e3 * x:.6f}", f"{t:.6f}", str(force)]}[x_columns]  # fmt: skip
            lines.append(cells)
    return [separator.join(cell.replace(".", decimal) if cells[0] != "Separator" else cell for cell in cells)
            for cells in lines]  # fmt: skip


@pytest.mark.parametrize("x_columns", ["One", "No", "Multi"])
@pytest.mark.parametrize("options", [{}, {"decimal": ","}, {"separator": ","}, {"segments": 3}, {"comment": False}])
def test_labview(tmp_path: Path, x_columns: str, options: dict[str, Any]) -> None:
    file = text(tmp_path / "a.lvm", labview(x_columns, **options))
    holds(file, "time=X_Value,position=pos,frictionForce=F")
    # The first clock is the time of those who name the signals only.
    assert read_table(file).names[0] == "time"


def test_labview_without_a_time_is_refused(tmp_path: Path) -> None:
    lines = [line for line in labview("No") if not line.startswith("Delta_X")]
    with pytest.raises(ValueError, match=r"X_Columns is No, and Delta_X of pos is not there: there is no time"):
        read_table(text(tmp_path / "a.lvm", lines))


def twincat(separator: str = "\t", decimal: str = ".", step: int = 1) -> list[str]:
    """Lines as TwinCAT Scope exports them: a clock in ms for each channel; the force has every few samples only."""
    lines = [["Name", "Scope"], ["File", "a.csv"], ["Starttime of export", "1"], ["Endtime of export", "2"],
             [], [], ["Name", "MAIN.x", "Name", "MAIN.F"], ["SymbolComment", "", "SymbolComment", ""],
             ["SampleTime[ms]", "1", "SampleTime[ms]", str(step)], ["Unit", "mm (Length)", "Unit", "(None)"],
             ["Unit ScaleFactor", "1", "Unit ScaleFactor", "1"], ["Unit Offset", "0", "Unit Offset"], []]  # fmt: skip
    for k, (t, x, _) in enumerate(ROWS):
        slow = [f"{1e3 * TIME[step * k]:g}", str(FORCE[step * k])] if step * k < len(TIME) else ["", ""]
        lines.append([f"{1e3 * t:g}", f"{1e3 * x:.6f}", *slow])
    return [separator.join(cell.replace(".", decimal) if k > 12 else cell for cell in cells)
            for k, cells in enumerate([*lines, ["EOF"]])]  # fmt: skip


@pytest.mark.parametrize(("separator", "decimal"), [("\t", "."), ("\t", ","), (";", ","), (",", ".")])
def test_twincat_scope(tmp_path: Path, separator: str, decimal: str) -> None:
    file = text(tmp_path / "a.csv", twincat(separator, decimal))
    holds(file, "time=time,position=MAIN.x,frictionForce=MAIN.F[N]")


def test_channel_with_a_clock_of_its_own_is_brought_to_the_chosen_one(tmp_path: Path) -> None:
    """Readings run on straight lines between their samples, commands are held, and a warning says so."""
    file = text(tmp_path / "a.csv", twincat(step=3))
    with pytest.warns(UserWarning, match=r"frictionForce was read at other times than time"):
        found = signals_of(file, "time=time,position=MAIN.x,frictionForce=MAIN.F[N]")
    last = TIME[::3][-1]
    inside = last >= TIME
    np.testing.assert_allclose(found["time"], TIME[inside], rtol=1e-12)
    np.testing.assert_allclose(found["frictionForce"], np.interp(TIME[inside], TIME[::3], FORCE[::3]), atol=1e-12)
    with pytest.warns(UserWarning, match="valveVoltage was read at other times"):
        held = signals_of(file, "time=time,position=MAIN.x,valveVoltage=MAIN.F[V]")["valveVoltage"]
    np.testing.assert_array_equal(held, np.repeat(FORCE[::3], 3)[: len(held)])


def test_empty_cells_of_a_slow_channel(tmp_path: Path) -> None:
    lines = [f"{t},{x},{force if k % 4 == 0 else ''}" for k, (t, x, force) in enumerate(ROWS)]
    with pytest.warns(UserWarning, match="frictionForce was read at other times"):
        found = signals_of(text(tmp_path / "a.csv", ["time,position,frictionForce", *lines]), None)
    inside = TIME[::4][-1] >= TIME
    np.testing.assert_allclose(found["frictionForce"], np.interp(TIME[inside], TIME[::4], FORCE[::4]), atol=1e-12)


COMBI = ["double run(50, 3) # time, position, frictionForce", "double run(50,3)", "float run ( 50 , 3 )"]


@pytest.mark.parametrize("head", COMBI)
def test_table_of_modelica(tmp_path: Path, head: str) -> None:
    """Names stand behind the head, as a run writes them, or columns have numbers; a row may take two lines."""
    lines = [f"{t} {x}{' # a remark' if k == 3 else ''}\n  {force}" for k, (t, x, force) in enumerate(ROWS)]
    file = text(tmp_path / "a.txt", ["#1", "# made by hand", head, *lines])
    holds(file, None if "time" in head else "time=1,position=2,frictionForce=3")


@pytest.mark.parametrize(
    ("lines", "refusal"),
    [
        (["double a(2,2)", "0 1", "1"], r"a\.txt:2: a is to have 2 x 2 numbers, but has 3"),
        (["double a(1,2)", "0 1", "double b(1,2)", "0 1"], "there are 2 tables in it, a, b"),
        (["double a(1,2)", "0 x"], r"a\.txt:3, column 2 \(2\): 'x' is no number"),
        (["0 1"], "there is no head of a table"),
    ],
)
def test_faulty_table_of_modelica_is_refused(tmp_path: Path, lines: list[str], refusal: str) -> None:
    with pytest.raises(ValueError, match=refusal):
        read_table(text(tmp_path / "a.txt", ["#1", *lines]))


@pytest.mark.parametrize(
    "head",
    [
        ["Time,Position,Force", "s,mm,N", "Elapsed time,Carriage left side,Load cell"],
        ["Test,7", "Time,Position,Force", "[s],[mm],[N]", "date,left,cell"],
    ],
)
def test_units_between_names_and_descriptions(tmp_path: Path, head: list[str]) -> None:
    lines = [f"{t},{1e3 * x:.3f},{force}" for t, x, force in ROWS]
    holds(text(tmp_path / "a.csv", [*head, *lines]), "time=Time,position=Position,frictionForce=Force")


def test_unknown_unit_below_a_name_is_refused_if_its_column_is_asked_for(tmp_path: Path) -> None:
    head = ["Time,Droop,Speed,Position", "[ms],[pulse],[r/min],[mm]"]
    file = text(tmp_path / "a.csv", [*head, *(f"{1e3 * t},3,4,{1e3 * x}" for t, x, _ in ROWS)])
    np.testing.assert_allclose(signals_of(file, "time=Time,position=Position")["position"], POSITION, rtol=1e-12)
    with pytest.raises(ValueError, match="pulse"):
        signals_of(file, "time=Time,position=Droop")


@pytest.mark.parametrize("head", [["x-axis,1,2", "second,Volt,Volt"], ["Source,CH1,CH2", "Second,Volt,Volt"]])
def test_oscilloscope_with_units_below_its_names(tmp_path: Path, head: list[str]) -> None:
    lines = [f"{t:.6e},{x:.6e},{force:.6e}" for t, x, force in ROWS]
    table = read_table(text(tmp_path / "a.csv", [*head, *lines]))
    assert table.header == head[0].split(",") and table.units == ["s", "V", "V"] and len(table.values) == len(TIME)
    np.testing.assert_allclose(table.values, np.array(ROWS), rtol=1e-12)


def test_oscilloscope_with_nothing_but_units_above_its_numbers(tmp_path: Path) -> None:
    head = ["Record Length,Analog:14000", "Sample Rate,1000.0", "Horizontal Scale, 0.00001", "Second,Volt"]
    table = read_table(text(tmp_path / "a.csv", [*head, *(f"{t},{x}" for t, x, _ in ROWS)]))
    assert table.header == ["Second", "Volt"] and table.units == ["s", "V"]
    np.testing.assert_array_equal(table.values[:, 1], POSITION)


def test_oscilloscope_with_a_preamble_beside_its_numbers(tmp_path: Path) -> None:
    told = ["Record Length,2.500000e+03", "Sample Interval,1.0e-03", "Trigger Point,1.25e+03", "Source,CH1",
            "Vertical Units,V", "Horizontal Units,s"]  # fmt: skip
    lines = [f"{told[k] if k < len(told) else ','},,{t:.6f},{x:.6f}," for k, (t, x, _) in enumerate(ROWS)]
    table = read_table(text(tmp_path / "F0000CH1.CSV", lines))
    assert table.names == ["time", "CH1"] and table.units == ["s", "V"]
    np.testing.assert_array_equal(table.values, np.array([TIME, POSITION]).T)


def test_columns_without_names_have_numbers(tmp_path: Path) -> None:
    file = text(tmp_path / "a.txt", [f"{t}\t{x}\t{force}" for t, x, force in ROWS])
    holds(file, "time=1,position=2,frictionForce=3")
    with pytest.raises(ValueError, match=r"no column `time`, only 1, 2, 3; columns says which"):
        signals_of(file, None)


def test_decimal_commas_behind_the_twentieth_row_and_in_quotes(tmp_path: Path) -> None:
    whole = [f"{k};{k};{k}" for k in range(30)]
    file = text(tmp_path / "a.csv", ["time;position;frictionForce", *whole, "30,5;31,25;32"])
    assert signals_of(file, None)["position"][-1] == 31.25
    quoted = [",".join(f'"{value}"'.replace(".", ",") for value in row) for row in ROWS]
    holds(text(tmp_path / "b.csv", ["time,position,frictionForce", *quoted]))


def test_compressed_text(tmp_path: Path) -> None:
    lines = ["time,position,frictionForce", *(f"{t},{x},{force}" for t, x, force in ROWS)]
    (tmp_path / "a.csv.gz").write_bytes(gzip.compress("\n".join(lines).encode()))
    holds(tmp_path / "a.csv.gz")


FRAME = pd.DataFrame(SIGNALS)


@pytest.mark.parametrize(
    "write",
    [
        lambda file: FRAME.to_parquet(file.with_suffix(".pq")) or file.with_suffix(".pq"),
        lambda file: FRAME.to_feather(file.with_suffix(".feather")) or file.with_suffix(".feather"),
        lambda file: FRAME.to_feather(file.with_suffix(".arrow")) or file.with_suffix(".arrow"),
        lambda file: np.savez(file.with_suffix(".npz"), **SIGNALS) or file.with_suffix(".npz"),
        lambda file: np.save(file.with_suffix(".npy"), FRAME.to_records(index=False)) or file.with_suffix(".npy"),
    ],
)  # fmt: skip
def test_files_of_python(tmp_path: Path, write: Callable[[Path], Path]) -> None:
    holds(write(tmp_path / "a"))


def test_tables_of_other_packages() -> None:
    import pyarrow
    import xarray

    holds(pyarrow.table(SIGNALS))
    holds(FRAME.to_records(index=False))
    holds(xarray.Dataset({name: ("time", SIGNALS[name]) for name in ("position", "frictionForce")}, {"time": TIME}))


def test_table_of_polars() -> None:
    import polars

    holds(polars.DataFrame(SIGNALS))


SIMULINK = {"time": TIME, "signals": {"values": np.array([POSITION, FORCE]).T, "label": "scope", "dimensions": 2.0}}
STRUCTURES: dict[str, tuple[dict[str, Any], str | None]] = {
    "vectors beside one of another length": ({**SIGNALS, "calibration": np.arange(4.0)}, None),
    "structure": ({"run": SIGNALS}, None),
    "two structures": (
        {"a": SIGNALS, "b": {"x": np.arange(3.0)}},
        "time=a.time,position=a.position,frictionForce=a.frictionForce",
    ),
    "structure with time": ({"out": SIMULINK}, "time=time,position=scope 1,frictionForce=scope 2"),
    "ControlDesk": (
        {
            "rec": {
                "X": {"Name": "time", "Data": TIME},
                "Y": [
                    {"Name": "x", "Unit": "m", "Data": POSITION, "XIndex": 1.0},
                    {"Name": "F", "Unit": "N", "Data": FORCE, "XIndex": 1.0},
                ],
            }
        },
        "time=time,position=x,frictionForce=F",
    ),
    "To File": ({"ans": np.array([TIME, POSITION, FORCE])}, "time=1,position=2,frictionForce=3"),
}


@pytest.mark.parametrize("kind", STRUCTURES)
def test_structures_of_matlab(tmp_path: Path, kind: str) -> None:
    variables, columns = STRUCTURES[kind]
    savemat(tmp_path / "a.mat", variables)
    holds(tmp_path / "a.mat", columns)


def test_vector_of_another_length_is_refused_if_it_is_asked_for(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {**SIGNALS, "calibration": np.arange(4.0)})
    with pytest.raises(ValueError, match=r"column 4 \(calibration\): it has 4 values, others have 50"):
        signals_of(tmp_path / "a.mat", "time=time,position=calibration[m],frictionForce=frictionForce")


def test_matlab_7_3(tmp_path: Path) -> None:
    import h5py

    with h5py.File(tmp_path / "a.mat", "w", userblock_size=512) as file:
        group = file.create_group("run")
        for name, values in SIGNALS.items():
            group.create_dataset(name, data=values[None, :])
        label = file.create_dataset("#refs#", data=np.zeros(1))
        assert label is not None
    holds(tmp_path / "a.mat")


def test_tdms(tmp_path: Path) -> None:
    import nptdms

    told = {"wf_increment": 1e-3, "wf_start_offset": 0.0}
    channels = [
        nptdms.ChannelObject("rig", "position", 1e3 * POSITION, {**told, "unit_string": "mm"}),
        nptdms.ChannelObject("rig", "frictionForce", FORCE, {**told, "unit_string": "N"}),
    ]
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        writer.write_segment(channels)
    holds(tmp_path / "a.tdms")


def test_channels_of_tdms_that_begin_at_other_times(tmp_path: Path) -> None:
    """A channel that begins 10 ms after the other is 10 ms later; a start that only some have is refused."""
    import nptdms

    begun = np.datetime64("2026-03-01T12:00:00.250", "us")

    def written(*starts: dict[str, Any]) -> Path:
        channels = [
            nptdms.ChannelObject(
                name, name, values, {"wf_increment": 1e-3, "wf_start_offset": 0.0, "unit_string": unit, **start}
            )
            for (name, unit, values), start in zip(
                (("position", "m", POSITION), ("frictionForce", "N", FORCE[10:])), starts, strict=True
            )
        ]
        with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
            writer.write_segment(channels)
        return tmp_path / "a.tdms"

    file = written({"wf_start_time": begun}, {"wf_start_time": begun + np.timedelta64(10, "ms")})
    # The groups of the file are in any order, and the clock of the first one counts.
    with pytest.warns(UserWarning, match="(position|frictionForce) was read at other times"):
        found = signals_of(file, None)
    late = found["time"] >= 0.0100001
    np.testing.assert_allclose(found["frictionForce"][late], FORCE[11:], rtol=1e-9)
    with pytest.raises(ValueError, match="1 of 2 channels with wf_increment have wf_start_time"):
        signals_of(written({"wf_start_time": begun}, {}), None)


def test_mdf_with_two_rates(tmp_path: Path) -> None:
    import asammdf

    with asammdf.MDF(version="4.10") as mdf:
        mdf.append([asammdf.Signal(1e3 * POSITION, TIME, "mm", "position")])
        mdf.append([asammdf.Signal(FORCE[::2], TIME[::2], "N", "frictionForce")])
        mdf.save(tmp_path / "a.mf4")
    with pytest.warns(UserWarning, match="frictionForce was read at other times"):
        found = signals_of(tmp_path / "a.mf4", None)
    inside = TIME[::2][-1] >= TIME
    np.testing.assert_allclose(found["position"], POSITION[inside], rtol=1e-12)
    np.testing.assert_allclose(found["frictionForce"], np.interp(TIME[inside], TIME[::2], FORCE[::2]), atol=1e-12)


@pytest.mark.parametrize(("ending", "package"), [("tdms", "npTDMS"), ("mf4", "asammdf")])
def test_missing_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str, package: str) -> None:
    monkeypatch.setitem(__import__("sys").modules, package.lower() if ending == "mf4" else "nptdms", None)
    (tmp_path / f"a.{ending}").write_bytes(b"")
    with pytest.raises(ImportError, match=rf"this needs {package}: pip install 'pneumatic-servo\[recorders\]'"):
        read_table(tmp_path / f"a.{ending}")


def test_long_record_is_thinned_to_a_millisecond_and_a_warning_says_so() -> None:
    time = 2e-5 * np.arange(210_000)
    data = {"time": time, "position": np.sin(time), "frictionForce": np.cos(time)}
    with pytest.warns(UserWarning, match=r"of 210000 samples, 0\.02 ms apart, one of 50 is used"):
        found = measured(1, data, None)
    assert {len(values) for values in found.signals.values()} == {4200}
    np.testing.assert_array_equal(found.signals["position"], data["position"][::50])
    assert found.where("position", 3) == "record 1, sample 150 of position"
    # What is not finer stays.
    data["time"] = 1e-3 * np.arange(210_000)
    assert len(measured(1, data, None).signals["time"]) == 210_000

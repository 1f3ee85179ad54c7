"""Tables as recorders, spreadsheets and pandas write them: the same record in each form gives the same signals."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pneumatic_servo as ps
import pytest
from pneumatic_servo.chosen_columns import columns_of
from pneumatic_servo.identification.signals import SIGNALS
from pneumatic_servo.identification.table import measured
from pneumatic_servo.tables import read_table

TIMES = (0.0, 0.001, 0.002)
WAYS = (1.5, 2.5, 3.25)
ROWS = "0,000;1,5\n0,001;2,5\n0,002;3,25\n"

FORMS: dict[str, tuple[str | bytes, str | Mapping[str, str]]] = {
    "exact names": ("Zeit [s];Weg [mm]\n" + ROWS, {"time": "Zeit [s]", "position": "Weg [mm]"}),
    "exact names in one text": ("Zeit [s];Weg [mm]\n" + ROWS, "time=Zeit [s],position=Weg [mm]"),
    "names without units": ("Zeit [s];Weg [mm]\n" + ROWS, {"time": "Zeit", "position": "Weg"}),
    "blanks before a unit": ("Zeit;Weg\n" + ROWS, {"time": "Zeit  [s]", "position": "Weg [mm]"}),
    "a unit after a slash": ("t / s;x/mm\n" + ROWS, {"time": "t / s", "position": "x"}),
    "a unit in words": ("Zeit in s;Weg in mm\n" + ROWS, {"time": "Zeit", "position": "Weg in mm"}),
    "a sign before an exact name": (
        "Zeit [s];Weg [mm]\n0;-1,5\n0,001;-2,5\n0,002;-3,25\n", {"time": "Zeit [s]", "position": "-Weg [mm]"}),
    "a separator at each end": (
        "Zeit [s];Weg [mm];\n0,000;1,5;\n0,001;2,5;\n0,002;3,25;\n", {"time": "Zeit", "position": "Weg"}),
    "a separator at the end of rows": (
        "Zeit [s];Weg [mm]\n0,000;1,5;\n0,001;2,5;\n0,002;3,25;\n", {"time": "Zeit", "position": "Weg"}),
    "a tab at each end": ("t\tx[mm]\t\n0\t1.5\t\n0.001\t2.5\t\n0.002\t3.25\t\n", {"time": "t", "position": "x"}),
    "a preamble": (
        "Prüfstand 3\nDatum;27.11.2026\nAbtastrate;1000\nPrüfer;Meier\n\nZeit [s];Weg [mm]\n" + ROWS,
        {"time": "Zeit [s]", "position": "Weg [mm]"}),
    "a preamble and units below the names": (
        "Messung\n3 Kanäle\nZeit;Weg\ns;mm\n" + ROWS, {"time": "Zeit", "position": "Weg"}),
    "names in a comment": ("# t,x[mm]\n0,1.5\n0.001,2.5\n0.002,3.25\n", {"time": "t", "position": "x"}),
    "Windows-1252": (("Prüfzeit [s];Höhe [mm]\n" + ROWS).encode("cp1252"), {"time": "Prüfzeit", "position": "Höhe"}),
    "micrometres of Windows-1252": (
        "t;Höhe [µm]\n0;1500\n0,001;2500\n0,002;3250\n".encode("cp1252"), {"time": "t", "position": "Höhe [µm]"}),
    "UTF-16": (("Zeit [s];Höhe [mm]\n" + ROWS).encode("utf-16"), {"time": "Zeit", "position": "Höhe"}),
    "a column of words": (
        "t,state,x [mm]\n0,on,1.5\n0.001,on,2.5\n0.002,off,3.25\n", {"time": "t", "position": "x"}),
    "a sensor that is not asked for": (
        "t,x [mm],F\n0,1.5,\n0.001,2.5,nan\n0.002,3.25,7\n", {"time": "t", "position": "x"}),
    "numbers of rows without a name": (
        ",t,x [mm]\n0,0,1.5\n1,0.001,2.5\n2,0.002,3.25\n", {"time": "t", "position": "x"}),
    "clock": ("t;x [mm]\n12:00:00.000;1,5\n12:00:00.001;2,5\n12:00:00.002;3,25\n", {"time": "t", "position": "x"}),
    "clock with a comma": (
        "Uhrzeit;x [mm]\n12:00:00,000;1,5\n12:00:00,001;2,5\n12:00:00,002;3,25\n",
        {"time": "Uhrzeit", "position": "x"}),
    "clock past midnight": (
        "t;x [mm]\n23:59:59.999;1,5\n00:00:00.000;2,5\n00:00:00.001;3,25\n", {"time": "t", "position": "x"}),
    "dates": (
        "t;x [mm]\n27.11.2026 23:59:59,999;1,5\n28.11.2026 00:00:00,000;2,5\n28.11.2026 00:00:00,001;3,25\n",
        {"time": "t", "position": "x"}),
    "dates of ISO 8601 in two zones": (
        "t,x [mm]\n2026-11-27T12:00:00.000Z,1.5\n2026-11-27T13:00:00.001+01:00,2.5\n2026-11-27T12:00:00.002Z,3.25\n",
        {"time": "t", "position": "x"}),
    "dates of America": (
        "t,x [mm]\n11/27/2026 11:59:59.999 AM,1.5\n11/27/2026 12:00:00.000 PM,2.5\n11/27/2026 12:00:00.001 PM,3.25\n",
        {"time": "t", "position": "x"}),
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_record_is_the_same_in_each_form(tmp_path: Path, form: str) -> None:
    content, columns = FORMS[form]
    file = tmp_path / "rig.csv"
    file.write_bytes(content.encode() if isinstance(content, str) else content)
    found = measured(1, file, columns_of(columns, SIGNALS)).signals
    assert found["time"].tolist() == list(TIMES)
    assert found["position"].tolist() == [float(f"{way}e-3") for way in WAYS]


def test_arrays_and_frames_have_exact_names_and_clocks_too() -> None:
    clock = ["12:00:00.000", "12:00:00.001", "12:00:00.002"]
    zoned = pandas.to_datetime(clock, format="%H:%M:%S.%f").tz_localize("Europe/Berlin")
    columns = columns_of({"time": "Zeit [s]", "position": "Weg [mm]"}, SIGNALS)
    for times in (list(TIMES), clock, zoned):
        data = {"Zeit [s]": times, "Weg [mm]": WAYS, "Zustand": ["on", "on", "off"]}
        for source in (data, pandas.DataFrame(data)):
            found = measured(1, source, columns).signals
            assert found["time"].tolist() == list(TIMES)
            assert np.allclose(found["position"], 1e-3 * np.array(WAYS), rtol=1e-15, atol=0.0)


def test_encoding_is_taken_as_given(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_bytes("t;Höhe\n0;1\n".encode("cp850"))
    assert read_table(file, "cp850").names == ["t", "Höhe"] != read_table(file).names
    with pytest.raises(ValueError, match=r"encoding='cp9': there is no such encoding"):
        read_table(file, "cp9")
    with pytest.raises(ValueError, match=r"a\.csv: byte 0x94 is no text in utf-8"):
        ps.fit(file, experiment="motion", law="Coulomb", encoding="utf-8", progress=False)
    file.write_bytes(b"t;x\n0;\x81\n")
    with pytest.raises(
        ValueError, match=r"a\.csv: byte 0x81 is no text in Windows-1252; encoding= says in which it is"
    ):
        read_table(file)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("time,valveVoltage\n0,low\n1,5\n", r"a\.csv:2, column 2 \(valveVoltage\): 'low' is no number"),
        ("time,valveVoltage\n0,5\n1,\n", r"a\.csv:3, column 2 \(valveVoltage\): '' is no number"),
        ("time,valveVoltage\n0,5\n1,inf\n", r"a\.csv:3, column 2 \(valveVoltage\): inf is not finite"),
        ("time;valveVoltage\n0;5\n1;6;7\n", r"a\.csv:3: 3 values, but the header has 2 columns"),
        ("0,5\n1,6\n", r"a\.csv:1: there is no column `time`, only 1, 2"),
        ("time,valveVoltage\n3/4/2026 0:00:00,5\n3/5/2026 0:00:00,5\n", r"may be of day and month or of month and day"),
        ("time,valveVoltage\n31.02.2026 0:00:00,5\n31.02.2026 0:00:01,5\n", r"the date '31\.02\.2026' is refused"),
    ],
)  # fmt: skip
def test_table_that_cannot_be_meant_is_refused_by_its_place(tmp_path: Path, content: str, words: str) -> None:
    (tmp_path / "a.csv").write_text(content, encoding="utf-8")
    with pytest.raises(ValueError, match=words):
        ps.Model().simulate(inputs=tmp_path / "a.csv", stop=1.0)


@pytest.mark.parametrize("values", [np.ma.masked_less([0.0, 1.0, 2.0], 1.0), [True, False, True], [1j, 2.0, 3.0]])
def test_signals_that_numpy_makes_numbers_of_are_refused(values: Any) -> None:
    with pytest.raises(
        ValueError, match=r"position is refused: it must be numbers; (value 0 is masked|the values are)"
    ):
        measured(1, {"time": TIMES, "position": values}, None)

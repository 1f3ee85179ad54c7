"""The command line of the Python package, run as a user runs it."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest

COMMAND = [sys.executable, "-c", "import sys; from pneumatic_servo.cli import main; sys.exit(main())"]
TABLE = "time,valveVoltage\n0,5\n0.2,6.5\n0.5,4\n"


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, *arguments], cwd=folder, capture_output=True, text=True, check=False)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "my.csv").write_text(TABLE, encoding="utf-8")
    return tmp_path


def test_simulation_writes_the_bits_of_the_package(folder: Path) -> None:
    done = run(
        folder, "simulate", "my.csv", "--law", "LuGre", "--set", "valve.C=5e-9", "--out", "a.csv", "--plot", "a.png"
    )
    assert done.returncode == 0, done.stderr
    assert (folder / "a.png").stat().st_size > 10_000
    with (folder / "a.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    expected = ps.Model().simulate(
        {"friction.law": "LuGre", "valve.C": 5e-9},
        inputs={"valveVoltage": ([0, 0.2, 0.5], [5, 6.5, 4])},
        stop=0.5,
        step=1e-3,
    )
    assert [float(row["position"]) for row in rows] == expected["position"].tolist()
    assert "position" in done.stdout and "501 rows" in done.stdout


@pytest.mark.parametrize(
    ("table", "options", "words"),
    [
        ("time,valveVoltage\n0,5\n0.5,6x\n", [], ["my.csv:3", "column 2", "valveVoltage", "6x"]),
        ("time,valveVoltage\n0,5\n0.5\n", [], ["my.csv:3", "1 values"]),
        ("time,voltage\n0,5\n", [], ["my.csv:1", "column 2", "voltage", "valveVoltage"]),
        ("t,valveVoltage\n0,5\n", [], ["my.csv:1", "time"]),
        ("time,valveVoltage\n0,5\n1,6\n0.5,6\n", [], ["my.csv:4", "column 1", "time", "0.5"]),
        ("time,supplyPressure\n0,5e5\n1,-1\n", [], ["my.csv:3", "column 2", "supplyPressure", "-1"]),
        ("time,valveVoltage\n0,nan\n", [], ["my.csv:2", "valveVoltage", "nan"]),
        ("time,valveVoltage\n", [], ["my.csv", "no rows"]),
        ("", [], ["my.csv: it is empty", "names of its columns"]),
        (TABLE, ["--set", "valve.c=1"], ["--set valve.c=1", "valve.C"]),
        (TABLE, ["--set", "valve.C=much"], ["valve.C", "much"]),
        (TABLE, ["--set", "valve.C"], ["valve.C", "NAME=VALUE"]),
        (TABLE, ["--law", "Lugre"], ["friction.law", "Lugre"]),
        (TABLE, ["--set", "friction.law=Dahl", "--law", "LuGre"], ["--law", "friction.law", "twice", "Dahl", "LuGre"]),
        (TABLE, ["--out", "missing/a.csv"], ["missing"]),
        (TABLE, ["--plot", "p.xyz"], ["--plot p.xyz", "'.xyz'", "png", "svg"]),
        (TABLE, ["--plot", "p"], ["--plot p", "ending", "png"]),
        (TABLE, ["--outputs", "positon"], ["positon"]),
        (TABLE, ["--step", "0"], ["--step 0"]),
    ],
)
def test_bad_input_is_named_and_leaves_nothing(folder: Path, table: str, options: list[str], words: list[str]) -> None:
    (folder / "my.csv").write_text(table, encoding="utf-8")
    done = run(folder, "simulate", "my.csv", "--out", "a.csv", *options)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ") and done.stderr.count("\n") == 1, done.stderr
    assert all(word in done.stderr for word in words), done.stderr
    assert sorted(file.name for file in folder.iterdir()) == ["my.csv"]


@pytest.mark.parametrize("command", ["simulate", "compare", "fit"])
@pytest.mark.parametrize("name", ["my.csv", "./my.csv", "link.csv"])
def test_table_that_is_read_is_not_overwritten(folder: Path, command: str, name: str) -> None:
    (folder / "link.csv").symlink_to("my.csv")
    own = {"simulate": [], "compare": ["--laws", "Coulomb,LuGre"],
           "fit": ["--experiment", "motion", "--law", "Coulomb", "--columns", "time=time"]}  # fmt: skip
    done = run(folder, command, "my.csv", *own[command], "--out", name)
    assert done.returncode == 2, done.stderr
    assert done.stderr == (
        f"error: {Path(name)}: it is read from, and would be overwritten; name another file to write\n"
    )
    assert (folder / "my.csv").read_text(encoding="utf-8") == TABLE


def test_file_to_write_is_named_once(folder: Path) -> None:
    done = run(folder, "simulate", "my.csv", "--out", "a.png", "--plot", "./a.png")
    assert done.returncode == 2 and done.stderr == "error: a.png: it is named twice among the files to write\n"
    assert sorted(file.name for file in folder.iterdir()) == ["my.csv"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["linearise", "--at", "velocity=0.05", "--set", "velocity=0.06"], ["--at", "velocity", "0.06", "0.05"]),
        (["linearise", "--at", "friction.law=Dahl", "--law", "LuGre"], ["--law", "friction.law", "Dahl", "LuGre"]),
        (["plan", "--law", "LuGre", "--set", "friction.law=Dahl"], ["--law LuGre", "twice", "Dahl"]),
        (["fit", "my.csv", "--experiment", "motion", "--law", "Coulomb,LuGre", "--columns", "time=time",
          "--set", "friction.law=LuGre"], ["--law Coulomb", "twice", "LuGre"]),
    ],
)  # fmt: skip
def test_what_is_given_twice_is_refused(folder: Path, options: list[str], words: list[str]) -> None:
    done = run(folder, *options)
    assert done.returncode == 2 and all(word in done.stderr for word in words), done.stderr


def test_law_may_be_given_twice_alike(folder: Path) -> None:
    done = run(folder, "simulate", "my.csv", "--set", "friction.law=LuGre", "--law", "LuGre", "--stop", "0.01")
    assert done.returncode == 0, done.stderr


def test_run_that_cannot_go_on_leaves_its_rows(folder: Path) -> None:
    scheme = ["--set", "solver.scheme=ExplicitEuler", "--set", "solver.step=1e-3"]
    done = run(folder, "simulate", "my.csv", "--law", "LuGre", *scheme, "--out", "a.csv")
    assert done.returncode == 1 and "diverges" in done.stderr
    with (folder / "a.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert 1 <= len(rows) < 501 and all(np.isfinite(float(row["position"])) for row in rows)


@pytest.mark.skipif(os.name == "nt", reason="interrupts are sent differently there")
def test_interrupt_leaves_the_rows_until_then(folder: Path) -> None:
    (folder / "my.csv").write_text("time,valveVoltage\n0,5\n100000,6\n", encoding="utf-8")
    process = subprocess.Popen(
        [*COMMAND, "simulate", "my.csv", "--step", "1e-4", "--outputs", "position",
         "--every", "10000", "--out", "a.csv"],
        cwd=folder, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    # Long enough for Python to start, and a fraction of what the 1e9 steps take, some minutes.
    time.sleep(4.0)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=20)
    assert process.returncode == 130 and told.endswith("error: interrupted\n")
    rows = (folder / "a.csv").read_text(encoding="utf-8").splitlines()
    assert 1 < len(rows) < 100_001 and rows[0] == "time,position"
    assert sorted(file.name for file in folder.iterdir()) == ["a.csv", "my.csv"]


def test_comparison_linearisation_and_variables(folder: Path) -> None:
    done = run(folder, "compare", "my.csv", "--laws", "Stribeck,GMS", "--out", "laws.csv")
    assert done.returncode == 0 and "GMS" in done.stdout
    assert (folder / "laws.csv").read_text(encoding="utf-8").startswith("law,travel (m)")
    done = run(folder, "linearise", "--at", "velocity=0.05,valve.hysteresis=0", "--out", "plant.npz")
    assert done.returncode == 0 and "chamberA.pressure" in done.stdout
    with np.load(folder / "plant.npz") as file:
        assert file["A"].shape == (8, 8) and file["states"][0] == "position"
    done = run(folder, "variables", "dead", "zone")
    assert done.returncode == 0 and "valve.deadZone = 0.08 (0 to 0.9)" in done.stdout


@pytest.mark.skipif(os.name == "nt", reason="pipes are closed differently there")
def test_reader_may_have_seen_enough(folder: Path) -> None:
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as unread:
        done = subprocess.run(
            [*COMMAND, "variables"], cwd=folder, stdout=unread, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (done.returncode, done.stderr) == (141, "")


def test_run_that_does_not_fit_into_memory_is_refused(folder: Path) -> None:
    done = run(folder, "simulate", "my.csv", "--stop", "3.6e6", "--step", "1e-6")
    assert done.returncode == 2 and done.stderr.startswith("error: ") and "every" in done.stderr, done.stderr


def test_help_teaches(folder: Path) -> None:
    done = run(folder, "--help")
    assert done.returncode == 0
    for word in ("simulate my.csv --law LuGre", "time,valveVoltage", "exit codes"):
        assert word in done.stdout


def test_table_of_another_encoding_is_read_or_named(folder: Path) -> None:
    (folder / "my.csv").write_bytes(TABLE.encode() + "0.6,5\n# 20 °C\n".encode("cp1252"))
    assert run(folder, "simulate", "my.csv", "--out", "a.csv").returncode == 0
    fit = ["fit", "my.csv", "--experiment", "motion", "--law", "Coulomb", "--encoding", "utf-8"]
    done = run(folder, *fit)
    assert done.returncode == 2 and done.stderr == "error: my.csv: byte 0xb0 is no text in utf-8\n"

"""Results go into regular files as a whole, and into anything else as a stream."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pneumatic_servo as ps
import pytest

HEAD = "time,position"

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="it has no such files")


def run() -> ps.Run:
    return ps.Model().simulate(inputs={"valveVoltage": 6.0}, stop=0.01, step=1e-3, outputs=["position"])


def test_pipe_gets_the_table_and_stays_a_pipe(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()), daemon=True)
    reader.start()
    run().to_csv(pipe)
    reader.join(10.0)
    assert stat.S_ISFIFO(pipe.lstat().st_mode)
    assert read[0].splitlines()[0] == HEAD
    assert len(read[0].splitlines()) == 12


def test_device_stays_a_device_and_its_refusal_is_named(tmp_path: Path) -> None:
    full = tmp_path / "full"
    try:
        # The device /dev/full, which a mistake here would replace.
        os.mknod(full, 0o666 | stat.S_IFCHR, os.makedev(1, 7))
        os.close(os.open(full, os.O_WRONLY))
    except PermissionError:
        pytest.skip("only root makes devices")
    with pytest.raises(OSError, match="full"):
        run().to_csv(full)
    assert stat.S_ISCHR(full.lstat().st_mode)


@pytest.mark.parametrize("is_there", [True, False])
def test_symbolic_link_is_followed(tmp_path: Path, is_there: bool) -> None:
    (tmp_path / "data").mkdir()
    target, link = tmp_path / "data" / "run.csv", tmp_path / "latest.csv"
    link.symlink_to(Path("data", "run.csv"))
    if is_there:
        target.write_text("old")
    run().to_csv(link)
    assert link.is_symlink()
    assert target.read_text().startswith(HEAD)
    assert [file.name for file in target.parent.iterdir()] == ["run.csv"]


def test_link_into_a_missing_folder_is_refused(tmp_path: Path) -> None:
    link = tmp_path / "latest.csv"
    link.symlink_to(tmp_path / "none" / "run.csv")
    with pytest.raises(FileNotFoundError, match=r"latest\.csv: there is no folder"):
        run().to_csv(link)


def test_file_that_is_replaced_keeps_who_may_read_it(tmp_path: Path) -> None:
    file = tmp_path / "secret.csv"
    file.write_text("old")
    file.chmod(0o600)
    run().to_csv(file)
    assert stat.S_IMODE(file.stat().st_mode) == 0o600


def test_standard_output_is_a_place_for_tables(tmp_path: Path) -> None:
    inputs = tmp_path / "in.csv"
    inputs.write_text("time,valveVoltage\n0,6\n0.01,6\n")
    command = [sys.executable, "-m", "pneumatic_servo", "simulate", inputs, "--outputs", "position"]
    told = tmp_path / "all.csv"
    with told.open("w") as stream:
        stream.write("before\n")
        stream.flush()
        subprocess.run([*command, "--out", "/dev/stdout"], stdout=stream, check=True)
    lines = told.read_text().splitlines()
    assert lines[:2] == ["before", HEAD]
    # The summary would spoil the table.
    assert len(lines) == 13


@pytest.mark.parametrize("ending", [".xlsx", ".parquet", ".pdf", ".JSON"])
def test_ending_of_another_format_is_refused(ending: str, tmp_path: Path) -> None:
    file = tmp_path / f"run{ending}"
    with pytest.raises(ValueError, match=rf"what is written is no {ending.lower()} file; name it run\.csv"):
        run().to_csv(file)
    with pytest.raises(ValueError, match=rf"what is written is no {ending.lower()} file; name it run\.ssv"):
        ps.DataSheet(bore=32, rod=12, stroke=200, mass=5, qn=700, supply=6).to_ssv(file)
    assert not file.exists()
    for ending in (".txt", ".tsv", "", ".2026"):
        run().to_csv(tmp_path / f"run{ending}")
        assert (tmp_path / f"run{ending}").read_text(encoding="utf-8").startswith("time,")

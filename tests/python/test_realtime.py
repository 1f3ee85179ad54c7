"""The host in C that runs the cylinder against the clock: compiled, and run briefly with the rights of the tests."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import fmpy
import pytest
from bounds import assert_close
from client import Client
from fmpy import extract

SOURCE = Path(__file__).parents[2] / "examples" / "host.c"
HEADERS = Path(fmpy.__file__).parent / "c-code"
STEPS = 500


pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the host is for Linux")


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    program = tmp_path_factory.mktemp("host") / "host"
    compiler = ["gcc", "-std=gnu11", "-O2", "-Wall", "-Wextra", "-Werror", "-I", HEADERS]
    subprocess.run([*compiler, "-o", program, SOURCE, "-ldl"], check=True)
    return program


@pytest.mark.parametrize("seconds", ["-1", "0", "abc", "1s", "", "nan", "inf", "1e30"])
def test_host_refuses_what_is_no_duration(program: Path, seconds: str) -> None:
    done = subprocess.run([program, "plant", seconds], capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"host: SECONDS is {seconds}; it must be a number from 0.001 to 1e9\n"), done.stderr


@pytest.mark.parametrize("arguments", [[], ["plant", "1", "2"]])
def test_host_tells_how_it_is_used(program: Path, arguments: list[str]) -> None:
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 2 and done.stderr.endswith("\nusage: host FOLDER [SECONDS]\n"), done.stderr


def test_host_runs_at_a_kilohertz_and_moves_the_carriage_as_fmpy_does(program: Path, fmu: Path, tmp_path: Path) -> None:
    folder = extract(str(fmu), tmp_path / "plant")
    done = subprocess.run([program, folder, str(1e-3 * STEPS)], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    text = done.stdout
    # Whether this is allowed depends on the machine; that it is said does not.
    assert re.search(r"^scheduler: (SCHED_FIFO|Operation not permitted)", text, re.MULTILINE), text
    assert re.search(r"^memory: (locked|Operation not permitted|Cannot allocate memory)", text, re.MULTILINE), text
    late, busy = text.split("late:")[1].split("busy:")
    for histogram in (late, busy):
        assert sum(int(count) for count in re.findall(r"us: (\d+)$", histogram, re.MULTILINE)) == STEPS, text

    with Client(fmu) as plant:
        plant.start()
        [position] = plant.get(["position"])
        for step in range(STEPS):
            plant.set({"valveVoltage": 5.0 + 40.0 * (0.3 - position)})
            plant.slave.doStep(1e-3 * step, 1e-3)
            [position] = plant.get(["position"])
    [found] = re.findall(r"^position: (.*)$", text, re.MULTILINE)
    # Equal up to the rounding of the voltage, which some processors compute in one operation.
    assert_close(float(found), position, rel=1e-9, what="position", why="some processors round the voltage once")
    assert abs(position - 0.25) > 1e-3, "the carriage has not moved"

"""The wheel in a fresh environment, without Rust and without this repository."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

PROGRAM = """
import shutil
import pneumatic_servo as ps
assert shutil.which("cargo") is None
run = ps.Model("PneumaticServoCylinder").simulate({"friction.law": "LuGre"}, inputs={"valveVoltage": 6.0}, stop=0.5)
assert run["position"][-1] > 0.25
print(ps.__file__)
"""


@pytest.fixture(scope="module")
def wheel(fmus: Path) -> Path:
    wheels = list((fmus.parent / "wheels").glob("*.whl"))
    assert len(wheels) == 1, "run `cargo xtask wheel` first"
    return wheels[0]


def test_wheel_is_for_every_python_and_every_linux(wheel: Path, fmus: Path) -> None:
    assert "-cp310-abi3-" in wheel.name
    if sys.platform == "linux":
        assert "manylinux_2_17" in wheel.name
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        assert "pneumatic_servo/py.typed" in names and "pneumatic_servo/_native.pyi" in names
        assert "pneumatic_servo/playground_files/index.html" in names
        files = [*fmus.glob("*.fmu"), *fmus.glob("*.ssp")]
        packed = {file: archive.read(f"pneumatic_servo/fmu_files/{file.name}") for file in files}
    # A comparison of megabytes within an assertion would look for their differences for hours.
    assert packed and not [file.name for file, content in packed.items() if content != file.read_bytes()]


def test_wheel_runs_in_a_fresh_environment_without_rust(wheel: Path, tmp_path: Path) -> None:
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "venv"], check=True)
    programs = tmp_path / "venv" / ("Scripts" if os.name == "nt" else "bin")
    install = [programs / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", wheel]
    subprocess.run(install, check=True)
    environment = {"PATH": str(programs), "MPLCONFIGDIR": str(tmp_path)}
    if "SYSTEMROOT" in os.environ:
        environment["SYSTEMROOT"] = os.environ["SYSTEMROOT"]

    def run(*command: str | Path) -> str:
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert str(tmp_path) in run(programs / "python", "-c", PROGRAM)
    (tmp_path / "out").mkdir()
    run(programs / "pneumatic-servo", "fmu", "--out", "out")
    assert (tmp_path / "out" / "PneumaticServoCylinder.fmu").is_file()
    page = Path(run(programs / "pneumatic-servo", "play", "--show-file").strip())
    assert "playground" in page.read_text(encoding="utf-8")

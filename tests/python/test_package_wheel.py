"""The wheel in a fresh environment, without Rust and without this repository."""

from __future__ import annotations

import math
import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Iterable, Mapping
from importlib.metadata import distribution
from pathlib import Path

import pytest
import tomllib
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PROGRAM = """
import shutil
import pneumatic_servo as ps
assert shutil.which("cargo") is None
run = ps.Model("PneumaticServoCylinder").simulate({"friction.law": "LuGre"}, inputs={"valveVoltage": 6.0}, stop=0.5)
assert run["position"][-1] > 0.25
print(ps.__file__)
"""


README = (Path(__file__).parents[2] / "python" / "README.md").read_text(encoding="utf-8")


def brought(requirements: Iterable[str], known: Mapping[str, float]) -> dict[str, float]:
    """Packages that requirements add, with the MB of each as it is installed here."""
    found = dict(known)
    for text in requirements:
        requirement = Requirement(text)
        name = canonicalize_name(requirement.name)
        if name in found or (requirement.marker and not requirement.marker.evaluate({"extra": ""})):
            continue
        package = distribution(name)
        files = [Path(str(file.locate())) for file in package.files or []]
        found[name] = 1e-6 * sum(file.stat().st_size for file in files if file.exists() and file.suffix != ".pyc")
        found |= brought(package.requires or [], found)
    return {name: size for name, size in found.items() if name not in known}


def test_page_says_what_each_extra_brings() -> None:
    """Without compiled modules it is less by some tenths; JAX and PyTorch are not in each environment of tests."""
    with (Path(__file__).parents[2] / "python" / "pyproject.toml").open("rb") as stream:
        project = tomllib.load(stream)["project"]
    extras = project["optional-dependencies"]
    rows = dict(re.findall(r"^\| `(\w+)` \|[^|]*\| (\d+) \|", README, re.MULTILINE))
    assert {*rows, "torch", "all"} == {*extras}
    base = brought(project["dependencies"], {})
    for extra in set(rows) - {"jax"}:
        size = sum(brought(extras[extra], base).values())
        assert 0.4 < size / float(rows[extra]) < 1.2, f"{extra}: {size:.0f} MB"
    every = re.search(r"servo\[all\]' +# (\d+) MB more", README)
    assert every is not None and 0.5 < sum(brought(extras["all"], base).values()) / float(every[1]) < 1.2
    # PyArrow, the largest of all but JAX and PyTorch, is for Parquet alone.
    assert [extra for extra in set(rows) - {"jax"} if "pyarrow" in brought(extras[extra], base)] == ["parquet"]
    assert "pyarrow" not in brought(extras["all"], base)


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


@pytest.mark.skipif(sys.platform != "linux", reason="reads an ELF file")
def test_wheel_takes_no_function_from_the_mathematics_of_the_system(wheel: Path, tmp_path: Path) -> None:
    """Their last bits differ from one system to the next; nalgebra's singular values take `hypot`."""
    with zipfile.ZipFile(wheel) as archive:
        extension = archive.extract("pneumatic_servo/_native.abi3.so", tmp_path)
    listed = subprocess.run(
        ["nm", "--dynamic", "--undefined-only", extension], check=True, capture_output=True, text=True
    )
    taken = {line.split()[-1].partition("@")[0] for line in listed.stdout.splitlines()}
    assert "malloc" in taken and not taken & {name + kind for name in dir(math) for kind in ("", "f")}


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
    [packages] = [file.parent for file in (tmp_path / "venv").rglob("pneumatic_servo")]
    assert not (packages / "pandas").exists() and not (packages / "scipy").exists()
    size = 1e-6 * sum(file.stat().st_size for file in packages.rglob("*") if file.is_file())
    installer = 1e-6 * sum(
        file.stat().st_size
        for tool in ("pip", "setuptools")
        for file in packages.rglob(f"{tool}/**/*")
        if file.is_file()
    )
    stated = re.search(r"pip install pneumatic-servo +# (\d+) MB", README)
    assert stated is not None and 0.7 < (size - installer) / float(stated[1]) < 1.2
    (tmp_path / "out").mkdir()
    run(programs / "pneumatic-servo", "fmu", "--out", "out")
    assert (tmp_path / "out" / "PneumaticServoCylinder.fmu").is_file()
    page = Path(run(programs / "pneumatic-servo", "play", "--show-file").strip())
    assert "playground" in page.read_text(encoding="utf-8")

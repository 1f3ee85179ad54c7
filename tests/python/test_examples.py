"""The examples, run as a user runs them: each checks its own result and fails otherwise."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
RUST = sorted((ROOT / "examples").glob("*.rs"))


NEEDS = {"stable_baselines": "stable_baselines3"}
"""Packages that are too large for the lists of the tests: these examples run where they are."""

SHORTER = {"minimum_time": ["--runs", "2000"], "policy_search": ["--generations", "3"]}
"""Searches that have found enough before they end by themselves."""


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda file: file.stem)
def test_example_runs(example: Path, tmp_path: Path) -> None:
    needed = NEEDS.get(example.stem)
    if needed is not None and find_spec(needed) is None:
        pytest.skip(f"it needs {needed}, which brings PyTorch")
    command = [sys.executable, example, *SHORTER.get(example.stem, [])]
    done = subprocess.run(command, text=True, capture_output=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda file: file.stem)
def test_example_tells_how_it_is_used(example: Path) -> None:
    done = subprocess.run([sys.executable, example, "--help"], text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"usage: {example.name}")


def test_example_says_how_to_get_what_it_needs(tmp_path: Path) -> None:
    without = (
        "import runpy, sys; sys.modules['stable_baselines3'] = None; "
        "runpy.run_path(sys.argv.pop(1), run_name='__main__')"
    )
    command = [sys.executable, "-c", without, ROOT / "examples" / "stable_baselines.py"]
    done = subprocess.run(command, text=True, capture_output=True, check=False, cwd=tmp_path)
    assert done.returncode == 1 and "pip install stable-baselines3" in done.stderr, done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("example", RUST, ids=lambda file: file.stem)
def test_rust_example_runs(example: Path) -> None:
    """Of the crate alone, without an FMU."""
    command = ["cargo", "run", "--quiet", "--package", "pneumatic-servo", "--example", example.stem]
    done = subprocess.run(command, text=True, capture_output=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()

"""The examples, run as a user runs them: each checks its own result and fails otherwise."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
RUST = sorted((ROOT / "examples").glob("*.rs"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda file: file.stem)
def test_example_runs(example: Path, tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, example], text=True, capture_output=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda file: file.stem)
def test_example_tells_how_it_is_used(example: Path) -> None:
    done = subprocess.run([sys.executable, example, "--help"], text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"usage: {example.name}")


@pytest.mark.parametrize("example", RUST, ids=lambda file: file.stem)
def test_rust_example_runs(example: Path) -> None:
    """Of the crate alone, without an FMU."""
    command = ["cargo", "run", "--quiet", "--package", "pneumatic-servo", "--example", example.stem]
    done = subprocess.run(command, text=True, capture_output=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()

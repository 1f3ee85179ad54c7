"""The examples, run as a user runs them: each checks its own result, and pages say what it prints."""

import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
RUST = sorted((ROOT / "examples").glob("*.rs"))


NEEDS = {"stable_baselines": "stable_baselines3"}
"""Packages that are too large for the lists of the tests: these examples run where they are."""

SHORTER = {"minimum_time": ["--runs", "2000"], "policy_search": ["--generations", "3"]}
"""Searches that have found enough before they end by themselves."""


QUANTITY = re.compile(
    r"(?<![\w.])(\d[\d,]*(?:\.\d+)?) (?:(µm|mm/s|mm|ms|Hz)(?!\w)|(?:gradients|runs|rounds|voltages|transitions))"
    r"|cost (?:of|is) (\d+(?:\.\d+)?)"
)
UNITS = {"µm": 1e-3, "mm/s": 1e-3, "mm": 1e-3, "ms": 1e-3}
"""To what an example is given in SI units, or prints in mm."""
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e-?\d+)?")
OTHER = {
    # The task in other numbers than the program has: between two places.
    "gain_tuning": ["50 mm"],
    # The end of a search of five times the runs.
    "minimum_time": ["110.83 ms"],
}  # fmt: skip
"""Quantities beside the figures of examples that their short runs neither print nor are given."""


def unfounded(example: Path, printed: str) -> list[str]:
    """Quantities in the section of a page about an example that it neither prints, to the digit, nor is given."""
    source = example.read_text(encoding="utf-8")
    known = [abs(float(number)) for number in NUMBER.findall(printed) + NUMBER.findall(source)]
    found = []
    for page in (ROOT / "docs").rglob("*.md"):
        text = page.read_text(encoding="utf-8")
        for part in re.split(r"(?m)^## ", text):
            if f"/examples/{example.name})" not in part or "![" not in part:
                continue
            for match in QUANTITY.finditer(part):
                number = match[1] or match[3]
                value, digits = float(number.replace(",", "")), len(number.partition(".")[2])
                scales = {1.0, UNITS.get(match[2] or "", 1.0)}
                places = [digits + round(-np.log10(scale)) for scale in scales]
                meant = [round(scale * value, place) for scale, place in zip(scales, places, strict=True)]
                if not any(round(one, place) == own for one in known for own, place in zip(meant, places, strict=True)):
                    found.append(match[0])
    return found


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda file: file.stem)
def test_example_runs(example: Path, tmp_path: Path) -> None:
    needed = NEEDS.get(example.stem)
    if needed is not None and find_spec(needed) is None:
        pytest.skip(f"it needs {needed}, which brings PyTorch")
    command = [sys.executable, example, *SHORTER.get(example.stem, [])]
    done = subprocess.run(command, text=True, capture_output=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
    assert set(unfounded(example, done.stdout)) == set(OTHER.get(example.stem, []))


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

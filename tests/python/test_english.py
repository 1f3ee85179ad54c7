"""The texts for people have no sentence that a reader would stumble over, by the few rules of `site/english.py`."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_texts_are_plain() -> None:
    command = [sys.executable, ROOT / "site" / "english.py"]
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stdout
    assert int(done.stdout.split(" sentences")[0].split()[-1]) > 1500

"""The texts for people have no sentence that a reader would stumble over, by the few rules of `site/english.py`."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def check(*files: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, ROOT / "site" / "english.py", *files]
    return subprocess.run(command, text=True, capture_output=True, check=False)


def test_texts_are_plain() -> None:
    done = check()
    assert done.returncode == 0, done.stdout
    assert int(done.stdout.split(" sentences")[0].split()[-1]) > 1500


LONG = " ".join(f"word{'s' * (number % 3)}" for number in range(41))


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("a.md", f"# Title\n\nShort. {LONG}.\n", "a.md:3: a sentence of 41 words"),
        ("a.md", "- One.\n- The the valve.\n", "a.md:2: The comes twice"),
        ("a.md", "It opens in\norder to close.\n", "'in order to' can be 'to'"),
        ("a.html", f"<p>Short.</p>\n<ul><li>{LONG}</li></ul>", "a.html:2: a sentence of 41 words"),
        ("a.ipynb", '{"cells": [{"cell_type": "markdown", "source": ["We utilise it."]}]}', "a.ipynb:1: 'utilise'"),
    ],
)
def test_what_is_hard_to_read_is_named(tmp_path: Path, name: str, text: str, told: str) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    done = check(tmp_path / name)
    assert done.returncode == 1 and told in done.stdout, done.stdout


@pytest.mark.parametrize(
    "text",
    [
        f"```\n{LONG}\n```\n\nShort.\n",
        f"| {LONG} |\n|---|\n\nShort.\n",
        f"See [{'a link'}](a.md) and `{LONG}`.\n",
        f"{LONG[:120]}.\n{LONG[:120]}.\n",
    ],
)
def test_code_and_tables_are_no_sentences(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.md").write_text(text, encoding="utf-8")
    done = check(tmp_path / "a.md")
    assert done.returncode == 0, done.stdout

"""The packages that the crates depend on have licences and sources that `deny.toml` allows, as cargo-deny reads it.

cargo-deny is no part of Rust and takes minutes to compile: this looks at the same table where it is not at hand.
"""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest
import tomllib

ROOT = Path(__file__).parents[2]
ALLOWED: set[str] = set(tomllib.loads((ROOT / "deny.toml").read_text(encoding="utf-8"))["licenses"]["allow"])


def is_allowed(licence: str) -> bool:
    """Tell whether an SPDX expression can be met with what is allowed; a slash is an old form of OR."""
    text = licence.strip().replace("/", " OR ")
    for operator, met in ((" OR ", any), (" AND ", all)):
        parts, depth, last = [], 0, 0
        for place, letter in enumerate(text):
            depth += {"(": 1, ")": -1}.get(letter, 0)
            if depth == 0 and text.startswith(operator, place):
                parts.append(text[last:place])
                last = place + len(operator)
        if parts:
            return met(is_allowed(part) for part in [*parts, text[last:]])
    inner = re.fullmatch(r"\((.*)\)", text)
    return is_allowed(inner[1]) if inner else " ".join(text.split()) in ALLOWED


@pytest.mark.parametrize(
    ("licence", "expected"),
    [
        ("MIT", True),
        ("MIT/Apache-2.0", True),
        ("GPL-3.0-only", False),
        ("GPL-3.0-only OR (MIT AND Zlib)", True),
        ("(MIT OR Apache-2.0) AND GPL-3.0-only", False),
        ("MIT OR Apache-2.0 AND GPL-3.0-only", True),
        ("(MIT OR GPL-3.0-only) AND (Apache-2.0 WITH LLVM-exception OR GPL-3.0-only)", True),
        ("", False),
    ],
)
def test_expressions_are_read(licence: str, expected: bool) -> None:
    assert is_allowed(licence) is expected


def test_every_package_is_allowed() -> None:
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--all-features"]
    done = subprocess.run(command, cwd=ROOT, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    packages = json.loads(done.stdout)["packages"]
    assert len(packages) > 200
    refused = {package["name"]: package["license"] for package in packages if not is_allowed(package["license"] or "")}
    assert refused == {}
    # Packages of the project have none; every other comes from the registry.
    sources = {package["source"] for package in packages if package["source"] is not None}
    assert {source.split("+")[0] for source in sources} <= {"registry", "sparse"} and len(sources) == 1

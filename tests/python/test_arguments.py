"""The table of all public arguments has every argument, and names tests that exist."""

from __future__ import annotations

import re
from pathlib import Path

import tomllib
from public import arguments, options

HERE = Path(__file__).parent
TABLE: dict[str, dict[str, str]] = tomllib.loads((HERE / "arguments.toml").read_text(encoding="utf-8"))
ENTRIES = {key: test for section in TABLE.values() for key, test in section.items()}


def test_every_argument_has_a_test_and_no_line_is_left_over() -> None:
    assert sum(len(section) for section in TABLE.values()) == len(ENTRIES), "a line is there twice"
    public = [argument.key for argument in arguments()] + [key for key, *_ in options()]
    assert len(public) == len(set(public)) > 150
    assert ENTRIES.keys() - set(public) == set()
    assert set(public) - ENTRIES.keys() == set(), "name a test that fails when it is ignored, in arguments.toml"


def test_tests_that_are_named_exist() -> None:
    for key, test in ENTRIES.items():
        if test.startswith("none: "):
            continue
        file, name = test.split("::")
        assert re.search(rf"^def {name}\(", (HERE / file).read_text(encoding="utf-8"), re.MULTILINE), (key, test)

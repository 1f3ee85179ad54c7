"""Whoever reads a figure in README or docs can find out what holds it: `figures.toml` lists it for every section."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import tomllib

ROOT = Path(__file__).parents[2]
TABLE: dict[str, dict[str, list[str]]] = tomllib.loads((Path(__file__).parent / "figures.toml").read_text("utf-8"))
UNITS = "nm µm mm pm µs ms ns s % kPa Pa bar mN N J kg g m/s mm/s K times steps instructions MB kB MiB minutes lines"
FIGURE = re.compile(rf"\d[\d,.]*(?:e-?\d+)?\s?(?:{'|'.join(map(re.escape, UNITS.split()))})\b")


def sections(page: Path) -> Iterator[tuple[str, str]]:
    """Yield the headings of a page with the text below them, without programs and generated tables."""
    text = page.read_text(encoding="utf-8")
    text = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    text = re.sub(r"<!-- [^>]*written by .*?<!-- end -->", "", text, flags=re.DOTALL)
    parts = re.split(r"^#+ (.*)$", text, flags=re.MULTILINE)
    return zip(parts[1::2], parts[2::2], strict=True)


def with_figures() -> set[tuple[str, str]]:
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return {
        (page.relative_to(ROOT).as_posix(), heading)
        for page in pages
        for heading, text in sections(page)
        if FIGURE.search(text)
    }


def test_every_section_with_figures_says_what_holds_them() -> None:
    listed = {(page, heading) for page, headings in TABLE.items() for heading in headings}
    found = with_figures()
    assert listed - found == set(), "listed, but without figures or gone"
    assert found - listed == set(), "a section with figures that nobody holds"


def test_what_holds_figures_is_there() -> None:
    commands = (ROOT / "packaging" / "src" / "lib.rs").read_text(encoding="utf-8")
    for page, headings in TABLE.items():
        for heading, holders in headings.items():
            assert holders, (page, heading)
            for holder in holders:
                kind, _, what = holder.partition(" ")
                where = f"{page}, {heading}: {holder}"
                if kind == "test":
                    file, _, name = what.partition("::")
                    assert (ROOT / file).exists(), where
                    text = (ROOT / file).read_text(encoding="utf-8") if name else ""
                    assert not name or re.search(rf"\b(fn|def) {name}\(", text), where
                elif kind == "run" and what.startswith("cargo xtask "):
                    assert f"    {what.split()[2].capitalize()}(" in commands, where
                elif kind == "run":
                    assert what.startswith(("cargo bench ", "cargo run ")) or (ROOT / what).is_file(), where
                else:
                    assert kind in ("given", "once") and what, where


def test_readme_counts_the_trajectories() -> None:
    cases = ("cases.json", "sensors.json")
    count = sum(len(json.loads((ROOT / "tests" / "reference" / name).read_text(encoding="utf-8"))) for name in cases)
    assert f"At the default tolerance {count} trajectories" in (ROOT / "README.md").read_text(encoding="utf-8")

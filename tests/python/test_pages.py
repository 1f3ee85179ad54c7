"""The programs and commands in the README, in docs and beside the tools run as they are printed."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

NOT_HERE = {
    "README.md": "its commands are those that build, and run these tests",
    "RELEASING.md": "its commands publish",
    "docs/start/python.md": "its command installs, and the environment of the tests has the package",
    "docs/start/data.md": "the same",
    "docs/start/rust.md": "its command changes a crate, and its program is the README's",
    "python/README.md": "its command installs, and the environment of the tests has the package",
    "docs/platforms.md": "its commands build and install",
    "docs/target.md": "its commands build, and compile for minutes: cargo xtask test --sources",
    "docs/realtime.md": "its host is compiled and run by test_realtime.py",
    "docs/tools/rust.md": "its program takes minutes to compile, and is run by hand",
    "docs/own.md": "its commands begin crates, as the tests of xtask do",
    "docs/own-packing.md": "its command packs a model of your own, whose FMU test_own.py looks at",
    "docs/observer.md": "its command packs the observer, whose FMU test_observer_fmu.py looks at",
    "docs/models.md": "its commands are the studies, which test_system_studies.py runs",
}
"""Pages whose shell commands are not run by these tests, and why; their programs are."""

KNOWN = {"python", "sh", "rust", "text"}
"""Languages of blocks: Rust is run by rustdoc, text is not to be run."""


def pages() -> Iterator[str]:
    """Every page that people read, as a path in the repository."""
    for file in [*sorted(ROOT.glob("*.md")), ROOT / "python" / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        yield file.relative_to(ROOT).as_posix()


def blocks(page: str, language: str) -> list[str]:
    """The fenced blocks of a language."""
    return re.findall(rf"```{language}\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL)


@pytest.fixture
def folder(fmu: Path, tmp_path: Path) -> Path:
    """A folder where FMUs and examples are to be found by the names that pages use."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    (tmp_path / "rig.csv").symlink_to(ROOT / "examples" / "rig.csv")
    for place in (tmp_path, tmp_path / "target" / "fmu"):
        place.mkdir(parents=True, exist_ok=True)
        for name in ("PneumaticServoCylinder.fmu", "PneumaticServoDrive.ssp"):
            (place / name).symlink_to(fmu.with_name(name).resolve())
    (tmp_path / "target" / "fmu" / "fmi3").symlink_to(fmu.with_name("fmi3").resolve())
    packed_apart = fmu.parent.with_name("own") / "fmu" / "FrictionObserver.fmu"
    (tmp_path / "target" / "fmu" / packed_apart.name).symlink_to(packed_apart.resolve())
    with zipfile.ZipFile(tmp_path / "PneumaticServoDrive.ssp") as archive:
        archive.extractall(tmp_path / "drive")
    (tmp_path / "drive" / "Components.ssd").replace(tmp_path / "drive" / "SystemStructure.ssd")
    return tmp_path


def programs() -> Iterator[tuple[str, int]]:
    """Each program by its page and its number there."""
    for page in pages():
        for number in range(len(blocks(page, "python"))):
            yield page, number


@pytest.mark.parametrize(("page", "number"), list(programs()))
def test_program_runs_alone(page: str, number: int, folder: Path) -> None:
    """As people copy it, by itself; and without warnings that nobody explains."""
    command = [sys.executable, "-c", blocks(page, "python")[number]]
    answer = subprocess.run(command, cwd=folder, env=os.environ | {"MPLBACKEND": "Agg"}, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr
    # FMPy names the inputs that a table leaves at their start values.
    assert not re.search(
        r"^(.*Warning: (?!missing input for variable).*)$", answer.stdout + answer.stderr, re.MULTILINE
    ), answer.stdout


@pytest.mark.parametrize("page", [page for page in pages() if blocks(page, "sh") and page not in NOT_HERE])
def test_commands_run(page: str, folder: Path) -> None:
    """With the tools of the environment that runs the tests; the first that fails ends it."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    command = ["sh", "-e", "-c", "\n".join(blocks(page, "sh"))]
    answer = subprocess.run(command, cwd=folder, env=os.environ | {"PATH": path}, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.strip() or answer.stderr.strip()


def test_every_block_says_what_it_is() -> None:
    """A block without a known language would escape the tests."""
    for page in pages():
        fences = re.findall(r"^```(.*)$", (ROOT / page).read_text(encoding="utf-8"), re.MULTILINE)
        assert len(fences) % 2 == 0, page
        assert set(fences[::2]) <= KNOWN, (page, fences[::2])
        assert set(fences[1::2]) <= {""}, page


def test_rust_stands_only_where_rustdoc_runs_it() -> None:
    own = [f"docs/{page}.md" for page in ("own-model", "own-packing", "own")]
    assert [page for page in pages() if blocks(page, "rust")] == ["README.md", *own]


def test_links_lead_somewhere() -> None:
    """Relative links, and anchors within the repository's pages."""
    for page in pages():
        text = (ROOT / page).read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^)\s]+)\)", text):
            if "://" in target:
                continue
            name, _, anchor = target.partition("#")
            file = (ROOT / page).parent / name if name else ROOT / page
            assert file.exists(), f"{page}: {target}"
            if anchor:
                headings = re.findall(r"^#+ (.*)$", file.read_text(encoding="utf-8"), re.MULTILINE)
                anchors = {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
                assert anchor in anchors, f"{page}: {target}"

"""The Python programs in the README and in the pages on tools run as they are printed."""

from __future__ import annotations

import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = ["README.md", "docs/tools/fmpy.md", "docs/tools/libcosim.md"]


@pytest.mark.parametrize("page", PAGES)
def test_programs_run(page: str, fmu: Path, tmp_path: Path) -> None:
    """One after the other, where the FMUs are to be found by the names that the page uses."""
    programs = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL)
    assert programs
    for folder in (tmp_path, tmp_path / "target" / "fmu"):
        folder.mkdir(parents=True, exist_ok=True)
        for name in ("PneumaticServoCylinder.fmu", "PneumaticServoDrive.ssp"):
            (folder / name).symlink_to(fmu.with_name(name).resolve())
    with zipfile.ZipFile(tmp_path / "PneumaticServoDrive.ssp") as archive:
        archive.extractall(tmp_path / "drive")
    (tmp_path / "drive" / "Components.ssd").replace(tmp_path / "drive" / "SystemStructure.ssd")
    command = [sys.executable, "-c", "\n".join(programs)]
    answer = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr

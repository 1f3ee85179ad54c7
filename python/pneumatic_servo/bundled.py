"""The FMUs that come with the package."""

from __future__ import annotations

import shutil
from pathlib import Path

from pneumatic_servo.files import whole

FOLDER = Path(__file__).parent / "fmu_files"


def fmus(out: str | Path | None = None) -> list[Path]:
    """Return the FMUs, and the drive as SSP, that come with the package.

    Parameters
    ----------
    out : path, optional
        A folder to copy them to; files of the same names are replaced.

    Returns
    -------
    list of pathlib.Path
        The copies, or the files inside the package.

    Raises
    ------
    FileNotFoundError
        When the package was built without FMUs, or there is no such folder.
    """
    files = sorted([*FOLDER.glob("*.fmu"), *FOLDER.glob("*.ssp")])
    if not files:
        raise FileNotFoundError("this package was built without FMUs; `cargo xtask wheel` puts them in")
    if out is None:
        return files
    folder = Path(out)
    if not folder.is_dir():
        raise FileNotFoundError(f"{folder} is not a folder")
    return [_copy(file, folder / file.name) for file in files]


def _copy(source: Path, target: Path) -> Path:
    with whole(target) as part:
        shutil.copyfile(source, part)
    return target

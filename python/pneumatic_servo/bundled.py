"""The FMUs that come with the package."""

from __future__ import annotations

import json
import shutil
import zipfile
from pathlib import Path

from pneumatic_servo.files import whole
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.variables import Value

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

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> [file.name for file in ps.fmus() if file.suffix == ".ssp"]
    ['PneumaticServoDrive.ssp']
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


def parameter_sets(model: str = "PneumaticServoCylinder") -> dict[str, dict[str, Value]]:
    """Return the sets of parameters that the FMU of a model carries, by name: identified on rigs, or examples.

    Parameters
    ----------
    model : str
        The model.

    Returns
    -------
    dict of dict
        Values by name, in SI units, as every run takes them.

    Raises
    ------
    FileNotFoundError
        When the package was built without FMUs, or has none of this model.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> ps.parameter_sets()["SlidingValvePolito"]["friction.law"]
    'Polito'
    """
    file = next((file for file in fmus() if file.stem == model and file.suffix == ".fmu"), None)
    if file is None:
        names = [file.stem for file in fmus() if file.suffix == ".fmu"]
        raise FileNotFoundError(f"there is no FMU of {model}{did_you_mean(model, names)}; there are {', '.join(names)}")
    with zipfile.ZipFile(file) as archive:
        names = [name for name in archive.namelist() if name.startswith("resources/") and name.endswith(".json")]
        sets = [json.loads(archive.read(name)) for name in sorted(names)]
    return {one["name"]: one["values"] for one in sets if "values" in one}


def _copy(source: Path, target: Path) -> Path:
    with whole(target) as part:
        shutil.copyfile(source, part)
    return target

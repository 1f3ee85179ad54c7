"""A configured machine as an FMU of its own."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from pneumatic_servo import _native, checks, values
from pneumatic_servo.bundled import fmus
from pneumatic_servo.files import check_ending, check_place, whole
from pneumatic_servo.model import Model, Parameters
from pneumatic_servo.names import did_you_mean

PRESETS = ("all", "rig", "minimal")
EXPERIMENT = ("start", "stop", "step", "tolerance")


def export_fmu(
    path: str | os.PathLike[str],
    settings: Parameters | None = None,
    *,
    model: str = "PneumaticServoCylinder",
    preset: str = "all",
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    parameters: Sequence[str] | None = None,
    name: str | None = None,
    default_experiment: Mapping[str, object] | None = None,
    source: str | os.PathLike[str] | None = None,
    beside: bool = False,
) -> list[Path]:
    """Write a configured machine as an FMU: its values are the start values, and only the wanted variables are left.

    The file is valid by itself, for co-simulation and model exchange, on all platforms of the FMU that it is made from.
    An instance starts with the values of the settings; what is not kept cannot be set. Value references stay.

    Parameters
    ----------
    path : path
        The file to write.
    settings : mapping or path, optional
        Parameters and start values of inputs, or a file of them, as `Model.simulate` takes them.
    model : str
        The model.
    preset : {"all", "rig", "minimal"}
        Variables that stay where they are not named below. ``rig``: those that count with these settings;
        ``minimal``: the command in, position, velocity, pressures and forces out, and as parameters the ten values of
        a data sheet.
    inputs, outputs, parameters : sequence of str, optional
        Variables that stay: inputs become ports, the other inputs and parameters are fixed at their values. An array
        stays as a whole.
    name : str, optional
        Name of the machine; by default that of the file.
    default_experiment : mapping, optional
        ``start``, ``stop`` and ``step`` in s, ``tolerance``; by default those of the model.
    source : path, optional
        The FMU to start from, of FMI 2.0 or 3.0; by default the one of FMI 2.0 that comes with the package.
    beside : bool
        Write beside it the values as JSON (``.json``, which YAML reads, too), a record of Modelica (``.mo``) and a
        script that adds the FMU to a model of Simulink (``.m``).

    Returns
    -------
    list of pathlib.Path
        The files that were written, the FMU first.

    Raises
    ------
    ValueError
        For a wrong name, a value out of range, or an input that the configured machine needs and that is left out.
        Nothing is written then.
    FileNotFoundError
        When the package was built without FMUs, and there is no `source`.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> machine = {"friction.law": "LuGre", "cylinder.bore": "40 mm", "supplyPressure": "6 bar"}
    >>> (file,) = ps.export_fmu("axis7.fmu", machine, preset="minimal")
    >>> list(ps.Model(str(file)).inputs)
    ['valveVoltage']
    >>> file.unlink()
    """
    return write(
        Path(path), Model(model), settings, preset, (inputs, outputs, parameters), name, default_experiment, source,
        beside, "",
    )  # fmt: skip


DRIVE = {"plant": "PneumaticServoCylinder", "controller": "PositionController"}
"""Components of the drive, and their models."""


def export_drive(
    path: str | os.PathLike[str],
    settings: Mapping[str, object] | None = None,
    *,
    name: str | None = None,
    source: str | os.PathLike[str] | None = None,
) -> Path:
    """Write plant and controller with values of their own as a system of SSP.

    Parameters
    ----------
    path : path
        The file to write, ``drive.ssp``.
    settings : mapping, optional
        Values by name, as ``plant.friction.law`` and ``controller.gain.position``. Others are those of the drive that
        comes with the package.
    name : str, optional
        Name of the drive; by default that of the file.
    source : path, optional
        The SSP to start from; by default the one that comes with the package.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    ValueError
        For a wrong name or value. Nothing is written then.
    FileNotFoundError
        When the package was built without FMUs, and there is no `source`.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> file = ps.export_drive("drive.ssp", {"controller.gain.position": 30.0})
    >>> file.name
    'drive.ssp'
    >>> file.unlink()
    """
    path = Path(path)
    check_ending(path, ".ssp")
    check_place(path)
    taken = Path(source) if source is not None else next(file for file in fmus() if file.suffix == ".ssp")
    parts: dict[str, dict[str, object]] = {component: {} for component in DRIVE}
    for key, value in checks.mapping("settings", settings).items():
        component, _, variable = str(key).partition(".")
        if component not in parts:
            raise ValueError(f"{key} is of no component; names begin with {' or '.join(f'{one}.' for one in parts)}")
        parts[component][variable] = value
    own = [
        (f"{component}.{variable}", value)
        for component, part in parts.items()
        for variable, value in Model(DRIVE[component])._settings(part, "settings").items()
    ]
    system = _native.export_system(taken.read_bytes(), name if name is not None else path.stem, own)
    with whole(path) as part_file:
        part_file.write_bytes(system)
    return path


def write(
    path: Path,
    model: Model,
    settings: Parameters | None,
    preset: str,
    kept: tuple[Sequence[str] | None, Sequence[str] | None, Sequence[str] | None],
    name: str | None,
    default_experiment: Mapping[str, object] | None,
    source: str | os.PathLike[str] | None,
    beside: bool,
    sections: str,
) -> list[Path]:
    """Write the FMU, and sections of its documentation page."""
    check_ending(path, ".fmu")
    check_place(path)
    for argument, names in zip(("inputs", "outputs", "parameters"), kept, strict=True):
        if isinstance(names, str):
            raise ValueError(f"{argument} = {names!r} is refused: give a list of names")
    taken = Path(source) if source is not None else _bundled(model.name)
    own = model._fitted(model._settings(settings, "settings"))
    fmu, files = _native.export_fmu(
        taken.read_bytes(), name if name is not None else path.stem, list(own.items()), preset,
        tuple(None if names is None else list(names) for names in kept), _experiment(default_experiment), sections,
    )  # fmt: skip
    written = [path]
    with whole(path) as part:
        part.write_bytes(fmu)
    if beside:
        for text, ending in ((text, Path(file).suffix) for file, text in files.items()):
            written.append(path.with_suffix(ending))
            with whole(written[-1]) as part:
                part.write_text(text, encoding="utf-8")
    return written


def _bundled(model: str) -> Path:
    files = {file.stem: file for file in fmus() if file.suffix == ".fmu"}
    if model not in files:
        raise FileNotFoundError(f"there is no FMU of {model}{did_you_mean(model, files)}; give source=")
    return files[model]


def _experiment(
    given: Mapping[str, object] | None,
) -> tuple[float | None, float | None, float | None, float | None]:
    stated = dict(given or {})
    for key in stated:
        if key not in EXPERIMENT:
            raise ValueError(f"default_experiment: there is no {key!r}; it may have {', '.join(EXPERIMENT)}")
    start, stop, step = (
        values.seconds(f"default_experiment: {key}", stated[key]) if key in stated else None for key in EXPERIMENT[:3]
    )
    tolerance = stated.get("tolerance")
    if tolerance is not None and not values.is_number(tolerance):
        raise ValueError(f"default_experiment: tolerance = {tolerance!r} is refused: it must be a number")
    return start, stop, step, None if tolerance is None else float(tolerance)  # type: ignore[arg-type]

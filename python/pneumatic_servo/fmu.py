"""FMUs as models: the same classes, with the shared library of an FMU 2.0 for co-simulation behind them.

What the interface of an FMU cannot do is refused: transitions, sensitivities and gradients of runs, and moving states.
A module made by ``python_module!`` of the crate behind an FMU has them.
"""

from __future__ import annotations

import platform
import shutil
import sys
import tempfile
import weakref
import zipfile
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree

from pneumatic_servo import _native
from pneumatic_servo.variables import Description, Value

KINDS = {"Real": "real", "Integer": "integer", "Boolean": "boolean", "Enumeration": "enumeration"}


class FmuModel:
    """A model in an FMU: its variables, and how a run of it starts."""

    def __init__(self, path: str | Path) -> None:
        self.name = str(Path(path).absolute())
        try:
            with zipfile.ZipFile(self.name) as archive:
                described = ElementTree.fromstring(archive.read("modelDescription.xml"))
        except (zipfile.BadZipFile, KeyError, ElementTree.ParseError) as error:
            raise ValueError(f"{path} is no FMU: {error}") from None
        if not described.get("generationTool", "").startswith("pneumatic-servo-fmu"):
            raise ValueError(f"{path} is no FMU of this library; FMPy runs others")
        how = described.find("CoSimulation")
        if described.get("fmiVersion") != "2.0" or how is None:
            raise ValueError(f"{path} is no FMU 2.0 for co-simulation; `package_fmus!` packs one beside that for 3.0")
        self.identifier, self.guid = how.attrib["modelIdentifier"], described.attrib["guid"]
        self.description = described.get("description", "")
        default = described.find("DefaultExperiment")
        times = {} if default is None else default.attrib
        self.experiment = float(times.get("stopTime", 1.0)), float(times.get("stepSize", 1e-3))
        self._described = _descriptions(described)

    def variables(self) -> list[Description]:
        """Return all variables, in the order of the description."""
        return [own for _, own in self._described]

    @cached_property
    def library(self) -> _native.Fmu:
        """The shared library for this machine with what it needs, unpacked when it is first needed."""
        variables = {
            own["name"]: (reference, own["kind"], {item: float(number) for number, item, _ in own["items"]})
            for reference, own in self._described
        }
        states = [own["derivative_of"] for _, own in self._described if own["derivative_of"] is not None]
        return _native.Fmu(self._unpacked(), (self.identifier, self.guid, self._resources()), variables, states)

    def _resources(self) -> str:
        """Return the folder of the resources as a URI: the values of a configured FMU."""
        folder = self._folder()
        with zipfile.ZipFile(self.name) as archive:
            for name in archive.namelist():
                if name == "resources/variant.txt":
                    archive.extract(name, folder)
        return (Path(folder).resolve() / "resources").as_uri()

    def _folder(self) -> str:
        folder = tempfile.mkdtemp(prefix="fmu-")
        # A loaded library cannot be deleted on Windows.
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        return folder

    def _unpacked(self) -> Path:
        ending = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
        system = {"win32": "win", "darwin": "darwin"}.get(sys.platform, "linux")
        names = [f"{system}64", f"{platform.machine().lower()}-{system}"]
        if platform.machine().lower() not in ("x86_64", "amd64") and sys.platform != "darwin":
            names = names[1:]
        with zipfile.ZipFile(self.name) as archive:
            wanted = [f"binaries/{name}/{self.identifier}{ending}" for name in names]
            found = next((name for name in wanted if name in archive.namelist()), None)
            if found is None:
                raise ValueError(f"{self.name} has no library for this machine: none of {', '.join(wanted)}")
            return Path(archive.extract(found, self._folder()))

    def meant(self, _name: str, _value: float) -> str:
        """Return nothing: the FMU warns of values that are hardly meant itself."""
        return ""

    def lacks(self, _settings: Sequence[tuple[str, Value]], names: Sequence[str]) -> list[str]:
        """Return nothing for each variable: the FMU warns of those without effect itself."""
        return [""] * len(names)

    def start(self, settings: Sequence[tuple[str, Value]], time: float) -> _native.FmuSimulation:
        """Start a run at a time in s."""
        return self.library.start(settings, time)


def nothing(_time: float, _seen: Mapping[str, float]) -> None:
    """Control nothing: a run of an FMU is a closed loop without a controller."""


def _number(text: str | None) -> float | None:
    if text is None:
        return None
    return float(text == "true") if text in ("true", "false") else float(text)


def _descriptions(described: ElementTree.Element) -> list[tuple[int, Description]]:
    """Return the value reference and the description of each variable."""
    shown = {
        unit.attrib["name"]: {one.attrib["name"]: one.attrib for one in unit.iter("DisplayUnit")}
        for unit in described.iter("Unit")
    }
    items = {
        simple.attrib["name"]: [
            (int(item.attrib["value"]), item.attrib["name"], item.get("description", ""))
            for item in simple.iter("Item")
        ]
        for simple in described.iter("SimpleType")
    }
    listed = list(described.iter("ScalarVariable"))
    found: list[tuple[int, Description]] = []
    for variable in listed:
        of = next(child for child in variable if child.tag in KINDS)
        causality, variability = variable.get("causality", "local"), variable.get("variability", "continuous")
        unit = of.get("unit", "1")
        name = of.get("displayUnit") or next(iter(shown.get(unit, {})), None)
        display = shown.get(unit, {}).get(name) if name else None
        factors = (float(display.get("factor", 1.0)), float(display.get("offset", 0.0))) if display else None
        state = of.get("derivative")
        found.append(
            (
                int(variable.attrib["valueReference"]),
                Description(
                    name=variable.attrib["name"],
                    role={"independent": "time", "parameter": variability}.get(causality, causality),
                    kind=KINDS[of.tag],
                    unit=unit,
                    # States have a start value there that follows from parameters.
                    start=_number(of.get("start")) if causality in ("input", "parameter") else None,
                    minimum=_number(of.get("min")),
                    maximum=_number(of.get("max")),
                    nominal=_number(of.get("nominal")),
                    display=(str(name), *factors) if factors else None,
                    items=items.get(of.get("declaredType", ""), []),
                    derivative_of=listed[int(state) - 1].attrib["name"] if state else None,
                    meaning=None,
                    counts_for=None,
                    follows=None,
                    is_conditional=False,
                    plausible=None,
                    text=variable.get("description", ""),
                ),
            )
        )
    return found

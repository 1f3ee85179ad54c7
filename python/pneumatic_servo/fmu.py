"""FMUs as models: the same classes, with the shared library of an FMU 2.0 for co-simulation behind them.

What the interface of an FMU cannot do is refused: transitions, sensitivities and gradients of runs, and moving states.
A module made by ``python_module!`` of the crate behind an FMU has them.
"""

from __future__ import annotations

import ctypes
import platform
import shutil
import sys
import tempfile
import weakref
import zipfile
from collections.abc import Mapping, Sequence
from ctypes import byref, c_byte, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from typing import Any, NoReturn
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.errors import warn
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.run_errors import SimulationError
from pneumatic_servo.variables import Description, Value

OWN = "a module of the crate behind the FMU has them: python_module! in docs/own-packing.md"
OK, WARNING = 0, 1
CO_SIMULATION = 1
KINDS = {"Real": "real", "Integer": "integer", "Boolean": "boolean", "Enumeration": "enumeration"}
LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)


class Callbacks(ctypes.Structure):
    """The structure ``fmi2CallbackFunctions``; FMUs of this library allocate by themselves."""

    _fields_ = (
        ("logger", LOGGER), ("allocate", c_void_p), ("free", c_void_p), ("finished", c_void_p), ("own", c_void_p)
    )  # fmt: skip


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
        self.found = {own["name"]: own for _, own in self._described}
        self.references = {own["name"]: reference for reference, own in self._described}
        self._library: ctypes.CDLL | None = None
        self._resources: str | None = None

    def variables(self) -> list[Description]:
        """Return all variables, in the order of the description."""
        return [own for _, own in self._described]

    @property
    def library(self) -> ctypes.CDLL:
        """The shared library for this machine, unpacked when it is first needed."""
        if self._library is None:
            self._library = ctypes.CDLL(str(self._unpacked()))
        return self._library

    @property
    def resources(self) -> str:
        """The folder of the resources as a URI: the values of a configured FMU."""
        if self._resources is None:
            folder = self._folder()
            with zipfile.ZipFile(self.name) as archive:
                for name in archive.namelist():
                    if name == "resources/variant.txt":
                        archive.extract(name, folder)
            self._resources = (Path(folder).resolve() / "resources").as_uri()
        return self._resources

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

    def start(self, settings: Sequence[tuple[str, Value]], time: float) -> FmuSimulation:
        """Start a run at a time in s."""
        return FmuSimulation(self, settings, time)


class FmuState:
    """A saved state as the FMU serializes it."""

    def __init__(self, data: bytes, time: float) -> None:
        self.data, self.time = data, time

    def to_bytes(self) -> bytes:
        """Return the bytes of the state; they are of use to the FMU that has made them alone."""
        return self.data


class FmuSimulation:
    """A running instance of an FMU."""

    def __init__(self, model: FmuModel, settings: Sequence[tuple[str, Value]], time: float) -> None:
        self.model, self.time, self._messages, self._warnings = model, time, list[str](), list[str]()
        # What `set` has given, and nothing else has changed since.
        self._given: dict[str, Value] = {}
        library = model.library
        # Kept for as long as the instance may call it.
        self._logger = LOGGER(self._hear)
        self._callbacks = Callbacks(logger=self._logger)
        library.fmi2Instantiate.restype = c_void_p
        instance = library.fmi2Instantiate(
            c_char_p(model.identifier.encode()), c_int(CO_SIMULATION), c_char_p(model.guid.encode()),
            c_char_p(model.resources.encode()), byref(self._callbacks), c_int(0), c_int(0),
        )  # fmt: skip
        if not instance:
            raise ValueError(self._told("the FMU cannot be instantiated"))
        self._instance = c_void_p(instance)
        self._call("fmi2SetDebugLogging", c_int(1), c_size_t(1), (c_char_p * 1)(b"logStatusWarning"))
        for name, value in settings:
            self.set_one(name, value)
        self._call("fmi2SetupExperiment", c_int(0), c_double(0.0), c_double(time), c_int(0), c_double(0.0))
        self._call("fmi2EnterInitializationMode")
        self._call("fmi2ExitInitializationMode")

    def __del__(self) -> None:
        instance = self.__dict__.pop("_instance", None)
        if instance is not None:
            self.model.library.fmi2FreeInstance.restype = None
            self.model.library.fmi2FreeInstance(instance)

    def _hear(self, _own: int, _name: bytes, status: int, _category: bytes, text: bytes) -> None:
        heard = self._warnings if status == WARNING else self._messages
        heard.append(_plain(text))

    def _told(self, otherwise: str) -> str:
        return "; ".join(self._messages) or otherwise

    def _call(self, name: str, *arguments: Any, failure: type[Exception] = ValueError) -> None:
        self._messages.clear()
        # As an attribute it is looked up once.
        status = getattr(self.model.library, name)(self._instance, *arguments)
        if status not in (OK, WARNING):
            raise failure(self._told(f"{name} of {self.model.identifier} ends with the status {status}"))
        while self._warnings:
            # The text begins with the function of the standard.
            warn(self._warnings.pop(0).partition(": ")[2])

    def _of(self, name: str) -> tuple[Any, Description]:
        own = self.model.found.get(name)
        if own is None:
            raise ValueError(f"there is no variable {name}{did_you_mean(name, list(self.model.found))}")
        return (c_uint * 1)(self.model.references[name]), own

    def set(self, settings: Sequence[tuple[str, Value]]) -> None:
        """Set inputs and tunable parameters one after the other; on an error none of them is."""
        done: list[tuple[str, Value]] = []
        try:
            for name, value in settings:
                before = self._given[name] if name in self._given else self.get(name)
                self.set_one(name, value)
                done.append((name, before))
                self._given[name] = value
        except ValueError:
            for name, before in reversed(done):
                self.set_one(name, before)
                self._given[name] = before
            raise

    def set_one(self, name: str, value: Value) -> None:
        """Set one input or tunable parameter."""
        reference, own = self._of(name)
        self._given.pop(name, None)
        if isinstance(value, str):
            ids = {item: number for number, item, _ in own["items"]}
            if value not in ids:
                raise ValueError(f"{name} = {value} is refused: it must be one of {', '.join(ids) or 'no words'}")
            value = ids[value]
        if own["kind"] == "real":
            self._call("fmi2SetReal", reference, c_size_t(1), (c_double * 1)(value))
            return
        if value != int(value):
            raise ValueError(f"{name} = {value} is refused: it must be a whole number")
        function = "fmi2SetBoolean" if own["kind"] == "boolean" else "fmi2SetInteger"
        self._call(function, reference, c_size_t(1), (c_int * 1)(int(value)))

    def get(self, name: str) -> float:
        """Return the value of one variable."""
        if name == "time":
            return self.time
        reference, own = self._of(name)
        if own["kind"] == "real":
            real = (c_double * 1)()
            self._call("fmi2GetReal", reference, c_size_t(1), real)
            return real[0]
        whole = (c_int * 1)()
        self._call("fmi2GetBoolean" if own["kind"] == "boolean" else "fmi2GetInteger", reference, c_size_t(1), whole)
        return float(whole[0])

    def step(self, size: float) -> None:
        """Integrate over a step of a size in s."""
        if not (np.isfinite(size) and self.time + size > self.time):
            raise ValueError(f"a step of {size} s leads nowhere from {self.time} s")
        self._call("fmi2DoStep", c_double(self.time), c_double(size), c_int(0), failure=SimulationError)
        self.time += size

    def notices(self) -> list[tuple[str, float, str]]:
        """Return nothing: an FMU warns through its logger."""
        return []

    def save(self) -> FmuState:
        """Return everything that affects the further run."""
        state, size = c_void_p(), c_size_t()
        self._call("fmi2GetFMUstate", byref(state))
        self._call("fmi2SerializedFMUstateSize", state, byref(size))
        data = (c_byte * size.value)()
        self._call("fmi2SerializeFMUstate", state, data, size)
        self._call("fmi2FreeFMUstate", byref(state))
        return FmuState(bytes(data), self.time)

    def restore(self, saved: FmuState) -> None:
        """Go back to a saved state."""
        if not isinstance(saved, FmuState):
            raise TypeError("the state is none that a run of an FMU has saved")
        state, data = c_void_p(), (c_byte * len(saved.data)).from_buffer_copy(saved.data)
        self._call("fmi2DeSerializeFMUstate", data, c_size_t(len(saved.data)), byref(state))
        self._call("fmi2SetFMUstate", state)
        self._call("fmi2FreeFMUstate", byref(state))
        self._given.clear()
        self.time = saved.time

    def states(self) -> list[str]:
        """Return the names of all continuous states that the description lists."""
        return [own["derivative_of"] for own in self.model.found.values() if own["derivative_of"] is not None]

    def jacobian(self, of: Sequence[str], to: Sequence[str]) -> NDArray[np.float64]:
        """Return partial derivatives of computed variables (rows) with respect to states and inputs (columns)."""
        rows = (c_uint * len(of))(*(self._of(name)[0][0] for name in of))
        matrix, one = np.zeros((len(of), len(to))), (c_double * 1)(1.0)
        for column, name in enumerate(to):
            found = (c_double * len(of))()
            self._call(
                "fmi2GetDirectionalDerivative", rows, c_size_t(len(of)), self._of(name)[0], c_size_t(1), one, found
            )
            matrix[:, column] = found
        return matrix

    def move_states(self, _states: Sequence[tuple[str, Value]]) -> NoReturn:
        """Refuse: an FMU for co-simulation integrates its states itself."""
        raise ValueError(f"states of an FMU for co-simulation cannot be moved; {OWN}")

    def transition(self, *_asked: object) -> NoReturn:
        """Refuse: the interface has none."""
        raise ValueError(f"an FMU has no transitions; {OWN}")


def nothing(_time: float, _seen: Mapping[str, float]) -> None:
    """Control nothing: a run of an FMU is a closed loop without a controller."""


def _plain(text: bytes) -> str:
    return text.decode(errors="replace").replace("%%", "%")


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
                    is_conditional=False,
                    plausible=None,
                    text=variable.get("description", ""),
                ),
            )
        )
    return found

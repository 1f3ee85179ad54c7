"""An FMI 2.0 co-simulation FMU, driven by the names of its variables."""

from __future__ import annotations

import math
import shutil
from collections.abc import Mapping, Sequence
from ctypes import byref, c_int
from pathlib import Path
from types import TracebackType
from typing import Any

import fmpy
from fmpy import calloc, free
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2OK,
)
from fmpy.logging import addLoggerProxy
from fmpy.model_description import ModelDescription, ScalarVariable

Value = float | int | bool | str
"""A value by its FMI type; items of enumerations by name or by number."""


# FMPy keeps one logger for the whole process, the last one, and calls it for instances that are given none, too.
_KEPT: list[fmi2CallbackFunctions] = []


class Client:
    """One instance of an FMU.

    Every status other than OK, warnings included, is an exception. Messages of the FMU are kept in `messages`.

    A use runs through `start`, any number of `step`, `set` and `get`, and the end of the `with` block.
    """

    def __init__(self, fmu: Path, logging: bool = False, guid: str | None = None) -> None:
        self.description: ModelDescription = fmpy.read_model_description(str(fmu))
        self.variables: dict[str, ScalarVariable] = {v.name: v for v in self.description.modelVariables}
        self.messages: list[str] = []
        self.time = math.nan
        self._folder = fmpy.extract(str(fmu))
        self._callbacks = self._make_callbacks()
        self.slave = FMU2StrictSlave(
            guid=guid or self.description.guid,
            unzipDirectory=self._folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="instance",
        )
        self.slave.messages = self.messages
        try:
            self.slave.instantiate(callbacks=self._callbacks, loggingOn=logging)
        except Exception as error:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise RuntimeError(f"{fmu.name} cannot be instantiated: {'; '.join(self.messages)}") from error

    def __enter__(self) -> Client:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.slave.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)

    def start(self, values: Mapping[str, Value] | None = None, tolerance: float | None = None) -> None:
        """Sets start values and initializes at time 0."""
        self.slave.setupExperiment(startTime=0.0, tolerance=tolerance)
        self.set(values or {})
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        self.time = 0.0

    def advance(self, end: float) -> None:
        """Makes one communication step to the time `end`."""
        self.slave.doStep(self.time, end - self.time)
        self.time = end

    def set(self, values: Mapping[str, Value]) -> None:
        """Sets inputs or parameters."""
        for name, value in values.items():
            variable = self.variables[name]
            reference = [variable.valueReference]
            if variable.type == "Real":
                self.slave.setReal(reference, [float(value)])
            elif variable.type == "Boolean":
                self.slave.setBoolean(reference, [bool(value)])
            else:
                self.slave.setInteger(reference, [self._number(variable, value)])

    def get(self, names: Sequence[str]) -> list[float]:
        """Reads variables; Booleans as 0 or 1."""
        return [float(self._get_one(self.variables[name])) for name in names]

    def names(self, causality: str) -> list[str]:
        """The names of all variables of a causality, in the order of the description."""
        return [v.name for v in self.description.modelVariables if v.causality == causality]

    def items(self, name: str) -> dict[str, int]:
        """The items of an enumeration variable."""
        return {item.name: int(item.value) for item in self.variables[name].declaredType.items}

    def _get_one(self, variable: ScalarVariable) -> Any:
        reference = [variable.valueReference]
        if variable.type == "Real":
            return self.slave.getReal(reference)[0]
        if variable.type == "Boolean":
            return self.slave.getBoolean(reference)[0]
        return self.slave.getInteger(reference)[0]

    def _number(self, variable: ScalarVariable, value: Value) -> int:
        return self.items(variable.name)[value] if isinstance(value, str) else int(value)

    def _make_callbacks(self) -> fmi2CallbackFunctions:
        messages = self.messages

        def log(environment: object, instance: bytes, status: int, category: bytes, message: bytes) -> None:
            messages.append(message.decode())

        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(log)
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        addLoggerProxy(byref(callbacks))
        _KEPT.append(callbacks)
        return callbacks


class FMU2StrictSlave(FMU2Slave):
    """FMPy lets warnings pass; here they are exceptions like every status other than OK.

    FMPy chooses the functions to load by the beginning of the name of this class.
    """

    messages: list[str]

    def _call(self, fname: str, *args: Any) -> Any:
        count = len(self.messages)
        try:
            result = super()._call(fname, *args)
            if self._functions[fname].restype is c_int and result != fmi2OK:
                raise FMICallException(function=fname, status=result)
        except FMICallException as error:
            for message in self.messages[count:]:
                error.add_note(message)
            raise
        return result

"""Descriptions of models: variables, default experiment, warnings about values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from html import escape
from pathlib import Path
from typing import cast

from pneumatic_servo import _native, plant_warnings
from pneumatic_servo.errors import Refused
from pneumatic_servo.fmu import FmuModel
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.variables import Value, Variable, Variables

KNOWN = ("name", "description", "variables", "parameters", "inputs", "outputs", "stop", "step")
"""Attributes of a model."""


class ModelDescription:
    """Description of a model without a run; `Model` adds runs."""

    def __init__(self, name: str | Path = "PneumaticServoCylinder") -> None:
        # A model in an FMU has the methods of a native one.
        self._is_fmu = str(name).endswith(".fmu")
        if self._is_fmu:
            self._native = cast(_native.Model, FmuModel(name))
        elif name not in _native.models():
            every = _native.models()
            raise ValueError(
                f"there is no model {name}{did_you_mean(str(name), every)}; it must be one of {', '.join(every)}"
            )
        else:
            self._native = _native.Model(str(name))
        self.name = self._native.name
        self.description = self._native.description
        self.variables = Variables(Variable.of(description) for description in self._native.variables())
        self.parameters = self._with_roles("fixed", "tunable")
        self.inputs = self._with_roles("input")
        self.outputs = self._with_roles("output")
        self.stop, self.step = self._native.experiment

    def __setattr__(self, name: str, value: object) -> None:
        # A user's class may have attributes of its own; here another one would do nothing.
        is_own = type(self).__module__.partition(".")[0] != __package__
        if not (is_own or name in KNOWN or name.startswith("_")):
            known = self.__dict__.get("variables")
            if isinstance(known, Variables) and name in known:
                raise AttributeError(
                    f"{name} is set for a run: simulate({{{name!r}: ...}}), or inputs={{{name!r}: ...}}"
                )
            raise AttributeError(f"a model has no attribute {name}{did_you_mean(name, KNOWN)}")
        super().__setattr__(name, value)

    def _with_roles(self, *roles: str) -> Variables:
        return Variables(variable for variable in self.variables.values() if variable.role in roles)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.name!r})"

    def __reduce__(self) -> tuple[type[ModelDescription], tuple[str]]:
        return type(self), (self.name,)

    def _in_unit(self, refused: Refused) -> Refused:
        variable = self.variables.get(refused.variable)
        return refused if variable is None else refused.with_unit(variable.unit)

    @contextmanager
    def _with_units(self) -> Iterator[None]:
        try:
            yield
        except Refused as refused:
            raise self._in_unit(refused) from None

    def _tell_saturated(self, settings: Mapping[str, Value]) -> None:
        for name, value in settings.items():
            if name in self.inputs:
                plant_warnings.warn_saturation(self.inputs[name], float(value), float(value))

    def _repr_html_(self) -> str:
        parts = [("Inputs", self.inputs), ("Parameters", self.parameters), ("Outputs", self.outputs)]
        tables = (
            f"<details{' open' if title == 'Inputs' else ''}><summary>{title}: {len(of)}</summary>"
            f"{of._repr_html_()}</details>"
            for title, of in parts
        )
        return f"<p><b>{escape(self.name)}</b>: {escape(self.description)}</p>{''.join(tables)}"

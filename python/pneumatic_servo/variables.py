"""The variables of a model, as its table states them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from html import escape
from typing import TypedDict

from pneumatic_servo.names import did_you_mean

Value = float | int | bool | str
"""A value as programs write it: a number in SI units, the name of an item of an enumeration, or true or false."""


class Description(TypedDict):
    """A variable as the extension module describes it."""

    name: str
    role: str
    kind: str
    unit: str
    start: float | None
    minimum: float | None
    maximum: float | None
    nominal: float | None
    display: tuple[str, float, float] | None
    items: list[tuple[int, str, str]]
    derivative_of: str | None
    meaning: str | None
    counts_for: tuple[str, str] | None
    follows: tuple[str, bool] | None
    plausible: tuple[float, float] | None
    is_conditional: bool
    text: str


@dataclass(frozen=True)
class Unit:
    """A unit to show values in: ``factor * value + offset``.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> bar = ps.Model().variables["supplyPressure"].shown
    >>> bar.name, round(bar.factor * 6e5 + bar.offset, 9)
    ('bar', 6.0)
    """

    name: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Variable:
    """One variable of a model.

    Attributes
    ----------
    name : str
        Structured name, for example ``chamberA.pressure``.
    role : str
        ``input``, ``fixed`` (parameter), ``tunable`` (parameter that may change while running), ``output``,
        ``local`` (computed, for analysis) or ``time``.
    kind : str
        ``real``, ``integer``, ``boolean`` or ``enumeration``.
    unit : str
        SI unit of the value.
    default : float, bool, str or None
        Start value; None for what is computed.
    minimum, maximum : float or None
        Smallest and largest legal value, where there is one.
    nominal : float or None
        Order of magnitude.
    shown : Unit
        Unit to show values in.
    items : dict
        Text of each item of an enumeration, by its name.
    text : str
        Description of the variable.
    meaning : str or None
        Meaning of a parameter of a friction law, independent of its name: ``static friction``, for example.
    counts_for : tuple of str, or None
        The enumeration and the item for which alone a parameter counts: ``("friction.law", "LuGre")``.
    follows : tuple of str and bool, or None
        The parameter that the default follows where both do not fit together, and whether in the proportion of their
        defaults: ``("cylinder.stroke", True)``.
    is_conditional : bool
        Whether it counts under conditions only: for an item, or with another parameter, as its text says.
    plausible : tuple of float, or None
        Range of the values that rigs have; a legal value beyond it gets a warning.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> mass = ps.Model().variables["mass.moving"]
    >>> mass.unit, mass.role, mass.kind
    ('kg', 'fixed', 'real')
    """

    name: str
    role: str
    kind: str
    unit: str
    default: Value | None
    minimum: float | None
    maximum: float | None
    nominal: float | None
    shown: Unit
    items: Mapping[str, str]
    ids: Mapping[str, int]
    derivative_of: str | None
    text: str
    meaning: str | None = None
    counts_for: tuple[str, str] | None = None
    follows: tuple[str, bool] | None = None
    is_conditional: bool = False
    plausible: tuple[float, float] | None = None

    @staticmethod
    def of(description: Description) -> Variable:
        """Read the description of a variable from the extension module."""
        items = description["items"]
        start = description["start"]
        default: Value | None = start
        if start is not None and description["kind"] == "enumeration":
            default = next(name for number, name, _ in items if number == start)
        elif start is not None and description["kind"] != "real":
            default = bool(start) if description["kind"] == "boolean" else int(start)
        display = description["display"]
        return Variable(
            name=description["name"],
            role=description["role"],
            kind=description["kind"],
            unit=description["unit"],
            default=default,
            minimum=description["minimum"],
            maximum=description["maximum"],
            nominal=description["nominal"],
            shown=Unit(*display) if display else Unit(description["unit"]),
            items={name: text for _, name, text in items},
            ids={name: number for number, name, _ in items},
            derivative_of=description["derivative_of"],
            text=description["text"],
            meaning=description["meaning"],
            counts_for=description["counts_for"],
            follows=description["follows"],
            is_conditional=description["is_conditional"],
            plausible=description["plausible"],
        )

    @property
    def range(self) -> str:
        """The legal values, for people."""
        if self.items:
            return ", ".join(self.items)
        if self.minimum is not None and self.maximum is not None:
            return f"{self.minimum:g} to {self.maximum:g}"
        if self.minimum is not None:
            return f"at least {self.minimum:g}"
        return "" if self.maximum is None else f"at most {self.maximum:g}"

    @property
    def range_in_unit(self) -> str:
        """The legal values with their unit, for people."""
        return self.range if self.unit == "1" or not self.range else f"{self.range} {self.unit}"

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        default = "" if self.default is None else f" = {self.default}{unit}"
        limits = f" ({self.range})" if self.range else ""
        return f"{self.name}{default}{limits}: {self.text}"


class Variables(Mapping[str, Variable]):
    """Variables by name, in the order of the table; shown as a table.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> parameters = ps.Model().parameters
    >>> "valve.C" in parameters, parameters["valve.C"].unit
    (True, 'm3/(s.Pa)')
    """

    def __init__(self, variables: Iterable[Variable]) -> None:
        self._variables = {variable.name: variable for variable in variables}
        self.leaders = frozenset(own.follows[0] for own in self._variables.values() if own.follows)

    def __getitem__(self, name: str) -> Variable:
        if name not in self._variables:
            raise KeyError(f"there is no {name} here{did_you_mean(name, self._variables)}")
        return self._variables[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._variables)

    def __len__(self) -> int:
        return len(self._variables)

    def __contains__(self, name: object) -> bool:
        return name in self._variables

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def matching(self, words: str) -> Variables:
        """Return the variables whose name or text has all the words, ignoring case."""
        wanted = words.lower().split()
        found = (v for v in self.values() if all(word in f"{v.name} {v.text}".lower() for word in wanted))
        return Variables(found)

    def __repr__(self) -> str:
        return "\n".join(str(variable) for variable in self.values())

    def _repr_html_(self) -> str:
        head = "<tr><th>name</th><th>default</th><th>unit</th><th>range</th><th>text</th></tr>"
        cells = ([v.name, "" if v.default is None else str(v.default), v.unit, v.range, v.text] for v in self.values())
        rows = ("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in cells)
        return f"<table>{head}{''.join(rows)}</table>"

"""Figures of runs, with units on their axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from io import BytesIO
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from cycler import cycler
from matplotlib.figure import Figure

from pneumatic_servo.variables import Unit, Variable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pneumatic_servo.run import Run

BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"
GREY = "#5a6570"
COLOURS = [BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY]
"""Colours that people with any colour vision tell apart."""

STYLE: Any = {
    "figure.dpi": 120,
    "font.size": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.prop_cycle": cycler(color=COLOURS),
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "grid.color": "#e3e7eb",
    "grid.linewidth": 0.8,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "savefig.bbox": "tight",
}
"""Settings of matplotlib for `matplotlib.rc_context`."""

USUAL = ["valveVoltage", "position", "velocity", "chamberA.pressure", "chamberB.pressure", "frictionForce"]
WIDTH, HEIGHT = 8.0, 1.9
"""Width of a figure and height of a panel in inches."""


class Drawing(Figure):
    """A figure that notebooks show, also where pyplot is not in use."""

    def _repr_png_(self) -> bytes:
        stream = BytesIO()
        self.savefig(stream, format="png")
        return stream.getvalue()


def draw_run(run: Run, names: Sequence[str] = ()) -> Figure:
    """Draw variables of a run over time, one panel per unit."""
    panels = _panels(run, names)
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 0.6 + HEIGHT * len(panels)), layout="constrained")
        axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for axis, (unit, variables) in zip(axes, panels.items(), strict=True):
            for variable in variables:
                _draw(axis, run, variable, variable.name)
            _label(axis, variables, unit)
            if len(variables) > 1:
                axis.legend(ncols=3)
        axes[-1].set_xlabel("time (s)")
        law = run.settings.get("friction.law")
        if law is not None:
            axes[0].set_title(f"friction law {law}")
    return figure


def draw_laws(runs: Mapping[str, Run], names: Sequence[str]) -> Figure:
    """Draw each variable of several runs over each other, one panel per variable."""
    variables = [next(iter(runs.values())).variables[name] for name in names]
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 0.6 + HEIGHT * len(variables)), layout="constrained")
        axes = figure.subplots(len(variables), 1, sharex=True, squeeze=False)[:, 0]
        for axis, variable in zip(axes, variables, strict=True):
            for law, run in runs.items():
                _draw(axis, run, variable, law)
            _label(axis, [variable], variable.shown)
        axes[-1].set_xlabel("time (s)")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=min(len(runs), 5))
    return figure


def _panels(run: Run, names: Sequence[str]) -> dict[Unit, list[Variable]]:
    """Sort what to draw by unit: by default the usual variables, or the first six where none of those is recorded."""
    chosen = list(names) or [name for name in USUAL if name in run.variables] or list(run.variables)[:6]
    panels: dict[Unit, list[Variable]] = {}
    for name in chosen:
        variable = run.variables[name]
        panels.setdefault(variable.shown, []).append(variable)
    return panels


def _draw(axis: Axes, run: Run, variable: Variable, label: str) -> None:
    shown = variable.shown
    # An input is held over each step; everything else moves between the rows.
    style = "steps-post" if variable.role == "input" else "default"
    axis.plot(run.time, shown.factor * run[variable.name] + shown.offset, drawstyle=style, label=label)


def _label(axis: Axes, variables: Sequence[Variable], unit: Unit) -> None:
    common = variables[0].name if len(variables) == 1 else variables[0].name.rpartition(".")[2]
    axis.set_ylabel(common if unit.name == "1" else f"{common} ({unit.name})")
    axis.margins(x=0)

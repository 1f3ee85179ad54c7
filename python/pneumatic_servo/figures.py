"""Figures of runs, with units on their axes."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from io import BytesIO
from typing import TYPE_CHECKING, Any, Protocol

import matplotlib as mpl
import numpy as np
from cycler import cycler
from matplotlib.figure import Figure, FigureBase
from numpy.typing import NDArray

from pneumatic_servo.variables import Unit, Variable, Variables

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Values = NDArray[np.float64]

BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"
GREY, SHADE = "#5a6570", "#eceff3"
COLOURS = [BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY]
"""Colours for all kinds of colour vision (Okabe and Ito)."""
STROKES: list[Any] = ["-", "--", "-.", (0, (1, 1)), (0, (5, 1)), (0, (3, 1, 1, 1))]
"""Styles of lines in the order of the colours, so that lines differ in print, too."""
CYCLE = cycler(color=COLOURS) + cycler(linestyle=STROKES)
"""Colours and styles for ``axes.prop_cycle`` where each line is one thing."""

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
CONTACTS = [
    ("relativeVelocity", "frictionForce"),
    ("trolley[1].velocity", "trolley[1].frictionForce"),
    ("velocity", "frictionForce"),
]
"""Velocity and friction of a contact; of the first pair that is recorded one is drawn against the other."""

WIDTH, HEIGHT = 8.0, 1.9
"""Width of a figure and height of a panel in inches."""

SPARSE = 0.02
"""Samples farther apart than this part of an axis are drawn as dots."""

TINY = 1e-300
"""In place of the extent of a curve that has none."""

LINES = 2.0
"""Layer of lines in matplotlib: above areas, below text."""


WINDOWS = ("qt", "tk", "gtk", "wx", "macosx", "webagg")
"""Beginnings of the names of backends of matplotlib that open windows."""


class Recorded(Protocol):
    """Data of a run for a figure: its times in s, its variables, their values in SI units, and its settings."""

    time: Values
    variables: Variables
    settings: dict[str, object]

    def __getitem__(self, name: str, /) -> Values: ...


class Drawing(Figure):
    """A figure that notebooks show, also where pyplot is not in use; where it has windows, `pyplot.show` shows it."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        pyplot = sys.modules.get("matplotlib.pyplot")
        if pyplot is not None and mpl.get_backend().lower().startswith(WINDOWS):
            self._join(pyplot)

    def show(self, warn: bool = True) -> None:
        """Show the figure in a window; without a display a warning says so."""
        if self.canvas.manager is None:
            import matplotlib.pyplot as plt

            self._join(plt)
        super().show(warn)

    def _join(self, pyplot: Any) -> None:
        """Take the place of a new figure of pyplot, in its window."""
        canvas = pyplot.figure(figsize=self.get_size_inches(), dpi=self.dpi).canvas
        canvas.figure = self
        self.set_canvas(canvas)

    def _repr_png_(self) -> bytes:
        stream = BytesIO()
        self.savefig(stream, format="png")
        return stream.getvalue()


def draw_run(run: Recorded, names: Sequence[str] = ()) -> Figure:
    """Draw variables of a run over time, one panel per unit."""
    panels = _panels(run, names)
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 0.6 + HEIGHT * len(panels)), layout="constrained")
        draw_panels(figure, run, panels)
        law = run.settings.get("friction.law")
        if law is not None:
            figure.axes[0].set_title(f"friction law {law}", loc="left")
    return figure


def draw_panels(figure: FigureBase, run: Recorded, panels: Sequence[tuple[str, Sequence[str]]]) -> None:
    """Draw panels one below the other, each with its label and the names of its curves; sticking is shaded.

    The first curve of a panel lies on top.
    """
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axis, (label, names) in zip(axes, panels, strict=True):
        variables = [run.variables[name] for name in names]
        _shade_sticking(axis, run)
        for place, variable in enumerate(variables):
            _draw(axis, run, variable, variable.name, above=-place)
        _label(axis, label, variables[0].shown)
        if len(variables) > 1:
            # Above the panel, where it hides nothing.
            above = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.0}
            axis.legend(ncols=min(len(variables), 4), handlelength=1.2, columnspacing=1.2, **above)
    axes[-1].set_xlabel("time (s)")
    figure.align_ylabels(axes)


def draw_laws(runs: Mapping[str, Recorded], names: Sequence[str]) -> Figure:
    """Draw each variable of several runs over each other, one panel per variable."""
    variables = [next(iter(runs.values())).variables[name] for name in names]
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 0.6 + HEIGHT * len(variables)), layout="constrained")
        axes = figure.subplots(len(variables), 1, sharex=True, squeeze=False)[:, 0]
        for axis, variable in zip(axes, variables, strict=True):
            for law, run in runs.items():
                _draw(axis, run, variable, law)
            _label(axis, variable.name, variable.shown)
        axes[-1].set_xlabel("time (s)")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=min(len(runs), 5))
    return figure


FEW = 6
"""Runs that are drawn as lines; of more a median and the bands of their distribution."""
BANDS = ((0.0, 100.0, 0.15), (5.0, 95.0, 0.3))
"""Percentiles and opacities of the bands."""


def draw_runs(runs: Sequence[Recorded], names: Sequence[str]) -> Figure:
    """Draw each variable of many runs, one panel per variable: lines of a few, of more median, 5 to 95 % and extent."""
    if len(runs) <= FEW:
        return draw_laws({f"run {number}": run for number, run in enumerate(runs)}, names)
    time = max((run.time for run in runs), key=len)
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 0.6 + HEIGHT * len(names)), layout="constrained")
        axes = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
        for axis, name in zip(axes, names, strict=True):
            values = np.full((len(runs), len(time)), np.nan)
            for row, run in zip(values, runs, strict=True):
                row[: len(run.time)] = shown(run, name)
            for low, high, opacity in BANDS:
                ends = np.nanpercentile(values, [low, high], axis=0)
                label = f"{low:g} to {high:g} %"
                axis.fill_between(time, *ends, color=BLUE, alpha=opacity, linewidth=0.0, label=label)
            axis.plot(time, np.nanmedian(values, axis=0), color=BLUE, label="median")
            _label(axis, name, runs[0].variables[name].shown)
        axes[-1].set_xlabel("time (s)")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def draw_friction(run: Recorded) -> Figure:
    """Draw friction against velocity, as a whole and near standstill."""
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 3.4), layout="constrained")
        whole, near = figure.subplots(1, 2)
        draw_contact(whole, run)
        draw_standstill(near, run)
    return figure


def contact(variables: Mapping[str, Variable]) -> tuple[str, str] | None:
    """Name the velocity and the friction force to draw against each other, if both of a contact are there."""
    return next((pair for pair in CONTACTS if set(pair) <= variables.keys()), None)


def draw_contact(axis: Axes, run: Recorded) -> None:
    """Draw friction against velocity: a line, with dots where samples are far apart and the line is only a guide."""
    velocity, force = _axes_of_contact(axis, run)
    gaps = np.hypot(*(np.diff(values) / max(np.ptp(values), TINY) for values in (velocity, force)))
    far = np.append(gaps > SPARSE, False) | np.append(False, gaps > SPARSE)
    axis.axhline(0.0, color=GREY, linewidth=0.6)
    axis.axvline(0.0, color=GREY, linewidth=0.6)
    axis.plot(velocity, force, color=GREEN, linewidth=0.5, alpha=0.4)
    axis.plot(np.where(far, np.nan, velocity), force, color=GREEN, linewidth=1.0)
    axis.plot(velocity[far], force[far], ".", color=GREEN, markersize=2.5)
    axis.set_title("friction force against velocity")


def draw_standstill(axis: Axes, run: Recorded) -> None:
    """Draw friction against a twentieth of the velocities, where the mass starts and stops; dots are samples."""
    velocity, force = _axes_of_contact(axis, run)
    limit = np.max(np.abs(velocity)) / 20.0
    near = np.abs(velocity) <= limit
    axis.plot(velocity, force, color=GREEN, linewidth=0.5, alpha=0.4)
    axis.plot(velocity[near], force[near], ".", color=GREEN, markersize=2.5)
    if limit > 0.0:
        inside = force[near]
        margin = 0.05 * max(np.ptp(inside), 1.0)
        axis.set(xlim=(-limit, limit), ylim=(np.min(inside) - margin, np.max(inside) + margin))
    axis.set_title("the same near standstill; dots: samples")


def _axes_of_contact(axis: Axes, run: Recorded) -> tuple[Values, Values]:
    pair = contact(run.variables)
    if pair is None:
        pairs = "; ".join(" and ".join(names) for names in CONTACTS)
        raise KeyError(f"friction against velocity needs both variables of a contact among the outputs: {pairs}")
    velocity, force = (run.variables[name].shown for name in pair)
    axis.set_xlabel(f"velocity ({velocity.name})")
    axis.set_ylabel(f"friction force ({force.name})")
    return shown(run, pair[0]), shown(run, pair[1])


def shown(run: Recorded, name: str) -> Values:
    """Return a variable in the unit that it is shown in."""
    unit = run.variables[name].shown
    values: Values = unit.factor * run[name] + unit.offset
    return values


def _panels(run: Recorded, names: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Sort the drawn variables by unit: by default the usual ones, or the first six where none of them is recorded."""
    chosen = list(names) or [name for name in USUAL if name in run.variables] or list(run.variables)[:6]
    panels: dict[Unit, list[str]] = {}
    for name in chosen:
        panels.setdefault(run.variables[name].shown, []).append(name)
    return [(names[0] if len(names) == 1 else names[0].rpartition(".")[2], names) for names in panels.values()]


def _draw(axis: Axes, run: Recorded, variable: Variable, label: str, above: int = 0) -> None:
    # An input is held over each step; everything else moves between the rows.
    style = "steps-post" if variable.role == "input" else "default"
    stroke = STROKES[len(axis.get_lines()) % len(STROKES)]
    values, order = shown(run, variable.name), LINES + 0.01 * above
    axis.plot(run.time, values, drawstyle=style, linestyle=stroke, label=label, zorder=order)


def _label(axis: Axes, text: str, unit: Unit) -> None:
    axis.set_ylabel(text if unit.name == "1" else f"{text} ({unit.name})")
    axis.margins(x=0)


def _shade_sticking(axis: Axes, run: Recorded) -> None:
    """Mark the time during which the mass sticks, where that is recorded."""
    if "sticking" in run.variables:
        sticking = run["sticking"] > 0.5
        across = axis.get_xaxis_transform()
        axis.fill_between(run.time, 0, 1, where=sticking, step="post", transform=across, color=SHADE, linewidth=0)

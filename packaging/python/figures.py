"""Figures of an experiment: what moved over time, and friction against velocity."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import FigureBase
from matplotlib.ticker import MaxNLocator
from run import EXPERIMENTS, Run

BLUE, VERMILION, GREEN, GREY = "#0072b2", "#d55e00", "#009e73", "#5b6876"
COLOURS = [BLUE, VERMILION, GREEN, GREY]

SPARSE = 0.02
"""Samples farther apart than this part of an axis are drawn as dots."""

TINY = 1e-300
"""In place of the extent of a curve that has none."""

STYLE = {
    "figure.dpi": 150,
    "savefig.bbox": "tight",
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e8ee",
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "lines.linewidth": 1.3,
    "legend.frameon": False,
}


FRICTION = [
    ("relativeVelocity", "frictionForce"),
    ("trolley[1].velocity", "trolley[1].frictionForce"),
    ("velocity", "frictionForce"),
]
"""Velocity and friction of a contact; of the first pair that a model has one is drawn against the other."""


def draw_run(run: Run, file: Path) -> None:
    """Everything about one run: curves over time on the left, friction (if any) against velocity on the right."""
    with plt.rc_context(STYLE):
        if any(set(pair) <= run.columns.keys() for pair in FRICTION):
            figure = plt.figure(figsize=(12, 8), layout="constrained")
            left, right = figure.subfigures(1, 2, width_ratios=(1.25, 1))
            draw_panels(left, run)
            draw_both_frictions(right, run)
        else:
            figure = plt.figure(figsize=(9, 7), layout="constrained")
            draw_panels(figure, run)
        figure.suptitle(title(run), fontsize=12, fontweight="bold", x=0.01, ha="left")
        save(figure, file)


def draw_panels(figure: FigureBase, run: Run) -> None:
    panels = EXPERIMENTS[run.model]["panels"]
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for panel, axis in zip(panels, axes, strict=True):
        draw_panel(axis, run, panel)
    axes[-1].set_xlabel("time (s)")
    figure.align_ylabels(axes)


def draw_both_frictions(figure: FigureBase, run: Run) -> None:
    """Friction against velocity, as a whole and near standstill."""
    whole, near = figure.subplots(2, 1)
    draw_friction(whole, run)
    whole.set_title("friction force against velocity")
    draw_friction(near, run)
    zoom(near, run)
    near.set_title("the same near standstill; dots: samples")
    figure.align_ylabels([whole, near])


def draw_overview(runs: Sequence[Run], file: Path) -> None:
    """Friction against velocity under every law with friction; each on its own axes, so that none squeezes others."""
    runs = [run for run in runs if np.any(run.columns[contact(run)[1]] != 0.0)]
    columns = 4
    rows = -(-len(runs) // columns)
    with plt.rc_context(STYLE):
        figure, grid = plt.subplots(rows, columns, figsize=(12, 2.7 * rows), squeeze=False, layout="constrained")
        for axis, run in zip(grid.flat, runs, strict=False):
            draw_friction(axis, run)
            axis.set_title(run.law)
            axis.xaxis.set_major_locator(MaxNLocator(4))
        for axis in list(grid.flat)[len(runs) :]:
            axis.set_visible(False)
        velocity, force = contact(runs[0])
        figure.supxlabel(runs[0].units.label("velocity", velocity), fontsize=9)
        figure.supylabel(runs[0].units.label("friction force", force), fontsize=9)
        for axis in grid.flat:
            axis.set(xlabel="", ylabel="")
        figure.suptitle(
            f"{runs[0].model}: friction force against velocity in the default experiment (dots: samples far apart)",
            fontsize=12,
            fontweight="bold",
        )
        save(figure, file)


def draw_panel(axis: Axes, run: Run, panel: dict[str, Any]) -> None:
    """The variables that share an axis; the last of them on top, in the first colour."""
    shade_sticking(axis, run)
    names = panel["curves"]
    for name, colour in zip(names, reversed(COLOURS[: len(names)]), strict=True):
        axis.plot(run.columns["time"], run.units.shown(run, name), color=colour, label=name)
    if len(names) > 1:
        axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(names), borderaxespad=0.0)
    axis.set_ylabel(run.units.label(panel["label"], names[0]))
    axis.margins(x=0)


def contact(run: Run) -> tuple[str, str]:
    """The velocity and the friction force to draw against each other."""
    return next(pair for pair in FRICTION if set(pair) <= run.columns.keys())


def draw_friction(axis: Axes, run: Run) -> None:
    names = contact(run)
    velocity, force = (run.units.shown(run, name) for name in names)
    axis.axhline(0, color=GREY, linewidth=0.6)
    axis.axvline(0, color=GREY, linewidth=0.6)
    draw_path(axis, velocity, force)
    axis.set_xlabel(run.units.label("velocity", names[0]))
    axis.set_ylabel(run.units.label("friction force", names[1]))


def draw_path(axis: Axes, x: np.ndarray, y: np.ndarray) -> None:
    """A line through samples, with dots where they are far apart: there the line is only a guide."""
    gaps = np.hypot(np.diff(x) / max(np.ptp(x), TINY), np.diff(y) / max(np.ptp(y), TINY))
    far = np.append(gaps > SPARSE, False) | np.append(False, gaps > SPARSE)
    axis.plot(x, y, color=GREEN, linewidth=0.5, alpha=0.4)
    axis.plot(np.where(far, np.nan, x), y, color=GREEN, linewidth=1.0)
    axis.plot(x[far], y[far], ".", color=GREEN, markersize=2.5)


def zoom(axis: Axes, run: Run) -> None:
    """Shows a twentieth of the speeds, where the mass starts and stops."""
    velocity, force = (run.units.shown(run, name) for name in contact(run))
    limit = np.max(np.abs(velocity)) / 20.0
    if limit > 0.0:
        for line in axis.lines[-3:]:
            line.remove()
        near = np.abs(velocity) <= limit
        axis.plot(velocity, force, color=GREEN, linewidth=0.5, alpha=0.4)
        axis.plot(velocity[near], force[near], ".", color=GREEN, markersize=2.5)
        inside = force[near]
        margin = 0.05 * max(np.ptp(inside), 1.0)
        axis.set_xlim(-limit, limit)
        axis.set_ylim(np.min(inside) - margin, np.max(inside) + margin)


def shade_sticking(axis: Axes, run: Run) -> None:
    """Marks the time during which the mass sticks."""
    if "sticking" not in run.columns:
        return
    times, sticking = run.columns["time"], run.columns["sticking"] > 0.5
    axis.fill_between(
        times, 0, 1, where=sticking, step="post", transform=axis.get_xaxis_transform(), color="#eceff3", linewidth=0
    )


def title(run: Run) -> str:
    text = f"{run.model}, friction law {run.law}" if run.law else run.model
    return f"{text} (shaded: sticking)" if np.any(run.columns.get("sticking", np.zeros(1)) > 0.5) else text


def save(figure: plt.Figure, file: Path) -> None:
    figure.savefig(file, metadata={"Software": None})
    plt.close(figure)

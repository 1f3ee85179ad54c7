"""Draws cost against error for every friction law: figure.py POINTS FIGURE."""

from __future__ import annotations

import csv
import sys
from collections import defaultdict
from pathlib import Path

import matplotlib.pyplot as plt

COLOURS = {
    "ours": "#0072b2",
    "cvode restarted": "#d55e00",
    "cvode free": "#e69f00",
    "bdf restarted": "#5b6876",
    "bdf free": "#a3adb8",
}
"""Drawn solvers; the other ways to use them lie between."""
NAMES = {"cvode": "CVODE", "bdf": "diffsol"}
"""Names of the solvers elsewhere."""
ERRORS = [
    ("position error in m", "largest error of the position (m)"),
    ("friction error in N", "rms error of the friction force (N)"),
]


def main(points: Path, figure: Path) -> None:
    curves: dict[str, dict[str, list[dict[str, str]]]] = defaultdict(lambda: defaultdict(list))
    with points.open(newline="") as file:
        for row in csv.DictReader(file):
            curves[row["law"]][row["solver"]].append(row)
    sheet, grid = plt.subplots(len(ERRORS), len(curves), figsize=(3 * len(curves), 6.4), sharey=True, squeeze=False)
    for axes, (column, label) in zip(grid, ERRORS, strict=True):
        for axis, (law, solvers) in zip(axes, curves.items(), strict=True):
            for solver in [name for name in COLOURS if name in solvers]:
                rows = solvers[solver]
                errors = [float(row[column]) for row in rows]
                costs = [float(row["nanoseconds per step"]) * 1e-3 for row in rows]
                axis.loglog(
                    errors, costs, "o-", markersize=3, linewidth=1.2, color=COLOURS[solver], label=shown(solver)
                )
            axis.set_title(law, loc="left", fontsize=10)
            axis.set_xlabel(label, fontsize=8)
            axis.grid(color="#e3e8ee", linewidth=0.7)
            axis.tick_params(labelsize=8)
        axes[0].set_ylabel("mean cost of a step of 1 ms (µs)", fontsize=8)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    sheet.legend(handles, labels, loc="lower center", ncols=len(labels), frameon=False)
    sheet.tight_layout(rect=(0, 0.05, 1, 1))
    sheet.savefig(figure, dpi=150, metadata={"Software": None})


def shown(solver: str) -> str:
    name, _, way = solver.partition(" ")
    return f"{NAMES.get(name, name)} {way}".strip()


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))

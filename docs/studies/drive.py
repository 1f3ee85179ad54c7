"""Runs the drive (cylinder and controller, `PneumaticServoDrive.ssp`) along its reference under each set of parameters.

Leaves a CSV per set and a figure of all in a folder named like the SSP.
"""

from __future__ import annotations

import argparse
import csv
import io
import sys
import zipfile
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pneumatic_servo as ps
from common import ROOT
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssv
from matplotlib.figure import Figure
from pneumatic_servo.figures import BLUE, GREEN, GREY, STYLE, VERMILION
from pneumatic_servo.files import write_csv

STEP = 1e-3
"""Communication step in s: the sample time of the controller."""

OUTPUTS = ["position", "velocity", "frictionForce", "pressureA", "pressureB", "sticking", "valveVoltage"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("ssp", type=Path, nargs="?", help="default: the package's")
    parser.add_argument("--output", type=Path, default=ROOT / "target" / "gallery", help="where that folder is made")
    arguments = parser.parse_args()
    ssp: Path = arguments.ssp or next(file for file in ps.fmus() if file.suffix == ".ssp")
    folder: Path = arguments.output / ssp.stem
    folder.mkdir(parents=True, exist_ok=True)
    runs = {name: simulate(ssp, name) for name in sets(ssp)}
    for name, columns in runs.items():
        write_csv(
            folder / f"{name}.csv", list(columns), zip(*(column.tolist() for column in columns.values()), strict=True)
        )
        error = columns["referencePosition"] - columns["position"]
        print(f"{name}: rms error {1e3 * np.sqrt(np.mean(error**2)):.2f} mm, {len(rests(columns))} rests")
    draw(runs, folder / f"{ssp.stem}.png")
    print(f"results and figure: {folder}")
    return 0


def sets(ssp: Path) -> list[str]:
    """The names of the sets of parameters in the SSP."""
    with zipfile.ZipFile(ssp) as archive:
        return [Path(name).stem for name in archive.namelist() if name.endswith(".ssv")]


def reference(ssp: Path) -> tuple[np.ndarray, np.ndarray]:
    """Times in s and positions in m between which the reference moves uniformly."""
    with zipfile.ZipFile(ssp) as archive:
        text = archive.read("resources/reference.csv").decode()
    rows = [(float(row["time"]), float(row["referencePosition"])) for row in csv.DictReader(io.StringIO(text))]
    times, positions = np.array(rows).T
    return times, positions


def simulate(ssp: Path, name: str) -> dict[str, np.ndarray]:
    """Follows the reference with a set of parameters; a column per connector of the system."""
    times, positions = reference(ssp)
    result = simulate_ssp(
        str(ssp),
        stop_time=times[-1],
        step_size=STEP,
        parameter_set=read_ssv(str(ssp), f"resources/{name}.ssv"),
        input={"referencePosition": lambda time: float(np.interp(time, times, positions))},
    )
    return {column: result[column] for column in ["time", "referencePosition", *OUTPUTS]}


def rests(columns: dict[str, np.ndarray], shortest: float = 0.05) -> list[float]:
    """Lengths in s of the times at rest while the reference moves, from `shortest` on."""
    moves = np.abs(np.gradient(columns["referencePosition"])) > 0.0
    still = np.concatenate([[False], (columns["velocity"] == 0.0) & moves, [False]])
    edges = np.flatnonzero(np.diff(still.astype(int)))
    lengths = (edges[1::2] - edges[::2]) * STEP
    return [float(length) for length in lengths if length >= shortest]


def draw(runs: dict[str, dict[str, np.ndarray]], file: Path) -> None:
    """One column per set: position and reference, error, friction force, voltage."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(12, 8), layout="constrained")
        grid = figure.subplots(4, len(runs), sharex=True, sharey="row", squeeze=False)
        for axes, (name, columns) in zip(grid.T, runs.items(), strict=True):
            time = columns["time"]
            position, error, force, voltage = axes
            position.set_title(name, fontweight="bold")
            position.plot(time, 1e3 * columns["referencePosition"], color=GREY, linewidth=0.9, label="reference")
            position.plot(time, 1e3 * columns["position"], color=BLUE, label="carriage")
            error.plot(time, 1e3 * (columns["referencePosition"] - columns["position"]), color=VERMILION)
            force.plot(time, columns["frictionForce"], color=GREEN, linewidth=0.9)
            voltage.plot(time, columns["valveVoltage"], color=GREY, linewidth=0.9)
            voltage.set_xlabel("time (s)")
        labels = ["position (mm)", "error (mm)", "friction force (N)", "valve voltage (V)"]
        for axis, label in zip(grid[:, 0], labels, strict=True):
            axis.set_ylabel(label)
        for axis in grid.flat:
            axis.margins(x=0)
        # FMPy starts all connectors at 0, so the first two samples are none of the drive's.
        grid[3, 0].set_ylim(3, 7)
        grid[0, 0].legend(loc="upper left")
        figure.align_ylabels(grid[:, 0])
        figure.suptitle("PneumaticServoDrive: a slow ramp with dry and with lubricated seals", fontsize=12)
        figure.savefig(file, metadata={"Software": None})


if __name__ == "__main__":
    sys.exit(main())

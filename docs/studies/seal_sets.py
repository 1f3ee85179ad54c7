"""The parameter sets of piston seals: fitted to published records, and shown against them.

Friction of five rings in a printed cylinder of 25 mm, measured by E. Zillen at TU Delft (2021, CC0 1.0, repository
EvaZillen/3D-printed-pneumatic-actuator). The records at 1, 3, 5 and 7 bar are fitted with `F = p*area + friction`, of
bristles whose limit grows with the pressure, `F0*(1 + kappa*p)`. They show no Stribeck peak: the interval of a Stribeck
velocity has no end. So static and Coulomb friction of the sets are alike.

The data are not part of this repository. Leaves a table (CSV) of the fits, which the sets are rounded from, and a
figure: friction over pressure, and force over position of one record under the set.

Usage: python docs/studies/seal_sets.py ../shared/data [--output target/studies]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pneumatic_servo as ps
from common import ROOT, parameter_set
from measured_data import RINGS, SEAL_COLUMNS
from numpy.typing import NDArray
from pneumatic_servo.figures import BLUE, GREY, STYLE, VERMILION, WIDTH, Drawing
from pneumatic_servo.files import write_csv

Array = NDArray[np.float64]

PRESSURES = (1, 3, 5, 7)
"""In bar above ambient."""
SHOWN = 3
"""Pressure in bar of the record that is drawn."""
PLAY = 0.4
"""Half of the play in mm that takes the jitter from the position for the drawing."""
LIMIT, STIFFNESS, GROWTH = "friction.dahl.Fc", "friction.dahl.sigma0", "friction.kappaA"
NAMES = {"friction.dahl.Fc": "friction.lugre.Fc", "friction.dahl.sigma0": "friction.lugre.sigma0"}
"""Without a peak LuGre is Dahl's law with a damping."""


def fitted(folder: Path, ring: str) -> ps.Fit:
    files = [folder / f"{ring}_{pressure}bar.csv" for pressure in PRESSURES]
    free = [LIMIT, STIFFNESS, GROWTH, "area"]
    return ps.fit(files, experiment="motion", law="Dahl", fit=free, columns=SEAL_COLUMNS, starts=0,
                  settings={"friction.dahl.sigma2": 0.0}, progress=False)  # fmt: skip


def alone(folder: Path, ring: str, pressure: int) -> float:
    """Return the friction in N of a record, by the mean of both directions: half of the width of its loop."""
    found = ps.fit(folder / f"{ring}_{pressure}bar.csv", experiment="motion", law="Coulomb", starts=0,
                   fit=["friction.coulomb.Fc", "area"], columns=SEAL_COLUMNS, progress=False,
                   settings={"friction.coulomb.sigma2": 0.0})  # fmt: skip
    return found.parameters["friction.coulomb.Fc"].value


def simulated(values: dict[str, ps.Value], time: Array, position: Array, pressure: Array) -> Array:
    """Return the friction in N of a set on the path of a record, its pressure in Pa above ambient."""
    own = {name: value for name, value in values.items() if name.startswith("friction.l")}
    level = 1.0 + float(values[GROWTH]) * pressure
    run = ps.Model("FrictionBench").simulate(
        {**own, "bench.drive": "PrescribedPosition"},
        inputs={"prescribedPosition": (time, position), "friction.level": (time, level)},
        stop=round(float(time[-1]), 2),
        step=0.01,
        outputs=["frictionForce"],
    )
    return np.interp(time, run["time"], run["frictionForce"])


def through_play(position: Array) -> Array:
    """Return a position in mm without the jitter of its sensor, which bristles would take for reversals."""
    found = np.empty_like(position)
    last = position[0]
    for place, here in enumerate(position):
        last = min(max(last, here - PLAY), here + PLAY)
        found[place] = last
    return found


def draw(sets: dict[str, dict[str, ps.Value]], measured: dict[str, list[float]], folder: Path, output: Path) -> None:
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 4.6), layout="constrained")
        rows = figure.subplots(2, len(sets), sharey="row")
        for (ring, values), above, below in zip(sets.items(), *rows, strict=True):
            line = np.linspace(0.5, 7.5, 20)
            limit, growth = float(values["friction.lugre.Fc"]), float(values[GROWTH])
            above.plot(line, limit * (1.0 + growth * 1e5 * line), color=BLUE, label="set")
            above.plot(PRESSURES, measured[ring], "o", ms=3, color=VERMILION, label="record")
            above.set(title=ring, xlabel="pressure (bar)", ylim=(0.0, 16.0))
            table = np.loadtxt(folder / f"{ring}_{SHOWN}bar.csv", delimiter=",", skiprows=16)
            begun = table[:, 0] - table[0, 0]
            table = table[begun < begun[-1] / 5.0]
            time, position, pressure, force = table.T
            friction = simulated(values, time - time[0], 1e-3 * through_play(position), 1e5 * pressure)
            area = np.mean((force - friction) / (1e5 * pressure))
            settled = slice(np.argmax(time > time[0] + 0.5), None)
            below.plot(position, force - 1e5 * pressure * area, color=GREY, lw=1.0, label="record")
            below.plot(position[settled], friction[settled], color=BLUE, lw=1.0, label="set")
            below.set(xlabel="position (mm)", ylim=(-12.0, 12.0))
        rows[0][0].set_ylabel("friction (N)")
        rows[1][0].set_ylabel(f"friction at {SHOWN} bar (N)")
        for row in rows:
            row[-1].legend(fontsize=6, loc="upper left")
        figure.savefig(output / "SealSets.png", metadata={"Software": None})


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, help="folder of the measurements")
    parser.add_argument("--output", type=Path, default=ROOT / "target" / "studies", help="folder of table and figure")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    folder = options.data / "seals"
    sets = {ring: parameter_set("Seal" + ring.replace("-", "").replace("Oring", "ORing")) for ring in RINGS}
    rows, measured = [], {}
    for ring, values in sets.items():
        found = fitted(folder, ring)
        for name in (LIMIT, STIFFNESS, GROWTH):
            one = found.parameters[name]
            shared = NAMES.get(name, name)
            rows.append((ring, shared, *(f"{end:.4g}" for end in (one.value, one.low, one.high)), values[shared]))
            print(*rows[-1])
        measured[ring] = [alone(folder, ring, pressure) for pressure in PRESSURES]
        print(ring, *(f"{one:.2f} N" for one in measured[ring]))
    write_csv(options.output / "seal_sets.csv", ["ring", "parameter", "value", "low", "high", "set"], rows)
    draw(sets, measured, folder, options.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Fits to what others have measured: pneumatic seals, and a contact that slides back and forth.

The data are not part of this repository; docs/identification/validation.md says where they are from. Their folder has
seals/RING_PRESSUREbar.csv (time_s, position_mm, pressure_bar, force_N) and presliding/tribometer.csv (time_s,
normal_force_N, position_mm, friction_force_N).

Usage: python docs/studies/measured_data.py ../shared/data [--output target/studies]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pneumatic_servo as ps
from matplotlib.figure import Figure
from numpy.typing import NDArray
from pneumatic_servo.figures import BLUE, GREY, STYLE, VERMILION, WIDTH, Drawing
from pneumatic_servo.files import write_csv
from tqdm import tqdm

Array = NDArray[np.float64]

ROOT = Path(__file__).resolve().parents[2]
RINGS = ("O-ring", "NAPN", "NAP310", "PK", "KDN")
FITTED, PREDICTED = (1, 3, 5), 7
"""Pressures in bar that a seal is fitted at, and the one that is predicted."""
SEAL_COLUMNS = "time=time_s,position=position_mm[mm],pressure=pressure_bar[bar],force=force_N"
SHOWN = 130
"""Samples of the tribometer in its figure: three strokes at the default interval."""
LOADED = 204.0
"""Time in s from which the tribometer is unloaded."""
WITH_MEMORY = ("MaxwellSlip", "GMS", "Leuven", "ElastoPlastic", "StickSlipCreep", "StickSlipSpring", "LuGre",
               "BlimanSorine", "ResetIntegrator", "Dahl", "Armstrong", "Bristle", "DNLRX", "RevisedLuGre")  # fmt: skip
OF_LAW: dict[str, dict[str, ps.Value]] = {
    "MaxwellSlip": {"friction.maxwellSlip.N": 4},
    "GMS": {"friction.gms.N": 4},
    "DNLRX": {"friction.dnlrx.N": 4, "friction.dnlrx.Ts": 0.005},
}
"""Four elements each; DNLRX takes its samples as often as the tribometer."""


@dataclass(frozen=True)
class Seal:
    """A ring: its fit to the lower pressures, and friction at each pressure as fitted to that alone."""

    ring: str
    fit: ps.Fit
    measured: dict[int, ps.Estimate]

    @property
    def predicted(self) -> tuple[float, float, float]:
        """Friction at the highest pressure as the others tell it."""
        return level(self.fit, 1e5 * PREDICTED)


def seal(folder: Path, ring: str) -> Seal:
    """Fit `F = p*area + F0*(1 + kappa*p)*sign(v)`."""
    files = {pressure: folder / f"{ring}_{pressure}bar.csv" for pressure in (*FITTED, PREDICTED)}
    together = [files[pressure] for pressure in FITTED]
    found = friction(together, "friction.coulomb.Fc,friction.kappaA,area", [files[PREDICTED]])
    alone = {pressure: friction([file], "friction.coulomb.Fc,area") for pressure, file in files.items()}
    levels = {pressure: one.parameters["friction.coulomb.Fc"] for pressure, one in alone.items()}
    return Seal(ring, found, levels)


def left_out(folder: Path, ring: str) -> ps.CrossValidation:
    """Leave out each pressure in turn, and predict it by the same law from the three others."""
    files = [folder / f"{ring}_{pressure}bar.csv" for pressure in (*FITTED, PREDICTED)]
    found = friction(files, "friction.coulomb.Fc,friction.kappaA,area", by="pressure")
    assert found.cross_validation is not None
    return found.cross_validation


def friction(files: Sequence[Path], free: str, predicted: Sequence[Path] = (), by: str = "") -> ps.Fit:
    """Coulomb friction of records, without a viscous part, which such speeds do not show."""
    return ps.fit(list(files), experiment="motion", law="Coulomb", fit=free, columns=SEAL_COLUMNS, starts=0,
                  settings={"friction.coulomb.sigma2": 0.0}, validation_data=list(predicted),
                  cross_validate=by)  # fmt: skip


def level(found: ps.Fit, pressure: float) -> tuple[float, float, float]:
    """Friction in N at a pressure in Pa above ambient, with the ends of its interval of 95 %."""
    base, kappa = found.parameters["friction.coulomb.Fc"], found.parameters["friction.kappaA"]
    value = base.value * (1.0 + kappa.value * pressure)
    halves = np.array([
        0.5 * np.log(base.high / base.low), 0.5 * (kappa.high - kappa.low) * pressure / (1.0 + kappa.value * pressure)
    ])  # fmt: skip
    correlation = found.certainty.correlation[0, 1]
    half = float(np.sqrt(halves @ np.array([[1.0, correlation], [correlation, 1.0]]) @ halves))
    return value, value * np.exp(-half), value * np.exp(half)


def draw_seals(seals: Sequence[Seal]) -> Figure:
    """Friction over pressure: the line that is fitted, and what each record says alone."""
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 2.6), layout="constrained")
        axes = figure.subplots(1, len(seals), sharey=True)
        for axis, one in zip(axes, seals, strict=True):
            pressures = np.linspace(0.5, 7.5, 30)
            bands = np.array([level(one.fit, 1e5 * pressure) for pressure in pressures])
            axis.plot(pressures, bands[:, 0], color=BLUE, label="fitted at 1, 3, 5 bar")
            axis.fill_between(pressures, bands[:, 1], bands[:, 2], color=BLUE, alpha=0.2, lw=0)
            for pressure, estimate in one.measured.items():
                axis.plot(pressure, estimate.value, "o", ms=3, color=GREY if pressure in FITTED else VERMILION)
            axis.plot([], [], "o", ms=3, color=VERMILION, label="measured at 7 bar")
            axis.set(title=one.ring, xlabel="pressure (bar)", xlim=(0.0, 8.0), ylim=(0.0, 16.0))
        axes[0].set_ylabel("friction (N)")
        axes[-1].legend(fontsize=6, loc="upper left")
    return figure


def tribometer(file: Path, every: int) -> dict[str, Array]:
    """The record until it is unloaded, at an interval of samples of 5 ms, with the signs of this library."""
    rows = np.loadtxt(file, delimiter=",", skiprows=1)
    rows = rows[rows[:, 0] < LOADED][::every]
    return {"time": rows[:, 0], "normalForce": rows[:, 1], "position": 1e-3 * rows[:, 2], "frictionForce": -rows[:, 3]}


def ranking(data: dict[str, Array], laws: Sequence[str]) -> list[ps.Fit]:
    """Fits of laws to the first half, the best prediction of the second half first."""
    fits = []
    for law in tqdm(laws, disable=None):
        one = ps.compare_fits(data, [law], experiment="motion", fit="offset.frictionForce",
                              settings_of={law: OF_LAW[law]} if law in OF_LAW else None,
                              validation=0.5, rated=5.0, starts=0)  # fmt: skip
        fits.append(one.best)
    return sorted(fits, key=lambda found: found.validation_rms["frictionForce"])


def draw_tribometer(fits: Sequence[ps.Fit], laws: Sequence[str]) -> Figure:
    """Force over position at the end of the half that was not fitted: measured, and predicted by a law each.

    Laws that were not fitted are left out; where none of them was, the four best are drawn.
    """
    chosen = [found for law in laws for found in fits if found.law == law] or list(fits[:4])
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 2.6), layout="constrained")
        axes = figure.subplots(1, len(chosen), sharey=True, squeeze=False)[0]
        for axis, found in zip(axes, chosen, strict=True):
            [window], [difference] = found.problem.windows, found.problem.differences(found.x)
            end = slice(-SHOWN, None)
            force = window.record.signals["frictionForce"]
            place = 1e3 * (window.record.signals["position"] - window.record.signals["position"].mean())
            axis.plot(place[end], force[end], color=GREY, lw=2.5)
            axis.plot(place[end], (force - difference["frictionForce"])[end], color=BLUE, lw=1.0)
            axis.set(title=f"{found.law}: {found.validation_rms['frictionForce']:.3f} N", xlabel="position (mm)")
        axes[0].set_ylabel("friction (N)")
        axes[0].plot([], [], color=GREY, lw=2.5, label="measured")
        axes[0].plot([], [], color=BLUE, lw=1.0, label="predicted")
        axes[0].legend(fontsize=6, loc="upper left")
    return figure


def numbers(parts: Sequence[float], digits: int) -> list[str]:
    """Numbers as text."""
    return [f"{part:.{digits}f}" for part in parts]


def write_seals(seals: Sequence[Seal], output: Path) -> None:
    """Write table and figure of the seals."""
    head = ["ring", "F0 (N)", "low", "high", "kappa (1/MPa)", "low", "high", "area (mm2)", "low", "high", "rms (N)",
            "friction predicted at 7 bar (N)", "low", "high", "measured (N)", "low", "high"]  # fmt: skip
    rows = []
    for one in seals:
        cells = [one.ring]
        for name, factor in (("friction.coulomb.Fc", 1.0), ("friction.kappaA", 1e6), ("area", 1e6)):
            estimate = one.fit.parameters[name]
            cells += numbers([factor * end for end in (estimate.value, estimate.low, estimate.high)], 3)
        alone = one.measured[PREDICTED]
        measured = (alone.value, alone.low, alone.high)
        rows.append([*cells, f"{one.fit.rms['force']:.2f}", *numbers(one.predicted, 2), *numbers(measured, 2)])
        print(*rows[-1])
    write_csv(output / "seals.csv", head, rows)
    draw_seals(seals).savefig(output / "seals.png", metadata={"Software": None})


def write_left_out(rings: dict[str, ps.CrossValidation], output: Path) -> None:
    """Write the table of each pressure of each ring as the three others predict it."""
    head = ["ring", "pressure left out (bar)", "friction predicted (N)", "low", "high", "measured (N)", "low", "high",
            "rms predicted (N)", "rms fitted along (N)", "within"]  # fmt: skip
    rows = []
    for ring, found in rings.items():
        for case in found.cases:
            told = case.friction
            assert told is not None
            predicted = (told.predicted, told.low, told.high, told.measured, told.measured_low, told.measured_high)
            left = (case.rms["force"], case.fitted["force"])
            rows.append([ring, f"{1e-5 * case.condition.value:.1f}", *numbers(predicted, 2), *numbers(left, 2),
                         "yes" if told.is_within else "no"])  # fmt: skip
            print(*rows[-1])
    print(sum(row[-1] == "yes" for row in rows), "of", len(rows), "within")
    write_csv(output / "seals_left_out.csv", head, rows)


def write_tribometer(fits: Sequence[ps.Fit], output: Path) -> None:
    """Write table and figure of the tribometer."""
    rows = [
        (found.law, len(found.parameters), f"{found.rms['frictionForce']:.3f}",
         f"{found.validation_rms['frictionForce']:.3f}", "yes" if found.converged else "no")
        for found in fits
    ]  # fmt: skip
    for row in rows:
        print(*row)
    head = ["law", "free parameters", "rms of the first half (N)", "rms of the second half (N)", "converged"]
    write_csv(output / "tribometer.csv", head, rows)
    draw_tribometer(fits, ("DNLRX", "MaxwellSlip", "Leuven", "LuGre")).savefig(
        output / "tribometer.png", metadata={"Software": None}
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, help="folder of the measurements")
    parser.add_argument("--output", type=Path, default=ROOT / "target" / "studies", help="folder of tables and figures")
    parser.add_argument("--laws", nargs="+", default=list(WITH_MEMORY), help="laws for the tribometer")
    parser.add_argument("--every", type=int, default=20, help="interval of the used samples of the tribometer")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    write_seals([seal(options.data / "seals", ring) for ring in tqdm(RINGS, disable=None)], options.output)
    rings = {ring: left_out(options.data / "seals", ring) for ring in tqdm(RINGS, disable=None)}
    write_left_out(rings, options.output)
    data = tribometer(options.data / "presliding" / "tribometer.csv", options.every)
    write_tribometer(ranking(data, options.laws), options.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())

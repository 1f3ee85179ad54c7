"""Progression, bifurcations and basins of attraction of the vibro-impact system.

Leaves three figures and prints the numbers behind them:

- progression of the body in 3 s over static friction and force ratio, with the border between forward and backward;
- the Poincare map of the relative velocity over friction, 200 cycles after 100 that are dropped, and the progression;
- which attractor a start on the plane of relative position and velocity leads to.

Usage: python docs/studies/vibro_impact.py [--small]
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass

import numpy as np
from common import Plant, arguments, parallel, parameter_set, plt, save
from pneumatic_servo import figures

FREQUENCY = 15.0
DURATION = 3.0
"""Time in s after which the progression is read."""

BORDER = (0.71085, 1.10532, -0.0168)
"""Amplitude in N on the published border between forward and backward motion: coefficients of 1, F_s, F_s^2."""

PUBLISHED_LEVELS = (2.3, 6.8, 13.6)
PUBLISHED_RATIOS = (0.59, 0.79, 0.99, 1.19)

DROPPED, KEPT = 100, 200
"""Cycles of the Poincare map."""

DIAGRAMS = ((0.5, 1.56), (0.5, 1.0), (1.0, 1.0), (1.5, 1.0))
"""Amplitude and frequency of the bifurcation diagrams, dimensionless."""

BASINS = ((1.0, 0.1), (1.5, 0.95), (1.5, 1.06))
"""Amplitude and friction of the basins at the frequency 1: two that are published, and one with irregular motion."""

SYSTEM = parameter_set("Bifurcations")
"""The dimensionless system of the bifurcations and basins."""

SAME = 2e-3
"""Points of the map that are closer count as one, dimensionless."""


def main() -> int:
    options = arguments(__doc__ or "")
    study_progression(options)
    study_bifurcations(options)
    study_basins(options)
    print(f"figures: {options.output}")
    return 0


# Progression


def progression(point: tuple[float, float]) -> float:
    """Path of the body in m at a static friction in N and a force ratio."""
    level, ratio = point
    plant = Plant(
        "VibroImpact", {"friction.Fs": level, "excitation.amplitude": ratio * level, "excitation.frequency": FREQUENCY}
    )
    plant.advance(DURATION)
    return plant.get(["position"])[0]


def study_progression(options: argparse.Namespace) -> None:
    levels = np.linspace(2.0, 14.0, 4 if options.small else 49)
    ratios = np.linspace(0.5, 1.5, 4 if options.small else 41)
    grid = [(level, ratio) for ratio in ratios for level in levels]
    published = [(level, ratio) for level in PUBLISHED_LEVELS for ratio in PUBLISHED_RATIOS]
    paths = 1e3 * np.array(parallel(options, "progression", progression, [*grid, *published]))
    print("progression in 3 s (mm) at F_s (rows) and force ratio " + ", ".join(map(str, PUBLISHED_RATIOS)))
    for level, row in zip(PUBLISHED_LEVELS, paths[len(grid) :].reshape(3, 4), strict=True):
        print(f"  {level:5.1f} N: " + "  ".join(f"{path:7.2f}" for path in row))
    with plt.rc_context(figures.STYLE):
        figure, axis = plt.subplots(figsize=(7, 4.5), layout="constrained")
        surface = paths[: len(grid)].reshape(len(ratios), len(levels))
        limit = 5.0 * np.ceil(np.max(np.abs(surface)) / 5.0)
        filled = axis.contourf(levels, ratios, surface, np.linspace(-limit, limit, 21), cmap="RdBu")
        axis.contour(levels, ratios, surface, [0.0], colors="black", linestyles="dashed")
        border = (BORDER[0] + BORDER[1] * levels + BORDER[2] * levels**2) / levels
        axis.plot(levels, border, color=figures.GREEN, linewidth=2, label="published border (fit of simulations)")
        axis.plot(*np.array(published).T, "k+", label="published experiments")
        axis.set(xlabel="static friction $F_s$ (N)", ylabel="force ratio $A/F_s$", ylim=(ratios[0], ratios[-1]))
        axis.set_title("progression of the body in 3 s; dashed: neither forward nor backward")
        figure.legend(loc="outside lower center", ncols=2)
        figure.colorbar(filled, label="progression (mm)", ticks=np.linspace(-limit, limit, 5))
        save(figure, options.output / "VibroImpact_progression.png")


# Bifurcations


@dataclass(frozen=True)
class Drive:
    """A dimensionless system."""

    amplitude: float
    frequency: float
    friction: float
    displacement: float = 0.0
    rate: float = 0.0

    def start(self) -> dict[str, float | str]:
        return {
            **SYSTEM,
            "dimensionless.chi": self.amplitude,
            "dimensionless.omega": self.frequency,
            "dimensionless.fr": self.friction,
            "displacement0": self.displacement,
            "displacementRate0": self.rate,
        }

    @property
    def cycle(self) -> float:
        return 2.0 * math.pi / self.frequency


def poincare(drive: Drive, dropped: int = DROPPED, kept: int = KEPT) -> np.ndarray:
    """Rows of displacement and its rate at the end of each cycle."""
    plant = Plant("VibroImpact", drive.start())
    plant.advance(dropped * drive.cycle)
    rows = np.empty((kept, 2))
    for index in range(kept):
        plant.advance((dropped + index + 1) * drive.cycle)
        rows[index] = plant.get(["displacement", "displacementRate"])
    return rows


def bifurcation(drive: Drive) -> tuple[np.ndarray, float]:
    """The map of the relative velocity, and the path of the body in the time 100."""
    rates = poincare(drive)[:, 1]
    plant = Plant("VibroImpact", drive.start())
    plant.advance(100.0)
    return rates, plant.get(["position"])[0]


def period(points: np.ndarray) -> int:
    """After how many points a map repeats; 0 if it does not within 8."""
    for candidate in range(1, 9):
        if np.max(np.abs(points[candidate:] - points[:-candidate])) < SAME:
            return candidate
    return 0


def study_bifurcations(options: argparse.Namespace) -> None:
    frictions = np.linspace(0.02, 2.0, 4 if options.small else 199)
    drives = [Drive(*diagram, friction) for diagram in DIAGRAMS for friction in frictions]
    results = parallel(options, "bifurcations", bifurcation, drives)
    with plt.rc_context(figures.STYLE):
        figure, axes = plt.subplots(2, len(DIAGRAMS), figsize=(13, 5.5), sharex=True, layout="constrained")
        for column, (amplitude, frequency) in enumerate(DIAGRAMS):
            own = results[column * len(frictions) : (column + 1) * len(frictions)]
            for friction, (rates, _) in zip(frictions, own, strict=True):
                axes[0, column].plot(np.full(rates.shape, friction), rates, ".", markersize=1.5, color=figures.BLUE)
            axes[0, column].set_title(rf"$\chi$ = {amplitude}, $\omega$ = {frequency}")
            axes[1, column].axhline(0.0, color=figures.GREY, linewidth=0.6)
            axes[1, column].plot(frictions, [path for _, path in own], color=figures.VERMILION)
            axes[1, column].set_xlabel("friction $f_r$")
            describe(amplitude, frequency, frictions, own)
        axes[0, 0].set_ylabel("relative velocity, once per cycle")
        axes[1, 0].set_ylabel(r"progression in $\tau$ = 100")
        save(figure, options.output / "VibroImpact_bifurcation.png")


def describe(
    amplitude: float, frequency: float, frictions: np.ndarray, results: list[tuple[np.ndarray, float]]
) -> None:
    """Prints the directions and periods that occur."""
    paths = np.array([path for _, path in results])
    periods = [period(rates) for rates, _ in results]
    kinds = [(f"period {p}" if p else "irregular", periods.count(p)) for p in sorted(set(periods))]
    counts = ", ".join(f"{kind}: {count}" for kind, count in kinds)
    turns = [f"{f:.2f}" for f, turn in zip(frictions[1:], np.diff(np.sign(paths)), strict=True) if turn]
    print(
        f"chi = {amplitude}, omega = {frequency}: direction changes at f_r = {', '.join(turns) or 'none'}; "
        f"fastest forward at {frictions[np.argmax(paths)]:.2f}; {counts}"
    )


# Basins


def attractor(drive: Drive) -> tuple[int, np.ndarray]:
    """Period of the map in the end, and its points."""
    points = poincare(drive, DROPPED, 24)
    return period(points), points


def study_basins(options: argparse.Namespace) -> None:
    size = 4 if options.small else 61
    displacements, rates = np.linspace(-0.4, 0.1, size), np.linspace(-0.5, 1.0, size)
    starts = [(d, v) for v in rates for d in displacements]
    drives = [Drive(amplitude, 1.0, friction, *start) for amplitude, friction in BASINS for start in starts]
    results = parallel(options, "basins", attractor, drives)
    with plt.rc_context(figures.STYLE):
        figure, axes = plt.subplots(1, len(BASINS), figsize=(13, 4.4), layout="constrained")
        for column, (amplitude, friction) in enumerate(BASINS):
            own = results[column * len(starts) : (column + 1) * len(starts)]
            kinds, members = classify(own)
            axis = axes[column]
            image = np.array(members).reshape(size, size)
            axis.imshow(
                image, origin="lower", extent=(-0.4, 0.1, -0.5, 1.0), aspect="auto", cmap="Set3", vmin=0, vmax=11
            )
            for number, (repeat, points) in enumerate(kinds):
                name = f"period {repeat}" if repeat else "irregular"
                share = members.count(number) / len(members)
                axis.plot(*points.T, "o" if repeat else ".", markersize=4, label=f"{name}: {100.0 * share:.0f} %")
                print(f"chi = {amplitude}, f_r = {friction}: {name}, {100.0 * share:.1f} % of the starts")
            axis.grid(visible=False)
            axis.set(title=rf"$\chi$ = {amplitude}, $\omega$ = 1, $f_r$ = {friction}", xlabel="relative position")
            # Below the axes, where it hides no part of a basin.
            axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=len(kinds))
        axes[0].set_ylabel("relative velocity")
        save(figure, options.output / "VibroImpact_basins.png")


def classify(results: list[tuple[int, np.ndarray]]) -> tuple[list[tuple[int, np.ndarray]], list[int]]:
    """The different attractors, and the number of each start's. All irregular motions count as one."""
    kinds: list[tuple[int, np.ndarray]] = []
    members = []
    for repeat, points in results:
        own = points[:repeat] if repeat else points
        for number, (other, known) in enumerate(kinds):
            if repeat == other and (repeat == 0 or np.min(np.max(np.abs(known - own[0]), axis=1)) < 5.0 * SAME):
                members.append(number)
                break
        else:
            members.append(len(kinds))
            kinds.append((repeat, own))
    return kinds, members


if __name__ == "__main__":
    sys.exit(main())

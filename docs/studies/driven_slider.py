"""The slider on the shaken tray: laws, convolution and random walk over one period, and over the tray's acceleration.

Leaves two figures and a table:

- velocities over one period, averaged over 18: tray, stick-free attractor, walk, and friction laws;
- amplitude and phase of the slider over the acceleration of the tray: onset, stick-slip, and the stick-free limit.

Usage: python docs/studies/driven_slider.py [--small]
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from dataclasses import dataclass

import numpy as np
from common import Plant, arguments, parallel, plt, save
from pneumatic_servo import figures

GRAVITY = 9.80665
FREQUENCY = 20.0
W = 2.0 * math.pi * FREQUENCY
MU_DYNAMIC, MU_STATIC = 0.32, 0.4
PERIODS = 18
"""Periods over which the published velocities are averaged."""

FORGET = 40
"""Periods that are dropped first."""

SAMPLES = 200
"""Samples per period."""

LAWS = ["Coulomb", "CoulombStiction", "Stribeck", "Karnopp", "Dahl", "ElastoPlastic", "GMS", "StribeckRegularised"]
FLIGHT_FACTORS = (1.0, 3.5)
"""Flight times in units of v_d/(mu_dyn g): by definition, and such that the phase of the attractor is three times as
large, which the source used."""


@dataclass(frozen=True)
class Shake:
    """A run: law, acceleration of the tray in g, flight factor of the stick-free attractor, seed of the walk."""

    law: str
    acceleration: float
    flight_factor: float = 1.0
    seed: int = 1


@dataclass(frozen=True)
class Course:
    """Velocities in m/s over one period, averaged over 18, and the walk in each of them."""

    slider: np.ndarray
    walk: np.ndarray
    tray: np.ndarray
    stick_free: np.ndarray
    walks: np.ndarray


def course(shake: Shake) -> Course:
    plant = Plant(
        "DrivenSlider",
        {
            "friction.law": shake.law,
            "muStatic": MU_STATIC,
            "muDynamic": MU_DYNAMIC,
            "tray.velocityAmplitude": shake.acceleration * GRAVITY / W,
            "walk.flightFactor": shake.flight_factor,
            "walk.seed": shake.seed,
        },
    )
    plant.advance(FORGET / FREQUENCY)
    names = ["velocity", "walk.velocity", "tray.velocity", "walk.stickFreeVelocity"]
    rows = np.empty((PERIODS * SAMPLES, len(names)))
    for index in range(len(rows)):
        rows[index] = plant.get(names)
        plant.advance((FORGET + (index + 1) / SAMPLES) / FREQUENCY)
    periods = rows.reshape(PERIODS, SAMPLES, len(names))
    return Course(*periods.mean(axis=0).T, walks=periods[:, :, 1])


def fundamental(velocity: np.ndarray) -> tuple[float, float]:
    """Amplitude in m/s, and delay behind the tray in degrees, of the first harmonic."""
    phase = 2.0 * np.pi * np.arange(len(velocity)) / len(velocity)
    value = 2.0 * np.mean(velocity * np.exp(1j * phase))
    return abs(value), math.degrees(np.angle(value))


def main() -> int:
    options = arguments(__doc__ or "")
    study_period(options)
    study_acceleration(options)
    print(f"figures and table: {options.output}")
    return 0


def study_period(options: argparse.Namespace) -> None:
    acceleration = 0.45
    laws = LAWS[:2] if options.small else LAWS
    shakes = [Shake(law, acceleration) for law in laws]
    shakes += [Shake("CoulombStiction", acceleration, factor) for factor in FLIGHT_FACTORS]
    courses = parallel(options, "one period", course, shakes)
    rows = []
    for law, own in zip(laws, courses, strict=False):
        rows.append([law, *fundamental(own.slider), rms(own.slider, courses[-1].walk)])
    for factor, own in zip(FLIGHT_FACTORS, courses[len(laws) :], strict=True):
        rows.append([f"stick-free attractor, flight factor {factor}", *fundamental(own.stick_free), math.nan])
        rows.append([f"walk, flight factor {factor}", *fundamental(own.walk), rms(own.walk, courses[-1].walk)])
    write(options, rows)
    spread = 1e3 * courses[-1].walks.std(axis=0).mean()
    print(f"the walk differs from period to period by {spread:.2f} mm/s (standard deviation)")
    with plt.rc_context(figures.STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(11, 4.2), sharey=True, layout="constrained")
        time = 1e3 * np.arange(SAMPLES) / SAMPLES / FREQUENCY
        for axis, factor, own in zip(axes, FLIGHT_FACTORS, courses[len(laws) :], strict=True):
            axis.plot(time, 1e3 * own.tray, color=figures.GREY, label="tray")
            axis.plot(time, 1e3 * own.stick_free, color=figures.GREY, linestyle="dashed", label="stick-free attractor")
            axis.plot(time, 1e3 * own.walk, color=figures.VERMILION, label=f"walk, mean of {PERIODS} periods")
            axis.plot(time, 1e3 * own.slider, color=figures.BLUE, label="law CoulombStiction")
            axis.set(title=f"flight factor {factor}", xlabel="time (ms)")
            axis.margins(x=0)
        axes[0].set_ylabel("velocity (mm/s)")
        axes[0].legend()
        save(figure, options.output / "DrivenSlider_period.png")


def rms(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.sqrt(np.mean((one - other) ** 2)))


def write(options: argparse.Namespace, rows: list[list[str | float]]) -> None:
    header = ["velocity of", "amplitude (mm/s)", "delay (deg)", "apart from the walk (mm/s rms)"]
    scaled = [(name, 1e3 * amplitude, delay, 1e3 * apart) for name, amplitude, delay, apart in rows]
    with (options.output / "DrivenSlider_period.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        # The attractor alone is not compared with the walk: an empty cell.
        writer.writerows([*row[:3], "" if math.isnan(row[3]) else row[3]] for row in scaled)
    for name, amplitude, delay, apart in scaled:
        from_walk = "" if math.isnan(apart) else f", {apart:5.2f} mm/s from the walk"
        print(f"  {name:40} {amplitude:6.2f} mm/s, {delay:5.1f} deg behind the tray{from_walk}")


def study_acceleration(options: argparse.Namespace) -> None:
    accelerations = np.linspace(0.2, 1.2, 5 if options.small else 101)
    kinds = [("Coulomb", figures.GREEN), ("CoulombStiction", figures.BLUE)]
    shakes = [Shake(law, acceleration) for law, _ in kinds for acceleration in accelerations]
    courses = parallel(options, "accelerations", course, shakes)
    with plt.rc_context(figures.STYLE):
        figure, axes = plt.subplots(2, 1, figsize=(8, 6), sharex=True, layout="constrained")
        for number, (law, colour) in enumerate(kinds):
            own = courses[number * len(accelerations) : (number + 1) * len(accelerations)]
            draw(axes, accelerations, [course.slider for course in own], colour, f"law {law}")
        draw(axes, accelerations, [course.walk for course in own], figures.VERMILION, "walk")
        draw(axes, accelerations, [course.stick_free for course in own], figures.GREY, "stick-free attractor")
        triangle = math.sqrt(1.0 + math.pi**2 / 4.0)
        for axis in axes:
            for place in (MU_DYNAMIC, MU_STATIC, MU_DYNAMIC * triangle):
                axis.axvline(place, color="#b0b8c0", linewidth=0.8, linestyle="dotted")
        axes[0].set(ylabel="amplitude / tray's amplitude", title="first harmonic of the slider's velocity")
        axes[1].set(ylabel="delay (deg)", xlabel="largest acceleration of the tray (g)")
        axes[0].legend()
        save(figure, options.output / "DrivenSlider_acceleration.png")


def draw(axes: np.ndarray, accelerations: np.ndarray, velocities: list[np.ndarray], colour: str, label: str) -> None:
    harmonics = np.array([fundamental(velocity) for velocity in velocities])
    axes[0].plot(accelerations, harmonics[:, 0] / (accelerations * GRAVITY / W), color=colour, label=label)
    axes[1].plot(accelerations, harmonics[:, 1], color=colour)


if __name__ == "__main__":
    sys.exit(main())

"""What the lubricant film of the law RevisedLuGre does: friction over velocity over frequency, and after a rest.

Leaves a figure and tables (CSV): loops of friction over a velocity of 0.05 +- 0.04 m/s, their area and the velocity up
to which they reach over the frequency, beside LuGre and the fluid inertia that the law leaves out; break-away after
rests.

Tran and Yanada (2013), Dynamic friction behaviors of pneumatic cylinders, Intelligent Control and Automation 4(2),
found on three cylinders that the loop reaches to higher velocities as the frequency grows, and that friction is nearly
linear in the velocity beyond it.

Usage: python docs/studies/film.py [--small]
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass

import numpy as np
import pneumatic_servo as ps
from common import arguments, parallel, plt, save
from numpy.typing import NDArray
from pneumatic_servo import figures
from pneumatic_servo.files import write_csv

Array = NDArray[np.float64]

MEAN, SWING = 0.05, 0.04
"""Of the velocity in m/s."""
SAMPLES = 2000
"""Of a period."""
SETTLING = 6.0
"""Time in s before the loop, at least; the film shrinks with a time constant of 1 s."""
WIDTH = 0.02
"""In N; where the rising and the falling branch are closer, the loop has ended."""
INERTIA = 1e-3
"""Time `T` in s of a fluid inertia `sigma2*(v + T*dv/dt)`, for example."""
SLOW = 1e-3
"""Velocity in m/s at which the contact is pulled after a rest."""
COLORS = (figures.GREEN, figures.BLUE, figures.VERMILION)
LOOPS = (0.02, 0.13, 1.0)
"""In Hz."""

GROUP = "friction.revisedLuGre."
VALUES = {
    name.removeprefix(GROUP): float(own.default or 0.0)
    for name, own in ps.Model("FrictionBench").parameters.items()
    if name.startswith(GROUP)
}


@dataclass(frozen=True)
class Shake:
    """A law, and the frequency of the velocity in Hz."""

    law: str
    frequency: float


def loop(shake: Shake) -> Array:
    """Return a period's rows of velocity in m/s and friction in N, the velocity rising from its mean."""
    lead = math.ceil(SETTLING * shake.frequency)
    time = np.arange((lead + 1) * SAMPLES + 1) / SAMPLES / shake.frequency
    velocity = MEAN + SWING * np.sin(2.0 * np.pi * shake.frequency * time)
    run = ps.Model("FrictionBench").simulate(
        {"friction.law": shake.law, "bench.drive": "PrescribedMotion"},
        inputs={"driveVelocity": (time, velocity)},
        stop=time[-1],
        step=time[1],
        outputs=["velocity", "frictionForce"],
    )
    return np.column_stack([run["velocity"], run["frictionForce"]])[-SAMPLES - 1 :]


def area(rows: Array) -> float:
    """Return the area in N.m/s that a loop encloses, above 0 where friction is higher while the velocity rises."""
    velocity, force = rows.T
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(velocity)))


def reach(rows: Array) -> float:
    """Return the velocity in m/s up to which both branches of a loop are apart."""
    quarter = SAMPLES // 4
    rising = np.concatenate([rows[3 * quarter : -1], rows[: quarter + 1]])
    falling = rows[quarter : 3 * quarter + 1][::-1]
    apart = np.abs(np.interp(rising[:, 0], falling[:, 0], falling[:, 1]) - rising[:, 1]) > WIDTH
    return float(rising[apart, 0].max()) if np.any(apart) else MEAN - SWING


def break_away(rest: float) -> tuple[float, float]:
    """Return the highest friction in N at the end of a rest in s, and what is left of the film at its end."""
    bench = ps.Model("FrictionBench").start({
        "friction.law": "RevisedLuGre", "bench.drive": "PrescribedMotion", "driveVelocity": MEAN
    })  # fmt: skip
    bench.step(5.0)
    bench["driveVelocity"] = 0.0
    bench.step(rest)
    film = bench["friction.revisedLuGre.film"]
    bench["driveVelocity"] = SLOW
    forces = []
    for _ in range(200):
        bench.step(2e-4)
        forces.append(bench["frictionForce"])
    return max(forces), film


def remaining(rest: float) -> float:
    """Return the film in closed form after a rest in s: it was grown, and shrinks with the time constant at rest."""
    grown = 1.0 - VALUES["Fc"] / VALUES["Fs"]
    return grown * math.exp(-rest / VALUES["tauH0"])


def draw(
    loops: dict[Shake, Array], frequencies: Array, rests: Array, found: list[tuple[float, float]],
    options: argparse.Namespace,
) -> None:  # fmt: skip
    with plt.rc_context(figures.STYLE):
        figure, (left, middle, right) = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
        for frequency, color in zip(LOOPS, COLORS, strict=True):
            velocity, force = loops[Shake("RevisedLuGre", frequency)].T
            left.plot(1e3 * velocity, force, color=color, label=f"{frequency:g} Hz")
        left.set(title="RevisedLuGre", xlabel="velocity (mm/s)", ylabel="friction (N)", xlim=(8, 30), ylim=(8.6, 9.4))
        left.legend()
        for law, color in (("RevisedLuGre", figures.BLUE), ("LuGre", figures.GREEN)):
            areas = [1e3 * area(loops[Shake(law, frequency)]) for frequency in frequencies]
            middle.semilogx(frequencies, areas, color=color, label=law)
        inertia = 1e3 * math.pi * VALUES["sigma2"] * INERTIA * SWING**2 * 2.0 * math.pi * frequencies
        shown = inertia < 0.8
        label = f"left out: fluid inertia, T = {1e3 * INERTIA:g} ms"
        middle.semilogx(frequencies[shown], inertia[shown], "--", color=figures.GREY, label=label)
        middle.set(title="area of the loop", xlabel="frequency (Hz)", ylabel="area (mN·m/s)", ylim=(0.0, 1.1))
        middle.legend(loc="upper left")
        fine = np.geomspace(rests[0], rests[-1], 200)
        closed = [(1.0 - remaining(rest)) * VALUES["Fs"] for rest in fine]
        right.semilogx(fine, closed, color=figures.GREY, label="$(1 - h)\\,F_s$")
        right.plot(rests, [force for force, _ in found], "o", color=figures.VERMILION, label="pulled at 1 mm/s")
        right.set(title="break-away after a rest", xlabel="rest (s)", ylabel="friction (N)")
        right.legend()
        save(figure, options.output / "Film.png")


def main() -> int:
    options = arguments(__doc__ or "")
    frequencies = np.geomspace(0.02, 8.0, 5 if options.small else 27)
    shakes = [Shake(law, float(one)) for law in ("RevisedLuGre", "LuGre") for one in (*frequencies, *LOOPS)]
    loops = dict(zip(shakes, parallel(options, "loops", loop, shakes), strict=True))
    rests = np.geomspace(0.1, 1000.0, 4 if options.small else 13)
    found = parallel(options, "rests", break_away, [float(rest) for rest in rests])
    draw(loops, frequencies, rests, found, options)
    head = ["law", "frequency (Hz)", "area (mN.m/s)", "reaches (mm/s)"]
    rows = [
        (shake.law, f"{shake.frequency:.4g}", f"{1e3 * area(one):.4f}", f"{1e3 * reach(one):.1f}")
        for shake, one in sorted(loops.items(), key=lambda item: (item[0].law, item[0].frequency))
    ]
    write_csv(options.output / "Film.csv", head, rows)
    head = ["rest (s)", "break-away (N)", "film", "film in closed form"]
    write_csv(
        options.output / "Film_rests.csv",
        head,
        ((f"{rest:.4g}", f"{force:.4f}", f"{film:.6f}", f"{remaining(rest):.6f}")
         for rest, (force, film) in zip(rests, found, strict=True)),
    )  # fmt: skip
    print(f"figure and tables: {options.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

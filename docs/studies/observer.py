"""The observer on the cylinder: its errors for every friction law, and wrong laws.

Leaves tables (CSV) and a figure:

- per law and filter the errors of velocity, friction and pressures, estimated from the voltage and a position with
  20 um of noise, the share of time in which they are within twice the band of 95 % that the observer tells, and the
  error of the velocity by a filtered derivative;
- the verdict of each observer on the record of each law: a wrong law is told by the correlation of its innovations.

Extended Kalman filters for friction are common for valves and drives, for example Zs. Horvath, State space estimation
for an electromechanical actuator valve using extended Kalman filter, Acta Technica Jaurinensis 8 (2015), 131-144.

Usage: python docs/studies/observer.py [--small]
"""

from __future__ import annotations

import csv
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
from common import arguments, parallel, plt, save
from numpy.typing import NDArray
from pneumatic_servo.observer import Method

Array = NDArray[np.float64]

PERIOD = 1e-3
NOISE = 20e-6
"""Of the position in m."""
CUTOFF = 30.0
"""Of the derivative's filter in Hz."""
PLANT: dict[str, ps.Value] = {"supplyPressure": 6e5}
SHOWN = ["velocity", "frictionForce", "chamberA.pressure", "chamberB.pressure"]
SMALL = ["Stribeck", "LuGre", "MaxwellSlip"]
METHODS: tuple[Method, ...] = ("extended", "unscented")
VERDICTS = ["None", "Coulomb", "Stribeck", "LuGre", "GMS"]


class Derivative:
    """A position's derivative, filtered by a first-order low-pass."""

    def __init__(self, start: float) -> None:
        self.last, self.velocity = start, 0.0
        self.share = 1.0 - np.exp(-2.0 * np.pi * CUTOFF * PERIOD)

    def update(self, position: float) -> float:
        self.velocity += self.share * ((position - self.last) / PERIOD - self.velocity)
        self.last = position
        return self.velocity


def voltage(time: float) -> float:
    """A motion with reversals and rests."""
    return float(5.0 + 1.2 * np.sin(2.0 * np.pi * 0.8 * time) + 0.5 * np.sin(2.0 * np.pi * 2.3 * time))


@dataclass
class Record:
    """A plant and estimates beside it, a row for each step: plant, estimates, their deviations, and the derivative."""

    plant: Array
    found: Array
    deviation: Array
    derivative: Array
    verdict: ps.Consistency

    @property
    def error(self) -> Array:
        return self.found - self.plant


def record(task: tuple[str, str, int, Method]) -> Record:
    """Let the observer of a law follow the plant of another for a number of steps."""
    law, own, steps, method = task
    warnings.simplefilter("ignore", ps.PlantWarning)
    noise = np.random.default_rng(1)
    plant = ps.Model().start(PLANT | {"friction.law": law})
    observer = ps.Observer(PLANT | {"friction.law": own}, measured={"position": NOISE}, period=PERIOD, method=method)
    derivative = Derivative(plant["position"])
    rows: list[list[list[float]]] = []
    for index in range(steps):
        plant["valveVoltage"] = voltage(index * PERIOD)
        plant.step(PERIOD)
        position = plant["position"] + NOISE * noise.standard_normal()
        found = observer.update({"valveVoltage": plant["valveVoltage"]}, {"position": position})
        deviation = observer.deviation
        rows.append(
            [plant.get(SHOWN).tolist(), [found[name] for name in SHOWN], [deviation[name] for name in SHOWN],
             [derivative.update(position)] * len(SHOWN)]
        )  # fmt: skip
    every = np.array(rows)
    return Record(every[:, 0], every[:, 1], every[:, 2], every[:, 3, 0], observer.consistency())


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def write(file: Path, head: list[str], rows: list[list[object]]) -> None:
    with file.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([head, *rows])


def draw(sample: Record, file: Path) -> None:
    figure, axes = plt.subplots(2, 1, figsize=(8, 6), layout="constrained")
    time = np.arange(len(sample.plant)) * PERIOD
    window = time < 1.5
    axes[0].plot(time[window], 1e3 * sample.derivative[window], color="0.75", label=f"derivative, {CUTOFF:g} Hz")
    for axis, column, factor, label in ((axes[0], 0, 1e3, "velocity (mm/s)"), (axes[1], 1, 1.0, "friction (N)")):
        middle, width = factor * sample.found[:, column], 1.96 * factor * sample.deviation[:, column]
        axis.plot(time[window], factor * sample.plant[window, column], "k", label="plant")
        axis.plot(time[window], middle[window], "C0--", label="observer")
        axis.fill_between(time[window], (middle - width)[window], (middle + width)[window], alpha=0.25, label="95 %")
        axis.set_ylabel(label)
        axis.legend(loc="upper right", ncols=4, fontsize="small")
    axes[1].set_xlabel("time (s)")
    save(figure, file)


def main() -> None:
    options = arguments(__doc__ or "")
    steps = 1500 if options.small else 4000
    laws = SMALL if options.small else list(ps.Model().parameters["friction.law"].items)
    tasks = [(law, law, steps, method) for law in laws for method in METHODS]
    records = dict(zip(tasks, parallel(options, "laws", record, tasks), strict=True))
    rows: list[list[object]] = []
    for (law, _, _, method), one in records.items():
        inside = np.mean(np.abs(one.error) < 2.0 * 1.96 * one.deviation + 1e-9, axis=0)
        errors = [rms(column) for column in one.error[200:].T]
        rows.append(
            [law, method, f"{1e3 * errors[0]:.2f}", f"{1e3 * rms((one.derivative - one.plant[:, 0])[200:]):.2f}",
             f"{errors[1]:.3f}", f"{1e-3 * errors[2]:.2f}", f"{1e-3 * errors[3]:.2f}", f"{inside[0]:.3f}",
             f"{inside[1]:.3f}", f"{one.verdict.mean_square:.2f}", f"{one.verdict.correlation:.2f}"]
        )  # fmt: skip
    write(
        options.output / "Observer_laws.csv",
        ["law", "filter", "velocity (mm/s rms)", "filtered derivative (mm/s rms)", "friction (N rms)",
         "pressure A (kPa rms)", "pressure B (kPa rms)", "velocity within twice 95 %", "friction within twice 95 %",
         "mean square", "correlation"],
        rows,
    )  # fmt: skip
    pairs = [(law, own, steps, METHODS[0]) for law in VERDICTS for own in VERDICTS]
    if not options.small:
        verdicts = parallel(options, "verdicts", record, pairs)
        found = np.array([one.verdict.correlation for one in verdicts]).reshape(len(VERDICTS), -1)
        table: list[list[object]] = [
            [law, *(f"{own:.2f}" for own in row)] for law, row in zip(VERDICTS, found.tolist(), strict=True)
        ]
        write(options.output / "Observer_verdicts.csv", ["plant", *VERDICTS], table)
    draw(records["Stribeck", "Stribeck", steps, METHODS[0]], options.output / "Observer.png")


if __name__ == "__main__":
    main()

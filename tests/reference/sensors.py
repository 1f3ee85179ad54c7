"""Readings of the cylinder's sensors, computed without the implementation.

    python sensors.py          write the CSV of every case of sensors.json

Needs NumPy and SciPy. The lags are integrated with the plant, as states after its own; integration stops at each
sample. Noise is left out: what of it can be known beforehand is its distribution.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from plant import GRAVITY, Inputs, Plant, Value
from simulation import INPUT_DEFAULTS, Run, configure

from friction import Law

FOLDER = Path(__file__).resolve().parent
TOLERANCE = 1e-11
COARSE_TOLERANCE = 1e-9
QUANTITIES = {"position": 1e-2, "pressureA": 1e5, "pressureB": 1e5, "force": 1.0}
"""Measured quantities, and their natural size."""
FAULTS = ("offset", "lag", "resolution", "sampleTime")
LATE = 1e-9
"""Times in s closer than this are one: sums of steps differ by rounding from multiples of them."""


class Sensor:
    """One sensor; the reading is held from sample to sample if it has a sample time."""

    def __init__(self, faults: Mapping[str, float]) -> None:
        self.offset, self.lag, self.resolution, self.period = (faults[name] for name in FAULTS)
        self._held = math.nan
        self._taken = 0

    def next_sample(self) -> float:
        """Time of the sample to be taken next."""
        return self._taken * self.period if self.period > 0.0 else math.inf

    def sample(self, quantity: float, lagged: float) -> None:
        value = self.seen(quantity, lagged)
        if self.resolution > 0.0:
            steps = math.floor(abs(value) / self.resolution + 0.5)
            value = math.copysign(steps * self.resolution, value)
        self._held = value
        self._taken += 1

    def reading(self, quantity: float, lagged: float) -> float:
        return self._held if self.period > 0.0 else self.seen(quantity, lagged)

    def seen(self, quantity: float, lagged: float) -> float:
        return (lagged if self.lag > 0.0 else quantity) + self.offset


class MeasuredPlant(Plant):
    """The plant and the lags of its sensors, whose states come last."""

    def __init__(self, parameters: dict[str, Value], sensors: Mapping[str, Sensor], carriage: float) -> None:
        super().__init__(parameters)
        self.sensors = sensors
        self.weight = float(parameters["wireForce"]) + carriage * GRAVITY * math.sin(float(parameters["incline"]))
        self.carriage = carriage
        self.lagged_at_start = [0.0] * len(sensors)

    def start(self, command: float, supply_pressure: float) -> list[float]:
        return super().start(command, supply_pressure) + self.lagged_at_start

    def units(self) -> list[float]:
        return super().units()[: -len(self.sensors)] + list(QUANTITIES.values())

    def rod_force(self, x: float, acceleration: float, external_force: float) -> float:
        spring = self.spring_stiffness * (x - self.spring_rest)
        return self.carriage * acceleration - external_force + self.weight + spring


class MeasuredRun(Run):
    """A run that integrates the lags, too."""

    _plant: MeasuredPlant

    def __init__(self, plant: MeasuredPlant, law: Law, tolerance: float) -> None:
        super().__init__(plant, law, tolerance)
        self._first = self._size - len(plant.sensors)

    def renew(self, inputs: Inputs, time: float) -> None:
        """Takes new inputs and leaves a regime that they have ended."""
        self.sample(inputs, time)
        self._adopt_inputs()

    def start(self) -> None:
        """Starts the lags at what their sensors measure."""
        super().start()
        self._plant.lagged_at_start = list(self.quantities(0.0).values())
        super().start()

    def quantities(self, time: float) -> dict[str, float]:
        """Measured quantities, at a time counted from the last sample of the inputs."""
        return self._measured(time, self._state, super()._rates(time, self._state)[1])

    def lagged(self) -> dict[str, float]:
        return dict(zip(QUANTITIES, self._state[self._first : self._size], strict=True))

    def _measured(self, time: float, state: list[float], acceleration: float) -> dict[str, float]:
        a, b = self._plant.gases(state)
        force = self._plant.rod_force(state[0], acceleration, self._inputs.external_force)
        return dict(zip(QUANTITIES, (state[0], a.pressure, b.pressure, force), strict=True))

    def _rates(self, time: float, state: list[float]) -> list[float]:
        rates = super()._rates(time, state)
        if math.isnan(rates[0]):
            return rates
        quantities = self._measured(time, state, rates[1])
        lagged = zip(self._plant.sensors.items(), state[self._first : self._size], strict=True)
        slopes = [(quantities[name] - z) / sensor.lag if sensor.lag > 0.0 else 0.0 for (name, sensor), z in lagged]
        return rates[: self._first] + slopes + rates[self._first :]


def simulate(case: Mapping[str, Any], tolerance: float) -> list[list[float]]:
    """The rows of a case."""
    parameters = dict(case["parameters"])
    carriage = parameters.pop("mass.carriage", 0.0)
    sensors = {
        name: Sensor({fault: parameters.pop(f"sensor.{name}.{fault}", 0.0) for fault in FAULTS}) for name in QUANTITIES
    }
    own, law = configure(parameters)
    run = MeasuredRun(MeasuredPlant(own, sensors, carriage), law, tolerance)
    return list(_rows(run, sensors, case))


def _rows(run: MeasuredRun, sensors: Mapping[str, Sensor], case: Mapping[str, Any]) -> Iterator[list[float]]:
    inputs = _inputs(case["inputs"], 0.0)
    run.sample(inputs, 0.0)
    run.start()
    time = 0.0
    for row in range(round(case["stopTime"] / case["outputStep"]) + 1):
        end = row * case["outputStep"]
        while time < end - LATE:
            stop = min(end, *(sensor.next_sample() for sensor in sensors.values()))
            run.sample(inputs, time)
            run.advance(stop - time)
            _take_samples(run, sensors, time, stop)
            time = stop
        if row == 0:
            _take_samples(run, sensors, 0.0, 0.0)
        inputs = _inputs(case["inputs"], end)
        run.renew(inputs, end)
        yield _row(run, sensors, case["columns"], end)


def _take_samples(run: MeasuredRun, sensors: Mapping[str, Sensor], begin: float, time: float) -> None:
    quantities, lagged = run.quantities(time - begin), run.lagged()
    for name, sensor in sensors.items():
        if sensor.next_sample() <= time + LATE:
            sensor.sample(quantities[name], lagged[name])


def _row(run: MeasuredRun, sensors: Mapping[str, Sensor], columns: list[str], time: float) -> list[float]:
    quantities, lagged = run.quantities(0.0), run.lagged()
    values = {"position": quantities["position"], "rodForce": quantities["force"]}
    for name, sensor in sensors.items():
        values[f"sensor.{name}.lagged"] = lagged[name]
        values[f"sensor.{name}.reading"] = sensor.reading(quantities[name], lagged[name])
    return [round(time, 9), *(values[column] for column in columns)]


def _inputs(changes: Mapping[str, list[list[float]]], time: float) -> Inputs:
    """The inputs from a time on."""
    values = dict(INPUT_DEFAULTS)
    for name, steps in changes.items():
        values[name] = [value for begin, value in steps if begin <= time + LATE][-1]
    return Inputs(values["valveVoltage"], values["externalForce"], values["supplyPressure"])


def main() -> None:
    for case in json.loads((FOLDER / "sensors.json").read_text()):
        rows = simulate(case, TOLERANCE)
        with (FOLDER / f"{case['name']}.csv").open("w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["time", *case["columns"]])
            writer.writerows([f"{value:.12g}" for value in row] for row in rows)
        apart = np.abs(np.array(rows) - np.array(simulate(case, COARSE_TOLERANCE))).max(axis=0)[1:]
        for column, difference in zip(case["columns"], apart, strict=True):
            print(f"{case['name']}, {column}: {difference:.1e}")


if __name__ == "__main__":
    main()

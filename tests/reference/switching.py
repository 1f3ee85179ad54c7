"""Two switching valves driven by pulses: their openings are broken lines over time."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from actuator import Actuator
from gas import Gas, Stream, orifice

Pulse = tuple[float, float]

ROUNDING = 1e-12
"""Pulses and pauses that are longer than a delay by less, in s, are as long."""


class SwitchingValves(Actuator):
    """The voltage makes pulses; a list of these makes the times at which a valve turns, and these its opening."""

    units = (1.0, 1.0)

    def __init__(self, parameters: Mapping[str, float | str]) -> None:
        def number(name: str) -> float:
            return float(parameters[name])

        self._conductance = number("switching.C")
        self._critical_ratio = number("switching.b")
        self._vents = parameters["switching.centre"] == "Vented"
        self._frequency = number("switching.frequency")
        self._opening_delay = number("switching.openingDelay")
        self._closing_delay = number("switching.closingDelay")
        self._travel = number("switching.travelTime")
        self._exhaust = Gas(number("ambientPressure"), number("ambientTemperature"))
        self._supply_temperature = number("supplyTemperature")
        self._pulses: list[list[Pulse]] = [[], []]
        self._lines: list[tuple[list[float], list[float]]] = [([0.0], [0.0])] * 2

    def command(self, voltage: float, time: float) -> float:
        """Takes the voltage where a period begins; periods must begin at communication points."""
        duty = min(max((voltage - 5.0) / 5.0, -1.0), 1.0)
        number = round(time * self._frequency)
        if abs(number / self._frequency - time) < 1e-9:
            if duty != 0.0:
                begin = number / self._frequency
                self._pulses[duty < 0.0].append((begin, begin + abs(duty) / self._frequency))
            self._lines = [self._line(self._turns(pulses)) for pulses in self._pulses]
        return duty

    def start(self, command: float) -> tuple[float, float]:
        return 0.0, 0.0

    def rates(self, state: list[float], command: float) -> tuple[float, float]:
        return 0.0, 0.0

    def kinks(self, begin: float, end: float) -> list[float]:
        return sorted({time for times, _ in self._lines for time in times if begin < time < end})

    def at(self, time: float, state: list[float]) -> list[float]:
        return [float(np.interp(time, times, openings)) for times, openings in self._lines]

    def streams(self, state: list[float], a: Gas, b: Gas, supply_pressure: float) -> tuple[list[Stream], list[Stream]]:
        supply = Gas(supply_pressure, self._supply_temperature)
        feeding = state
        venting = [1.0 - opening for opening in state] if self._vents else state[::-1]
        return self._pair(feeding[0], venting[0], supply, a), self._pair(feeding[1], venting[1], supply, b)

    def spool(self, state: list[float]) -> float:
        return 0.0

    def _pair(self, feeding: float, venting: float, supply: Gas, chamber: Gas) -> list[Stream]:
        return [
            orifice(self._conductance * feeding, self._critical_ratio, supply, chamber),
            orifice(self._conductance * venting, self._critical_ratio, self._exhaust, chamber),
        ]

    def _turns(self, pulses: list[Pulse]) -> list[float]:
        """The times at which a valve begins to open, to close, to open, and so on."""
        joined: list[Pulse] = []
        for begin, end in pulses:
            if joined and begin - joined[-1][1] <= self._closing_delay + ROUNDING:
                joined[-1] = (joined[-1][0], end)
            elif end - begin > self._opening_delay + ROUNDING:
                joined.append((begin, end))
        return [turn for begin, end in joined for turn in (begin + self._opening_delay, end + self._closing_delay)]

    def _line(self, turns: list[float]) -> tuple[list[float], list[float]]:
        """The corners of the opening over time."""
        times, openings = [0.0], [0.0]
        for number, (turn, following) in enumerate(pairwise([*turns, float("inf")])):
            end = 1.0 - number % 2
            opening = openings[-1]
            arrival = turn + abs(end - opening) * self._travel
            times.append(turn)
            openings.append(opening)
            if arrival <= following:
                times.append(arrival)
                openings.append(end)
            else:
                times.append(following)
                openings.append(opening + (following - turn) / self._travel * (1.0 if end > opening else -1.0))
        return times, openings

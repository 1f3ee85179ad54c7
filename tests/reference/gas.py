"""Air: its states, its streams, and the orifice of ISO 6358."""

from __future__ import annotations

import math
from typing import NamedTuple

GAS_CONSTANT = 287.05
GAMMA = 1.4
CV = GAS_CONSTANT / (GAMMA - 1.0)
CP = GAMMA * CV
NORMAL_DENSITY = 1.185
NORMAL_TEMPERATURE = 293.15
LAMINAR_RATIO = 0.995


class Gas(NamedTuple):
    """A state of air."""

    pressure: float
    temperature: float


class Stream(NamedTuple):
    """A mass flow into a chamber and the temperature of the side it comes from."""

    mass_flow: float
    temperature: float


def orifice(conductance: float, critical_ratio: float, outside: Gas, inside: Gas) -> Stream:
    """The flow from ``outside`` into ``inside`` through an ISO 6358 orifice."""
    if outside.pressure >= inside.pressure:
        return Stream(_orifice_flow(conductance, critical_ratio, outside, inside), outside.temperature)
    return Stream(-_orifice_flow(conductance, critical_ratio, inside, outside), inside.temperature)


def _orifice_flow(conductance: float, critical_ratio: float, upstream: Gas, downstream: Gas) -> float:
    ratio = downstream.pressure / upstream.pressure
    choked = conductance * upstream.pressure * NORMAL_DENSITY * math.sqrt(NORMAL_TEMPERATURE / upstream.temperature)
    if ratio <= critical_ratio:
        return choked
    if ratio < LAMINAR_RATIO:
        return choked * _subsonic(ratio, critical_ratio)
    laminar_edge = _subsonic(LAMINAR_RATIO, critical_ratio)
    return choked * laminar_edge * (1.0 - ratio) / (1.0 - LAMINAR_RATIO)


def _subsonic(ratio: float, critical_ratio: float) -> float:
    return math.sqrt(1.0 - ((ratio - critical_ratio) / (1.0 - critical_ratio)) ** 2)

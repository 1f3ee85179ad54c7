"""What can be measured."""

from __future__ import annotations

SIGNALS = {
    "time": "s",
    "position": "m",
    "velocity": "m/s",
    "frictionForce": "N",
    "force": "N",
    "normalForce": "N",
    "pressure": "Pa",
    "valveVoltage": "V",
    "supplyPressure": "Pa",
    "externalForce": "N",
    "chamberA.pressure": "Pa",
    "chamberB.pressure": "Pa",
}
"""Signals and their SI units. `pressure` is that of a test bench above ambient, those of the chambers are absolute, as
everywhere in the model."""

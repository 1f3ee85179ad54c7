"""Gases by name."""

from __future__ import annotations

import pneumatic_servo as ps
import pytest
from pneumatic_servo.gases import GASES

MOVING = {"inputs": {"valveVoltage": 8.0}, "stop": 0.4, "step": 1e-3}
MOLAR = {"nitrogen": 28.0134, "oxygen": 31.998, "argon": 39.948, "helium": 4.0026, "hydrogen": 2.016,
         "carbon dioxide": 44.0095}  # fmt: skip


def test_gas_constants_are_those_of_molar_masses() -> None:
    assert set(MOLAR) | {"air"} == set(GASES)
    for name, mass in MOLAR.items():
        assert ps.gas(name)["gas.R"] == pytest.approx(8314.4626 / mass, rel=1e-4)


def test_air_is_the_default() -> None:
    variables = ps.Model().variables
    assert ps.gas("air") == {name: variables[name].default for name in ps.gas("helium")}


def test_consumption_is_the_volume_of_the_gas() -> None:
    """The same volume at the reference conditions weighs less: helium a seventh."""
    found = {}
    for name in ("air", "helium"):
        run = ps.Model().simulate({**ps.gas(name), "consumption.enabled": True}, **MOVING)  # type: ignore[arg-type]
        found[name] = run.consumption()
        assert found[name].volume == pytest.approx(run["supply.consumedVolume"][-1], rel=1e-9)
    densities = [one.mass / one.volume for one in found.values()]
    assert densities[1] / densities[0] == pytest.approx(4.0026 / 28.965, rel=1e-3)


def test_unknown_gas_and_impossible_values_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"no gas 'Nitrogen'; did you mean nitrogen\?; there are air"):
        ps.gas("Nitrogen")
    with pytest.raises(ps.Refused, match=r"gas\.gamma = 1"):
        ps.Model().start({"gas.gamma": 1.0})

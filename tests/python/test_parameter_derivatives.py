"""Derivatives with respect to tunable parameters, through FMPy: both versions of FMI, both kinds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from bounds import assert_close
from fmpy import extract, instantiate_fmu, read_model_description
from numpy.typing import NDArray

STRIBECK = 7
SLIDING = {"velocity0": 0.02, "chamberA.pressure0": 4e5, "valveVoltage": 7.0, "supplyPressure": 6e5}
PARAMETERS = {
    "friction.stribeck.Fs": 1e-3,
    "friction.stribeck.vs": 1e-6,
    "friction.stribeck.sigma2": 1e-2,
    "friction.kappaA": 1e-9,
    "valve.C": 1e-13,
    "valve.leakage": 1e-6,
    "supplyTemperature": 1e-2,
    "wireForce": 1e-2,
}
"""Parameters, and what they are changed by."""
UNKNOWNS = ["acceleration", "der(chamberA.pressure)", "der(chamberB.temperature)", "frictionForce", "rodForce"]


class Plant(NamedTuple):
    """An instance in initialization mode, where values follow the parameters at once; its functions by names."""

    set: Callable[[str, float], None]
    get: Callable[[list[str]], NDArray]
    derivatives: Callable[[str], NDArray]
    adjoint: Callable[[list[float], list[str]], list[float]] | None


KINDS = ("CoSimulation", "ModelExchange")


@pytest.fixture(params=[(version, kind) for version in "23" for kind in KINDS])
def plant(request: pytest.FixtureRequest, fmus: Path, tmp_path: Path) -> Iterator[Plant]:
    """A carriage that slides, of either version and either kind."""
    version, kind = request.param
    file = fmus / ("." if version == "2" else "fmi3") / "PneumaticServoCylinder.fmu"
    extract(str(file), unzipdir=str(tmp_path))
    description = read_model_description(str(file))
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    instance = instantiate_fmu(str(tmp_path), description, fmi_type=kind)
    if version == "2":
        setter, getter = instance.setReal, instance.getReal
        instance.setInteger([references["friction.law"]], [STRIBECK])
        instance.setupExperiment(startTime=0.0)
    else:
        setter, getter = instance.setFloat64, instance.getFloat64
        instance.setInt64([references["friction.law"]], [STRIBECK])
    for name, value in SLIDING.items():
        setter([references[name]], [value])
    instance.enterInitializationMode()
    unknowns = [references[name] for name in UNKNOWNS]

    def derivatives(name: str) -> NDArray:
        return np.array(instance.getDirectionalDerivative(unknowns, [references[name]], [1.0]))

    def adjoint(seeds: list[float], names: list[str]) -> list[float]:
        knowns = [references[name] for name in names]
        return list(instance.getAdjointDerivative(unknowns, knowns, seeds, len(knowns)))

    yield Plant(
        set=lambda name, value: setter([references[name]], [value]),
        get=lambda names: np.array(getter([references[name] for name in names])),
        derivatives=derivatives,
        adjoint=adjoint if version == "3" else None,
    )
    instance.freeInstance()


def test_derivatives_are_those_of_differences(plant: Plant) -> None:
    for name, step in PARAMETERS.items():
        exact, value = plant.derivatives(name), plant.get([name])[0]
        sides = []
        for change in (step, -step):
            plant.set(name, value + change)
            sides.append(plant.get(UNKNOWNS))
        plant.set(name, value)
        difference = (sides[0] - sides[1]) / (2 * step)
        rounding = 1e-13 * np.abs(sides[0]) / step
        assert_close(difference, exact, within=2e-8 * np.abs(exact) + rounding, what="differences")
        assert np.any(exact != 0), name


@pytest.mark.parametrize("plant", [("3", kind) for kind in KINDS], indirect=True)  # FMI 2.0 has none.
def test_adjoint_derivatives_are_their_transpose(plant: Plant) -> None:
    assert plant.adjoint is not None
    seeds = [1.0, -2e-6, 0.5, 3.0, -1.0]
    for name, found in zip(PARAMETERS, plant.adjoint(seeds, list(PARAMETERS)), strict=True):
        terms = seeds * plant.derivatives(name)
        assert_close(found, terms.sum(), within=1e-14 * np.abs(terms).sum(), what="adjoint")

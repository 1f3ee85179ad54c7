"""Closed loops: runs with a controller are runs as all others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest

SHORT: dict[str, Any] = {"stop": 0.3, "step": 1e-3}
START = {"supplyPressure": 6e5, "position0": 0.2}


def proportional(time: float, seen: Mapping[str, float]) -> float:
    return 5.0 + 20.0 * (0.25 - seen["position"])


def closed(**options: Any) -> ps.Run:
    return ps.Model().simulate(START, **{"controller": proportional, **SHORT, **options})


def test_closed_loop_is_recorded_with_the_bits_of_its_replay() -> None:
    run = closed()
    assert {"valveVoltage", "position", "chamberA.pressure"} <= set(run)
    again = ps.Model().simulate(START, inputs=run, **SHORT)
    assert np.array_equal(again["position"], run["position"])
    expected = [proportional(0.0, {"position": place}) for place in run["position"][:-1]]
    assert run["valveVoltage"][1:].tolist() == expected


def test_period_and_delay_are_those_of_a_sampled_controller() -> None:
    voltage = closed(period=0.01)["valveVoltage"][1:].reshape(-1, 10)
    assert (voltage == voltage[:, :1]).all() and len(set(voltage[:, 0])) > 20
    late = closed(delay="5 ms")
    assert (late["valveVoltage"][1:6] == 5.0).all()
    assert late["valveVoltage"][6] == proportional(0.0, {"position": 0.2})


def test_controller_of_the_library_is_called_by_its_name() -> None:
    t = np.arange(0.0, 2.0, 1e-3)
    reference = {"referencePosition": (t, 0.2 + 0.05 * np.sin(3 * t))}
    run, weak = (
        ps.Model().simulate(START, inputs=reference, controller=controller, stop=2.0, step=1e-3)
        for controller in ("PositionController", ("PositionController", {"gain.position": 1.0}))
    )
    errors = [
        np.max(np.abs(one["position"][1000:2000] - reference["referencePosition"][1][1000:])) for one in (run, weak)
    ]
    assert errors[0] < 0.005 < errors[1]


class Integral:
    def __init__(self) -> None:
        self.sum = 0.0

    def __call__(self, time: float, seen: Mapping[str, float]) -> dict[str, float]:
        self.sum += 1e-3 * (0.25 - seen["position"])
        return {"valveVoltage": 5.0 + 20.0 * (0.25 - seen["position"]) + 50.0 * self.sum}


def test_many_runs_and_laws_have_a_controller_each() -> None:
    controller = Integral()
    plant = ps.Model()
    runs = plant.simulate_many(
        {"friction.law": ["Stribeck", "LuGre"]}, common=START, controller=controller, progress=False, **SHORT
    )
    found = plant.compare(["Stribeck", "LuGre"], START, controller=controller, progress=False, **SHORT)
    for number, law in enumerate(found.laws):
        alone = plant.simulate({**START, "friction.law": law}, controller=controller, **SHORT)
        assert np.array_equal(runs["position"][number], alone["position"])
        assert np.array_equal(found[law]["position"], alone["position"])
    assert controller.sum == 0.0


@pytest.mark.parametrize(("options", "told"), [
    ({"period": 1.5e-3}, "period = 0.0015 is refused: it must be a whole number of steps of 0.001 s"),
    ({"delay": -1e-3}, "delay = -0.001 is refused"),
    ({"controller": lambda t, seen: {"voltage": 6.0}}, "at t = 0 s the controller sets voltage, which is no input"),
    ({"controller": lambda t, seen: "6"}, "the controller sets valveVoltage = '6': it must be a number"),
    ({"controller": lambda t, seen: np.nan}, "at t = 0.0 s valveVoltage = nan V is refused"),
    ({"inputs": {"valveVoltage": 6.0}}, "valveVoltage is given twice, among the inputs and by the controller"),
    ({"controller": "FrictionBench"}, "controller = 'FrictionBench' is refused"),
    ({"controller": None, "period": 0.01}, "period and delay are for a controller"),
])  # fmt: skip
def test_mistakes_with_controllers_are_refused(options: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        closed(**options)

"""Each run has a controller with its own state, and a resumed study the controller and inputs of its begin."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
import pneumatic_servo as ps
import pytest

SHORT: dict[str, Any] = {"stop": 0.2, "step": 1e-3, "outputs": ["position"]}
Law = Callable[[float, Mapping[str, float]], float]


def of_number() -> Law:
    total = 0.0

    def law(time: float, seen: Mapping[str, float]) -> float:
        nonlocal total
        total += 0.3 - seen["position"]
        return 5.0 + 0.1 * total

    return law


def of_nested_functions() -> Law:
    state = {"sums": [0.0]}

    def add(error: float) -> float:
        state["sums"][0] += error
        return state["sums"][0]

    return lambda time, seen: 5.0 + 0.1 * add(0.3 - seen["position"])


class Held:
    def __init__(self) -> None:
        self.law = of_number()

    def __call__(self, time: float, seen: Mapping[str, float]) -> float:
        return self.law(time, seen)


def in_default(time: float, seen: Mapping[str, float], sums: list[float] = [0.0]) -> float:  # noqa: B006
    sums[0] += 0.3 - seen["position"]
    return 5.0 + 0.1 * sums[0]


def of_partial(sums: list[float], time: float, seen: Mapping[str, float]) -> float:
    return in_default(time, seen, sums)


LAWS: dict[str, Callable[[], Law]] = {
    "number": of_number, "nested functions": of_nested_functions, "held by an object": Held,
    "bound method": lambda: Held().__call__, "default argument": lambda: in_default,
    "partial": lambda: partial(of_partial, [0.0]),
}  # fmt: skip


@pytest.mark.parametrize("kind", LAWS)
def test_equal_machines_in_loops_give_equal_runs(kind: str) -> None:
    law, plant = LAWS[kind](), ps.Model()
    runs = plant.simulate_many(number=3, controller=law, progress=False, **SHORT)
    bits = {run["position"].tobytes() for run in runs}
    bits |= {plant.simulate(controller=law, **SHORT)["position"].tobytes()}
    assert len(bits) == 1


def test_functions_of_a_controller_share_their_state_in_the_copy() -> None:
    def make() -> Any:
        count = 0

        def up() -> None:
            nonlocal count
            count += 1

        def law(time: float, seen: Mapping[str, float]) -> float:
            up()
            return 5.0 + 0.01 * count

        return law

    def numbered(time: float, seen: Mapping[str, float]) -> float:
        return 5.0 + 0.01 * (1 + round(time / 1e-3))

    plant = ps.Model()
    one, other = (plant.simulate(controller=law, **SHORT)["position"] for law in (make(), numbered))
    assert one.tobytes() == other.tobytes()


def test_controller_that_cannot_be_copied_is_refused() -> None:
    voltages = (6.0 for _ in range(10**6))
    with pytest.raises(TypeError, match=r"voltages .*cannot be copied"):
        ps.Model().simulate(controller=lambda time, seen: next(voltages), **SHORT)


TIMES, VOLTS = np.linspace(0.0, 0.2, 201), np.linspace(6.0, 7.0, 201)
COURSES = np.linspace(VOLTS, VOLTS + 0.1, 3)
NOTATIONS: dict[str, Any] = {
    "constant": 6.0, "per run": np.array([6.0, 6.5, 7.0]), "times and values": (TIMES, VOLTS),
    "two points": ([0.0, 0.2], [6.0, 7.0]), "rows": np.column_stack([TIMES, VOLTS]), "series": pd.Series(VOLTS, TIMES),
    "per run courses": (TIMES, COURSES), "function": lambda time: 6.0 + time,
}  # fmt: skip


@pytest.mark.parametrize("notation", NOTATIONS)
def test_study_is_resumed_under_each_notation_of_inputs(notation: str) -> None:
    given = {"inputs": {"valveVoltage": NOTATIONS[notation]}, "number": 3, "progress": False, **SHORT}
    many = ps.Model().simulate_many
    whole = many(**given)
    part = many(**given)
    part.rows[1] = 5
    part._values[1] = np.nan
    assert many(resume=part, **given)["position"].tobytes() == whole["position"].tobytes()
    with pytest.raises(ValueError, match="the input valveVoltage of the earlier runs is another one"):
        many(resume=part, **{**given, "inputs": {"valveVoltage": ([0.0, 0.2], [5.0, 7.0])}})


def gained(gain: float) -> Law:
    return lambda time, seen: 5.0 + gain * (0.3 - seen["position"])


OTHERS: dict[str, dict[str, Any]] = {
    "gain": {"controller": gained(21.0)}, "law": {"controller": of_number()}, "period": {"period": 2e-3},
    "delay": {"delay": 1e-3}, "none": {"controller": None, "inputs": {"valveVoltage": 6.0}},
    "input": {"inputs": {"externalForce": 1.0}},
}  # fmt: skip


@pytest.mark.parametrize("other", OTHERS)
def test_study_is_not_resumed_under_another_controller(other: str) -> None:
    given: dict[str, Any] = {"controller": gained(20.0), "number": 3, "progress": False, **SHORT}
    many = ps.Model().simulate_many
    part = many(**given)
    part.rows[1] = 5
    again = many(resume=part, **{**given, "controller": gained(20.0)})
    assert again.is_complete.all()
    with pytest.raises(ValueError, match="resume: "):
        many(resume=part, **{**given, **OTHERS[other]})
    reference: dict[str, Any] = {**given, "controller": "PositionController"}
    part = many(inputs={"referencePosition": 0.3}, **reference)
    with pytest.raises(ValueError, match="the input referencePosition of the earlier runs is another one"):
        many(inputs={"referencePosition": 0.4}, resume=part, **reference)

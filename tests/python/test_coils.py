"""Boolean inputs: coils of four valves, in every form in which inputs are given."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest

COILS = {"actuation": "SwitchingValves", "switching.command": "EachCoil"}
TIMES = np.array([0.0, 0.05, 0.12, 0.2])
FEEDS_A = np.array([True, False, True, True])
SHORT = {"stop": 0.2, "step": 1e-3}


def forms() -> dict[str, dict[str, object]]:
    """The same commands of the first and the last coil, in several forms."""
    numbers = FEEDS_A.astype(float)

    def at(time: float) -> bool:
        return bool(FEEDS_A[np.searchsorted(TIMES, time, side="right") - 1])

    return {
        "points of true and false": {"coil[1]": (TIMES, FEEDS_A), "coil[4]": True},
        "points of numbers": {"coil[1]": (TIMES, numbers), "coil[4]": 1},
        "held points": {"coil[1]": {"hold": (TIMES, FEEDS_A.tolist())}, "coil[4]": np.True_},
        "functions": {"coil[1]": at, "coil[4]": lambda time: np.bool_(time >= 0.0)},
    }


@pytest.mark.parametrize("form", forms())
def test_true_and_false_are_held_in_every_form(form: str) -> None:
    run = ps.Model().simulate(COILS, inputs=forms()[form], **SHORT)
    simulation = ps.Model().start({**COILS, "coil[4]": True})
    for time in run.time[:-1]:
        simulation["coil[1]"] = bool(FEEDS_A[np.searchsorted(TIMES, time + 1e-9, side="right") - 1])
        simulation.step(1e-3)
    assert abs(simulation["position"] - run["position"][-1]) < 1e-12
    assert run["position"][-1] > 0.26
    assert set(run["coil[1]"]) == {0.0, 1.0}


@pytest.mark.parametrize(("on", "off"), [("1", "0"), ("True", "False"), ("TRUE", "FALSE")])
def test_table_has_a_column_of_a_coil(tmp_path: Path, on: str, off: str) -> None:
    table = tmp_path / "coils.csv"
    rows = [f"{time},{on if feeds else off},{on}" for time, feeds in zip(TIMES, FEEDS_A, strict=True)]
    table.write_text("\n".join(["time,coil[1],coil[4]", *rows]))
    given = ps.Model().simulate(COILS, inputs=forms()["functions"], **SHORT)
    assert np.array_equal(ps.Model().simulate(COILS, inputs=table, **SHORT)["position"], given["position"])


def test_runs_side_by_side_have_coils_of_their_own() -> None:
    inputs = {"coil[1]": [True, False], "coil[4]": True}
    runs = ps.Model().simulate_many([COILS, COILS], inputs=inputs, **SHORT)
    position = runs["position"][:, -1]
    assert position[0] > 0.26 > position[1]


def test_controller_sets_coils() -> None:
    def controller(time: float, measured: dict[str, float]) -> dict[str, object]:
        feeds = measured["position"] < 0.28
        return {"coil[1]": feeds, "coil[2]": not feeds, "coil[3]": not feeds, "coil[4]": feeds}

    run = ps.Model().simulate(COILS, controller=controller, **SHORT)
    assert set(run["coil[3]"]) == {0.0, 1.0}
    at_switch = run["position"][np.flatnonzero(np.diff(run["coil[3]"]) > 0.0)[0]]
    assert 0.28 <= at_switch < 0.285


@pytest.mark.parametrize("value", [0.5, 2, -1, "on", None, [1, 2], float("nan")])
def test_other_values_are_refused_by_name(value: object) -> None:
    with pytest.raises((ValueError, TypeError), match=r"coil\[2\]"):
        ps.Model().simulate(COILS, inputs={"coil[2]": value}, **SHORT)
    simulation = ps.Model().start(COILS)
    with pytest.raises((ValueError, TypeError), match=r"coil\[2\]"):
        simulation["coil[2]"] = value
    assert simulation["coil[2]"] == 0.0


def test_points_between_true_and_false_are_refused() -> None:
    with pytest.raises(ValueError, match=r"at t = 0.1 s coil\[1\] = 0.5"):
        ps.Model().simulate(COILS, inputs={"coil[1]": ([0.0, 0.1], [0.0, 0.5])}, **SHORT)
    with pytest.raises(ValueError, match=r"valveVoltage.*true and false"):
        ps.Model().simulate(inputs={"valveVoltage": ([0.0, 0.1], [True, False])}, **SHORT)


def test_nothing_is_differentiated_by_a_coil() -> None:
    model = ps.Model()
    simulation = model.start(COILS)
    for attempt in (
        lambda: simulation.jacobian(["der(chamberA.pressure)"], ["coil[1]"]),
        lambda: model.linearise(COILS, inputs=["coil[1]"]),
        lambda: simulation.transition(1e-3, parameters=["coil[1]"]),
    ):
        with pytest.raises((ValueError, TypeError), match=r"coil\[1\]"):
            attempt()

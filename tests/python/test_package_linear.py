"""Linearisation and comparison in the Python package."""

from __future__ import annotations

import control
import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close, largest

SLIDING = {"velocity": 0.05, "valve.hysteresis": 0.0, "supplyPressure": 6e5}


@pytest.fixture(scope="module")
def plant() -> ps.Model:
    return ps.Model("PneumaticServoCylinder")


LAWS = ["Stribeck", "LuGre", "StribeckRegularised"]
SLOW = [(law, velocity) for law in ("Stribeck", "Coulomb", "LuGre") for velocity in (1e-4, 1e-3, -1e-3, 0.01, -0.03)]


@pytest.mark.parametrize(("law", "velocity"), [*((law, 0.05) for law in LAWS), *SLOW])
def test_trimmed_plant_stays_where_it_is(plant: ps.Model, law: str, velocity: float) -> None:
    found = plant.linearise(at=SLIDING | {"friction.law": law, "velocity": velocity})
    point = dict(zip(found.states, found.x, strict=True))
    assert point["velocity"] == velocity and point["position"] == 0.25
    # Both chambers are between ambient and supply pressure.
    assert 101325.0 < point["chamberA.pressure"] < 6e5 and 101325.0 < point["chamberB.pressure"] < 6e5
    start = {"friction.law": law, "velocity0": velocity, "valve.hysteresis": 0.0, "supplyPressure": 6e5}
    simulation = plant.start(start)
    simulation.move_states({name: value for name, value in point.items() if name != "velocity"})
    simulation["valveVoltage"] = found.u[0]
    rates = ["acceleration", "der(chamberA.pressure)", "der(chamberB.temperature)", "der(valve.spoolVelocity)"]
    # In nominal units.
    scale = [plant.variables[name].nominal for name in rates]
    assert_close(
        simulation.get(rates),
        np.zeros(len(rates)),
        within=1e-9 * np.array(scale),
        what="rates",
        why="what the trim promises",
    )
    # The slower, the closer to the dead zone of 0.4 V.
    assert 0.4 < np.sign(velocity) * (found.u[0] - 5.0) < 0.405 + 3.0 * abs(velocity)


def sliding_friction(law: str, velocity: float) -> float:
    """Return the friction force in N of steady sliding, of the laws whose curve falls and of the others."""
    falling = 2.7 / (1.0 + (velocity / 0.01) ** 2) if law == "Armstrong" else 0.0
    return 8.3 + falling + 30.0 * velocity


LEFT = {"MaxwellSlip": 1.5e-14, "StickSlipSpring": 1.5e-14, "DNLRX": 2e-3, "Armstrong": 2e-3}
"""Part of the friction by which what lags behind has not followed; springs have, up to rounding."""


@pytest.mark.parametrize("law", LEFT)
@pytest.mark.parametrize("velocity", [0.005, 0.05])
@pytest.mark.filterwarnings("ignore:friction.law = DNLRX")
def test_friction_remembers_the_motion_at_its_operating_point(plant: ps.Model, law: str, velocity: float) -> None:
    """Laws whose memory is no state: held in place, their springs would be relaxed, and hold."""
    found = plant.linearise(at=SLIDING | {"friction.law": law, "velocity": velocity}, outputs=["frictionForce"])
    assert_close(found.y[0], sliding_friction(law, velocity), rel=LEFT[law], what=law)
    assert found.A[found.states.index("velocity"), found.states.index("position")] == 0.0


def test_states_given_by_their_start_values_are_given(plant: ps.Model) -> None:
    """The position that starts a motion, and the velocity, stay; nothing is sought at rest instead."""
    settings = {"friction.law": "Stribeck", "valve.hysteresis": 0.0, "supplyPressure": 6e5}
    named = plant.linearise(at=settings | {"position": 0.2, "velocity": 0.05})
    started = plant.linearise(at=settings | {"position0": 0.2, "velocity0": 0.05})
    assert started.x.tolist() == named.x.tolist() and started.u.tolist() == named.u.tolist()
    assert started.x[:2].tolist() == [0.2, 0.05]


def test_motion_without_room_behind_has_an_operating_point(plant: ps.Model) -> None:
    """At a cover, so fast that a run-up would begin beyond it."""
    found = plant.linearise(at={"position": 0.0, "velocity": 2.0, "valve.hysteresis": 0.0, "friction.law": "Dahl"})
    assert found.x[:2].tolist() == [0.0, 2.0]


def test_matrices_are_those_of_small_differences(plant: ps.Model) -> None:
    found = plant.linearise(at=SLIDING, outputs=["frictionForce", "pressureForce"])
    simulation = plant.start({"velocity0": 0.05, "valve.hysteresis": 0.0, "supplyPressure": 6e5})
    rates = [next(v.name for v in plant.variables.values() if v.derivative_of == name) for name in found.states]

    def at(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        simulation.move_states(dict(zip(found.states, x.tolist(), strict=True)))
        simulation["valveVoltage"] = found.u[0]
        return simulation.get(rates), simulation.get(found.outputs)

    for column, name in enumerate(found.states):
        change = np.zeros(len(found.x))
        change[column] = 1e-5 * (plant.variables[name].nominal or 1.0)
        above, below = at(found.x + change), at(found.x - change)
        both = zip((found.A, found.C), (rates, found.outputs), above, below, strict=True)
        for matrix, rows, high, low in both:
            measured = (high - low) / (2.0 * change[column])
            # Rounding of the values, in nominal units.
            units = np.array([plant.variables[row].nominal or 1.0 for row in rows])
            assert_close(measured, matrix[:, column], within=1e-14 * units / change[column], what="differences")


def test_columns_of_several_inputs_and_states_are_those_of_each_alone(plant: ps.Model) -> None:
    simulation = plant.start({"velocity0": 0.05, "valve.hysteresis": 0.0, "supplyPressure": 6e5, "valveVoltage": 7.0})
    simulation.step(0.05)
    of = ["acceleration", "der(chamberA.pressure)", "der(valve.spoolVelocity)"]
    to = ["valveVoltage", "velocity", "externalForce", "supplyPressure", "chamberA.pressure", "chamberB.pressure"]
    together = simulation.jacobian(of, to)
    alone = [simulation.jacobian(of, [name]) for name in to]
    assert all(column.any() for column in alone), "each has an effect"
    assert np.array_equal(together, np.hstack(alone))
    # Rows and columns come in the order that is asked for.
    assert np.array_equal(simulation.jacobian(of[::-1], to[::-1]), together[::-1, ::-1])


def test_several_inputs_are_trimmed_and_linearised_together(plant: ps.Model) -> None:
    both = plant.linearise(at=SLIDING, inputs=["valveVoltage", "externalForce"], trim=False)
    for column, name in enumerate(both.inputs):
        one = plant.linearise(at=SLIDING, inputs=[name], trim=False)
        assert np.array_equal(both.B[:, [column]], one.B) and np.array_equal(both.D[:, [column]], one.D)
    assert both.B[both.states.index("velocity"), 1] != 0.0 and not both.B[both.states.index("velocity"), 0]


def test_scaling_keeps_the_poles(plant: ps.Model) -> None:
    found = plant.linearise(at=SLIDING)
    scaled = found.scaled()
    assert largest(scaled.A) < 1e-3 * largest(found.A)
    poles, same = (np.sort_complex(np.linalg.eigvals(matrix)) for matrix in (found.A, scaled.A))
    assert_close(same, poles, rel=1e-11, within=1e-11, what="poles", why="LAPACK rounds differently on each processor")


def test_scaled_transfer_is_that_of_nominal_values(plant: ps.Model) -> None:
    """Effect of an input of one nominal value on an output, in its nominal values; also where it acts at once."""
    given = {"inputs": ["valveVoltage", "externalForce"], "outputs": ["acceleration", "position"]}
    found = plant.linearise(at=SLIDING, **given)
    assert np.count_nonzero(found.D) == 1, "a force accelerates at once"
    scaled = found.scaled()
    nominal = {name: plant.variables[name].nominal for names in given.values() for name in names}
    for frequency in (1.0, 1e3):
        there, here = (
            one.C @ np.linalg.solve(2j * np.pi * frequency * np.eye(len(one.A)) - one.A, one.B) + one.D
            for one in (scaled, found)
        )
        for row, output in enumerate(given["outputs"]):
            for column, name in enumerate(given["inputs"]):
                expected = here[row, column] * nominal[name] / nominal[output]
                assert_close(there[row, column], expected, rel=2e-11, what="transfer")


def test_text_has_a_row_for_each_row_of_a_matrix(plant: ps.Model) -> None:
    found = plant.linearise(at=SLIDING)
    lines = repr(found).splitlines()
    for title, rows in (("A", found.states), ("B", found.states), ("C", found.outputs), ("D", found.outputs)):
        begin = next(index for index, line in enumerate(lines) if line.split(" ")[0] == title)
        assert [line.split(" ")[0] for line in lines[begin + 1 : begin + 1 + len(rows)]] == list(rows)


def test_state_space_of_python_control_has_names(plant: ps.Model) -> None:
    system = plant.linearise(at=SLIDING).to_control()
    assert isinstance(system, control.StateSpace)
    assert system.state_labels[2] == "chamberA_pressure" and system.input_labels == ["valveVoltage"]


def test_stuck_plant_does_not_react(plant: ps.Model) -> None:
    with pytest.warns(ps.PlantWarning) as caught:
        a, b, _, _ = plant.linearise(at={"valve.hysteresis": 0.0}, states=["position", "velocity"], trim=False)
    assert [str(one.message) for one in caught] == [
        "valveVoltage = 5 V: it has no effect here, B is 0; the carriage sticks, and an input has none while the valve "
        "is in its dead zone, or within the play of its hysteresis; linearise about a motion instead, for example at "
        "velocity = 0.05 with valve.hysteresis = 0"
    ]
    assert not a.any() and not b.any()


@pytest.mark.parametrize(
    "at",
    [
        # Without supply nothing pushes the carriage uphill.
        {"velocity": 0.2, "supplyPressure": 101325.0, "incline": 1.0, "valve.hysteresis": 0.0},
        # No valve of this size feeds so much air.
        {"velocity": 5.0, "valve.hysteresis": 0.0},
        # At rest, a chamber above the supply only loses air.
        {"chamberA.pressure": 9e5, "supplyPressure": 5e5},
    ],
)
def test_point_that_does_not_exist_is_refused(plant: ps.Model, at: dict[str, float]) -> None:
    with pytest.raises(ps.TrimError, match="no operating point"):
        plant.linearise(at=at)


def test_given_velocity_that_is_lost_is_refused(plant: ps.Model) -> None:
    """So slow a mass comes to rest before the valve has followed, and Karnopp's law has it stick."""
    with pytest.raises(ps.TrimError, match=r"velocity = -1e-0?5 m/s was given, but the plant comes to velocity = 0"):
        plant.linearise(at={"velocity": -1e-5, "valve.hysteresis": 0.0, "friction.law": "Karnopp"})


def test_model_without_the_default_input_needs_inputs() -> None:
    with pytest.raises(ValueError, match="'valveVoltage' is not an input of FrictionBench; the inputs are "):
        ps.Model("FrictionBench").linearise()


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"states": ["positon"]}, "positon"),
        ({"outputs": ["positon"]}, "positon"),
        ({"inputs": ["valve.C"]}, "valve.C"),
        ({"inputs": ["valveVoltag"]}, "'valveVoltag' is not an input of PneumaticServoCylinder"),
        ({"inputs": [""]}, "'' is not an input"),
        ({"at": {"position": 0.1, "position0": 0.2}}, "position0"),
        ({"at": {"velocty": 0.1}}, "velocty"),
    ],
)
def test_wrong_names_are_named(plant: ps.Model, arguments: dict[str, object], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        plant.linearise(**{"at": SLIDING} | arguments)


def test_comparison_tells_laws_apart(plant: ps.Model) -> None:
    times = np.arange(0, 2, 1e-3)
    compared = plant.compare(
        ["Stribeck", "StribeckRegularised", "None"],
        inputs={"valveVoltage": (times, 5.0 + 2.0 * np.sin(2.0 * np.pi * times))},
        stop=2.0,
        progress=False,
    )
    rows = {law: facts for law, *facts in compared.rows()}
    travel, _, friction, rest, apart = zip(*rows.values(), strict=True)
    assert rest[0] > 0.1 and rest[2] < 0.01, "only the set-valued law rests"
    assert apart[0] == 0.0 and 0.0 < apart[1] < apart[2]
    assert friction[2] == 0.0 < friction[0] and travel[2] > travel[0]
    assert len(compared.plot().axes) == 3
    with pytest.raises(KeyError, match="Dahl"):
        compared["Dahl"]


def test_run_begins_at_an_operating_point() -> None:
    """There nothing but the position moves: after 20 ms pressures and velocity are what they were."""
    plant = ps.Model()
    found = plant.linearise({"velocity": 0.05, "valve.hysteresis": 0.0, "supplyPressure": 6e5})
    simulation = plant.start(found)
    assert simulation.get(found.states).tolist() == found.x.tolist()
    before = simulation.get(["velocity", "chamberA.pressure", "valveVoltage"])
    for _ in range(20):
        simulation.step(1e-3)
    after = simulation.get(["velocity", "chamberA.pressure", "valveVoltage"])
    assert after == pytest.approx(before, rel=2e-3)
    assert found.settings["valveVoltage"] == found.u[0]
    run = plant.simulate(found, inputs={"valveVoltage": float(found.u[0])}, stop=0.01, step=1e-3)
    assert run["velocity"][0] == 0.05


FOUR = ["position", "velocity", "chamberA.pressure", "chamberB.pressure"]


def gain(system: ps.Linearisation, frequency: float) -> np.ndarray:
    """Return the transfer at a frequency in Hz."""
    pole = 2j * np.pi * frequency * np.eye(len(system.A)) - system.A
    return np.asarray(system.C @ np.linalg.solve(pole, system.B) + system.D)


def test_states_that_are_left_out_follow_at_once(plant: ps.Model) -> None:
    """Below the slowest of them the transfer is that of the whole plant, and a regulator can be designed."""
    whole, few = plant.linearise(at=SLIDING), plant.linearise(at=SLIDING, states=FOUR)
    assert few.states == tuple(FOUR) and "valve.spool" in few.left_out and few.held == ()
    assert "left out, following at once: " in repr(few) and "valve.spool" in few._repr_html_()
    assert_close(gain(few, 1e-4), gain(whole, 1e-4), rel=1e-5, what="static gain")
    assert_close(gain(few, 1.0), gain(whole, 1.0), rel=0.1, what="gain far below the 115 Hz of the spool")
    gains, _, poles = control.lqr(few.A, few.B, np.diag([1e6, 1e2, 1e-8, 1e-8]), [[1.0]])
    assert np.isfinite(gains).all() and poles.real.max() < 0.0


def test_states_that_are_held_take_the_effect_of_an_input(plant: ps.Model) -> None:
    with pytest.warns(
        ps.PlantWarning, match=r"valveVoltage = .* V: it has no effect here, B is 0; it acts through valve"
    ):
        held = plant.linearise(at=SLIDING, states=FOUR, left_out="hold")
    assert not held.B.any() and set(held.held) == set(held.left_out) and "left out, held" in repr(held)
    whole = plant.linearise(at=SLIDING)
    kept = [whole.states.index(name) for name in FOUR]
    assert np.array_equal(held.A, whole.A[np.ix_(kept, kept)])


def test_position_that_is_left_out_is_held(plant: ps.Model) -> None:
    """It comes to no rest of its own."""
    found = plant.linearise(at=SLIDING, states=FOUR[1:], outputs=["velocity"])
    assert found.held == ("position",) and found.B.any()
    assert plant.linearise(at=SLIDING).left_out == {}


def test_other_ways_to_leave_states_out_are_refused(plant: ps.Model) -> None:
    with pytest.raises(ValueError, match=r"left_out is 'residualise' or 'hold', not 'truncate'"):
        plant.linearise(at=SLIDING, states=FOUR, left_out="truncate")  # type: ignore[arg-type]


def test_many_points_are_those_of_each_alone(plant: ps.Model) -> None:
    points = [{"velocity": velocity, "position": 0.1} for velocity in (0.02, -0.05, 0.3)]
    shared = {"valve.hysteresis": 0.0, "supplyPressure": 6e5, "position": 0.3}
    together = plant.linearise_many(points, shared=shared, workers=2)
    for point, found in zip(points, together, strict=True):
        alone = plant.linearise(shared | point)
        assert all(np.array_equal(one, other) for one, other in zip(found, alone, strict=True))
        assert found.x.tolist() == alone.x.tolist() and found.x[0] == 0.1
    with pytest.raises(ps.TrimError, match="point 1 of 2: no operating point was found: "):
        plant.linearise_many([{"velocity": 0.1}, {"velocity": 5.0}], shared=shared)
    with pytest.raises(TypeError, match="points must be a list of mappings"):
        plant.linearise_many({"velocity": [0.1]})  # type: ignore[arg-type]


def test_voltage_that_balances_nothing_is_the_cause_that_is_named() -> None:
    with pytest.raises(
        ps.TrimError, match=r"with valveVoltage = 6.5 V nothing balances at rest: .*velocity = 0.05 m/s"
    ):
        ps.Model().linearise({"valveVoltage": 6.5, "valve.hysteresis": 0.0})


def test_law_that_holds_its_force_between_samples_is_told(plant: ps.Model) -> None:
    with pytest.warns(UserWarning, match=r"friction\.law = DNLRX: it holds its force between samples"):
        linear = plant.linearise({"friction.law": "DNLRX", "velocity": 0.1})
    velocity = linear.states.index("velocity")
    assert linear.A[velocity, velocity] == 0.0

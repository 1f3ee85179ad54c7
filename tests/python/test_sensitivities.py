"""Sensitivities of runs and transitions of steps, as the Python package gives them."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from scipy.optimize import minimize

GIVEN: dict[str, Any] = {
    "inputs": {"valveVoltage": lambda t: 5.0 + 2.0 * np.sin(2.0 * np.pi * t)},
    "stop": 0.3,
    "step": 1e-3,
    "outputs": ["position", "chamberA.pressure", "valveVoltage", "sticking"],
}
TIGHT = {"solver.relativeTolerance": 1e-9}


@pytest.fixture(scope="module")
def plant() -> ps.Model:
    return ps.Model()


def test_sensitivities_are_those_of_differences(plant: ps.Model) -> None:
    names = ["valve.C", "friction.stribeck.Fs", "valveVoltage"]
    run = plant.simulate(TIGHT, sensitivities=names, **GIVEN)
    plain = plant.simulate(TIGHT, **GIVEN)
    assert run["position"].tobytes() == plain["position"].tobytes() and plain.sensitivities is None
    found = run.sensitivities
    assert found is not None and found.names == tuple(names)
    for name in names[:2]:
        value = float(plant.parameters[name].default)  # type: ignore[arg-type]
        above, below = (
            plant.simulate({**TIGHT, name: value * (1.0 + sign * 3e-5)}, **GIVEN)["position"] for sign in (1.0, -1.0)
        )
        expected = (above - below) / (6e-5 * value)
        # Of runs with errors of 1e-9 differences hold four to five digits.
        assert np.abs(found["position", name] - expected).max() < 2e-5 * np.abs(expected).max(), name
    assert (found["valveVoltage", "valveVoltage"] == 1.0).all(), "an input changes with itself"
    assert (found["valveVoltage", "valve.C"] == 0.0).all()
    assert found.jacobian("position").shape == (301, 3)
    assert len(found) == 12 and ("position", "valve.C") in list(found)


def test_events_have_delays_and_rates(plant: ps.Model) -> None:
    run = plant.simulate(
        TIGHT, sensitivities=["friction.stribeck.Fs", "valveVoltage"], start=2.0, **{**GIVEN, "stop": 2.3}
    )
    found = run.sensitivities
    assert found is not None
    event = next(event for event in found.events if event.name == "breakAway")
    assert 2.0 < event.time < 2.3 and list(event.delays) == ["friction.stribeck.Fs", "valveVoltage"]
    assert event.delays["friction.stribeck.Fs"] > 0.0 > event.delays["valveVoltage"], (
        "more friction, later; more air, sooner"
    )
    assert 0.0 < found.smallest_rate == min(abs(event.rate) for event in found.events)


def test_point_without_a_derivative_is_raised_by_time_and_reason(plant: ps.Model) -> None:
    run = plant.simulate(sensitivities=["velocity0", "valve.C"], **GIVEN)
    found = run.sensitivities
    assert found is not None and list(found.lost) == ["velocity0"]
    with pytest.raises(ps.NoDerivative, match=r"from t = 0 s on, at the start: the modes differ") as raised:
        _ = found["position", "velocity0"]
    again = pickle.loads(pickle.dumps(raised.value))
    assert (again.time, again.event, str(again)) == (0.0, "the start", str(raised.value))
    assert np.isnan(found.until_lost("position", "velocity0")).all()
    assert np.isfinite(found["position", "valve.C"]).all()


FREE = {
    "bench.drive": "Free",
    "mass": 1.5,
    "velocity0": 1e-9,
    "friction.coulomb.Fc": 2.0,
    "friction.coulomb.sigma2": 0.0,
}
HELD = {"bench.drive": "Free", "friction.coulombStiction.Fs": 1.5, "friction.coulombStiction.Fc": 1.0}
PAIR = {"trolleys": 2, "load.angle0": 1.5}


@pytest.mark.parametrize(
    ("model", "law", "parameters", "inputs", "problem"),
    [
        ("FrictionBench", "Coulomb", FREE, {"appliedForce": 2.0 - 1e-9}, r"s on, at stop: the motion only grazes"),
        (
            "FrictionBench",
            "CoulombStiction",
            HELD,
            {"appliedForce": 1.5},
            r"t = 0 s on, at the start: the modes differ",
        ),
        ("Festoon", "CoulombStiction", PAIR, {}, r"t = 0\.054\d+ s on, at breakAway: breakAway happens at the same"),
    ],
)
def test_events_without_a_derivative_are_told_by_time_and_name(
    model: str, law: str, parameters: dict[str, Any], inputs: dict[str, Any], problem: str
) -> None:
    """A motion that grazes its limit, a mode that begins just at its limit, and two events at one instant."""
    by = "load.mass" if model == "Festoon" else "friction.coulomb.Fc" if law == "Coulomb" else "appliedForce"
    given = {"friction.law": law, **parameters}
    found = ps.Model(model).simulate(given, inputs=inputs, sensitivities=[by], stop=2.0, step=0.1).sensitivities
    assert found is not None and list(found.lost) == [by]
    with pytest.raises(ps.NoDerivative, match=problem):
        _ = found[next(iter(found))]


def test_reading_that_is_rounded_is_refused(plant: ps.Model) -> None:
    parameters = {"sensor.position.sampleTime": 1e-3, "sensor.position.resolution": 1e-5}
    given = {**GIVEN, "outputs": ["position", "sensor.position.reading"]}
    found = plant.simulate(parameters, sensitivities=["valve.C"], **given).sensitivities
    assert found is not None
    assert np.isfinite(found["position", "valve.C"]).all()
    with pytest.raises(ps.NoDerivative, match=r"at sensor\.position\.reading: it is rounded"):
        _ = found["sensor.position.reading", "valve.C"]
    # Backwards, too, where it has a weight; what is beside it is none the worse.
    run = plant.simulate({**parameters, "valve.hysteresis": 0.0}, **given)
    with pytest.raises(ps.NoDerivative, match=r"t = 0\.3 s on, at sensor\.position\.reading: it is rounded"):
        run.vjp({"sensor.position.reading": np.arange(301.0)})
    assert np.isfinite(run.vjp({"position": 1.0}).inputs["valveVoltage"]).all()


@pytest.mark.parametrize(
    ("names", "problem"),
    [
        (["valve.D"], "there is no variable valve.D; did you mean"),
        (["friction.law"], "with respect to friction.law: it is a choice"),
        (["friction.gms.N"], "with respect to friction.gms.N: it is a whole number"),
        (["valve.C", "valve.C"], "with respect to valve.C: it is given twice"),
        (["solver.relativeTolerance"], "it changes how a run is computed"),
    ],
)
def test_names_of_no_direction_are_refused(plant: ps.Model, names: list[str], problem: str) -> None:
    with pytest.raises(ValueError, match=problem.replace(".", r"\.")):
        plant.simulate(sensitivities=names, **GIVEN)


def test_text_is_no_list_of_names(plant: ps.Model) -> None:
    with pytest.raises(TypeError, match=r"sensitivities must be a list of names, not the text 'valve\.C'"):
        plant.simulate(sensitivities="valve.C", **GIVEN)


def test_sensitivities_that_do_not_fit_into_memory_are_refused_before_the_run(plant: ps.Model) -> None:
    names = [name for name, variable in plant.parameters.items() if variable.kind == "real" and "solver" not in name]
    with pytest.raises(MemoryError, match=r"in 3000001 rows do not fit into 2 GiB: record fewer"):
        plant.simulate(sensitivities=names[:30], **{**GIVEN, "stop": 3000.0})


def test_what_was_not_recorded_or_has_no_slope_is_named(plant: ps.Model) -> None:
    found = plant.simulate(sensitivities=["valve.C"], **GIVEN).sensitivities
    assert found is not None
    with pytest.raises(KeyError, match="velocity is not recorded"):
        _ = found["velocity", "valve.C"]
    with pytest.raises(KeyError, match=r"the run is not differentiated by valve\.c; did you mean valve\.C"):
        _ = found["position", "valve.c"]
    with pytest.raises(TypeError, match=r"""two names are needed, .*, not 'position'"""):
        _ = found["position"]  # type: ignore[index]
    with pytest.raises(KeyError, match="sticking is no real number"):
        _ = found["sticking", "valve.C"]


def test_transition_maps_small_changes(plant: ps.Model) -> None:
    """Through a break-away: 1 ms in which the carriage begins to slide."""
    simulation = plant.start({**TIGHT, "valveVoltage": 6.0})
    run = plant.simulate({**TIGHT, "valveVoltage": 6.0}, sensitivities=["valveVoltage"], stop=0.3, step=1e-3)
    assert run.sensitivities is not None
    steps = int(next(event.time for event in run.sensitivities.events if event.name == "breakAway") * 1e3)
    for _ in range(steps):
        simulation.step(1e-3)
    saved = simulation.save()
    size, outputs = 4e-3, ["position", "velocity", "chamberA.pressure"]
    step = simulation.transition(size, parameters=["valve.C"], outputs=outputs)
    assert simulation["sticking"] == 0.0
    A, B, C, D = step
    assert A.shape == (len(step.next_states), len(step.states)) and B.shape == (
        len(step.next_states),
        len(plant.inputs),
    )
    assert C.shape == (3, len(step.states)) and D.shape == (3, len(plant.inputs)) and step.Q.shape == (3, 1)
    assert step.inputs == tuple(plant.inputs) and step.parameters == ("valve.C",) and step.outputs == tuple(outputs)

    def after(change: float) -> np.ndarray:
        simulation.restore(saved)
        simulation.move_states({"chamberA.pressure": simulation["chamberA.pressure"] + change})
        simulation.step(size)
        return simulation.get(outputs)

    expected = (after(2.0) - after(-2.0)) / 4.0
    column = C[:, step.states.index("chamberA.pressure")]
    assert np.allclose(column, expected, rtol=1e-4, atol=1e-12), (column, expected)


def test_transition_refuses_by_name_and_does_nothing_then(plant: ps.Model) -> None:
    simulation = plant.start()
    with pytest.raises(ValueError, match="with respect to position: it is no parameter"):
        simulation.transition(1e-3, parameters=["position"])
    with pytest.raises(ValueError, match="there is no variable posiion; did you mean position"):
        simulation.transition(1e-3, outputs=["posiion"])
    with pytest.raises(ValueError, match="leads nowhere"):
        simulation.transition(0.0)
    assert simulation.time == 0.0


def test_transitions_of_many_have_the_bits_of_one(plant: ps.Model) -> None:
    """Of several laws, with memories of their own, and of another model; on one thread and on several."""
    laws = ["Stribeck", "LuGre", "CoulombStiction", "MaxwellSlip"]

    def simulations() -> list[ps.Simulation]:
        begun = [plant.start({"friction.law": law, "valveVoltage": 6.0 + number}) for number, law in enumerate(laws)]
        for number, simulation in enumerate(begun):
            simulation.step(0.05 + 0.01 * number)
        return [*begun, ps.Model("FrictionBench").start({"friction.law": "GMS"})]

    size, by, of = 2e-3, ["velocity0"], ["velocity", "frictionForce"]
    alone = simulations()
    expected = [simulation.transition(size, parameters=by, outputs=of) for simulation in alone]
    for workers in (1, 3, None):
        together = simulations()
        found = ps.transitions(together, size, parameters=by, outputs=of, workers=workers)
        assert [simulation.save().to_bytes() for simulation in together] == [it.save().to_bytes() for it in alone]
        for one, other in zip(found, expected, strict=True):
            for name in ("A", "B", "C", "D", "P", "Q"):
                assert getattr(one, name).tobytes() == getattr(other, name).tobytes(), name
            assert (one.states, one.next_states, one.inputs) == (other.states, other.next_states, other.inputs)
            assert {name: str(lost) for name, lost in one.lost.items()} == {
                name: str(lost) for name, lost in other.lost.items()
            }
    assert len({one.states for one in found}) > 2, "states differ from law to law"


def test_transitions_of_many_refuse_by_name_and_number(plant: ps.Model) -> None:
    simulations = [plant.start(), plant.start()]
    with pytest.raises(ValueError, match="simulation 2 is given twice"):
        ps.transitions([*simulations, simulations[0]], 1e-3)
    with pytest.raises(ValueError, match="there is no variable posiion; did you mean position"):
        ps.transitions(simulations, 1e-3, outputs=["posiion"])
    with pytest.raises(ValueError, match=r"with respect to friction\.law: it is a choice"):
        ps.transitions(simulations, 1e-3, parameters=["friction.law"])
    with pytest.raises(ValueError, match="leads nowhere"):
        ps.transitions(simulations, 0.0)
    with pytest.raises(ValueError, match="workers = 0 is refused: it must be at least 1"):
        ps.transitions(simulations, 1e-3, workers=0)
    assert [simulation.time for simulation in simulations] == [0.0, 0.0]
    assert ps.transitions([], 1e-3) == []


def test_adjoint_times_seed_is_tangent_times_cotangent(plant: ps.Model) -> None:
    """The chain of transitions forwards, with random seeds, against `vjp`, which takes it backwards."""
    rng = np.random.default_rng(1)
    parameters = {"friction.law": "CoulombStiction"}
    steps, names, outputs = 200, ["valve.C", "position0"], ["position", "chamberB.pressure"]
    voltage = 5.0 + 2.0 * np.sin(2.0 * np.pi * np.arange(steps) * 2e-3)
    times = np.arange(steps) * 1e-3
    run = plant.simulate(
        parameters, inputs={"valveVoltage": (times, voltage)}, stop=0.2, step=1e-3, outputs=outputs, sensitivities=names
    )
    weights = rng.standard_normal((2, steps + 1)) / [[1.0], [1e5]]
    gradient = run.vjp(dict(zip(outputs, weights, strict=True)), parameters=names)
    seeds = {"valveVoltage": rng.standard_normal(steps), "valve.C": 1e-9}
    # The first voltage sets the start, too.
    seeds["valveVoltage"][0] = 0.0
    simulation = plant.start({**parameters, "valveVoltage": voltage[0]})
    state, total = dict.fromkeys(gradient.states, 0.0), 0.0
    for step in range(steps):
        simulation.set_one("valveVoltage", voltage[step])
        made = simulation.transition(1e-3, parameters=["valve.C"], outputs=outputs)
        x = np.array([state.get(name, 0.0) for name in made.states])
        u = seeds["valveVoltage"][step] * np.eye(made.D.shape[1])[0]
        p = np.array([seeds["valve.C"]])
        total += weights[:, step + 1] @ (made.C @ x + made.D @ u + made.Q @ p)
        state = dict(zip(made.next_states, made.A @ x + made.B @ u + made.P @ p, strict=True))
    found = gradient.inputs["valveVoltage"] @ seeds["valveVoltage"] + gradient.parameters["valve.C"] * seeds["valve.C"]
    assert abs(found - total) <= 1e-10 * abs(total)
    # Sensitivities that are carried along have an error control of their own: the solver's tolerance.
    assert run.sensitivities is not None and any(event.name == "breakAway" for event in run.sensitivities.events)
    for name in names:
        forward = sum(run.sensitivities[of, name] @ row for of, row in zip(outputs, weights, strict=True))
        assert abs(gradient.parameters[name] - forward) < 1e-5 * abs(forward), name


def test_gradient_is_that_of_differences_of_runs(plant: ps.Model) -> None:
    """By the voltage of a step, of the first, which sets the start, and of the highest, which the play holds."""
    times = np.arange(150) * 2e-3
    voltage = np.concatenate([np.linspace(6.0, 6.7, 105), np.linspace(6.695, 6.3, 45)])

    def end(change: float, at: int) -> ps.Run:
        changed = voltage.copy()
        changed[at] += change
        return plant.simulate(
            {"solver.relativeTolerance": 1e-10}, inputs={"valveVoltage": (times, changed)}, stop=0.3, step=2e-3,
            outputs=["position"], every=5,
        )  # fmt: skip

    weights = np.zeros(31)
    weights[-1] = 1.0
    gradient = end(0.0, 0).vjp({"position": weights}).inputs["valveVoltage"]
    for at in (0, 20, 80, 104):
        expected = (end(1e-4, at)["position"][-1] - end(-1e-4, at)["position"][-1]) / 2e-4
        # Differences of runs with errors of 1e-10 agree to 1e-7; at the begin, where the carriage rests, to 4e-5.
        assert abs(gradient[at] - expected) < (1e-6 if at else 1e-4) * abs(expected), at
    assert gradient[104] > 4.0 * gradient[103], "the highest voltage lasts for some steps"


def test_voltage_that_rests_is_treated_as_chosen(plant: ps.Model) -> None:
    """More of it moves the spool, less does not; parameters are none the worse."""
    given = {"inputs": {"valveVoltage": 6.5}, "stop": 0.2, "step": 1e-3, "outputs": ["position"]}
    for play in (0.01, 0.0):
        run = plant.simulate({"valve.hysteresis": play}, **given)
        for at_rest in ("mean", "zero", "refuse"):
            simulation = plant.start({"valve.hysteresis": play, "valveVoltage": 6.5})
            simulation.step(0.2)
            step = simulation.transition(1e-3, outputs=["position"], at_rest=at_rest)
            is_lost = play > 0.0 and at_rest == "refuse"
            assert ("valveVoltage" in step.lost) == is_lost == bool(np.isnan(step.B[:, 0]).any())
            assert "position" not in step.lost and np.isfinite(step.A[:, step.states.index("position")]).all()
            if is_lost:
                with pytest.raises(ps.NoDerivative, match=r"at valveVoltage: left and right derivatives .* at_rest$"):
                    run.vjp({"position": 1.0}, at_rest=at_rest)
            else:
                gradient = run.vjp({"position": 1.0}, parameters=["valve.C"], at_rest=at_rest)
                by_voltage = gradient.inputs["valveVoltage"]
                assert np.isfinite(by_voltage).all() and by_voltage.any() == (play == 0.0 or at_rest == "mean")
                assert gradient.parameters["valve.C"] > 0.0
    with pytest.raises(ValueError, match="at_rest = 'nan' is refused: it must be one of mean, zero, refuse"):
        run.vjp({"position": 1.0}, at_rest="nan")  # type: ignore[arg-type]


def test_mean_at_rest_is_that_of_the_differences_to_both_sides(plant: ps.Model) -> None:
    def at(more: float) -> ps.Simulation:
        simulation = plant.start({"valveVoltage": 6.5, "solver.relativeTolerance": 1e-10})
        simulation.step(0.05)
        simulation["valveVoltage"] = 6.5 + more
        return simulation

    simulations = [at(more) for more in (0.0, 1e-4, -1e-4)]
    found, _, _ = (one.transition(1e-3, outputs=["valve.spool"]) for one in simulations)
    here, up, down = (one["valve.spool"] for one in simulations)
    assert (up - here) / 1e-4 > 0.01 and down == here
    assert found.D[0, 0] == pytest.approx(0.5 * (up - here) / 1e-4, rel=1e-4)
    # The step that was made is the one that was asked for, and many at once have the same bits.
    plain = at(0.0)
    plain.step(1e-3)
    assert plain.save().to_bytes() == simulations[0].save().to_bytes()
    [alone] = ps.transitions([at(0.0)], 1e-3, outputs=["valve.spool"])
    assert alone.D.tobytes() == found.D.tobytes() and alone.A.tobytes() == found.A.tobytes()


def test_search_can_begin_with_a_voltage_that_rests(plant: ps.Model) -> None:
    """The way of the carriage after 0.1 s, by 50 voltages that are all the same at first."""
    points = 2e-3 * np.arange(50)

    def cost(voltages: np.ndarray) -> tuple[float, np.ndarray]:
        run = plant.simulate(inputs={"valveVoltage": {"hold": (points, voltages)}}, stop=0.1, step=2e-3,
                             outputs=["position"])  # fmt: skip
        weights = np.zeros(51)
        weights[-1] = 1.0
        off = 1e3 * (run["position"][-1] - 0.26)
        return off**2, 2e3 * off * run.vjp({"position": weights}).inputs["valveVoltage"]

    start = np.full(50, 6.5)
    found = minimize(cost, start, jac=True, method="L-BFGS-B", bounds=[(0.1, 9.9)] * 50, options={"maxiter": 15})
    assert found.fun < 1e-3 * cost(start)[0]


@pytest.mark.filterwarnings("ignore:friction.stribeck.Fc = ")
def test_what_follows_a_parameter_is_in_its_column(plant: ps.Model) -> None:
    def at(force: float) -> ps.Simulation:
        simulation = plant.start({"friction.stribeck.Fs": force, "valveVoltage": 8.0, "valve.hysteresis": 0.0})
        simulation.step(0.2)
        return simulation

    outputs = ["velocity", "frictionForce"]
    found = at(7.0).transition(1e-3, parameters=["friction.stribeck.Fs"], outputs=outputs)
    [many] = ps.transitions([at(7.0)], 1e-3, parameters=["friction.stribeck.Fs"], outputs=outputs)
    assert found.parameters == ("friction.stribeck.Fs",) and many.Q.tobytes() == found.Q.tobytes()
    alone = at(7.0).transition(1e-3, parameters=["friction.stribeck.Fs", "friction.stribeck.Fc"], outputs=outputs)
    # Sliding friction is the part of it that the defaults are.
    assert found.Q[:, 0] == pytest.approx(alone.Q[:, 0] + 8.3 / 11.0 * alone.Q[:, 1], rel=1e-12)
    assert abs(found.Q[1, 0]) > 2.0 * abs(alone.Q[1, 0])


def test_gradients_refuse_what_has_none(plant: ps.Model) -> None:
    run = plant.simulate(**GIVEN)
    with pytest.raises(KeyError, match="velocity was not recorded"):
        run.vjp({"velocity": 1.0})
    with pytest.raises(ValueError, match="sticking is no real number"):
        run.vjp({"sticking": 1.0})
    with pytest.raises(ValueError, match=r"have the shape \(3,\); the run has 301 rows"):
        run.vjp({"position": [1.0, 2.0, 3.0]})
    with pytest.raises(ValueError, match="must be finite"):
        run.vjp({"position": np.nan})
    with pytest.raises(ValueError, match=r"friction\.law: it is a choice"):
        run.vjp({"position": 1.0}, parameters=["friction.law"])
    with pytest.raises(ValueError, match="one by one"):
        plant.simulate_many([{}], **GIVEN, progress=False)[0].vjp({"position": 1.0})
    constant = plant.simulate(inputs={"valveVoltage": 6.0}, stop=0.01, step=1e-3)
    with pytest.raises(ValueError, match="one by one"):
        pickle.loads(pickle.dumps(constant)).vjp({"position": 1.0})

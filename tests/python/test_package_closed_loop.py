"""Closed loops: runs with a controller are runs as all others."""

from __future__ import annotations

import functools
import pickle
import threading
from collections.abc import Callable, Mapping
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


def integrating(shared: list[float] | None = None) -> Callable[[float, Mapping[str, float]], float]:
    """Return a PI law as people write it: its integral is a variable of the function around it."""
    integral, kept = 0.0, shared or [0.0]

    def add(error: float) -> None:
        nonlocal integral
        integral += error
        kept[0] += error

    def law(time: float, seen: Mapping[str, float]) -> float:
        error = 0.3 - seen["position"]
        add(error)
        return min(max(5.0 + 10.0 * error + 0.05 * integral + 0.05 * kept[0], 0.0), 10.0)

    return law


class Pid:
    def __init__(self) -> None:
        self.integral = 0.0

    def act(self, gain: float, time: float, seen: Mapping[str, float]) -> float:
        self.integral += 0.3 - seen["position"]
        return min(max(5.0 + gain * (0.3 - seen["position"]) + 0.1 * self.integral, 0.0), 10.0)


def by_default(time: float, seen: Mapping[str, float], kept: list[float] = [0.0]) -> float:  # noqa: B006
    kept[0] += 0.3 - seen["position"]
    return min(max(5.0 + 10.0 * (0.3 - seen["position"]) + 0.1 * kept[0], 0.0), 10.0)


@pytest.mark.parametrize(
    "controller",
    [integrating(), integrating, functools.partial(Pid().act, 10.0), by_default],
    ids=["closure", "factory", "method", "default"],
)
def test_each_run_has_a_controller_without_a_past(controller: Any) -> None:
    given: dict[str, Any] = {"controller": controller, "stop": 0.3, "step": 1e-3, "outputs": ["position"]}
    plant = ps.Model()
    alone = [plant.simulate(**given)["position"].tobytes() for _ in range(2)]
    runs = plant.simulate_many({"mass.moving": [1.0, 1.0, 1.0]}, progress=False, **given)
    same = plant.simulate({"mass.moving": 1.0}, **given)["position"].tobytes()
    assert alone[0] == alone[1] and {run["position"].tobytes() for run in runs} == {same}
    assert by_default.__defaults__ == ([0.0],)


def counting(time: float, seen: Mapping[str, float]) -> float:
    counting.calls += 1  # type: ignore[attr-defined]
    return 5.0


counting.calls = 0  # type: ignore[attr-defined]


def test_state_that_no_copy_can_have_is_refused() -> None:
    lock = threading.Lock()

    def locked(time: float, seen: Mapping[str, float]) -> float:
        with lock:
            return 5.0

    for controller, told in ((counting, "counting keeps calls among its attributes"), (locked, "lock = "),
                             (lambda: 5.0, "a function without parameters makes a controller")):  # fmt: skip
        with pytest.raises(TypeError, match=told):
            ps.Model().simulate(controller=controller, stop=0.01, step=1e-3)


def test_run_of_few_rows_has_the_inputs_of_all_steps() -> None:
    given: dict[str, Any] = {"stop": 0.3, "step": 1e-3, "outputs": ["valveVoltage", "supplyPressure", "position"]}
    voltage = {"valveVoltage": lambda t: 5.0 + 2.0 * np.sin(40.0 * t), "supplyPressure": 6e5}
    plant = ps.Model()
    several = {"valveVoltage": (np.linspace(0, 0.3, 30), np.random.default_rng(1).uniform(4, 6, (2, 30)))}
    tenth = [
        (plant.simulate(inputs=voltage, every=7, **given), plant.simulate(inputs=voltage, **given)),
        (plant.simulate(controller=integrating(), every=7, **given), plant.simulate(controller=integrating(), **given)),
        *zip(plant.simulate_many(number=2, inputs=several, every=7, progress=False, **given),
             plant.simulate_many(number=2, inputs=several, progress=False, **given), strict=True),
    ]  # fmt: skip
    for few, all_rows in tenth:
        again = plant.simulate(inputs=few, **given)
        assert again["position"].tobytes() == all_rows["position"].tobytes()
        assert few.select(["valveVoltage"]).inputs_between_rows() == ["valveVoltage"]
        with pytest.warns(ps.PlantWarning, match="valveVoltage changed between rows"):
            frame = few.to_pandas()
        with pytest.raises(ValueError, match="valveVoltage changed between rows"):
            plant.simulate(inputs=frame, **given)
        for record in (few, frame):
            with pytest.raises(ValueError, match="valveVoltage changed between rows"):
                ps.fit(record, experiment="rig", law="Coulomb")
    # Rows that have it all: a voltage that holds for as long.
    held = plant.simulate(inputs={"valveVoltage": {"hold": ([0.0, 0.1, 0.2], [5.0, 6.0, 4.0])}}, every=10, **given)
    assert held.inputs_between_rows() == [] and not held.to_pandas().attrs
    # Of many loops nobody keeps the steps.
    [loop] = plant.simulate_many(number=1, controller=integrating(), every=7, progress=False, **given)
    with pytest.raises(ValueError, match="each row stands for 7 steps"):
        plant.simulate(inputs=loop, **given)


class Telling:
    """A controller with a state, which tells its error beside the voltage."""

    def __init__(self) -> None:
        self.sum = 0.0

    def __call__(self, time: float, seen: Mapping[str, float]) -> dict[str, float]:
        error = 0.3 - seen["position"]
        self.sum += error
        return {"valveVoltage": 5.0 + 4.0 * error + 1e-3 * self.sum, "error": error, "sum": self.sum}


def test_controller_is_given_back_and_what_it_tells_is_recorded() -> None:
    plant, own = ps.Model(), Telling()
    run = plant.simulate(
        stop=0.1, step=1e-3, outputs=["position"], controller=own, period=2e-3, record={"error": "m", "sum": "m"}
    )
    assert run.variables["error"].unit == "m" and list(run.variables)[-2:] == ["error", "sum"]
    # A row has the values of the last sample before it; the samples are those of every second row.
    samples = 0.3 - run["position"][:-1:2]
    assert run["error"][1::2].tolist() == samples.tolist() == run["error"][2::2].tolist()
    assert isinstance(run.controller, Telling) and run.controller is not own and own.sum == 0.0
    assert run.controller.sum == run["sum"][-1] == pytest.approx(samples.sum())
    assert run.to_pandas()["error"].iloc[0] == samples[0] and run[["error"]].controller is run.controller
    factory = plant.simulate(stop=0.1, step=1e-3, controller=Telling, period=2e-3, record=["error", "sum"])
    assert isinstance(factory.controller, Telling) and factory["sum"].tolist() == run["sum"].tolist()
    assert pickle.loads(pickle.dumps(run)).controller is None


def test_variables_of_a_controller_of_the_library_are_recorded() -> None:
    plant = ps.Model()
    name = next(iter(ps.Model("PositionController").outputs.keys() - plant.variables.keys()))
    run = plant.simulate(
        inputs={"referencePosition": 0.3}, stop=0.05, step=1e-3, controller="PositionController", record=[name]
    )
    assert isinstance(run.controller, ps.Simulation)
    assert run[name][-1] == run.controller[name] and run.variables[name].text


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"controller": Telling}, r"the controller sets error, which is no input.* recorded by record=\['error'\]"),
        ({"controller": Telling, "record": ["position"]}, "record: position is a variable of PneumaticServoCylinder"),
        ({"controller": "PositionController", "record": ["eror"]}, "record: the controller has no variable eror"),
        ({"controller": lambda _t, _y: {"a": "b"}, "record": ["a"]}, "the controller records a = 'b': no number"),
        ({"record": ["error"]}, "record is for a controller, and none is given"),
    ],
)
def test_what_cannot_be_recorded_is_named(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ps.Model().simulate(stop=0.01, step=1e-3, **options)


class Beside:
    """The controller of the library, stepped from Python beside the plant."""

    def __init__(self, reference: Callable[[float], float], period: float, **gains: float) -> None:
        self.reference, self.period, self.running = reference, period, None
        self.settings: dict[str, Any] = {"sampleTime": period, **{f"gain.{name}": gain for name, gain in gains.items()}}

    def __call__(self, time: float, seen: Mapping[str, float]) -> dict[str, float]:
        measured = {"position": seen["position"], "velocity": seen["velocity"]}
        measured["referencePosition"] = self.reference(time)
        if self.running is None:
            self.running: Any = ps.Model("PositionController").start({**self.settings, **measured})
        self.running.set(measured)
        self.running.step(self.period)
        return {"valveVoltage": self.running["valveVoltage"], "integral": self.running["integral"]}


def reference(time: float) -> float:
    return 0.25 + 0.04 * np.sin(9.0 * time)


@pytest.mark.parametrize(
    "options",
    [{}, {"period": 3e-3, "every": 7}, {"period": 2e-3, "delay": 5e-3}, {"start": 0.7, "stop": 1.1, "delay": 1e-3}],
    ids=["each step", "every third", "late", "another clock"],
)
def test_controller_of_the_library_beside_the_plant_has_the_bits_of_one_in_python(options: dict[str, Any]) -> None:
    given: dict[str, Any] = {**SHORT, "record": ["integral"], **options}
    plant = ps.Model()
    moved = {"externalForce": lambda t: 20.0 * np.sin(30.0 * t)}
    here = plant.simulate(START, controller=Beside(reference, given.get("period", 1e-3), velocity=6.0), inputs=moved,
                          **given)  # fmt: skip
    there = plant.simulate(
        START, controller=("PositionController", {"gain.velocity": 6.0}),
        inputs={**moved, "referencePosition": reference}, **given,
    )  # fmt: skip
    for name in here:
        assert here[name].tobytes() == there[name].tobytes(), name
    assert np.ptp(there["integral"][1:]) > 0.0 and np.ptp(there["position"]) > 0.02
    assert there.controller["time"] > 0.0 and there.controller["integral"] == there["integral"][-1]


MANY: dict[str, Any] = {
    "parameters": {"mass.moving": np.linspace(0.8, 1.6, 6)}, "common": START, "progress": False, "stop": 0.2,
    "step": 1e-3, "outputs": ["position", "valveVoltage"],
}  # fmt: skip


def test_many_loops_with_a_controller_of_the_library_run_on_all_cores() -> None:
    plant = ps.Model()
    references = 0.25 + np.outer(np.linspace(0.02, 0.06, 6), np.sin(9.0 * T))
    given = {**MANY, "controller": "PositionController", "record": ["positionError"]}
    runs = [
        plant.simulate_many(inputs={"referencePosition": (T, references)}, workers=workers, **given)
        for workers in (1, 3)
    ]
    assert runs[0].variables["positionError"].unit == "m"
    for number, mass in enumerate(MANY["parameters"]["mass.moving"]):
        alone = plant.simulate(
            {**START, "mass.moving": mass}, inputs={"referencePosition": (T, references[number])}, stop=0.2, step=1e-3,
            controller="PositionController", outputs=MANY["outputs"], record=["positionError"],
        )  # fmt: skip
        for name in alone:
            for many in runs:
                assert many[name][number].tobytes() == alone[name].tobytes(), (name, number)


T = np.arange(0.0, 0.2, 1e-3)


def test_refused_run_of_many_loops_is_named() -> None:
    heavy = {"mass.moving": 1.0, "mass.carriage": 5.0}
    with pytest.raises(ValueError, match=r"run 1 of 2: .*mass\.carriage = 5 kg is refused"):
        ps.Model().simulate_many([{}, heavy], inputs={"referencePosition": 0.3}, controller="PositionController",
                                 progress=False, **SHORT)  # fmt: skip

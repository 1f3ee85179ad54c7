"""The Python package: what it computes, and what it says when something is wrong."""

from __future__ import annotations

import pickle
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close, largest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

STEP = 1e-3
TIMES = np.arange(0, 1.0, STEP)
VOLTAGES = 5.0 + 2.0 * np.sin(2.0 * np.pi * TIMES)


@pytest.fixture(scope="module")
def plant() -> ps.Model:
    return ps.Model("PneumaticServoCylinder")


def by_fmu(fmu: Path, settings: dict[str, float], outputs: list[str]) -> np.ndarray:
    """The same run through FMPy: start values before initialization, then a fresh voltage at each point."""
    description = read_model_description(str(fmu))
    number = {variable.name: variable.valueReference for variable in description.modelVariables}
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=extract(str(fmu)),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="plant",
    )
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    for name, value in settings.items():
        set_value = slave.setInteger if name == "friction.law" else slave.setReal
        set_value([number[name]], [value])
    slave.setReal([number["valveVoltage"]], [VOLTAGES[0]])
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    wanted = [number[name] for name in outputs]
    rows = [slave.getReal(wanted)]
    for index, voltage in enumerate(VOLTAGES):
        slave.setReal([number["valveVoltage"]], [voltage])
        slave.doStep(currentCommunicationPoint=index * STEP, communicationStepSize=STEP)
        rows.append(slave.getReal(wanted))
    slave.freeInstance()
    return np.array(rows).T


@pytest.mark.parametrize("law", ["Stribeck", "LuGre", "GMS", "Bristle", "DNLRX"])
def test_results_are_those_of_the_fmu_bit_for_bit(plant: ps.Model, fmu: Path, law: str) -> None:
    outputs = ["position", "velocity", "frictionForce", "chamberA.pressure", "chamberB.temperature", "valve.spool"]
    run = plant.simulate(
        {"friction.law": law, "supplyPressure": 6e5},
        inputs={"valveVoltage": (TIMES, VOLTAGES)},
        stop=1.0,
        step=STEP,
        outputs=outputs,
    )
    number = plant.parameters["friction.law"].ids[law]
    expected = by_fmu(fmu, {"friction.law": number, "supplyPressure": 6e5}, outputs)
    assert np.ptp(run["position"]) > 0.01
    for name, values in zip(outputs, expected, strict=True):
        assert run[name].tobytes() == values.tobytes(), name


def test_points_functions_and_steps_by_hand_give_the_same_bits(plant: ps.Model) -> None:
    arguments = {"stop": 0.3, "step": STEP, "outputs": ["position", "chamberA.pressure"]}
    points = plant.simulate(inputs={"valveVoltage": (TIMES, VOLTAGES)}, **arguments)
    function = plant.simulate(
        inputs={"valveVoltage": lambda t: VOLTAGES[round(t / STEP)] if t < 0.9995 else 5.0}, **arguments
    )
    simulation = plant.start({"valveVoltage": VOLTAGES[0]})
    for voltage in VOLTAGES[:300]:
        simulation["valveVoltage"] = voltage
        simulation.step(STEP)
    for name in arguments["outputs"]:
        assert points[name].tobytes() == function[name].tobytes()
    # Added up, the communication points differ by rounding, and so do the results.
    assert_close(simulation["position"], points["position"][-1], within=5e-15, what="position")


def test_many_runs_have_the_bits_of_single_ones(plant: ps.Model) -> None:
    laws, gains = ["Stribeck", "LuGre", "Dahl"], np.array([0.5, 1.0, 2.0])
    courses = 5.0 + gains[:, None] * (VOLTAGES - 5.0)
    runs = plant.simulate_many(
        {"friction.law": laws, "supplyPressure": 6e5},
        inputs={"valveVoltage": (TIMES, courses), "externalForce": np.array([0.0, 1.0, 2.0])},
        stop=0.5, step=STEP, outputs=["position", "velocity"], progress=False,
    )  # fmt: skip
    assert runs["position"].shape == (3, 501)
    for number, law in enumerate(laws):
        alone = plant.simulate(
            {"friction.law": law, "supplyPressure": 6e5},
            inputs={"valveVoltage": (TIMES, courses[number]), "externalForce": float(number)},
            stop=0.5, step=STEP, outputs=["position", "velocity"],
        )  # fmt: skip
        assert runs[number]["velocity"].tobytes() == alone["velocity"].tobytes()


def test_rows_can_be_thinned_without_changing_them(plant: ps.Model) -> None:
    arguments = {"inputs": {"valveVoltage": (TIMES, VOLTAGES)}, "stop": 0.5, "step": STEP, "outputs": ["position"]}
    every, tenth = plant.simulate(**arguments), plant.simulate(**arguments, every=10)
    assert tenth["position"].tobytes() == every["position"][::10].tobytes()
    assert tenth.time.tobytes() == every.time[::10].tobytes()


def test_pairs_of_points_at_one_time_make_a_step(plant: ps.Model) -> None:
    run = plant.simulate(
        inputs={"valveVoltage": ([0.0, 0.1, 0.1, 0.2], [5.0, 5.0, 6.0, 7.0])}, stop=0.3, step=0.05,
        outputs=["valveVoltage", "position"],
    )  # fmt: skip
    # A row shows the input that has been held until then.
    assert run["valveVoltage"].tolist() == [5.0, 5.0, 5.0, 6.0, 6.5, 7.0, 7.0]


def test_saved_states_repeat_bit_for_bit(plant: ps.Model) -> None:
    simulation = plant.start({"friction.law": "GMS"})

    def go() -> list[float]:
        places = []
        for voltage in VOLTAGES[:200]:
            simulation["valveVoltage"] = voltage
            simulation.step(STEP)
            places.append(simulation["position"])
        return places

    go()
    saved, once = simulation.save(), go()
    simulation.restore(saved)
    assert go() == once and simulation.time == pytest.approx(0.4)


def test_saved_states_go_through_bytes_and_pickles(plant: ps.Model) -> None:
    simulation = plant.start({"friction.law": "LuGre"})
    simulation["valveVoltage"] = 7.0
    simulation.step(0.1)
    saved = simulation.save()
    simulation.step(0.1)
    expected = simulation["position"]
    for copy in (ps.SavedState.from_bytes(saved.to_bytes()), pickle.loads(pickle.dumps(saved))):
        other = plant.start({"friction.law": "LuGre"})
        other.restore(copy)
        other.step(0.1)
        assert other["position"] == expected
    data = bytearray(saved.to_bytes())
    data[len(data) // 2] ^= 1
    for broken in (bytes(data), saved.to_bytes()[:-1], b""):
        with pytest.raises(ValueError, match=f"{len(broken)} bytes are no state"):
            ps.SavedState.from_bytes(broken)


def test_saved_state_of_another_law_is_refused(plant: ps.Model) -> None:
    saved = plant.start({"friction.law": "LuGre"}).save()
    simulation = plant.start({"friction.law": "Stribeck"})
    with pytest.raises(ValueError, match="saved state"):
        simulation.restore(saved)
    assert simulation.time == 0.0


def test_run_that_does_not_fit_into_memory_is_refused(plant: ps.Model) -> None:
    with pytest.raises(MemoryError, match="every"):
        plant.simulate(stop=3.6e6, step=1e-6)
    with pytest.raises(MemoryError, match="1000 runs"):
        plant.simulate_many({}, number=1000, stop=3.6e6, step=1e-5)


def test_variables_are_those_of_the_description(plant: ps.Model, fmu: Path) -> None:
    described = {variable.name: variable for variable in read_model_description(str(fmu)).modelVariables}
    # A choice by name needs no Integers that choose by number.
    numbers = {f"{name}Number" for name, variable in plant.parameters.items() if variable.kind == "enumeration"}
    assert numbers <= set(described)
    # FMI 2.0 needs no variable for the time.
    assert set(plant.variables) - {"time"} == set(described) - numbers
    for name, variable in plant.variables.items():
        if name == "time":
            continue
        assert variable.text == described[name].description
    conductance = plant.parameters["valve.C"]
    assert (conductance.default, conductance.unit, conductance.minimum is not None) == (3.93e-9, "m3/(s.Pa)", True)
    assert plant.parameters["friction.law"].default == "Stribeck"
    of_options = ["imposedPosition", "imposedVelocity", "valveVoltageA", "valveVoltageB"]
    coils = [f"coil[{number}]" for number in (1, 2, 3, 4)]
    assert list(plant.inputs) == ["valveVoltage", "externalForce", "supplyPressure", *of_options, *coils]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda plant: ps.Model("Cylinder"), ["Cylinder", "PneumaticServoCylinder"]),
        (lambda plant: plant.simulate({"valve.c": 1.0}), ["valve.c", "valve.C"]),
        (lambda plant: plant.simulate({"valve.deadZone": 2.0}), ["valve.deadZone", "2", "0.9"]),
        (lambda plant: plant.simulate({"friction.law": "Lugre"}), ["friction.law", "Lugre", "LuGre"]),
        (lambda plant: plant.simulate({"cylinder.rod": 0.5}), ["cylinder", "0.5"]),
        (lambda plant: plant.simulate({"position": 0.1}), ["position", "computed"]),
        (lambda plant: plant.simulate(outputs=["positon"]), ["positon", "position"]),
        (lambda plant: plant.simulate(outputs=[]), ["outputs"]),
        (lambda plant: plant.simulate(outputs=["position"] * 2), ["position", "twice"]),
        (lambda plant: plant.simulate(inputs={"voltage": 5.0}), ["voltage", "valveVoltage"]),
        (lambda plant: plant.simulate(inputs={"valveVoltage": ([0, 1], [5, np.nan])}), ["valveVoltage", "nan", "1.0"]),
        (lambda plant: plant.simulate(inputs={"valveVoltage": ([0, 1, 0.5], [5] * 3)}), ["valveVoltage", "1.0", "0.5"]),
        (lambda plant: plant.simulate(inputs={"valveVoltage": ([0, 1], [5])}), ["valveVoltage", "shape"]),
        (lambda plant: plant.simulate(inputs={"supplyPressure": ([0, 1], [5e5, -1.0])}), ["supplyPressure", "-1"]),
        (lambda plant: plant.simulate(inputs={"supplyPressure": lambda t: 1.0 - t}), ["supplyPressure", "1.001"]),
        (lambda plant: plant.simulate({"valveVoltage": 5}, inputs={"valveVoltage": 5.0}), ["valveVoltage", "twice"]),
        (lambda plant: plant.simulate(stop=1.0, step=0.3), ["1.0", "0.3"]),
        (lambda plant: plant.simulate(step=-1.0), ["step", "-1.0"]),
        (lambda plant: plant.simulate(stop=float("nan")), ["stop", "nan"]),
        (lambda plant: plant.simulate_many([{}, {"valve.b": -1.0}], progress=False), ["run 1", "valve.b", "-1"]),
        (lambda plant: plant.simulate_many({"valve.b": [0.2, 0.3], "mass.moving": [1.0]}), ["valve.b", "mass.moving"]),
        (lambda plant: plant.start().set({"friction.law": "LuGre"}), ["friction.law", "fixed"]),
        (lambda plant: plant.start().step(0.0), ["0"]),
        (lambda plant: plant.start().step(float("nan")), ["NaN"]),
        (lambda plant: plant.compare(["LuGre"], {"friction.law": "Dahl"}), ["friction.law", "twice"]),
        (lambda plant: plant.compare(["LuGre"], {"friction.lawNumber": 10}), ["friction.lawNumber", "twice"]),
        (lambda plant: plant.start({"friction.law": 1.5}), ["friction.law", "1.5"]),
        (lambda plant: plant.start({"valve.polarity": 0.5}), ["valve.polarity", "0.5"]),
        (lambda plant: plant.start({"balance.enabled": 0.5}), ["balance.enabled", "0.5"]),
    ],
)  # fmt: skip
def test_bad_input_is_named(plant: ps.Model, call: Callable[[ps.Model], object], words: list[str]) -> None:
    with pytest.raises(ValueError, match=re.escape(words[0])) as caught:
        call(plant)
    assert all(word in str(caught.value) for word in words), str(caught.value)


POINTS = ([0.0, 1.0], [5.0, 6.0])
FORMS = "a constant, a pair (t, u)"


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda plant: plant.start({"supplyPressure": None}), ["supplyPressure = None", "number"]),
        (lambda plant: plant.simulate({"supplyPressure": [6e5]}), ["supplyPressure = [600000.0]", "single number"]),
        (lambda plant: plant.simulate_many([{"valve.b": None}]), ["valve.b = None", "number"]),
        (lambda plant: plant.simulate_many({"valve.b": np.zeros((2, 2))}), ["valve.b = [0. 0.]", "single number"]),
        (lambda plant: plant.start({5: 1.0}), ["5 is no name"]),
        (lambda plant: plant.start().set({"supplyPressure": None}), ["supplyPressure = None", "number"]),
        (lambda plant: plant.start().set_one("supplyPressure", None), ["supplyPressure = None", "number"]),
        (lambda plant: plant.start().move_states({"position": None}), ["position = None", "number"]),
        (lambda plant: plant.start().move_states({"position": np.nan}), ["position = NaN", "finite"]),
        (lambda plant: plant.start(time=np.nan), ["time = nan", "finite number of seconds"]),
        (lambda plant: plant.start(time="0"), ["time = '0'", "finite number of seconds"]),
        (lambda plant: plant.simulate(stop="1"), ["stop = '1'", "finite number of seconds"]),
        (lambda plant: plant.simulate(stop=1e300), ["stop = 1e+300", "1e+303 steps"]),
        (lambda plant: plant.simulate(every=2.5), ["every = 2.5", "whole number"]),
        (lambda plant: plant.simulate(every=0), ["every = 0", "at least 1"]),
        (lambda plant: plant.simulate_many([{}], workers=-1), ["workers = -1", "at least 1"]),
        (lambda plant: plant.simulate_many([{}], workers=2.5), ["workers = 2.5", "whole number"]),
        (lambda plant: plant.simulate_many(number=-1), ["number = -1", "at least 1"]),
        (lambda plant: plant.simulate(inputs={"valveVoltage": None}), ["valveVoltage = None", FORMS]),
        (lambda plant: plant.simulate(inputs={"valveVoltage": "5"}), ["valveVoltage = '5'", FORMS]),
        (lambda plant: plant.simulate(inputs={"valveVoltage": list(POINTS)}), ["valveVoltage = [[0.0, 1.0]", FORMS]),
        (lambda plant: plant.simulate(inputs={"valveVoltage": ([0, 1], [5, "x"])}), ["valveVoltage = [5, 'x']"]),
        (lambda plant: plant.simulate(inputs={"valveVoltage": ([0, 1], [5, [1]])}), ["valveVoltage = [5, [1]]"]),
        (lambda plant: plant.simulate(inputs={"valveVoltage": lambda t: None}), ["t = 0 s valveVoltage = None"]),
        (lambda plant: plant.simulate_many([{}], inputs={"valveVoltage": None}), ["valveVoltage = None", FORMS]),
        (lambda plant: plant.simulate_many([{}], inputs={"valveVoltage": "5"}), ["valveVoltage = '5'", FORMS]),
        (lambda plant: plant.simulate_many([{}], inputs={"valveVoltage": [5, [6]]}), ["valveVoltage = [5, [6]]"]),
        (lambda plant: plant.simulate_many([{}], inputs={"valveVoltage": lambda t: ""}), ["0 s valveVoltage = ''"]),
    ],
)  # fmt: skip
def test_value_of_another_kind_is_named(plant: ps.Model, call: Callable[[ps.Model], object], words: list[str]) -> None:
    with pytest.raises(ValueError, match=re.escape(words[0])) as caught:
        call(plant)
    assert all(word in str(caught.value) for word in words), str(caught.value)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda plant: plant.simulate(outputs="carriage.x"), "outputs must be a list of names, not the text 'carriage"),
        (lambda plant: plant.simulate(outputs=5), "outputs must be a list of names, not 5"),
        (lambda plant: plant.simulate(outputs=[1]), "outputs must be a list of names, but has 1"),
        (lambda plant: plant.simulate_many([{}], outputs="position"), "outputs must be a list of names, not the text"),
        (lambda plant: plant.compare("LuGre"), "laws must be a list of names, not the text 'LuGre'"),
        (lambda plant: plant.compare(["LuGre"], outputs="position"), "outputs must be a list of names, not the text"),
        (lambda plant: plant.linearise(states="position"), "states must be a list of names, not the text 'position'"),
        (lambda plant: plant.linearise(inputs="valveVoltage"), "inputs must be a list of names, not the text 'valve"),
        (lambda plant: plant.linearise(outputs="position"), "outputs must be a list of names, not the text 'position'"),
        (lambda plant: plant.start().get("position"), "names must be a list of names, not the text 'position'"),
        (lambda plant: plant.start().jacobian("velocity", ["position"]), "of must be a list of names, not the text"),
        (lambda plant: plant.start().jacobian(["velocity"], "position"), "to must be a list of names, not the text"),
        (lambda plant: plant.start("LuGre"), "parameters must be a mapping of names to values, not 'LuGre'"),
        (lambda plant: plant.simulate(inputs=[5.0]), "inputs must be a mapping of names to values, not [5.0]"),
        (lambda plant: plant.simulate_many(["x"]), "parameters[0] must be a mapping of names to values, not 'x'"),
        (lambda plant: plant.simulate_many("LuGre"), "parameters must be mappings of names to values, not 'LuGre'"),
        (lambda plant: plant.start().set("x"), "values must be a mapping of names to values, not 'x'"),
    ],
)  # fmt: skip
def test_text_is_no_list_of_names(plant: ps.Model, call: Callable[[ps.Model], object], words: str) -> None:
    with pytest.raises(TypeError, match=re.escape(words)):
        call(plant)


def test_one_constant_is_for_all_runs(plant: ps.Model) -> None:
    runs = plant.simulate_many([{}, {"friction.law": "None"}], inputs={"valveVoltage": 7}, stop=0.01, step=STEP,
                               progress=False)  # fmt: skip
    assert (runs["valveVoltage"] == 7.0).all()


@pytest.mark.parametrize("wrong", [{"valveVoltage": None}, {"valveVoltage": np.nan}, {"voltage": 5.0}])
def test_values_are_set_all_or_none(plant: ps.Model, wrong: dict[str, float]) -> None:
    simulation, other = plant.start({"friction.law": "LuGre"}), plant.start({"friction.law": "LuGre"})
    with pytest.raises(ValueError, match=next(iter(wrong))):
        simulation.set({"supplyPressure": 7e5, "friction.lugre.Fs": 12.0, **wrong})
    assert simulation["supplyPressure"] == plant.inputs["supplyPressure"].default
    assert simulation["friction.lugre.Fs"] == plant.parameters["friction.lugre.Fs"].default
    with pytest.raises(ValueError, match="positon"):
        simulation.move_states({"velocity": 0.1, "positon": 0.2})
    for plants in (simulation, other):
        plants.set(valveVoltage=7.0)
        plants.step(0.1)
    assert simulation["position"] == other["position"]


def test_run_that_cannot_go_on_leaves_what_was_finished(plant: ps.Model) -> None:
    settings = {"friction.law": "LuGre", "solver.scheme": "ExplicitEuler", "solver.step": 1e-3}
    with pytest.raises(ps.SimulationError, match=r"at t = .* diverges") as caught:
        plant.simulate(settings, inputs={"valveVoltage": (TIMES, VOLTAGES)}, stop=1.0, step=STEP)
    finished = caught.value.finished
    assert isinstance(finished, ps.Run)
    assert 1 <= len(finished) < 1001 and np.isfinite(finished["position"]).all()
    runs = plant.simulate_many(
        [settings, {}], inputs={"valveVoltage": (TIMES, VOLTAGES)}, stop=1.0, step=STEP, keep_failures=True,
        progress=False,
    )  # fmt: skip
    assert list(runs.failures) == [0] and runs.is_complete.tolist() == [False, True]
    assert len(runs[0]) == len(finished)


def test_exception_of_an_input_function_comes_through(plant: ps.Model) -> None:
    with pytest.raises(ZeroDivisionError):
        plant.simulate(inputs={"valveVoltage": lambda t: 1.0 / (0.1 - t) if t < 0.1 else 1 / 0}, stop=1.0, step=0.01)


def test_comparison_that_is_interrupted_keeps_the_runs_that_have_begun(plant: ps.Model) -> None:
    laws = plant.parameters["friction.law"].items

    def stop(done: int, total: int) -> None:
        assert total == len(laws)
        if done:
            raise KeyboardInterrupt

    given = {"inputs": {"valveVoltage": 6.5}, "stop": 0.1, "step": STEP}
    with pytest.raises(ps.Interrupted) as caught:
        plant.compare(laws, **given, progress=stop)
    kept = caught.value.finished
    assert isinstance(kept, ps.Comparison) and kept.laws and len(kept.laws) == len(kept.runs)
    whole = plant.compare(kept.laws, **given, progress=False)
    for law in kept.laws:
        rows = len(kept[law])
        assert rows > 0 and kept[law]["position"].tobytes() == whole[law]["position"][:rows].tobytes()


def test_comparison_has_no_runs_that_have_not_begun() -> None:
    begun = SimpleNamespace(rows=[5, 0, 3], of=lambda numbers: [f"run {number}" for number in numbers])
    kept = ps.Comparison.of_begun(["Dahl", "LuGre", "GMS"], begun)  # type: ignore[arg-type]
    assert kept is not None and kept.laws == ("Dahl", "GMS") and kept.runs == ["run 0", "run 2"]
    assert ps.Comparison.of_begun(["Dahl"], SimpleNamespace(rows=[0])) is None  # type: ignore[arg-type]


@pytest.mark.parametrize("many", [False, True])
def test_interrupt_stops_within_a_fifth_of_a_second(plant: ps.Model, many: bool) -> None:
    # Some seconds of work, of which few rows are kept.
    arguments = {"stop": 100.0 if many else 20_000.0, "step": STEP, "every": 100, "outputs": ["position"]}
    simulate = partial(plant.simulate_many, [{}] * 200, progress=False) if many else plant.simulate
    pressed: list[float] = []

    def press() -> None:
        pressed.append(time.perf_counter())
        signal.raise_signal(signal.SIGINT)

    timer = threading.Timer(0.3, press)
    timer.start()
    with pytest.raises(ps.Interrupted) as caught:
        simulate(**arguments)
    assert time.perf_counter() - pressed[0] < 0.2
    finished = caught.value.finished
    assert finished is not None and len(finished) > 1
    assert isinstance(caught.value, KeyboardInterrupt)


def test_file_that_cannot_be_written_is_named_as_it_was_given(
    plant: ps.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = plant.simulate(stop=0.01, step=STEP, outputs=["position"])
    with pytest.raises(FileNotFoundError, match=r"missing/run\.csv: there is no folder .*missing$"):
        run.to_csv(tmp_path / "missing" / "run.csv")
    with pytest.raises(IsADirectoryError, match=r": it is a folder"):
        run.to_csv(tmp_path)

    def full(**_: object) -> None:
        raise OSError(28, "No space left on device", str(tmp_path / ".run-temporary.csv"))

    monkeypatch.setattr("tempfile.mkstemp", full)
    with pytest.raises(OSError, match=r"No space left on device: '.*/run\.csv'"):
        run.to_csv(tmp_path / "run.csv")


def test_progress_is_told(plant: ps.Model) -> None:
    told: list[tuple[int, int]] = []
    plant.simulate(stop=1.0, step=STEP, outputs=["position"], progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (1000, 1000)


def test_figure_has_units_on_its_axes(plant: ps.Model) -> None:
    run = plant.simulate(inputs={"valveVoltage": (TIMES, VOLTAGES)}, stop=1.0, step=STEP)
    labels = [axis.get_ylabel() for axis in run.plot().axes]
    assert "position (mm)" in labels and "pressure (bar)" in labels
    drawn = run.plot("position").axes[0].lines[0].get_ydata()
    assert np.allclose(drawn, 1e3 * run["position"])


def test_figure_of_the_friction_shows_force_against_velocity(plant: ps.Model) -> None:
    run = plant.simulate(inputs={"valveVoltage": (TIMES, VOLTAGES)}, stop=1.0, step=STEP)
    whole, near = run.plot_friction().axes
    curves = [line for line in whole.lines if len(line.get_xdata()) == len(run)]
    assert all(np.allclose(line.get_ydata(), run["frictionForce"]) for line in curves) and curves
    assert np.allclose(curves[0].get_xdata(), 1e3 * run["velocity"])
    assert_close(near.get_xlim()[1], 50.0 * largest(run["velocity"]), rel=1e-14, what="limit")
    assert near.get_xlim()[0] == -near.get_xlim()[1]
    # All samples near standstill are within the other axis, with a twentieth of their range to spare.
    inside = run["frictionForce"][np.abs(run["velocity"]) <= 0.05 * np.max(np.abs(run["velocity"]))]
    spare = 0.05 * np.ptp(inside)
    assert spare > 0.05
    assert_close(np.array(near.get_ylim()), [np.min(inside) - spare, np.max(inside) + spare], rel=1e-14, what="range")
    with pytest.raises(KeyError, match="velocity and frictionForce"):
        plant.simulate(stop=0.01, step=STEP, outputs=["position"]).plot_friction()


def test_figure_shades_the_time_of_sticking(plant: ps.Model) -> None:
    run = plant.simulate(
        inputs={"valveVoltage": (TIMES, VOLTAGES)}, stop=1.0, step=STEP, outputs=["position", "sticking"]
    )
    shaded = run.plot("position").axes[0].collections[0].get_paths()
    beginnings = [path.vertices[:, 0].min() for path in shaded]
    starts = np.flatnonzero(np.diff(run["sticking"], prepend=0.0) > 0.0)
    assert np.allclose(beginnings, run.time[starts])
    assert not plant.simulate(stop=0.1, step=STEP, outputs=["position"]).plot().axes[0].collections


def test_other_models_run_too() -> None:
    for name in ps.models():
        model = ps.Model(name)
        assert (model.name, len(model.simulate(stop=10 * model.step))) == (name, 11)


def test_import_loads_only_what_every_use_needs() -> None:
    """Each of these takes about as long as all the rest; a command would wait for it each time."""
    program = (
        "import sys, pneumatic_servo.cli; "
        "print({'matplotlib', 'scipy', 'pandas', 'control', 'arviz', 'jax', 'torch'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert done.stdout == "set()\n"

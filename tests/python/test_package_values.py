"""Values as people type them: units, what is unusual, defaults that follow, names that are nearly right."""

from __future__ import annotations

import copy
import pickle
import re
import warnings
from collections.abc import Callable

import numpy as np
import pandas
import pint
import pneumatic_servo as ps
import pytest
from pneumatic_servo.inputs import _illegal
from pneumatic_servo.plant_warnings import SATURATES

STEP = 1e-3
SHORT: dict[str, object] = {"stop": 0.05, "step": STEP, "outputs": ["position", "chamberA.pressure"]}


@pytest.fixture(scope="module")
def plant() -> ps.Model:
    return ps.Model()


class Quantity:
    """Interface of a quantity of pint that the package uses."""

    def __init__(self, magnitude: object, factor: float) -> None:
        self.magnitude, self.units, self._factor = magnitude, "bar", factor

    def to(self, unit: str) -> Quantity:
        if unit != "Pa":
            raise ValueError(f"cannot convert bar to {unit}")
        return Quantity(self._factor * np.asarray(self.magnitude)[()], 1.0)


@pytest.mark.parametrize("supply", ["6 bar", "600 kPa", "6bar", (6, "bar"), (0.6, "MPa"), Quantity(6.0, 1e5), 6e5])
def test_pressure_may_have_a_unit(plant: ps.Model, supply: object) -> None:
    expected = plant.simulate({"supplyPressure": 6e5}, inputs={"valveVoltage": 7}, **SHORT)
    for run in (
        plant.simulate({"supplyPressure": supply}, inputs={"valveVoltage": "7 V"}, **SHORT),
        plant.simulate(inputs={"supplyPressure": supply, "valveVoltage": (7000, "mV")}, **SHORT),
        plant.simulate_many([{"supplyPressure": supply}], inputs={"valveVoltage": "7 V"}, progress=False, **SHORT)[0],
        plant.simulate_many(number=2, inputs={"supplyPressure": supply, "valveVoltage": 7}, progress=False, **SHORT)[1],
    ):
        assert run["chamberA.pressure"].tobytes() == expected["chamberA.pressure"].tobytes()
    simulation = plant.start({"supplyPressure": supply})
    assert simulation["supplyPressure"] == 6e5
    simulation["supplyPressure"] = "5 bar"
    assert simulation["supplyPressure"] == 5e5
    simulation.set({"supplyPressure": supply})
    assert simulation["supplyPressure"] == 6e5


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("cylinder.bore", "32 mm", 0.032),
        ("cylinder.bore", "3.2 cm", 0.032),
        ("ambientTemperature", "20 degC", 293.15),
        ("ambientTemperature", "20 °C", 293.15),
        ("chamberA.deadVolume", "5 cm³", 5e-6),
        ("valve.C", "0.5 dm3/(s.bar)", 5e-9),
        ("incline", "90 deg", np.pi / 2),
        ("mass.moving", "900 g", 0.9),
        ("supplyPressure", "5 barg", 601_325.0),
        ("supplyPressure", "5 bar(g)", 601_325.0),
        ("load.stiffness", "12 N/mm", 12_000.0),
    ],
)
def test_units_have_their_factors(plant: ps.Model, name: str, text: str, value: float) -> None:
    assert plant.start({name: text})[name] == pytest.approx(value, rel=1e-15)


def test_arrays_have_units_too(plant: ps.Model) -> None:
    expected = plant.simulate_many({"supplyPressure": [5e5, 6e5]}, inputs={"valveVoltage": 7}, progress=False, **SHORT)
    for given in (([5, 6], "bar"), (np.array([500.0, 600.0]), "kPa"), pint.Quantity([5.0, 6.0], "bar")):
        runs = plant.simulate_many({"supplyPressure": given}, inputs={"valveVoltage": 7}, progress=False, **SHORT)
        assert runs["position"].tobytes() == expected["position"].tobytes()
        runs = plant.simulate_many(inputs={"supplyPressure": given, "valveVoltage": 7}, progress=False, **SHORT)
        assert runs["position"].tobytes() == expected["position"].tobytes()
    one = plant.simulate(inputs={"valveVoltage": ([0, 1], [5, 6])}, **SHORT)
    for given in (([0, 1], [5000, 6000], "mV"), (pint.Quantity([0, 1000], "ms"), pint.Quantity([5000, 6000], "mV"))):
        other = plant.simulate(inputs={"valveVoltage": given}, **SHORT)
        assert one["position"].tobytes() == other["position"].tobytes()


def test_times_have_units_too(plant: ps.Model) -> None:
    given = {"inputs": {"valveVoltage": 7.0}, "outputs": ["position"]}
    expected = plant.simulate(stop=0.05, step=1e-3, **given)
    for stop, step in (("50 ms", "1 ms"), ((50, "ms"), 1e-3), (0.05, pint.Quantity(1, "ms"))):
        assert plant.simulate(stop=stop, step=step, **given)["position"].tobytes() == expected["position"].tobytes()
    assert plant.start(time="20 ms").time == 0.02
    with pytest.raises(ValueError, match=r"stop: the unit bar is refused; it must be one of s, "):
        plant.simulate(stop="5 bar")


def test_numbers_of_fits_and_plans_have_units() -> None:
    data = {"time": np.arange(0, 4, 0.01), "position": 0.02 * np.sin(2 * np.arange(0, 4, 0.01))}
    data["frictionForce"] = 7 * np.sign(np.cos(2 * data["time"])) + 0.1 * np.sin(300 * data["time"])
    given: dict[str, object] = {"experiment": "motion", "law": "Coulomb", "starts": 0, "progress": False}
    one = ps.fit(data, fit="friction.coulomb.Fc=6:1:20", play=1e-5, width=0.04, segment=2.0, **given)
    words = "friction.coulomb.Fc=6 N:1000 mN:0.02 kN"
    other = ps.fit(data, fit=words, play="10 um", width="40 ms", segment=(2000, "ms"), **given)
    assert other.values == one.values
    with pytest.raises(ValueError, match=r"fit='friction.coulomb.Fc=6 mm': the unit mm is refused"):
        ps.fit(data, fit="friction.coulomb.Fc=6 mm", **given)
    plan = {"law": "Coulomb", "experiment": "motion", "progress": False}
    assert repr(ps.plan(duration=2.0, step=0.01, stroke=0.03, **plan)) == repr(
        ps.plan(duration="2000 ms", step="10 ms", stroke="30 mm", **plan)
    )


def test_inputs_may_be_columns_and_series(plant: ps.Model) -> None:
    times = np.arange(0, 0.1, STEP)
    voltages = 5.0 + np.sin(60.0 * times)
    expected = plant.simulate(inputs={"valveVoltage": (times, voltages)}, **SHORT)["position"].tobytes()
    for given in (np.column_stack([times, voltages]), pandas.Series(voltages, index=times)):
        assert plant.simulate(inputs={"valveVoltage": given}, **SHORT)["position"].tobytes() == expected
    frame = pandas.DataFrame({"time": times, "valveVoltage": voltages, "position": 0.0})
    assert plant.simulate(inputs=frame, **SHORT)["position"].tobytes() == expected


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda plant: plant.start({"supplyPressure": "6 mm"}), ["supplyPressure", "unit mm", "Pa, hPa", "bar"]),
        (lambda plant: plant.start({"supplyPressure": "6"}), ["supplyPressure", "'6' has no unit", "6 Pa"]),
        (lambda plant: plant.start({"supplyPressure": "6,5 bar"}), ["supplyPressure", "did you mean 6.5 bar?"]),
        (lambda plant: plant.start({"supplyPressure": Quantity(6.0, 1e5).to("Pa").units}), ["no number in Pa"]),
        (lambda plant: plant.start({"mass.moving": Quantity(6.0, 1e5)}), ["mass.moving", "must be in kg", "convert"]),
        (lambda plant: plant.start({"supplyPressure": -1}), ["supplyPressure = -1 Pa", "at least 0 Pa"]),
        (lambda plant: plant.start({"cylinder.bore": 32}), ["cylinder.bore = 32 m", "32 mm, which is 0.032 m"]),
        (lambda plant: plant.start({"cylinder.bore": 3.2e-5}), ["cylinder.bore = 3.2e-05 m", "0.0001 to 1 m"]),
        (lambda plant: plant.start({"position0": 250.01}), ["position0 = 250.01 m", "did you mean 250.01 mm"]),
        (lambda plant: plant.start({"chamberA.pressure0": 44.8}), ["chamberA.pressure0 = 44.8 Pa", "44.8 bar"]),
        (lambda plant: plant.start({"position0": 5}), ["position0 = 5 m", "cylinder.stroke = 0.5"]),
        (lambda plant: plant.start({"ambientTemperature": 20}), ["ambientTemperature = 20 K", "20 degC"]),
        (lambda plant: plant.start({"friction.law": 99}), ["friction.law = 99", "1 None", "14 LuGre", "24 Stick"]),
        (lambda plant: plant.start({"friction.law": True}), ["friction.law = True", "14 LuGre"]),
        (lambda plant: plant.start({"friction.law": "lugre"}), ["did you mean LuGre?", "Stribeck"]),
        (lambda plant: plant.compare(["Lugre"]), ["did you mean LuGre?"]),
        (lambda plant: plant.start({"mass": 1.0}), ["mass", "did you mean mass.moving or mass.carriage"]),
        (lambda plant: plant.simulate(inputs={"voltage": 5.0}), ["voltage is not an input", "did you mean valveV"]),
        (lambda plant: plant.simulate(outputs=["posi"]), ["outputs", "posi", "did you mean position"]),
        (lambda plant: plant.linearise(outputs=["posi"]), ["outputs", "posi", "did you mean position"]),
        (lambda plant: plant.linearise(states=["positon"]), ["states", "positon", "did you mean position"]),
        (lambda plant: plant.linearise(inputs=["voltage"]), ["'voltage' is not an input", "did you mean valveVoltage"]),
        (lambda plant: ps.Model("PneumaticServoCylindr"), ["did you mean PneumaticServoCylinder?"]),
        (
            lambda plant: plant.simulate_many({"valve.b": [0.2, 0.3]}, number=3),
            ["how many runs? The inputs, or `number`, are for 3 runs, the parameters have values for {'valve.b': 2}"],
        ),
        (
            lambda plant: plant.simulate_many({"valve.b": [0.2, 0.3], "mass.moving": [1.0]}),
            ["how many runs? The parameters have values for {'valve.b': 2, 'mass.moving': 1}"],
        ),
    ],
)
def test_refusal_says_what_would_be_right(
    plant: ps.Model, call: Callable[[ps.Model], object], words: list[str]
) -> None:
    with pytest.raises(ValueError, match=re.escape(words[0])) as caught:
        call(plant)
    assert all(word in str(caught.value) for word in words), str(caught.value)


@pytest.mark.parametrize(
    ("mapping", "key", "words"),
    [
        (lambda plant: plant.parameters, "mass", "did you mean mass.moving or mass.carriage"),
        (lambda plant: plant.simulate(**SHORT), "posi", "did you mean position?"),
        (lambda plant: plant.compare(["LuGre"], stop=0.01, step=STEP, progress=False), "Lugre", "did you mean LuGre?"),
    ],
)
def test_key_that_is_nearly_right_is_answered(
    plant: ps.Model, mapping: Callable[[ps.Model], dict[str, object]], key: str, words: str
) -> None:
    with pytest.raises(KeyError, match=words):
        mapping(plant)[key]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda plant: plant.start({"supplyPressure": 6}), "supplyPressure = 6 Pa: it acts as .* did you mean 6 bar"),
        (lambda plant: plant.simulate({"supplyPressure": 6}, **SHORT), "supplyPressure = 6 Pa: .* did you mean 6 bar"),
        (lambda plant: plant.simulate({"supplyPressure": 600}, **SHORT), "did you mean 600 kPa"),
        (
            lambda plant: plant.simulate(inputs={"supplyPressure": lambda t: 6e5 if t < 0.03 else 6.0}, **SHORT),
            "supplyPressure = 6 Pa",
        ),
        (
            lambda plant: plant.simulate_many([{}, {"supplyPressure": 6}], progress=False, **SHORT),
            "run 1 of 2: supplyPressure = 6 Pa",
        ),
        (lambda plant: plant.start().set(supplyPressure=6), "supplyPressure = 6 Pa"),
        (lambda plant: plant.start().__setitem__("valveVoltage", 50), "valveVoltage = 50 V: it saturates at 0 and"),
        (lambda plant: plant.simulate({"valveVoltage": 50}, **SHORT), "valveVoltage = 50 V: it saturates"),
        (lambda plant: plant.simulate(inputs={"valveVoltage": -1}, **SHORT), "valveVoltage = -1 V: it saturates"),
        (
            lambda plant: plant.simulate(inputs={"valveVoltage": lambda t: 1000 * t}, **SHORT),
            "valveVoltage = 49 V: it saturates",
        ),
        (
            lambda plant: plant.simulate_many(inputs={"valveVoltage": [5, 50]}, progress=False, **SHORT),
            "valveVoltage = 50 V: it saturates",
        ),
        (
            lambda plant: plant.simulate(inputs={"valveVoltage": ([0, 0.01], [5, 6])}, **SHORT),
            "valveVoltage is given until 0.01 s, but the run goes on to 0.05 s: its last value holds",
        ),
        (
            lambda plant: plant.simulate(inputs={"valveVoltage": ([0.01, 1], [5, 6])}, **SHORT),
            "valveVoltage is given from 0.01 s on, but the run starts at 0 s: its first value holds",
        ),
        (
            lambda plant: plant.simulate_many(number=1, inputs={"valveVoltage": ([0, 0.01], [5, 6])}, progress=False,
                                              **SHORT),
            "valveVoltage is given until 0.01 s",
        ),
        (lambda plant: plant.linearise(), "valveVoltage = 5 V: it has no effect here, B is 0; the carriage sticks"),
    ],
)  # fmt: skip
def test_unusual_is_warned_of(plant: ps.Model, call: Callable[[ps.Model], object], words: str) -> None:
    with pytest.warns(ps.PlantWarning, match=words):
        call(plant)


@pytest.mark.parametrize(
    ("points", "told"),
    [
        # From the begin to the last step, 0.049 s, at which an input is applied.
        ([0.0, 0.049], []),
        ([1e-10, 0.049 - 1e-10], []),
        # A table of samples every 10 ms covers until 10 ms after its last one.
        ([0.0, 0.01, 0.02, 0.03, 0.04], []),
        ([0.0, 0.01, 0.02, 0.03], ["until 0.03 s, but the run goes on to 0.05 s: its last value holds from there on"]),
        ([0.0, 0.048], ["until 0.048 s, but the run goes on to 0.05 s: its last value holds from there on"]),
        ([0.001, 0.049], ["from 0.001 s on, but the run starts at 0 s: its first value holds before"]),
        (
            [0.001, 0.048],
            [
                "from 0.001 s on, but the run starts at 0 s: its first value holds before",
                "until 0.048 s, but the run goes on to 0.05 s: its last value holds from there on",
            ],
        ),
    ],
)
def test_points_that_do_not_reach_are_told_with_their_ends(
    plant: ps.Model, points: list[float], told: list[str]
) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        plant.simulate(inputs={"valveVoltage": (points, [5.0] * len(points))}, stop=0.05, step=1e-3)
    assert [str(one.message) for one in caught] == [f"valveVoltage is given {text}" for text in told]


def test_warning_is_told_once_at_each_place_and_for_the_caller(plant: ps.Model) -> None:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("default")
        for _ in range(3):
            plant.start({"supplyPressure": 6})
    assert [Path_of(one) for one in told] == [__file__]


def Path_of(one: warnings.WarningMessage) -> str:
    return one.filename


def test_ends_of_samples_and_steps_are_not_unusual(plant: ps.Model) -> None:
    times = np.arange(0, 0.05, STEP)
    plant.simulate(inputs={"valveVoltage": (times, 5 + times)}, **SHORT)
    # Sampled ten times as slowly as the plant is stepped.
    plant.simulate(inputs={"valveVoltage": (times[::10], 5 + times[::10])}, **SHORT)


def test_text_of_the_voltage_says_where_it_saturates(plant: ps.Model) -> None:
    low, high = SATURATES["valveVoltage"]
    assert f"saturates at {low:g} and {high:g} V" in plant.inputs["valveVoltage"].text


@pytest.mark.parametrize("actuation", ["TwoValves", "TwoRegulators"])
def test_commands_of_chambers_saturate_as_well(plant: ps.Model, actuation: str) -> None:
    with pytest.warns(ps.PlantWarning, match="valveVoltageA = 11 V: it saturates at 0 and 10 V"):
        beyond = plant.simulate({"actuation": actuation}, inputs={"valveVoltageA": 11.0}, **SHORT)
    full = plant.simulate({"actuation": actuation}, inputs={"valveVoltageA": 10.0}, **SHORT)
    assert np.array_equal(beyond["chamberA.pressure"], full["chamberA.pressure"])


@pytest.mark.parametrize(
    ("given", "follower", "value", "default"),
    [
        ({"mass.moving": 0.5}, "mass.carriage", 0.5, "0.75 kg"),
        ({"cylinder.stroke": 0.2}, "position0", 0.1, "0.25 m"),
        ({"friction.law": "Stribeck", "friction.stribeck.Fs": 5.5}, "friction.stribeck.Fc", 4.15, "8.3 N"),
    ],
)
def test_default_that_does_not_fit_follows_and_says_so(
    plant: ps.Model, given: dict[str, object], follower: str, value: float, default: str
) -> None:
    leader, _ = plant.variables[follower].follows or ("", False)
    with pytest.warns(ps.PlantWarning, match=f"{follower} = .*its default, {default}, does not fit {leader}"):
        run = plant.simulate(given, **SHORT)
    assert run.settings[follower] == pytest.approx(value)
    # Given, it is what was given.
    expected = plant.simulate({**given, follower: run.settings[follower]}, **SHORT)
    assert run["position"].tobytes() == expected["position"].tobytes()
    with pytest.warns(ps.PlantWarning, match=follower):
        assert plant.start(given)[follower] == pytest.approx(value)
    with pytest.warns(ps.PlantWarning, match=f"run 1 of 2: {follower}"):
        runs = plant.simulate_many([{}, given], progress=False, **SHORT)
    assert runs[1]["position"].tobytes() == run["position"].tobytes()


def test_levels_of_friction_follow_together(plant: ps.Model) -> None:
    fs = plant.parameters["friction.polito.Fs"].default
    with pytest.warns(ps.PlantWarning) as told:
        settings = plant.simulate({"friction.law": "Polito", "friction.polito.Fs": 1.0}, **SHORT).settings
    for level in ("Fc1", "Fc2"):
        assert settings[f"friction.polito.{level}"] == plant.parameters[f"friction.polito.{level}"].default / fs
    assert len(told) == 2


def test_default_that_fits_stays(plant: ps.Model) -> None:
    assert "mass.carriage" not in plant.simulate({"mass.moving": 0.8}, **SHORT).settings
    assert plant.start({"friction.stribeck.Fs": 9.0})["friction.stribeck.Fc"] == 8.3


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"mass.moving": 0.5, "mass.carriage": 0.6}, "mass.carriage = 0.6 kg is refused: .* mass.moving = 0.5$"),
        (
            {"cylinder.bore": "6 mm"},
            "cylinder.rod = 0.00.* m is refused: .*this is its default: give cylinder.rod, too",
        ),
        ({"friction.stribeck.Fs": 9.0, "friction.stribeck.Fc": 10.0}, "friction.stribeck.Fc = 10 N is refused"),
    ],
)
def test_default_that_follows_nothing_is_refused_as_such(plant: ps.Model, given: dict[str, object], words: str) -> None:
    with pytest.raises(ps.Refused, match=words):
        plant.start(given)
    with pytest.raises(ValueError, match=f"run 0 of 1: {words}"):
        plant.simulate_many([given], progress=False, **SHORT)


def machines(number: int) -> list[dict[str, float]]:
    """Random machines from 6 to 320 mm bore, as data sheets have them."""
    random = np.random.default_rng(40)
    found = []
    for _ in range(number):
        bore = float(np.exp(random.uniform(np.log(6e-3), np.log(0.32))))
        area = np.pi / 4 * bore**2
        force = float(random.uniform(0.02, 0.1) * 5e5 * area)
        found.append({
            "cylinder.bore": bore, "cylinder.rod": bore * float(random.uniform(0.2, 0.5)),
            "cylinder.stroke": float(random.uniform(2, 15)) * bore, "mass.moving": 1e4 * area * random.uniform(0.2, 5),
            "chamberA.deadVolume": max(1e-8, 0.01 * area), "chamberB.deadVolume": max(1e-8, 0.01 * area),
            "friction.stribeck.Fs": force, "valve.C": 2e-5 * area, "supplyPressure": float(random.uniform(4e5, 1e6)),
        })  # fmt: skip
    return found


def test_machines_of_all_sizes_run(plant: ps.Model) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ps.PlantWarning)
        runs = plant.simulate_many(
            machines(400), inputs={"valveVoltage": ([0, 0.2], [5, 8])}, stop=0.2, step=STEP, outputs=["position"],
            progress=False,
        )  # fmt: skip
    assert runs.is_complete.all() and np.isfinite(runs["position"]).all()
    assert (np.ptp(runs["position"], axis=1) > 1e-4).mean() > 0.9


def test_simulation_is_copied_and_pickled(plant: ps.Model) -> None:
    simulation = plant.start({"friction.law": "LuGre"})
    simulation["valveVoltage"] = 7.0
    simulation.step(0.05)
    others = [copy.copy(simulation), copy.deepcopy(simulation), pickle.loads(pickle.dumps(simulation))]
    for one in (simulation, *others):
        one.step(0.05)
    assert {one["position"] for one in others} == {simulation["position"]} and simulation.time == 0.1
    assert {one["valveVoltage"] for one in others} == {7.0}


def test_scaled_point_says_in_what_it_is(plant: ps.Model) -> None:
    system = plant.linearise({"velocity": 0.05, "valve.hysteresis": 0})
    text = repr(system.scaled())
    nominal = plant.variables["chamberA.pressure"].nominal
    assert "in units of nominal values:" in text and re.search(rf"chamberA.pressure = \S+ times {nominal:g} Pa\n", text)
    assert re.search(r"chamberA.pressure = \S+ Pa\n", repr(system))


def test_variables_are_shown_a_line_each(plant: ps.Model) -> None:
    lines = repr(plant.variables).splitlines()
    assert lines == [str(variable) for variable in plant.variables.values()]
    assert all(line.startswith(name) for line, name in zip(lines, plant.variables, strict=True))


def test_parameters_say_what_they_mean_and_count_for() -> None:
    known = ps.Model().variables
    assert known["friction.maxwellSlip.k[1]"].counts_for == ("friction.law", "MaxwellSlip")
    assert known["valve.deadZone"].counts_for == ("actuation", "ProportionalValve")
    assert known["mass.moving"].counts_for is None
    meanings = [known[f"friction.{name}"].meaning for name in ("law", "stribeck.Fs", "polito.Fc2", "level")]
    assert meanings == ["friction law", "static friction", "Coulomb friction", None]


def test_ends_of_a_range_are_legal_in_a_column(plant: ps.Model) -> None:
    dead_zone = plant.variables["valve.deadZone"]
    assert (dead_zone.minimum, dead_zone.maximum) == (0.0, 0.9)
    columns = [[0.0, 0.9], [0.0, 0.91], [-1e-9, 0.5], [0.5, np.nan]]
    assert [_illegal(dead_zone, np.array(column)) for column in columns] == [None, 1, 0, 1]

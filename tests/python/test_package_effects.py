"""Values without effect are told by name, with what would make them count."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
import pneumatic_servo as ps
import pytest

SHORT: dict[str, Any] = {"stop": 0.01, "step": 1e-3}
QUIET: dict[str, Any] = {**SHORT, "progress": False}

LOST: dict[str, tuple[Mapping[str, Any], str]] = {
    "another law": (
        {"friction.law": "LuGre", "friction.stribeck.Fs": 40.0},
        "friction.stribeck.Fs has no effect: it counts only with friction.law = Stribeck, and here it is LuGre",
    ),
    "another law by number": ({"friction.lawNumber": 13, "friction.lugre.Fs": 40.0}, "and here it is Armstrong"),
    "exponent of another gas": ({"thermal.exponent": 1.3}, "with thermal.model = Polytropic or PolytropicServo"),
    "table of a linear valve": ({"valve.tableA.opening[3]": 0.4}, "valve.characteristic = Table"),
    "point beyond the table": (
        {"valve.characteristic": "Table", "valve.tableA.points": 5, "valve.tableA.opening[7]": 0.5},
        "valve.tableA.points of at least 7",
    ),
    "dead zone of a table": ({"valve.characteristic": "Table", "valve.deadZone": 0.1}, "characteristic = Linear"),
    "regulator without one": ({"regulator.tau": 0.1}, "actuation = PressureRegulator, and here it is Prop"),
    "valve without one": ({"actuation": "SwitchingValves", "valve.C": 3e-9}, "actuation = ProportionalValve"),
    "element beyond the number": ({"friction.law": "GMS", "friction.gms.k[9]": 2e5}, "friction.gms.N of at least 9"),
    "hose of no length": (
        {"hoseA.diameter": 0.006},
        "hoseA.length, throttleA.C, quickExhaustA.C or cushion.length above 0",
    ),
    "vessel of no volume": ({"supply.C": 2e-8}, "supply.volume above 0"),
    "rest of no spring": ({"load.rest": 0.1}, "load.stiffness above 0"),
    "viscosity without a hose": ({"gas.viscosity": 1e-4}, "cushion.length or piston.leakage above 0"),
    "mass of an imposed motion": ({"motion": "Imposed", "mass.moving": 2.0}, "motion = Free or coupling.compliance"),
    "step of an adaptive solver": ({"solver.step": 1e-6}, "solver.scheme other than Adaptive"),
}


@pytest.mark.parametrize("case", LOST)
def test_value_without_effect_is_told(case: str) -> None:
    settings, told = LOST[case]
    with pytest.warns(ps.PlantWarning, match="no effect") as warned:
        changed = ps.Model().simulate(settings, inputs={"valveVoltage": 6.0}, **SHORT)
    assert any(told in str(one.message) for one in warned)
    # The message is right: without the last of the settings the run has the same bits.
    same = ps.Model().simulate(dict(list(settings.items())[:-1]), inputs={"valveVoltage": 6.0}, **SHORT)
    assert np.array_equal(changed["position"], same["position"])


@pytest.mark.parametrize("settings", [
    {"friction.law": "LuGre", "friction.lugre.Fs": 40.0},
    {"thermal.model": "Polytropic", "thermal.exponent": 1.3},
    {"hoseA.length": 0.5, "hoseA.diameter": 0.006},
    ps.gas("nitrogen"),
    {"friction.law": "LuGre", "friction.stribeck.Fs": 11.0},  # its default: nothing is lost
])  # fmt: skip
def test_value_that_counts_is_not_told(settings: Mapping[str, Any]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", ps.PlantWarning)
        ps.Model().simulate(settings, inputs={"valveVoltage": 6.0}, **SHORT)
        for run in ps.parameter_sets().values():
            ps.Model().start(run)


def test_set_of_a_whole_rig_may_be_used_in_part() -> None:
    rig = {**ps.parameter_sets()["Rig"], "supplyPressure": 6e5, "actuation": "PressureRegulator"}
    with warnings.catch_warnings():
        warnings.simplefilter("error", ps.PlantWarning)
        ps.Model().start(rig)
        ps.Model().simulate_many({"mass.moving": [1.0, 1.1]}, common=rig, **QUIET)
    # Changed parameters, and names that are none of it, are reported.
    for changed in ({"valve.C": 3e-9}, {"friction.lugre.Fs": 40.0}):
        with pytest.warns(ps.PlantWarning, match=f"^{next(iter(changed))} has no effect"):
            ps.Model().start({**rig, **changed})


@pytest.mark.parametrize(("name", "value", "hint"), [
    ("friction.dahl.sigma0", 9.0, "did you mean 9 N/um"),
    ("friction.stribeck.vs", 12.0, "did you mean 12 mm/s, which is 0.012 m/s"),
    ("valve.bandwidth", 0.12, "did you mean 0.12 kHz, which is 120 Hz"),
    ("valve.hysteresis", 0.35, "did you mean 0.35 %, which is 0.0035?"),
])  # fmt: skip
def test_value_that_is_hardly_meant_is_told_with_its_unit(name: str, value: float, hint: str) -> None:
    settings: dict[str, Any] = {"friction.law": "Dahl" if "dahl" in name else "Stribeck", name: value}
    with pytest.warns(ps.PlantWarning, match=re.escape(hint)) as warned:
        ps.Model().start(settings)
    assert len(warned) == 1
    law = {"friction.law": settings["friction.law"]}
    with pytest.warns(ps.PlantWarning, match=re.escape(hint)):
        ps.Model().simulate_many({name: [ps.Model().parameters[name].default, value]}, common=law, **QUIET)


def test_value_without_effect_is_told_once_while_running() -> None:
    simulation = ps.Model().start({"friction.law": "LuGre"})
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        for force in (40.0, 41.0, 42.0):
            simulation["friction.stribeck.Fs"] = force
        simulation.set({"friction.lugre.Fs": 12.0})
    assert len(told) == 1
    assert "friction.stribeck.Fs has no effect" in str(told[0].message)


def test_value_that_counts_in_some_run_is_not_told() -> None:
    fs = {"friction.stribeck.Fs": [40.0, 41.0]}
    with warnings.catch_warnings():
        warnings.simplefilter("error", ps.PlantWarning)
        ps.Model().simulate_many({**fs, "friction.law": ["LuGre", "Stribeck"]}, **QUIET)
    with pytest.warns(ps.PlantWarning, match="friction.stribeck.Fs has no effect"):
        ps.Model().simulate_many({**fs, "friction.law": ["LuGre", "Dahl"]}, **QUIET)


def test_environments_tell_what_simulate_tells() -> None:
    with pytest.warns(ps.PlantWarning, match="did you mean 6 bar"):
        gymnasium.make("pneumatic_servo/Positioning-v0", parameters={"supplyPressure": 6})
    with pytest.warns(ps.PlantWarning, match="friction.stribeck.Fs has no effect"):
        gymnasium.make("pneumatic_servo/Positioning-v0", law="LuGre", ranges={"friction.stribeck.Fs": (9.0, 12.0)})


BENCH = {
    "time": np.arange(0, 4, 0.01),
    "position": 0.02 * np.sin(2 * np.arange(0, 4, 0.01)),
    "frictionForce": 7 * np.sign(np.cos(2 * np.arange(0, 4, 0.01))),
}


def fit(law: str, **options: Any) -> ps.Fit:
    return ps.fit(BENCH, experiment="motion", law=law, starts=0, progress=False, **options)


def test_parameter_of_another_law_cannot_be_fitted() -> None:
    with pytest.raises(ValueError, match=r"fit='friction.lugre.Fs': it has no effect here"):
        fit("Stribeck", fit=["friction.lugre.Fs"])


def test_known_parameter_of_another_law_is_told() -> None:
    with pytest.warns(ps.PlantWarning, match="friction.stribeck.sigma2 has no effect"):
        fit("Coulomb", settings={"friction.stribeck.sigma2": 0.0})


def test_laws_that_are_fitted_together_have_their_own_parameters() -> None:
    settings = {"friction.coulomb.sigma2": 0.0, "friction.dahl.sigma0": 1e6}
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "no effect", ps.PlantWarning)
        found = ps.compare_fits(
            BENCH, ["Coulomb", "Dahl"], experiment="motion", settings=settings, starts=0, progress=False
        )
    assert "friction.dahl.sigma0" not in found["Coulomb"].settings


def compare(laws: list[str], settings: Mapping[str, Any] | None = None) -> ps.Comparison:
    return ps.Model().compare(laws, settings, inputs={"valveVoltage": 6.0}, **QUIET)


def test_comparison_tells_values_that_one_law_alone_has() -> None:
    with pytest.warns(ps.PlantWarning, match=r"Fs = 40 N counts for Stribeck alone; .* friction.lugre.Fs = 11 N"):
        compare(["Stribeck", "LuGre"], {"friction.stribeck.Fs": 40.0})
    with warnings.catch_warnings():
        warnings.simplefilter("error", ps.PlantWarning)
        compare(["Stribeck", "LuGre"], {"friction.stribeck.Fs": 40.0, "friction.lugre.Fs": 40.0})


@pytest.mark.parametrize(("laws", "notes"), [
    (["Stribeck", "LuGre"], []),
    (["Stribeck", "Dahl"], ["static friction", "Coulomb friction", "viscous friction: Stribeck 30 N.s/m; Dahl 0"]),
    (["LuGre", "MaxwellSlip"], ["static friction: LuGre 11 N; MaxwellSlip no such parameter", "Coulomb friction"]),
])  # fmt: skip
def test_comparison_says_in_which_levels_laws_are_unlike(laws: list[str], notes: list[str]) -> None:
    found = compare(laws)
    assert len(found.notes) == len(notes)
    assert all(told.startswith(note) for told, note in zip(found.notes, notes, strict=True))
    assert all(note in repr(found) and note in found._repr_html_() for note in notes)


def test_bristle_with_other_damping_is_told_that_it_decays() -> None:
    """Unless its decay is stated, be it as the default or as none, which is the law as published."""
    bristle = {"friction.law": "LuGre", "friction.lugre.sigma0": 1e5, "friction.lugre.sigma1": 316.0}
    with pytest.warns(ps.PlantWarning, match=r"friction\.lugre\.vd = 0\.01 m/s: the default: .* decays"):
        ps.Model().start(bristle)
    with warnings.catch_warnings():
        warnings.simplefilter("error", ps.PlantWarning)
        for stated in (0.01, 0.0):
            ps.Model().start({**bristle, "friction.lugre.vd": stated})


DRIVES: dict[str, tuple[Mapping[str, Any], Mapping[str, Any], str]] = {
    "motion that is free": (
        {},
        {"imposedPosition": (np.array([0.0, 0.01]), np.array([0.25, 0.3]))},
        "motion = Imposed, and here it is Free",
    ),
    "command of a chamber": ({}, {"valveVoltageA": 8.0}, "actuation other than ProportionalValve"),
    "one command for two valves": ({"actuation": "TwoValves"}, {"valveVoltage": 8.0}, "and here it is TwoValves"),
    "one command for two coils": (
        {"actuation": "SwitchingValves", "switching.command": "EachValve"},
        {"valveVoltage": 8.0},
        "switching.command = OneVoltage",
    ),
    "a voltage for coils": (
        {"actuation": "SwitchingValves", "switching.command": "EachCoil"},
        {"valveVoltage": 8.0},
        "switching.command = OneVoltage",
    ),
    "coil beside a valve": ({}, {"coil[1]": True}, "actuation = SwitchingValves, and here it is ProportionalValve"),
}


@pytest.mark.parametrize("case", DRIVES)
def test_input_without_effect_is_told(case: str) -> None:
    settings, inputs, told = DRIVES[case]
    model = ps.Model()
    expected = model.simulate(settings, **SHORT)["position"]
    with pytest.warns(ps.PlantWarning, match="no effect") as warned:
        changed = model.simulate(settings, inputs=inputs, **SHORT)
    assert any(f"{next(iter(inputs))} has no effect: it counts only with " in str(one.message) for one in warned)
    assert any(told in str(one.message) for one in warned) and np.array_equal(changed["position"], expected)
    with pytest.warns(ps.PlantWarning, match="no effect"):
        model.simulate_many([settings, settings], inputs=inputs, **QUIET)
    if not isinstance(value := next(iter(inputs.values())), tuple):
        plant = model.start(settings)
        with pytest.warns(ps.PlantWarning, match="no effect"):
            plant[next(iter(inputs))] = value
        with pytest.warns(ps.PlantWarning, match="no effect"):
            model.simulate({**settings, **inputs}, **SHORT)


@pytest.mark.parametrize(
    ("output", "on"),
    [
        ("supply.consumed", {"consumption.enabled": True}),
        ("sensor.end[2]", {"sensor.endDistance[2]": 0.26}),
    ],
)
def test_output_of_an_option_that_is_off_is_told(output: str, on: Mapping[str, Any]) -> None:
    given: dict[str, Any] = {"inputs": {"valveVoltage": 8.0}, "outputs": [output], "stop": 0.05, "step": 1e-3}
    with pytest.warns(ps.PlantWarning, match=re.escape(f"{output} is 0 throughout: it counts only with ")):
        assert not ps.Model().simulate(**given)[output].any()
    assert ps.Model().simulate(on, **given)[output].any()


def test_inputs_and_outputs_that_count_are_not_told() -> None:
    two = {"actuation": "TwoValves"}
    model = ps.Model()
    model.simulate(two, inputs={"valveVoltageA": 8.0, "valveVoltageB": 3.0, "valveVoltage": 5.0}, **SHORT)
    model.simulate_many([two, {}], inputs={"valveVoltage": 8.0}, **QUIET)
    plant = model.start({"motion": "Imposed"})
    plant["imposedVelocity"] = 0.1


@pytest.mark.parametrize("given", [0.01, (np.array([0.0, 1.0]), np.array([0.01, 0.02]))], ids=["constant", "points"])
def test_motion_that_an_input_imposes_starts_where_the_input_does(given: Any) -> None:
    """The default of the input, beyond the end of a short stroke, is not where this run starts."""
    short = {"motion": "Imposed", "cylinder.stroke": 0.04, "chamberB.open": True}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ps.PlantWarning)
        run = ps.Model().simulate(short, inputs={"imposedPosition": given}, stop=0.1, step=1e-2)
        assert run["position"][0] == 0.01
        with pytest.raises(ps.Refused, match=r"imposedPosition = 0\.25 m is refused"):
            ps.Model().simulate(short, stop=0.1, step=1e-2)

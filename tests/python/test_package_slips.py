"""Slips of people who know the field: each is refused by variable and value, warned of, or does what is meant."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pneumatic_servo.envs as envs
import pytest
from pneumatic_servo.cli import main

TIMES = np.arange(0, 0.1, 1e-3)
VOLTAGES = 5.0 + 3.0 * np.sin(60.0 * TIMES)
GIVEN: dict[str, Any] = {"stop": 0.1, "step": 1e-3, "outputs": ["position", "velocity"]}
MANY: dict[str, Any] = {**GIVEN, "progress": False}
STEADY = {"velocity": 0.05, "valve.hysteresis": 0.0}
BENCH = {
    "time": np.arange(0, 4, 0.01),
    "position": 0.02 * np.sin(2 * np.arange(0, 4, 0.01)),
    "frictionForce": 7 * np.sign(np.cos(2 * np.arange(0, 4, 0.01)))
    + 0.05 * np.random.default_rng(0).standard_normal(400),
}
SHEET: dict[str, Any] = {"bore": 32, "rod": 12, "stroke": 200, "mass": 5, "qn": 700, "supply": 6}
plant = ps.Model()


def simulate(parameters: Any = None, voltage: Any = (TIMES, VOLTAGES), **options: Any) -> ps.Run:
    return plant.simulate(parameters, inputs={"valveVoltage": voltage}, **{**GIVEN, **options})


def many(*parameters: Any, **options: Any) -> ps.Runs:
    return plant.simulate_many(*parameters, **{**MANY, **options})


def fit(*data: Any, **options: Any) -> ps.Fit:
    given: dict[str, Any] = {"experiment": "motion", "law": "Coulomb", "starts": 0, "progress": False, **options}
    return ps.fit(data[0] if len(data) == 1 else list(data) or BENCH, **given)


def slow(time: float, seen: object) -> float:
    return 6.0


def later(**options: Any) -> ps.Run:
    return plant.simulate(controller=slow, **GIVEN, **options)


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "unit with a capital": (lambda: simulate({"supplyPressure": "6 Bar"}), "unit Bar is refused; did you mean bar?"),
    "bytes for a text": (lambda: simulate({"supplyPressure": b"6 bar"}), "supplyPressure = b'6 bar' is refused"),
    "groups as mappings": (lambda: simulate({"valve": {"deadZone": 0.1}}), "no variable valve; did you mean valve"),
    "name of another convention": (lambda: simulate({"valve_deadZone": 0.1}), "did you mean valve.deadZone?"),
    "function that compares": (lambda: simulate(voltage=lambda t: t > 0.02), "at t = 0 s valveVoltage = (np.)?False"),
    "function of texts": (lambda: simulate(voltage=lambda t: "6 V"), "at t = 0 s valveVoltage = '6 V' is refused"),
    "step that is true": (lambda: many(number=True), "number = True is refused: it must be a whole number"),
    "outputs without an order": (lambda: simulate(outputs={"position", "velocity"}), "outputs must be .* not a set"),
    "laws without an order": (lambda: plant.compare({"LuGre", "Dahl"}, stop=0.1, step=1e-3), "laws must .* not a set"),
    "row of a run": (lambda: simulate()[5], r"a run is asked for names, run\['position'\]\[0\], not for 5"),
    "column of a run": (lambda: simulate()[:, 0], "a run is asked for names"),
    "attribute of a run": (lambda: simulate().position, r"no attribute position; write run\['position'\]"),
    "run as an array": (lambda: np.asarray(simulate()), r"a run is no array; write run\['position'\]"),
    "runs as an array": (lambda: np.asarray(many(number=2)), r"runs are no array; write runs\['position'\]"),
    "rows and columns of runs": (lambda: many(number=2)[0, 1], r"runs are asked for a number or a name, .*\(0, 1\)"),
    "run of a number too large": (lambda: many(number=2).of([2]), "there are 2 runs, and none of number 2"),
    "no runs": (lambda: many([]), "parameters is empty: there are no runs"),
    "values of no runs": (lambda: many({"mass.moving": []}), "mass.moving is empty: there are no runs"),
    "sheet for all runs": (lambda: many(ps.DataSheet(**SHEET)), "what all runs share is given by common="),
    "executor by its name": (lambda: many(number=2, executor="threads"), "executor = 'threads' is refused"),
    "states twice": (lambda: plant.linearise(STEADY, states=["velocity", "velocity"]), "states has velocity twice"),
    "no outputs": (lambda: plant.linearise(STEADY, outputs=[]), "outputs is empty: name at least one"),
    "state as bytes": (lambda: plant.start().restore(plant.start().save().to_bytes()), "restore takes what save"),
    "time that is set": (lambda: setattr(plant.start(), "time", 0.0), "no attribute time that can be set"),
    "call of another tool": (lambda: plant.start().do_step(1e-3), "no attribute do_step; did you mean step?"),
    "one simulation for many": (lambda: ps.transitions(plant.start(), 1e-3), "must be a list of simulations, not <Sim"),
    "several laws in one fit": (lambda: fit(law=["Coulomb", "Dahl"]), "compare_fits fits several"),
    "share as a text": (lambda: fit(validation="30%"), "validation='30%': it must be at least 0 and below 1"),
    "share of a law in percent": (lambda: fit(law_error=20), "law_error=20: .*; did you mean 0.2?"),
    "cluster by its address": (lambda: fit(cluster="tcp://1.2.3.4"), "cluster='tcp://1.2.3.4' is refused"),
    "column for two signals": (
        lambda: fit({"t": [0.0], "x": [1.0]}, columns="time=t,position=x,frictionForce=x"),
        "x is given for position and for frictionForce"),
    "fit of a law that is not fitted": (
        lambda: ps.compare_fits(BENCH, ["Coulomb"], experiment="motion", fit_of={"Dahl": "friction.dahl.sigma0"}),
        "fit_of: Dahl is not among the laws that are fitted: Coulomb"),
    "noise of all signals": (
        lambda: ps.plan(law="Coulomb", experiment="motion", duration=2.0, step=0.01, noise=0.1),
        "noise must be a mapping of names to values, not 0.1"),
    "stroke of a plan in mm": (
        lambda: ps.plan(law="Coulomb", experiment="motion", duration=2.0, step=0.01, stroke=50),
        "did you mean 50 mm"),
    "sheet that never moves": (lambda: ps.DataSheet(**SHEET, min_pressure=7), "min_pressure = 7 bar: the piston never"),
    "dead volume longer than the stroke": (lambda: ps.DataSheet(**SHEET, clearance=500), "clearance = 500 mm"),
    "option of another environment": (lambda: envs.Positioning(step=0.01), "has no option step; did you mean"),
    "parameters of an environment as a list": (lambda: envs.Positioning(parameters=["a"]), "parameters must be"),
    "law drawn twice": (lambda: envs.VectorPositioning(2, laws=["LuGre", "LuGre"]), "laws has LuGre twice"),
}  # fmt: skip

WARNED: dict[str, tuple[Callable[[], object], str]] = {
    "derivative by what has no effect": (
        lambda: simulate(sensitivities=["friction.lugre.Fs"]), "friction.lugre.Fs has no effect here"),
    "period longer than the run": (lambda: later(period=0.2), "period = 0.2 s: the run ends after 0.1 s"),
    "delay longer than the run": (lambda: later(delay=0.1), "delay = 0.1 s: the run ends after 0.1 s"),
    "record that is given twice": (lambda: fit(BENCH, BENCH), "record 2 has the samples of record 1: they count twice"),
    "record that predicts itself": (lambda: fit(validation_data=BENCH), "which is fitted: it predicts nothing"),
}  # fmt: skip

MEANT: dict[str, Callable[[], bool]] = {
    "decimal number": lambda: simulate({"supplyPressure": Decimal("6e5")}).settings["supplyPressure"] == 6e5,
    "percent of a share": lambda: plant.start({"valve.deadZone": "5 %"})["valve.deadZone"] == 0.05,
    "array of one from a function": lambda: same(simulate(voltage=lambda t: np.array([6.0])), simulate(voltage=6.0)),
    "times with a unit of their own": lambda: same(simulate(voltage=((1e3 * TIMES, "ms"), VOLTAGES)), simulate()),
    "both with their units": lambda: same(simulate(voltage=((1e3 * TIMES, "ms"), (1e3 * VOLTAGES, "mV"))), simulate()),
    "held points with their units": lambda: same(
        simulate(voltage={"hold": ((1e3 * TIMES[::5], "ms"), (1e3 * VOLTAGES[::5], "mV"))}),
        simulate(voltage={"hold": (TIMES[::5], VOLTAGES[::5])}),
    ),
    "time by name": lambda: simulate()["time"] is not None and simulate()["time"][-1] == 0.1,
    "names in a tuple": lambda: list(simulate()["velocity", "position"]) == ["velocity", "position"],
    "items of a run": lambda: [name for name, _ in simulate().items()] == ["position", "velocity"],
    "runs by true and false": lambda: many({"mass.moving": [1.0, 2.0]}).of([False, True]).numbers == [1],
    "name in runs": lambda: "position" in many(number=2) and "mass.moving" not in many(number=2),
    "laws of a comparison": lambda: (
        list(plant.compare(["LuGre", "Dahl"], stop=0.1, step=1e-3, progress=False)) == ["LuGre", "Dahl"]
    ),
    "list of sheets": lambda: many([ps.DataSheet(**SHEET)])[0].settings["cylinder.bore"] == 0.032,
}


def same(one: ps.Run, other: ps.Run) -> bool:
    return bool(np.allclose(one["position"], other["position"], rtol=0.0, atol=1e-12))


@pytest.mark.parametrize("slip", REFUSED)
def test_slip_is_refused(slip: str) -> None:
    call, words = REFUSED[slip]
    with pytest.raises((TypeError, ValueError, AttributeError, IndexError), match=words):
        call()


@pytest.mark.parametrize("slip", WARNED)
def test_slip_is_warned_of(slip: str) -> None:
    call, words = WARNED[slip]
    with pytest.warns(ps.PlantWarning, match=words):
        call()


@pytest.mark.parametrize("slip", MEANT)
def test_slip_does_what_is_meant(slip: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert MEANT[slip]()


def test_files_that_are_something_else_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    workbook, table = tmp_path / "rig.xlsx", tmp_path / "u.csv"
    workbook.write_bytes(b"PK\3\4rest")
    with pytest.raises(ValueError, match=r"rig\.xlsx: it is a workbook, .* pandas\.read_excel"):
        fit(workbook)
    table.write_text("time,valveVoltage\n0,5\n0.1,7\n", encoding="utf-8")
    assert main(["simulate", str(table), "--out", str(tmp_path / "run.png")]) == 2
    assert "run.png: it is a table; --plot" in capsys.readouterr().err

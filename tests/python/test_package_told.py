"""The whole text of each refusal of an argument: what is wrong, by name and value, and what would be right."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pint
import pneumatic_servo as ps
import pytest
from gymnasium.error import ResetNeeded
from pneumatic_servo import envs
from pneumatic_servo.cli.common import settings_of
from pneumatic_servo.differentiable import Trajectory
from shared import LAWS

T = np.arange(0, 0.2, 1e-3)
SHEET: dict[str, Any] = {"bore": 32, "stroke": 200, "mass": 5, "qn": 700}
KNOWN = ", ".join(LAWS)


def simulate(parameters: Any = None, **options: Any) -> Any:
    return ps.Model().simulate(parameters, **{"stop": 0.01, "step": 1e-3, "outputs": ["position"], **options})


def driven(given: Any) -> object:
    return simulate(inputs={"valveVoltage": given})


def of_table(header: str, *rows: list[Any]) -> object:
    return simulate(inputs=pd.DataFrame(list(rows), columns=header.split(", ")))


def several(parameters: Any = (), **options: Any) -> Any:
    return ps.Model().simulate_many(parameters, **{"stop": 0.01, "step": 1e-3, "progress": False, **options})


def trajectory(**options: Any) -> object:
    given = {"parameters": [], "inputs": ["valveVoltage"], "outputs": ["position"], "given": None, **options}
    return Trajectory(ps.Model(), **{"stop": 0.01, "step": 1e-3, **given})


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "names as text": (
        lambda: simulate(outputs="position"),
        "outputs must be a list of names, not the text 'position'",
    ),
    "no names at all": (
        lambda: simulate(outputs=3),
        "outputs must be a list of names, not 3",
    ),
    "a name that is a number": (
        lambda: simulate(outputs=["position", 3]),
        "outputs must be a list of names, but has 3",
    ),
    "no outputs": (
        lambda: simulate(outputs=[]),
        "outputs is empty: name at least one variable to record",
    ),
    "an output twice": (
        lambda: simulate(outputs=["position", "velocity", "position"]),
        "outputs has position twice",
    ),
    "parameters that are a list": (
        lambda: simulate([1.0]),
        "parameters must be a mapping of names to values, not [1.0]",
    ),
    "inputs that are a list": (
        lambda: simulate(inputs=[1.0]),
        "inputs must be a mapping of names to values, not [1.0]",
    ),
    "inputs of laws that are a list": (
        lambda: ps.Model().compare(["Dahl"], inputs=[1.0]),
        "inputs must be a mapping of names to values, not [1.0]",
    ),
    "a part of a row": (
        lambda: simulate(every=1.5),
        "every = 1.5 is refused: it must be a whole number",
    ),
    "no row": (
        lambda: simulate(every=0),
        "every = 0 is refused: it must be at least 1",
    ),
    "a step of nothing": (
        lambda: simulate(step=0),
        "step = 0.0 is refused: it must be positive",
    ),
    "too many steps": (
        lambda: simulate(stop=1e9, step=1e-9),
        "stop = 1000000000.0 is refused: from 0.0 s these are 1e+18 steps of 1e-09 s",
    ),
    "a stop that is no number": (
        lambda: simulate(stop=float("nan")),
        "stop = nan is refused: it must be a finite number of seconds",
    ),
    "a stop that is a thing": (
        lambda: simulate(stop=[1.0]),
        "stop = [1.0] is refused: it must be a finite number of seconds",
    ),
    "a name that is none": (
        lambda: simulate({3: 1.0}),
        "3 is no name of a variable",
    ),
    "a parameter misspelt": (
        lambda: simulate({"suplyPressure": 6e5}),
        "there is no variable suplyPressure; did you mean supplyPressure or supply.vesselPressure or "
        "der(supply.vesselPressure)?",
    ),
    "a law misspelt": (
        lambda: simulate({"friction.law": "Stribek"}),
        'friction.law = "Stribek" is refused: did you mean Stribeck? it must be one of ' + KNOWN,
    ),
    "a law unlike any": (
        lambda: simulate({"friction.law": "x"}),
        'friction.law = "x" is refused: it must be one of ' + KNOWN,
    ),
    "given twice": (
        lambda: simulate({"valveVoltage": 5.0}, inputs={"valveVoltage": 5.0}),
        "valveVoltage is given twice, among the parameters and among the inputs",
    ),
    "one array of a pair": (
        lambda: driven((T,)),
        "valveVoltage: points are a pair of times and values, not 1 arrays",
    ),
    "times in a unit of something else": (
        lambda: driven((pint.Quantity([0.0, 1.0], "kg"), [5.0, 6.0])),
        "time = <Quantity([0...., 'kilogram')> is refused: it must be in s (Cannot convert from 'kilogram' ([mass]) "
        "to 'second' ([time]))",
    ),
    "three arrays": (
        lambda: driven((T, T, T)),
        "valveVoltage: points are a pair of times and values, not 3 arrays",
    ),
    "a time that is none": (
        lambda: driven(([0.0, float("nan")], [5.0, 5.0])),
        "valveVoltage: time 1 is nan",
    ),
    "values of many runs for one": (
        lambda: driven((T, np.zeros((2, 200)))),
        "valveVoltage: values have the shape (2, 200), but one run takes as many as there are times",
    ),
    "an input of none": (
        lambda: driven(None),
        "valveVoltage = None is refused: it must be a constant, a pair (t, u) of times and values, or a function "
        "of time, in V or with a unit",
    ),
    "nothing in a unit": (
        lambda: simulate({"supplyPressure": (None, "bar")}),
        "supplyPressure = None is refused: it must be a single number in Pa",
    ),
    "a setting of a command that is given twice": (
        lambda: settings_of(ps.Model(), ["valve.b=0.3,valve.C=1e-9", "valve.b=0.4"]),
        "--set valve.b=0.4: valve.b is given twice",
    ),
    "a setting of a command without a value": (
        lambda: settings_of(ps.Model(), ["valve.b"], "--at"),
        "--at valve.b: it must be NAME=VALUE, or a file *.ssv",
    ),
    "a setting of a command that is misspelt": (
        lambda: settings_of(ps.Model(), ["valve.c=1e-9"]),
        "--set valve.c=1e-9: there is no valve.c here; did you mean valve.C?",
    ),
    "a setting of a command that is no number": (
        lambda: settings_of(ps.Model(), ["valve.b=low"]),
        "--set valve.b=low: 'low' is no number",
    ),
    "a setting of a command that is no truth": (
        lambda: settings_of(ps.Model(), ["chamberB.open=yes"]),
        "--set chamberB.open=yes: it must be true or false",
    ),
    "text without a unit": (
        lambda: simulate({"supplyPressure": "6"}),
        "supplyPressure: the text '6' has no unit; write 6 or '6 Pa'",
    ),
    "text for a ratio": (
        lambda: simulate({"valve.b": "0.3"}),
        "valve.b: the text '0.3' has no unit; write 0.3",
    ),
    "text without a number": (
        lambda: driven("five"),
        "valveVoltage: 'five' is no number in V",
    ),
    "an input that is a truth": (
        lambda: driven(True),
        "valveVoltage = True is refused: it must be a constant, a pair (t, u) of times and values, or a function "
        "of time, in V or with a unit",
    ),
    "a function of no number, of many runs": (
        lambda: several([{}], inputs={"valveVoltage": lambda time: "5 V"}),
        "at t = 0.0 s valveVoltage = '5 V' is refused: it must be a number",
    ),
    "a table with a name misspelt": (
        lambda: of_table("time, valveVoltge", [0.0, 5.0]),
        "the DataFrame:0, column 2: valveVoltge is not an input; did you mean valveVoltage or valve.leakage or "
        "valve.polarity?; the inputs are valveVoltage, externalForce, supplyPressure",
    ),
    "a table without inputs": (
        lambda: of_table("time, position", [0.0, 0.1]),
        "the DataFrame:0: there is no column of an input; the inputs are valveVoltage, externalForce, supplyPressure",
    ),
    "a table with a name twice": (
        lambda: of_table("time, valveVoltage, valveVoltage", [0.0, 5.0, 6.0]),
        "the DataFrame:0, column 3: valveVoltage is there twice",
    ),
    "a table with time misspelt": (
        lambda: of_table("valveVoltage, tme", [5.0, 0.0]),
        "the DataFrame:0: there is no column `time`, only valveVoltage, tme; did you mean tme?",
    ),
    "a table over t": (
        lambda: of_table("t, valveVoltage", [0.0, 5.0]),
        "the DataFrame:0: there is no column `time`, only t, valveVoltage; did you mean t?",
    ),
    "a table without time": (
        lambda: of_table("a, valveVoltage", [0.0, 5.0]),
        "the DataFrame:0: there is no column `time`, only a, valveVoltage",
    ),
    "a table without rows": (
        lambda: of_table("time, valveVoltage"),
        "the DataFrame: there are no rows below the header",
    ),
    "a table that goes back": (
        lambda: of_table("time, valveVoltage", [0.0, 5.0], [1.0, 6.0], [0.5, 6.0]),
        "the DataFrame:2, column 1 (time): time falls from 1.0 s to 0.5 s",
    ),
    "a table that begins late": (
        lambda: of_table("time, valveVoltage", [0.5, 5.0], [1.0, 6.0]),
        "the DataFrame: the first time is 0.5 s; a run starts at 0 s",
    ),
    "a table with a text": (
        lambda: of_table("time, valveVoltage", [0.0, 5.0], [1.0, "low"]),
        "the DataFrame:1, column 2 (valveVoltage): 'low' is no number",
    ),
    "a table with nothing": (
        lambda: of_table("time, valveVoltage", [0.0, np.nan]),
        "the DataFrame:0, column 2 (valveVoltage): nan is not finite",
    ),
    "a table in a unit of something else": (
        lambda: of_table("time, valveVoltage[bar]", [0.0, 5.0]),
        "the DataFrame:0, column 2 (valveVoltage): the unit bar is refused; it must be one of V, mV",
    ),
    "a table with what cannot be": (
        lambda: of_table("time, supplyPressure[bar]", [0.0, 6.0], [0.01, -1.0]),
        "the DataFrame:1, column 2 (supplyPressure): -100000.0 Pa is refused: it must be at least 0 Pa",
    ),
    "an input that is none": (
        lambda: simulate(inputs={"positon": 1.0}),
        "positon is not an input; the inputs are valveVoltage, externalForce, supplyPressure",
    ),
    "a record without inputs": (
        lambda: simulate(inputs=simulate()),
        "the run has no input among what it recorded: position",
    ),
    "runs of different numbers": (
        lambda: several({"mass.moving": [1.0, 2.0], "supplyPressure": [5e5, 6e5, 7e5]}),
        "how many runs? The parameters have values for {'mass.moving': 2, 'supplyPressure': 3}",
    ),
    "more inputs than runs": (
        lambda: several([{}, {}], inputs={"valveVoltage": [5.0, 5.0, 5.0]}),
        "the inputs are for 3 runs, the parameters for 2",
    ),
    "rows that are no runs": (
        lambda: several([{}, {}], inputs={"valveVoltage": (T, np.zeros((3, 200)))}),
        "the inputs are for 3 runs, the parameters for 2",
    ),
    "a run of several that is refused": (
        lambda: several([{}, {"cylinder.bore": 16}]),
        "run 1 of 2: cylinder.bore = 16 m is refused: it must be 0.001 to 1 m; did you mean 16 mm, which is 0.016 m?",
    ),
    "parameters of runs as a number": (
        lambda: several(3),
        "parameters must be mappings of names to values, not 3",
    ),
    "no worker": (
        lambda: several([{}], workers=0),
        "workers = 0 is refused: it must be at least 1",
    ),
    "no law to compare": (
        lambda: ps.Model().compare([]),
        "laws is empty: name at least one friction law",
    ),
    "a law given twice": (
        lambda: ps.Model().compare(["Dahl", "LuGre", "Dahl"]),
        "laws has Dahl twice",
    ),
    "a law among the parameters too": (
        lambda: ps.Model().compare(["Dahl"], {"friction.law": "LuGre"}),
        "the law is given twice, among the laws and as friction.law among the parameters",
    ),
    "what was not recorded": (
        lambda: simulate()["velocity"],
        "velocity was not recorded; there are position",
    ),
    "a number of no run": (
        lambda: several([{}, {}])[2],
        "there are 2 runs, and none of number 2",
    ),
    "a law that was not compared": (
        lambda: ps.Model().compare(["Dahl", "Coulomb"], stop=0.01, step=1e-3, progress=False)["Dal"],
        "Dal was not compared; did you mean Dahl?; there are Dahl, Coulomb",
    ),
    "a slope of runs side by side": (
        lambda: several([{}])[0].vjp({"position": np.zeros(11)}),
        "only runs that `simulate` has made, one by one, have gradients",
    ),
    "a slope of what switches": (
        lambda: simulate(outputs=["sticking"]).vjp({"sticking": np.zeros(11)}),
        "sticking is no real number, and has no derivative",
    ),
    "an input misspelt": (
        lambda: ps.Model().linearise(inputs=["valveVoltag"]),
        "inputs: 'valveVoltag' is not an input of PneumaticServoCylinder; did you mean valveVoltage?; the inputs "
        "are valveVoltage, externalForce, supplyPressure",
    ),
    "an input of a model that has none": (
        lambda: ps.Model("Festoon").linearise(inputs=["force"], outputs=[]),
        "inputs: 'force' is not an input of Festoon; did you mean pulseForce?; the inputs are craneVelocity, "
        "pulseForce",
    ),
    "no state": (
        lambda: ps.Model().linearise(states=["positon"]),
        "states: there is no variable positon; did you mean position or position0?",
    ),
    "a position given twice": (
        lambda: ps.Model().linearise({"position": 0.1, "position0": 0.2}),
        "position is given twice, as itself and as position0",
    ),
    "an output of a linearisation misspelt": (
        lambda: ps.Model().linearise(outputs=["positon"]),
        "outputs: there is no variable positon; did you mean position or position0?",
    ),
    "a parameter to differentiate by misspelt": (
        lambda: trajectory(parameters=["valve.c"]),
        "parameters: valve.c is no parameter; did you mean valve.C?",
    ),
    "a choice to differentiate by": (
        lambda: trajectory(parameters=["friction.law"]),
        "parameters: friction.law is no real number, and nothing can be differentiated by it",
    ),
    "an input to differentiate by misspelt": (
        lambda: trajectory(inputs=["valveVoltag"]),
        "inputs: valveVoltag is not an input; did you mean valveVoltage?",
    ),
    "an output that has no slope": (
        lambda: trajectory(outputs=["sticking"]),
        "outputs: sticking is no real number, and has no derivative",
    ),
    "what varies and is given": (
        lambda: trajectory(parameters=["valve.C"], given={"valve.C": 1e-8}),
        "valve.C is given twice, as what varies and among what is given",
    ),
    "a parameter twice": (
        lambda: trajectory(parameters=["valve.C", "valve.C"]),
        "parameters: valve.C is given twice",
    ),
    "no flow": (
        lambda: ps.DataSheet(bore=32, stroke=200, mass=5),
        "the flow of the valve is given by exactly one of qn, kv, cv, conductance, not by []",
    ),
    "two flows": (
        lambda: ps.DataSheet(**SHEET, kv=1.0),
        "the flow of the valve is given by exactly one of qn, kv, cv, conductance, not by ['qn', 'kv']",
    ),
    "no bore": (
        lambda: ps.DataSheet(**{**SHEET, "bore": 0}),
        "bore = 0: it must be positive",
    ),
    "no stroke": (
        lambda: ps.DataSheet(**{**SHEET, "stroke": -200}),
        "stroke = -200: it must be positive",
    ),
    "no mass": (
        lambda: ps.DataSheet(**{**SHEET, "mass": float("inf")}),
        "mass = inf: it must be positive",
    ),
    "no flow at all": (
        lambda: ps.DataSheet(**{**SHEET, "qn": 0}),
        "qn = 0: it must be positive",
    ),
    "a supply below nothing": (
        lambda: ps.DataSheet(**SHEET, supply=-1),
        "supply = -1: it must be positive",
    ),
    "a rod of less than nothing": (
        lambda: ps.DataSheet(**SHEET, rod=-1),
        "rod = -1: it must not be negative",
    ),
    "a rod as thick as the bore": (
        lambda: ps.DataSheet(**SHEET, rod=32),
        "rod = 32: it must be smaller than the bore, 32",
    ),
    "a second rod as thick as the bore": (
        lambda: ps.DataSheet(**SHEET, rod_a=32),
        "rod_a = 32: it must be smaller than the bore, 32",
    ),
    "a ratio of one": (
        lambda: ps.DataSheet(**SHEET, critical_ratio=1.0),
        "critical_ratio = 1.0: it must be at least 0 and below 1",
    ),
    "a bore in m": (
        lambda: ps.DataSheet(**{**SHEET, "bore": 0.032}),
        "bore = 0.032 mm is refused: it must be from 1 to 1000 mm; did you give it in m? that would be 32 mm",
    ),
    "targets that fall": (
        lambda: envs.Positioning(targets=(0.4, 0.1)),
        "targets = (0.4, 0.1) is refused: it must be an increasing pair of positions in m",
    ),
    "targets beyond the stroke": (
        lambda: envs.Positioning(targets=(0.1, 0.6)),
        "targets = (0.1, 0.6) is refused: the stroke ends at 0.5 m",
    ),
    "one target": (
        lambda: envs.Positioning(targets=0.3),
        "targets = 0.3 is refused: it must be a pair, the least and the largest",
    ),
    "a period of nothing": (
        lambda: envs.Positioning(period=0.0),
        "period = 0.0 is refused: it must be positive",
    ),
    "a duration of nothing": (
        lambda: envs.Positioning(duration=0.0),
        "duration = 0.0 is refused: it must be positive",
    ),
    "a stroke that varies": (
        lambda: envs.Positioning(ranges={"cylinder.stroke": (0.3, 0.5)}),
        "ranges: cylinder.stroke is refused: observations are in units of the one stroke",
    ),
    "a range that falls": (
        lambda: envs.Positioning(ranges={"mass.moving": (2.0, 1.0)}),
        "ranges: mass.moving is refused: 2.0 is larger than 1.0",
    ),
    "a range of one": (
        lambda: envs.Positioning(ranges={"mass.moving": 2.0}),
        "ranges: mass.moving = 2.0 is refused: it must be a pair, the least and the largest",
    ),
    "a range of what is given": (
        lambda: envs.Positioning(ranges={"mass.moving": (1.0, 2.0)}, parameters={"mass.moving": 1.0}),
        "mass.moving is given twice, among the ranges and among the parameters",
    ),
    "a seed of letters": (
        lambda: envs.Positioning().reset(seed="a"),
        "seed = 'a' is refused: it must be a whole number",
    ),
    "a seed below nothing": (
        lambda: envs.VectorPositioning(2).reset(seed=-1),
        "seed = -1 is refused: it must be at least 0",
    ),
    "a seed too few": (
        lambda: envs.VectorPositioning(3).reset(seed=[1, 2]),
        "seed has 2 numbers, but there are 3 plants",
    ),
    "no such mode": (
        lambda: envs.Positioning(render_mode="ansi"),
        "render_mode = 'ansi' is refused: it must be None or 'human' or 'rgb_array'",
    ),
    "no such mode of a fleet": (
        lambda: envs.VectorPositioning(2, render_mode="human"),
        "render_mode = 'human' is refused: it must be None or 'rgb_array'",
    ),
    "no such option": (
        lambda: envs.Positioning().reset(options={"targt": 0.2}),
        "options: there is no targt; did you mean target?; there is target",
    ),
    "a target beyond the stroke": (
        lambda: envs.Positioning().reset(options={"target": 0.6}),
        "options: target = 0.6 is refused: it must be within the stroke, 0 to 0.5 m",
    ),
    "a target that is none": (
        lambda: envs.Positioning().reset(options={"target": "left"}),
        "options: target = 'left' is refused: it must be one in m, or one per plant",
    ),
    "a mask of others": (
        lambda: envs.VectorPositioning(2).reset(options={"reset_mask": np.array([True])}),
        "options: reset_mask must be true or false for each of 2 plants, not array([ True])",
    ),
    "a part of a fleet at first": (
        lambda: envs.VectorPositioning(2).reset(options={"reset_mask": np.array([True, False])}),
        "a part of the plants cannot begin anew before all have begun",
    ),
    "a step at first": (
        lambda: envs.Positioning().step(np.zeros(1)),
        "step was called before reset",
    ),
    "a step of a fleet at first": (
        lambda: envs.VectorPositioning(2).step(np.zeros((2, 1))),
        "step was called before reset",
    ),
    "a figure at first": (
        lambda: envs.Positioning(render_mode="rgb_array").render(),
        "render was called before reset",
    ),
    "figures of a fleet at first": (
        lambda: envs.VectorPositioning(2, render_mode="rgb_array").render(),
        "render was called before reset",
    ),
    "transitions at first": (
        lambda: envs.VectorPositioning(2).transitions(np.zeros((2, 1)), parameters=[], outputs=[]),
        "transitions was called before reset",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refusal_says_what_is_wrong(name: str) -> None:
    refused, text = REFUSED[name]
    with pytest.raises((ValueError, TypeError, KeyError, IndexError, ResetNeeded)) as caught:
        refused()
    assert caught.value.args[0] == text

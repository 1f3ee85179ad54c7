"""The whole text of each refusal of data and options to fit, compare and plan."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from pneumatic_servo.identification.band import check_level
from shared import LAWS
from test_identification import RIG, RIG_COLUMNS, bench

T = np.arange(0, 0.2, 1e-3)
KNOWN = ", ".join(LAWS)
SIGNALS = (
    "time, position, velocity, frictionForce, force, normalForce, pressure, valveVoltage, supplyPressure, "
    "externalForce, chamberA.pressure, chamberB.pressure"
)


def fit(data: Any = None, **options: Any) -> object:
    given = {"experiment": "motion", "law": "Coulomb", "starts": 0, "progress": False, **options}
    return ps.fit(bench() if data is None else data, **given)


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "all held out": (
        lambda: fit(hold_out=1.0),
        "hold_out=1.0: it must be at least 0 and below 1",
    ),
    "inputs between samples": (
        lambda: fit(inputs="cubic"),
        "inputs='cubic': it must be held or lines",
    ),
    "no such loss": (
        lambda: fit(loss="hubert"),
        "loss='hubert': it must be one of linear, soft_l1, huber, cauchy",
    ),
    "no such intervals": (
        lambda: fit(intervals="bayes"),
        "intervals='bayes': it must be jacobian, profile or bootstrap",
    ),
    "a width of nothing": (
        lambda: fit(width=0.0),
        "width=0.0: it must be positive",
    ),
    "a width that is none": (
        lambda: fit(width="wide"),
        "width = 'wide' is refused: it must be a finite number of seconds",
    ),
    "a window of nothing": (
        lambda: fit(window=0.0),
        "window=0.0: it must be positive",
    ),
    "a window shorter than samples": (
        lambda: fit(window=0.02),
        "window=0.02 s: no part has 10 samples, which are 0.01 s apart",
    ),
    "no such experiment": (
        lambda: fit(experiment="rigg"),
        "experiment='rigg': it must be one of motion, force, mechanical, pneumatic, rig; did you mean rig?",
    ),
    "no such law": (
        lambda: fit(law="Stribek"),
        "law='Stribek': there is no such law; did you mean Stribeck?; there are " + KNOWN,
    ),
    "the law twice": (
        lambda: fit(settings={"friction.law": "Dahl"}),
        "law='Coulomb': the law is given twice, by settings as Dahl",
    ),
    "a sensor that has no part": (
        lambda: fit(settings={"offset.chamberA.pressure": 1.0}),
        "settings='offset.chamberA.pressure': only sensors of frictionForce, position have a part in this experiment",
    ),
    "a sensor that has no part in a rig": (
        lambda: fit(RIG, experiment="pneumatic", columns=RIG_COLUMNS, settings={"offset.frictionForce": 1.0}),
        "settings='offset.frictionForce': only sensors of chamberA.pressure, chamberB.pressure, position, "
        "valveVoltage have a part in this experiment",
    ),
    "no such parameter": (
        lambda: fit(settings={"mass.movin": 1.0}),
        "settings='mass.movin': there is no such parameter of FrictionBench",
    ),
    "free twice": (
        lambda: fit(fit="friction.coulomb.Fc,friction.coulomb.Fc"),
        "fit: friction.coulomb.Fc is given twice",
    ),
    "a choice that is free": (
        lambda: fit(fit="friction.law"),
        "fit='friction.law': friction.law is no real parameter, so that it cannot be fitted",
    ),
    "a sensor that is none": (
        lambda: fit(fit="delay.positon"),
        "fit='delay.positon': positon is not compared or driving here, only frictionForce, position",
    ),
    "an area without pressures": (
        lambda: fit(fit="area"),
        "fit='area': area needs the columns force and pressure, in the experiment motion",
    ),
    "two bounds of three": (
        lambda: fit(fit="friction.coulomb.Fc:1"),
        "fit='friction.coulomb.Fc:1': it must be NAME[=start][:low:high]",
    ),
    "words that are no name": (
        lambda: fit(fit="="),
        "fit='=': it must be NAME[=start][:low:high]",
    ),
    "no data": (
        lambda: fit([]),
        "there are no data",
    ),
    "data of no kind": (
        lambda: fit(3),
        "data must be a file, a DataFrame, a run, a mapping of arrays, or a list of those, not int",
    ),
    "no time": (
        lambda: fit({"position": T, "frictionForce": T}),
        "experiment='motion' needs columns for time; time is missing",
    ),
    "signals of different lengths": (
        lambda: fit({**bench(), "position": np.zeros(3)}),
        "record 1: position has the shape (3,), time (1000,)",
    ),
    "a sample that is none": (
        lambda: fit({**bench(), "position": np.where(bench()["time"] > 1, np.nan, bench()["position"])}),
        "record 1: position is nan at sample 101",
    ),
    "time that falls": (
        lambda: fit({**bench(), "time": -bench()["time"]}),
        "record 1: time must rise, but -0.01 s follows -0.0 s",
    ),
    "a signal misspelt": (
        lambda: fit({**bench(), "positon": bench()["position"]}),
        "there is no signal positon; did you mean position?; there are "
        + SIGNALS
        + "; `columns` says which of the arrays is which signal",
    ),
    "a signal that is lacking": (
        lambda: fit({"time": bench()["time"], "position": bench()["position"]}),
        "experiment='motion' needs a column for frictionForce, or for force",
    ),
    "no motion": (
        lambda: fit({"time": bench()["time"], "frictionForce": bench()["position"]}),
        "experiment='motion' needs a column for position or velocity",
    ),
    "no column of time": (
        lambda: fit(columns="position=x,frictionForce=f"),
        "columns: no column is given for time, for example time=t",
    ),
    "a column without a signal": (
        lambda: fit(columns="time"),
        "columns='time': it must be signal=column or signal=column[unit]",
    ),
    "a column twice": (
        lambda: fit(columns="time=t,position=x,position=y"),
        "columns: position is given twice",
    ),
    "columns that are a number": (
        lambda: fit(columns=3),
        "columns must be a text or a mapping of signals to columns, not 3",
    ),
    "a signal of columns misspelt": (
        lambda: fit(columns="time=t,positon=x"),
        "columns='positon=x': there is no signal positon; did you mean position?; there are " + SIGNALS,
    ),
    "a column that is empty": (
        lambda: fit(columns={"time": "t", "position": ""}),
        "columns='position=': it must be position=column or position=column[unit]",
    ),
    "a unit of no signal": (
        lambda: fit(columns="time=t,position=x[V]"),
        "columns='position=x[V]': the unit V is refused; it must be one of m, cm, mm, um, in, or for the "
        "experiment force of rad, mrad, deg",
    ),
    "an array that is lacking": (
        lambda: fit({**bench(), "x": T}, columns="time=time,position=positon"),
        "columns: there is no array positon for position; did you mean position?; there are time, position, "
        "frictionForce, x",
    ),
    "all at rest": (
        lambda: fit({**bench(), "position": np.zeros(len(bench()["time"]))}),
        "position never changes: all at rest, so that nothing can be learned of friction",
    ),
    "too short": (
        lambda: fit({name: values[:20] for name, values in bench().items()}),
        "record 1: too short, 20 samples without a gap; at least 50 are needed",
    ),
    "one sample": (
        lambda: fit({name: values[:1] for name, values in bench().items()}),
        "record 1: too short, a single sample; at least 50 are needed",
    ),
    "no starts": (
        lambda: fit(starts=-1),
        "starts=-1: it must not be negative",
    ),
    "laws as a text": (
        lambda: ps.compare_fits(bench(), "LuGre", experiment="motion"),
        "laws must be a list of names, not the text 'LuGre'",
    ),
    "no law": (
        lambda: ps.compare_fits(bench(), [], experiment="motion"),
        "laws: name at least one law",
    ),
    "a law that is empty": (
        lambda: ps.compare_fits(bench(), ["Dahl", ""], experiment="motion"),
        "laws='Dahl,': a law between the commas is empty",
    ),
    "a law compared twice": (
        lambda: ps.compare_fits(bench(), ["Dahl", "Dahl"], experiment="motion"),
        "laws: Dahl is given twice",
    ),
    "a series of one": (
        lambda: ps.fit_series([bench()], experiment="motion", law="Coulomb", changing="friction.coulomb.Fc"),
        "1 record is refused: a series has at least two",
    ),
    "a series of a file": (
        lambda: ps.fit_series("a.csv", experiment="motion", law="Coulomb", changing="friction.coulomb.Fc"),
        "records must be a mapping or a sequence of data, not str",
    ),
    "an option of no series": (
        lambda: ps.fit_series([bench()] * 2, experiment="motion", law="Coulomb", changing="a", posterior=True),
        "fit_series has no option posterior; there are columns, settings, seed, starts, rated, width, play, "
        "window, inputs, workers, executor, cluster, progress",
    ),
    "a series of nothing": (
        lambda: ps.fit_series([bench()] * 2, experiment="motion", law="Coulomb", changing=""),
        "changing: name what may change",
    ),
    "a plan of a force": (
        lambda: ps.plan(experiment="force", law="Coulomb"),
        "experiment='force': a plan can be made for rig or motion",
    ),
    "a plan too short": (
        lambda: ps.plan(law="Coulomb", duration=0.1, step=0.01),
        "duration 0.1 s and step 0.01 s: there must be at least 100 samples",
    ),
    "a plan without a stroke": (
        lambda: ps.plan(experiment="motion", law="Coulomb", stroke=0.0),
        "stroke=0.0 m: it must be positive",
    ),
    "noise of no signal": (
        lambda: ps.plan(law="Coulomb", noise={"positon": 1e-6}),
        "noise='positon': there is no signal positon; did you mean position?; there are position, velocity, "
        "chamberA.pressure, chamberB.pressure, frictionForce, force",
    ),
    "noise of nothing": (
        lambda: ps.plan(law="Coulomb", noise={"position": 0.0}),
        "noise of position = 0 m is refused: it must be positive",
    ),
    "noise in m": (
        lambda: ps.plan(law="Coulomb", noise={"position": 5.0}),
        "noise of position = 5 m is refused: it must be at most 0.01 m, since no sensor of that noise is of use; "
        "did you mean 5.0 um?",
    ),
    "a level of one": (
        lambda: check_level(1.0),
        "level = 1.0 is refused: it must be between 0 and 1",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refusal_says_what_is_wrong(name: str) -> None:
    refused, text = REFUSED[name]
    with pytest.raises((ValueError, TypeError)) as caught:
        refused()
    assert str(caught.value) == text


@pytest.mark.parametrize(
    ("option", "given", "text"),
    [
        ("rated", 0.0, "rated=0.0: it must be positive"),
        ("rated", "2 m", "rated: the unit m is refused; it must be one of N, kN, mN"),
        ("play", -1.0, "play=-1.0: it must not be negative"),
        ("play", "2 N", "play: the unit N is refused; it must be one of m, cm, mm, um, in"),
        ("width", "2 N", "width: the unit N is refused; it must be one of s, ms, us, min"),
        ("window", "2 N", "window: the unit N is refused; it must be one of s, ms, us, min"),
        ("law_error", float("inf"), "law_error=inf: it must be positive"),
        ("seed", -1, "seed=-1: it must not be negative"),
        ("seed", 1.5, "seed = 1.5 is refused: it must be a whole number"),
        ("starts", float("nan"), "starts=nan: it must not be negative"),
        ("workers", 0, "workers = 0 is refused: it must be at least 1"),
        ("workers", 1.5, "workers = 1.5 is refused: it must be a whole number"),
        ("settings", {"friction.coulomb.Fc": -1.0}, "friction.coulomb.Fc = -1 N is refused: it must be 0 to 1e+06 N"),
    ],
)
def test_number_that_cannot_be_is_refused_by_its_name(option: str, given: object, text: str) -> None:
    with pytest.raises(ValueError, match="^" + re.escape(text)):
        fit(**{option: given})


def test_options_of_a_fit_have_units() -> None:
    found: Any = fit(rated="0.01 kN", width="50 ms", play="20 um", window="5 s", inputs="lines", workers=1)
    options = found.problem.experiment.options
    assert [options.rated, options.width, options.play, options.window] == pytest.approx([10.0, 0.05, 2e-5, 5.0])
    assert options.inputs == "lines" and found.problem.workers == 1 and len(found.problem.windows) == 2


def test_area_is_asked_for_where_it_is_needed() -> None:
    data = {**bench(), "pressure": 1e5 * np.ones(1000), "force": bench()["frictionForce"]}
    del data["frictionForce"]
    text = "fit: area has no default; it must be free, or known by settings"
    with pytest.raises(ValueError, match="^" + re.escape(text) + "$"):
        fit(data, fit="friction.coulomb.Fc")


def test_fit_says_what_it_is_at_and_holds_out_what_it_is_told_to() -> None:
    said: list[str] = []
    found: Any = fit([bench(seed) for seed in range(2)], law="Stribeck", hold_out_data=[bench(2)], progress=said.append,
                     cross_validate="record")  # fmt: skip
    steps = ["last refinement", "intervals", "cross-validation", "condition 1 of 2: record 1 is left out",
             "condition 2 of 2: record 2 is left out"]  # fmt: skip
    assert [text for text in said if text in steps] == steps
    # The noise of each is 0.05 N.
    assert found.hold_out_rms == {"frictionForce": pytest.approx(0.05, rel=0.05)}
    assert [bool(np.all(window.held)) for window in found.problem.windows] == [False, False, True]

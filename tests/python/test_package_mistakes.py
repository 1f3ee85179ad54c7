"""Mistakes as people make them: each is refused or warned of in words that help, or does what was meant."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pneumatic_servo as ps
import pytest
from shared import LAWS

T = np.arange(0, 0.2, 1e-3)
U = 5 + 2 * np.sin(20 * T)
BENCH = {
    "time": np.arange(0, 4, 0.01),
    "position": 0.02 * np.sin(2 * np.arange(0, 4, 0.01)),
    "frictionForce": 7 * np.sign(np.cos(2 * np.arange(0, 4, 0.01))),
}


def simulate(parameters: object = None, inputs: object = None, **options: object) -> ps.Run:
    given: dict[str, Any] = {"stop": 0.2, "step": 1e-3, "outputs": ["position"], **options}
    return ps.Model().simulate(
        parameters or {"supplyPressure": 6e5},  # type: ignore[arg-type]
        inputs=inputs if inputs is not None else {"valveVoltage": (T, U)},  # type: ignore[arg-type]
        **given,
    )


def driven(*course: object) -> Callable[[], object]:
    return lambda: simulate(inputs={"valveVoltage": course if len(course) > 1 else course[0]})


def having(**values: object) -> Callable[[], object]:
    named = {name.replace("__", "."): value for name, value in values.items()}
    return lambda: simulate({"supplyPressure": 6e5, **named})


def fit(changed: Mapping[str, object] | None = None, **options: object) -> ps.Fit:
    given: dict[str, Any] = {"experiment": "motion", "law": "Coulomb", "starts": 0, "progress": False, **options}
    return ps.fit({**BENCH, **(changed or {})}, **given)


KNOWN = ", ".join(f"{number} {law}" for number, law in enumerate(LAWS, 1))


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "number as text": (
        having(supplyPressure="6"),
        "supplyPressure: the text '6' has no unit; write 6 or '6 Pa'",
    ),
    "volts for bars": (
        having(supplyPressure="6 V"),
        "supplyPressure: the unit V is refused; it must be one of Pa, hPa, mbar, kPa, MPa, bar, psi, atm, "
        "barg, mbarg, kPag, MPag, psig, Pag, bara, mbara, kPaa, MPaa, psia",
    ),
    "degrees Celsius": (
        having(ambientTemperature=20),
        "ambientTemperature = 20 K is refused: it must be 100 to 1000 K; did you mean 20 degC, which is 293.15 K?",
    ),
    "degrees for radians": (
        having(incline=30),
        "incline = 30 rad is refused: it must be -1.5708 to 1.5708 rad; did you mean 30 deg, which is 0.523599 rad?",
    ),
    "bore in mm": (
        having(cylinder__bore=16),
        "cylinder.bore = 16 m is refused: it must be 0.0001 to 1 m; did you mean 16 mm, which is 0.016 m?",
    ),
    "position in mm": (
        having(position0=250),
        "position0 = 250 m is refused: it must be 0 to 10 m; did you mean 250 mm, which is 0.25 m?",
    ),
    "dependence in 1/bar": (
        having(friction__kappaA=0.2),
        "friction.kappaA = 0.2 1/Pa is refused: it must be -0.001 to 0.001 1/Pa; did you mean 0.2 1/bar, which is "
        "2e-6 1/Pa?",
    ),
    "rod thicker than the bore": (
        having(cylinder__rod=0.02),
        "cylinder.rod = 0.02 m is refused: it must be smaller than cylinder.bore = 0.016",
    ),
    "beyond the stroke": (
        having(position0=0.6),
        "position0 = 0.6 m is refused: it must not exceed cylinder.stroke = 0.5",
    ),
    "vacuum around it": (
        having(ambientPressure=0),
        "ambientPressure = 0 Pa is refused: it must be 1000 to 1e+07 Pa",
    ),
    "number of no law": (
        having(friction__law=99),
        "friction.law = 99 is refused: it must be one of " + KNOWN,
    ),
    "a law that is true": (
        having(friction__law=True),
        "friction.law = True is refused: it must be one of " + KNOWN,
    ),
    "nothing": (
        having(supplyPressure=None),
        "supplyPressure = None is refused: it must be a single number in Pa",
    ),
    "a list": (
        having(supplyPressure=[6e5]),
        "supplyPressure = [600000.0] is refused: it must be a single number in Pa",
    ),
    "not a number": (
        having(supplyPressure=float("nan")),
        "supplyPressure = nan Pa is refused: it must be a finite number in Pa",
    ),
    "a complex number": (
        having(supplyPressure=6e5 + 1j),
        "supplyPressure = (600000+1j) is refused: it must be a single number in Pa",
    ),
    "an output set": (
        having(position=0.1),
        "position cannot be set: it is computed",
    ),
    "times and values swapped": (
        driven([5.0, 7.0, 6.0], [0.0, 0.1, 0.2]),
        "valveVoltage: time falls from 7.0 s to 6.0 s at point 2",
    ),
    "one value too few": (
        driven(T, U[:-1]),
        "valveVoltage: times of shape (200,) do not fit values of shape (199,)",
    ),
    "two columns of values": (
        driven(T, np.c_[U, U]),
        "valveVoltage: times of shape (200,) do not fit values of shape (200, 2)",
    ),
    "a gap of NaN": (
        driven(T, np.where(T > 0.1, np.nan, U)),
        "at t = 0.101 s valveVoltage = nan V is refused: it must be a finite number in V",
    ),
    "time running back": (
        driven(T[::-1], U),
        "valveVoltage: time falls from 0.199 s to 0.198 s at point 1",
    ),
    "a small letter": (
        lambda: simulate(inputs={"valvevoltage": (T, U)}),
        "valvevoltage is not an input; did you mean valveVoltage?; the inputs are valveVoltage, "
        "externalForce, supplyPressure, imposedPosition, imposedVelocity, valveVoltageA, valveVoltageB, "
        "coil[1], coil[2], coil[3], coil[4]",
    ),
    "a function without a value": (
        driven(lambda t: None),
        "at t = 0 s valveVoltage = None is refused: it must be a number",
    ),
    "a text among values": (
        driven(T, "3 kV"),
        "valveVoltage = '3 kV' is refused: it must be numbers in V, or (t, u, unit); could not convert string"
        " to float: '3 kV'",
    ),
    "a start after the stop": (
        lambda: simulate(start=1.0),
        "stop = 0.2 is refused: the run starts at 1.0 s",
    ),
    "a step that does not divide": (
        lambda: simulate(step=7e-4),
        "stop = 0.2 is refused: from 0.0 s it is no whole number of steps of 0.0007 s",
    ),
    "an output misspelt": (
        lambda: simulate(outputs=["posiion"]),
        "outputs: there is no variable posiion; did you mean position or position0 or imposedPosition?",
    ),
    "no file": (
        lambda: simulate("no.ssv"),
        "[Errno 2] No such file or directory: 'no.ssv'",
    ),
    "a negative step": (
        lambda: ps.Model().start().step(-1e-3),
        "a step of -0.001 s leads nowhere from 0 s",
    ),
    "a state of another model": (
        lambda: ps.Model().start().restore(ps.Model("FrictionBench").start().save()),
        "the saved state does not belong to this model with these parameters: it has another number of parameters or "
        "inputs",
    ),
    "a model misspelt": (
        lambda: ps.Model("PneumaticServoCilinder"),
        "there is no model PneumaticServoCilinder; did you mean PneumaticServoCylinder?; it must be one of "
        "PneumaticServoCylinder, FrictionBench, PositionController, DrivenSlider, VibroImpact, Festoon",
    ),
    "a record in mm": (
        lambda: fit({"position": 1e3 * BENCH["position"]}),
        "record 1: position is from -19.999 to 20 m; is it in mm, -0.019999 to 0.02 m? then write position=...[mm]",
    ),
    "force and position swapped": (
        lambda: fit({"position": BENCH["frictionForce"], "frictionForce": BENCH["position"]}),
        "record 1: position is from -7 to 7 m; is it in mm, -0.007 to 0.007 m? then write position=...[mm]",
    ),
    "a force that is one number": (
        lambda: fit({"frictionForce": np.full(400, 5.0)}),
        "record 1: frictionForce = 5 N all the time, so that nothing can be learned of it; is it the right column?",
    ),
    "a dead sensor": (
        lambda: fit({"frictionForce": np.zeros(400)}),
        "record 1: frictionForce = 0 N all the time, so that nothing can be learned of it; is it the right column?",
    ),
    "a signal of words": (
        lambda: fit({"frictionForce": ["low"] * 400}),
        "frictionForce is refused: it must be numbers; could not convert string to float: 'low'",
    ),
    "bounds swapped": (
        lambda: fit(fit="friction.coulomb.Fc:9:1"),
        "fit='friction.coulomb.Fc:9:1': the lower bound 9 is not below the upper bound 1",
    ),
    "known and free": (
        lambda: fit(fit="friction.coulomb.Fc", settings={"friction.coulomb.Fc": 7}),
        "fit='friction.coulomb.Fc': it is also among the known values of settings",
    ),
    "a share in percent": (
        lambda: fit(validation=30),
        "validation=30: it must be at least 0 and below 1",
    ),
}

WARNED: dict[str, tuple[Callable[[], object], str]] = {
    "mass in g": (
        having(mass__moving=880),
        "mass.moving = 880 kg: the piston of cylinder.bore = 0.016 m pushes with 201 N at 10 bar, which "
        "hardly moves it; did you mean 880 g, which is 0.88 kg?",
    ),
    "a mass of one run in g": (
        lambda: ps.Model().simulate_many({"mass.moving": [0.88, 880]}, stop=0.01, step=1e-3, progress=False),
        "run 1 of 2: mass.moving = 880 kg: the piston of cylinder.bore = 0.016 m pushes with 201 N at 10 bar,"
        " which hardly moves it; did you mean 880 g, which is 0.88 kg?",
    ),
    "times of an input in ms": (
        driven(1e3 * T, U),
        "valveVoltage is given until 199 s, but the run ends at 0.2 s: the rest does nothing; if its times "
        "are in ms, write 1e-3 * t",
    ),
    "a stop in ms": (
        lambda: simulate(stop=20.0, step=0.1),
        "valveVoltage is given until 0.199 s, but the run goes on to 20 s: its last value holds from there on",
    ),
    "a voltage in percent": (
        driven(T, 50 + 20 * np.sin(20 * T)),
        "valveVoltage = 69.9992 V: it saturates at 0 and 10 V, and does no more beyond",
    ),
    "a voltage about zero": (
        driven(T, 10 * np.sin(20 * T)),
        "valveVoltage = -7.43579 V: it saturates at 0 and 10 V, and does no more beyond",
    ),
    "a force in mN": (
        lambda: simulate(inputs={"externalForce": 3e5, "valveVoltage": 5.0}),
        "externalForce = 300000 N: the piston of cylinder.bore = 0.016 m pushes with 201 N at 10 bar; so much"
        " more only holds the carriage at an end of its stroke",
    ),
    "a friction force turned": (
        lambda: fit({"frictionForce": -BENCH["frictionForce"]}),
        "the fitted model does not describe frictionForce: RMS residual 7 N of a signal that varies by 6.888"
        " N rms; check units, signs, assumed values and estimated parameters",
    ),
    "a time of the bench in ms": (
        lambda: fit({"time": 1e3 * BENCH["time"]}),
        "record 1: time (in s): samples are 10 s apart, too far to see the carriage start and stop; is it in "
        "ms? then write time=...[ms]",
    ),
    "a number of the sample as time": (
        lambda: fit({"time": np.arange(400.0)}),
        "record 1: time (in s): samples are 1 s apart, too far to see the carriage start and stop; is it in "
        "ms? then write time=...[ms]",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_mistake_is_refused_in_words_that_help(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    mistake, text = REFUSED[name]
    with pytest.raises((ValueError, TypeError, FileNotFoundError)) as caught:
        mistake()
    assert str(caught.value) == text


@pytest.mark.parametrize("name", WARNED)
def test_mistake_is_warned_of(name: str) -> None:
    mistake, text = WARNED[name]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mistake()
    told = [str(one.message) for one in caught if issubclass(one.category, ps.PlantWarning)]
    assert text in told


def test_what_is_unusual_but_meant_gives_the_right_result() -> None:
    expected = simulate()["position"]
    as_words = simulate(inputs={"valveVoltage": (T.tolist(), [repr(float(value)) for value in U])})
    assert as_words["position"].tobytes() == expected.tobytes()
    # A jump has two points of one time.
    jump = simulate(inputs={"valveVoltage": ([0.0, 0.1, 0.1, 0.2], [5.0, 5.0, 7.0, 7.0])})
    assert np.ptp(jump["position"][:100]) < 1e-9 < np.ptp(jump["position"])
    psi = simulate({"supplyPressure": "87.02264 psi"})
    assert psi["position"] == pytest.approx(expected, abs=1e-7)


def test_dates_are_seconds_since_the_first() -> None:
    expected = fit().values
    dates = pandas.date_range("2026-01-01", periods=400, freq="10ms")
    for time in (dates, dates - dates[0], dates.to_numpy()):
        assert fit({"time": time}).values == pytest.approx(expected, rel=1e-6)
    frame = pandas.DataFrame({**BENCH, "time": dates})
    assert ps.fit(frame, experiment="motion", law="Coulomb", starts=0, progress=False).values == pytest.approx(
        expected, rel=1e-6
    )


def test_method_of_a_model_that_is_asked_of_the_package_is_named() -> None:
    with pytest.raises(AttributeError, match=r"no attribute 'simulate_many'; it is a method: Model\(\)\.simulate_many"):
        ps.simulate_many  # noqa: B018
    with pytest.raises(AttributeError, match=r"no attribute '_grid'$"):
        ps._grid  # noqa: B018


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (
            "chamberA.leakage",
            r"inputs: chamberA.leakage is a parameter, not an input: .* plant\['chamberA.leakage'\] =",
        ),
        ("cylinder.bore", "inputs: cylinder.bore is a parameter, not an input: give it among the parameters$"),
    ],
)
def test_parameter_among_the_inputs_is_told_where_it_belongs(name: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ps.Model().simulate(inputs={name: ([0.0, 0.1], [0.01, 0.02])}, stop=0.1)
    with pytest.raises(ValueError, match=words):
        ps.Model().simulate_many([{}, {}], inputs={name: 0.01}, stop=0.1)

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


REFUSED: dict[str, tuple[Callable[[], object], list[str]]] = {
    "number as text": (having(supplyPressure="6"), ["supplyPressure", "'6' has no unit", "6 Pa"]),
    "volts for bars": (having(supplyPressure="6 V"), ["supplyPressure", "unit V", "Pa", "bar"]),
    "degrees Celsius": (having(ambientTemperature=20), ["ambientTemperature = 20 K", "did you mean 20 degC"]),
    "degrees for radians": (having(incline=30), ["incline = 30 rad", "did you mean 30 deg"]),
    "bore in mm": (having(cylinder__bore=16), ["cylinder.bore = 16 m", "did you mean 16 mm"]),
    "position in mm": (having(position0=250), ["position0 = 250 m", "did you mean 250 mm"]),
    "rod thicker than the bore": (having(cylinder__rod=0.02), ["cylinder.rod = 0.02 m", "cylinder.bore = 0.016"]),
    "beyond the stroke": (having(position0=0.6), ["position0 = 0.6 m", "cylinder.stroke = 0.5"]),
    "vacuum around it": (having(ambientPressure=0), ["ambientPressure = 0 Pa", "1000 to 1e+07 Pa"]),
    "number of no law": (having(friction__law=99), ["friction.law = 99", "7 Stribeck"]),
    "a law that is true": (having(friction__law=True), ["friction.law = True", "7 Stribeck"]),
    "nothing": (having(supplyPressure=None), ["supplyPressure = None", "a single number in Pa"]),
    "a list": (having(supplyPressure=[6e5]), ["supplyPressure = [600000.0]", "a single number in Pa"]),
    "not a number": (having(supplyPressure=float("nan")), ["supplyPressure = nan Pa", "a finite number in Pa"]),
    "a complex number": (having(supplyPressure=6e5 + 1j), ["supplyPressure = (600000+1j)", "number in Pa"]),
    "an output set": (having(position=0.1), ["position cannot be set", "computed"]),
    "times and values swapped": (driven(U, T), ["valveVoltage: time falls", "at point"]),
    "one value too few": (driven(T, U[:-1]), ["valveVoltage", "(200,)", "(199,)"]),
    "two columns of values": (driven(T, np.c_[U, U]), ["valveVoltage", "(200, 2)"]),
    "a gap of NaN": (driven(T, np.where(T > 0.1, np.nan, U)), ["valveVoltage = nan V", "t = 0.101 s", "finite"]),
    "time running back": (driven(T[::-1], U), ["valveVoltage: time falls", "point 1"]),
    "a small letter": (lambda: simulate(inputs={"valvevoltage": (T, U)}), ["did you mean valveVoltage"]),
    "a function without a value": (driven(lambda t: None), ["valveVoltage = None", "must be a number"]),
    "a text among values": (driven(T, "3 kV"), ["valveVoltage = '3 kV'", "numbers in V"]),
    "a start after the stop": (lambda: simulate(start=1.0), ["stop = 0.2", "starts at 1.0 s"]),
    "a step that does not divide": (lambda: simulate(step=7e-4), ["stop = 0.2", "whole number of steps of 0.0007 s"]),
    "an output misspelt": (lambda: simulate(outputs=["posiion"]), ["posiion", "did you mean position"]),
    "no file": (lambda: simulate("no.ssv"), ["no.ssv"]),
    "a negative step": (lambda: ps.Model().start().step(-1e-3), ["a step of -0.001 s"]),
    "a state of another model": (
        lambda: ps.Model().start().restore(ps.Model("FrictionBench").start().save()), ["saved state", "this model"]
    ),
    "a model misspelt": (lambda: ps.Model("PneumaticServoCilinder"), ["did you mean PneumaticServoCylinder"]),
    "a record in mm": (
        lambda: fit({"position": 1e3 * BENCH["position"]}), ["position is from -19.9", "write position=...[mm]"]
    ),
    "force and position swapped": (
        lambda: fit({"position": BENCH["frictionForce"], "frictionForce": BENCH["position"]}),
        ["position is from -7 to"],
    ),
    "a force that is one number": (
        lambda: fit({"frictionForce": np.full(400, 5.0)}), ["frictionForce = 5 N all the time", "right column"]
    ),
    "a dead sensor": (lambda: fit({"frictionForce": np.zeros(400)}), ["frictionForce = 0 N all the time"]),
    "a signal of words": (
        lambda: fit({"frictionForce": ["low"] * 400}), ["frictionForce is refused", "must be numbers"]
    ),
    "bounds swapped": (lambda: fit(fit="friction.coulomb.Fc:9:1"), ["lower bound 9", "upper bound 1"]),
    "known and free": (
        lambda: fit(fit="friction.coulomb.Fc", settings={"friction.coulomb.Fc": 7}), ["friction.coulomb.Fc", "known"]
    ),
    "a share in percent": (lambda: fit(hold_out=30), ["hold_out=30", "below 1"]),
}  # fmt: skip

WARNED: dict[str, tuple[Callable[[], object], list[str]]] = {
    "mass in g": (
        having(mass__moving=880), ["mass.moving = 880 kg", "201 N at 10 bar", "did you mean 880 g, which is 0.88 kg"]
    ),
    "a mass of one run in g": (
        lambda: ps.Model().simulate_many({"mass.moving": [0.88, 880]}, stop=0.01, step=1e-3, progress=False),
        ["run 1 of 2: mass.moving = 880 kg"],
    ),
    "times of an input in ms": (driven(1e3 * T, U), ["until 199 s", "the run ends at 0.2 s", "1e-3 * t"]),
    "a stop in ms": (lambda: simulate(stop=20.0, step=0.1), ["given until 0.199 s", "the run goes on to 20 s"]),
    "a voltage in percent": (driven(T, 50 + 20 * np.sin(20 * T)), ["valveVoltage = 69.9", "saturates at 0 and 10 V"]),
    "a voltage about zero": (driven(T, 10 * np.sin(20 * T)), ["valveVoltage = -7.4", "saturates at 0 and 10 V"]),
    "a force in mN": (
        lambda: simulate(inputs={"externalForce": 3e5, "valveVoltage": 5.0}), ["externalForce = 300000 N", "201 N"]
    ),
    "a friction force turned": (
        lambda: fit({"frictionForce": -BENCH["frictionForce"]}), ["does not describe frictionForce", "signs"]
    ),
    "a time of the bench in ms": (
        lambda: fit({"time": 1e3 * BENCH["time"]}), ["samples are 10 s apart", "write time=...[ms]"]
    ),
    "a number of the sample as time": (
        lambda: fit({"time": np.arange(400.0)}), ["samples are 1 s apart", "write time=...[ms]"]
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_mistake_is_refused_in_words_that_help(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    mistake, words = REFUSED[name]
    with pytest.raises((ValueError, TypeError, FileNotFoundError)) as caught:
        mistake()
    told = str(caught.value)
    assert all(word in told for word in words), told


@pytest.mark.parametrize("name", WARNED)
def test_mistake_is_warned_of(name: str) -> None:
    mistake, words = WARNED[name]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mistake()
    told = [str(one.message) for one in caught if issubclass(one.category, ps.PlantWarning)]
    assert any(all(word in text for word in words) for text in told), told


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

"""The observer: its estimates, what it knows of their errors, and whether it tells a wrong law."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close

NOISE = 20e-6
PERIOD = 1e-3
PLANT: dict[str, ps.Value] = {"supplyPressure": 6e5}
SHOWN = ["velocity", "frictionForce", "chamberA.pressure", "chamberB.pressure"]


def voltage(time: float) -> float:
    return 5.0 + 1.2 * np.sin(2.0 * np.pi * 0.8 * time) + 0.5 * np.sin(2.0 * np.pi * 2.3 * time)


def follow(
    law: str, own: str | None = None, *, steps: int = 2000, **options: object
) -> tuple[ps.Observer, np.ndarray, np.ndarray]:
    """Let an observer follow a plant by its position; also return errors and deviations, row by row."""
    noise = np.random.default_rng(7)
    plant = ps.Model().start(PLANT | {"friction.law": law})
    observer = ps.Observer(PLANT | {"friction.law": own or law}, measured={"position": NOISE}, period=PERIOD, **options)  # type: ignore[arg-type]
    errors, deviations = [], []
    for index in range(steps):
        plant["valveVoltage"] = voltage(index * PERIOD)
        plant.step(PERIOD)
        measured = plant["position"] + NOISE * noise.standard_normal()
        found = observer.update({"valveVoltage": voltage(index * PERIOD)}, {"position": measured})
        deviation = observer.deviation
        errors.append([found[name] - plant[name] for name in SHOWN])
        deviations.append([deviation[name] for name in SHOWN])
    return observer, np.array(errors), np.array(deviations)


@pytest.mark.parametrize("law", ["Stribeck", "LuGre", "GMS", "MaxwellSlip", "Karnopp"])
def test_errors_are_within_the_bands_that_the_observer_tells(law: str) -> None:
    """Through stick and slip, from the position alone."""
    observer, errors, deviations = follow(law)
    inside = np.mean(np.abs(errors) < 2.0 * 1.96 * deviations + 1e-9, axis=0)
    assert inside.min() > 0.95, dict(zip(SHOWN, inside, strict=True))
    # A derivative filtered at 30 Hz has 13 mm/s.
    velocity, _, *pressures = np.sqrt(np.mean(errors[200:] ** 2, axis=0))
    assert velocity < 2e-3 and max(pressures) < 5e3
    assert np.mean(deviations[200:, 0]) < 1e-3, "the bands are no wider than of use"
    assert observer.consistency().is_consistent


@pytest.mark.filterwarnings("error")
def test_unscented_filter_knows_its_errors_under_bristles() -> None:
    """The bonds, on which the force hangs, are not estimated: steps from points around the estimate see them break."""
    _, errors, deviations = follow("Bristle", method="unscented")
    velocity, friction, *_ = np.mean(np.abs(errors) < 2.0 * 1.96 * deviations + 1e-9, axis=0)
    assert velocity > 0.95 and friction > 0.6


def test_wrong_law_is_told_by_the_innovations() -> None:
    right, wrong = (follow("Stribeck", law)[0].consistency() for law in ("Stribeck", "Coulomb"))
    assert right.is_consistent and "consistent" in str(right)
    assert wrong.correlation > 1.0 and not wrong.is_consistent and str(wrong).startswith("not consistent")


WALKS = {
    "position": 1e-6, "velocity": 0.02, "chamberA.pressure": 4e3, "chamberB.pressure": 6e3, "chamberA.temperature": 1.0,
    "chamberB.temperature": 2.0, "valve.spool": 0.01, "valve.spoolVelocity": 1.0, "friction.deflection": 1e-7,
}  # fmt: skip


def test_estimates_are_those_of_a_filter_on_public_transitions() -> None:
    """The same filter in its textbook form, written with `transition` and `move_states`.

    Its derivatives are accurate to the tolerance of the scheme, those of the observer to 1e-4.
    """
    settings = PLANT | {"friction.law": "LuGre"}
    observer = ps.Observer(settings, measured={"position": NOISE}, period=PERIOD, process=WALKS)
    model, plant = (ps.Model().start(settings) for _ in range(2))
    names, covariance = list(observer.states), observer.covariance
    assert names == model.states and set(names) == set(WALKS)
    walks = np.array([WALKS[name] for name in names])
    row = np.array([float(name == "position") for name in names])
    noise = np.random.default_rng(3)
    for index in range(300):
        plant["valveVoltage"] = model["valveVoltage"] = voltage(index * PERIOD)
        plant.step(PERIOD)
        step = model.transition(PERIOD, at_rest="zero")
        a = step.A[np.ix_(*([one.index(name) for name in names] for one in (step.next_states, step.states)))]
        predicted = a @ covariance @ a.T + np.diag(walks**2 * PERIOD)
        measured = plant["position"] + NOISE * noise.standard_normal()
        found = observer.update({"valveVoltage": model["valveVoltage"]}, {"position": measured})
        gain = predicted @ row / (row @ predicted @ row + NOISE**2)
        innovation = measured - model["position"]
        assert_close(observer.innovation["position"], innovation, within=0.01 * NOISE, what="innovation")
        state = model.get(names) + gain * innovation
        model.move_states(dict(zip(names, state.tolist(), strict=True)))
        covariance = predicted - np.outer(gain, row @ predicted)
        units = np.sqrt(np.diag(covariance))
        assert_close([found[name] for name in names], state, within=0.01 * units, what="estimates")
        scale = np.outer(units, units)
        assert_close(observer.covariance / scale, covariance / scale, within=0.01, what="covariance")


def test_estimate_does_not_drift_while_the_carriage_sticks() -> None:
    plant = ps.Model().start(PLANT)
    observer = ps.Observer(PLANT, measured={"position": NOISE}, period=PERIOD)
    noise = np.random.default_rng(5)
    for _ in range(2000):
        plant.step(PERIOD)
        found = observer.update({}, {"position": plant["position"] + NOISE * noise.standard_normal()})
    assert plant["sticking"] and abs(found["position"] - plant["position"]) < NOISE
    assert abs(found["velocity"]) < 1e-3


def test_unknown_force_is_estimated() -> None:
    plant = ps.Model().start(PLANT | {"friction.law": "LuGre"})
    observer = ps.Observer(
        PLANT | {"friction.law": "LuGre"}, measured={"position": NOISE}, period=PERIOD, process={"externalForce": 30.0}
    )
    plant["externalForce"] = 12.0
    found = {}
    for index in range(1500):
        plant["valveVoltage"] = voltage(index * PERIOD)
        plant.step(PERIOD)
        found = observer.update({"valveVoltage": voltage(index * PERIOD)}, {"position": plant["position"]})
    assert "externalForce" in observer.states
    assert abs(found["externalForce"] - 12.0) < 3.0 * observer.deviation["externalForce"] < 12.0


def test_measurements_may_be_missing() -> None:
    observer = ps.Observer(PLANT, measured={"position": NOISE, "chamberA.pressure": 1e3}, period=PERIOD)
    observer.update({"valveVoltage": 6.0}, {"chamberA.pressure": None})
    assert np.isnan(list(observer.innovation.values())).all() and observer.normalised_square == 0.0
    assert observer.deviation["position"] >= NOISE * (1.0 - 1e-12), "nothing is known better"
    observer.update({}, {"position": 0.25})
    assert np.isfinite(observer.innovation["position"]) and np.isnan(observer.innovation["chamberA.pressure"])
    assert observer.deviation["position"] < 0.75 * NOISE


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"measured": {}}, "measured is empty"),
        ({"measured": {"positon": 1e-5}}, "positon"),
        ({"measured": {"position": 0.0}}, "position = 0.* must be positive"),
        ({"measured": {"sticking": 1.0}}, "sticking"),
        ({"period": 0.0}, "period"),
        ({"process": {"frictionForce": 1.0}}, "frictionForce"),
        ({"initial": {"externalForce": 1.0}}, "externalForce"),
        ({"process": {"velocity": -1.0}}, "velocity = -1"),
        ({"method": "particle"}, "method = 'particle' is refused: it must be one of extended, unscented"),
    ],
)
def test_wrong_arguments_are_named(arguments: dict[str, object], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ps.Observer(PLANT, **{"measured": {"position": NOISE}, "period": PERIOD} | arguments)  # type: ignore[arg-type]


def test_wrong_values_are_named() -> None:
    observer = ps.Observer(PLANT, measured={"position": NOISE}, period=PERIOD)
    with pytest.raises(ValueError, match="'valveVoltag' is no input"):
        observer.update({"valveVoltag": 6.0}, {})
    with pytest.raises(ValueError, match="'velocity' is not measured; position"):
        observer.update({}, {"velocity": 0.0})
    with pytest.raises(ValueError, match="position = nan is refused"):
        observer.update({}, {"position": float("nan")})
    with pytest.raises(ValueError, match="a verdict needs at least 100 measurements"):
        observer.consistency()


def test_law_whose_force_hangs_on_its_memory_is_told() -> None:
    words = r"friction\.law = Bristle: its force hangs on \d+ numbers of its memory.*method='unscented'"
    with pytest.warns(ps.PlantWarning, match=words):
        ps.Observer({"friction.law": "Bristle"}, measured={"position": NOISE}, period=PERIOD)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("law", ["Armstrong", "MaxwellSlip", "Leuven", "StickSlipSpring"])
def test_law_that_keeps_a_few_numbers_is_not_warned_of(law: str) -> None:
    ps.Observer({"friction.law": law}, measured={"position": NOISE}, period=PERIOD)


@pytest.mark.parametrize("method", ["extended", "unscented"])
def test_law_that_holds_its_force_between_samples_is_told(method: Literal["extended", "unscented"]) -> None:
    with pytest.warns(ps.PlantWarning, match=r"friction\.law = DNLRX: it holds its force between samples"):
        ps.Observer({"friction.law": "DNLRX"}, measured={"position": NOISE}, period=PERIOD, method=method)

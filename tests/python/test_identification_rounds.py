"""How a fit goes on around its searches: a start that cannot be, sensors in turn with parameters, and its end."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pneumatic_servo.identification import fitting
from pneumatic_servo.identification.fitting import _check_start, _interrupted, _result, _with_likely_sensors
from pneumatic_servo.identification.intervals import Certainty
from pneumatic_servo.identification.parameters import Free
from pneumatic_servo.identification.problem import FAILED
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.solve import ROUGH, Solution
from pneumatic_servo.identification.watch import Watch

Array = NDArray[np.float64]


@dataclass
class Rounds:
    """A problem whose sensors are as likely as a list says, one after the other."""

    noises: list[float]
    sensors: dict[str, Sensor] = field(default_factory=lambda: {"p": Sensor(1.0), "q": Sensor(1.0)})

    def likely_sensors(self, x: Array) -> dict[str, Sensor]:
        return {"p": Sensor(self.noises.pop(0)), "q": Sensor(1.0)}

    def seen_by(self, sensors: dict[str, Sensor]) -> Rounds:
        return replace(self, sensors=sensors)


@pytest.mark.parametrize(
    ("noises", "rounds", "noise"),
    [
        # Less than 3 % of the noise of all signals matters no more, up or down.
        ([1.029], 0, 1.029),
        ([0.972], 0, 0.972),
        ([1.031, 1.031], 1, 1.031),
        ([0.5, 0.25, 0.2501, 9.0], 2, 0.2501),
        # Four times at most.
        ([2.0, 1.0, 2.0, 1.0, 7.0], 4, 1.0),
    ],
)
def test_sensors_and_parameters_are_fitted_in_turn_until_both_agree(
    noises: list[float], rounds: int, noise: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[tuple[float, float, str, tuple[Any, ...]]] = []

    def refine(problem: Any, x: Array, loss: str, watch: Any, *effort: Any) -> Solution:
        calls.append((problem.sensors["p"].noise, float(x[0]), loss, effort))
        return Solution(x + 1.0, 0.0, True, "")

    monkeypatch.setattr(fitting, "refine", refine)
    stages: list[str] = []
    watch: Any = SimpleNamespace(stage=stages.append)
    given = list(noises)
    problem: Any = Rounds(noises)
    found, best = _with_likely_sensors(problem, Solution(np.zeros(1), 0.0, True, ""), "huber", watch)
    assert found.sensors["p"].noise == noise
    # Each search goes on where the one before has ended; only the last is fine.
    expected = [(given[k], float(k), "huber", (ROUGH,)) for k in range(rounds)]
    assert calls == [*expected, (noise, float(rounds), "huber", ())]
    assert stages == ["sensors"] * rounds + ["last refinement"] and best.x[0] == rounds + 1.0


def test_start_that_cannot_be_simulated_is_refused_with_the_words_of_the_model() -> None:
    refusals = ["said before"]
    left = np.array([[-FAILED, FAILED]])

    def residuals(vectors: list[Array]) -> Array:
        refusals.append("Fs < Fc")
        return left

    problem: Any = SimpleNamespace(start=np.zeros(1), refusals=refusals, residuals=residuals)
    with pytest.raises(ValueError, match=r"^the start values cannot be simulated: Fs < Fc$"):
        _check_start(problem)
    # A part that can be is enough.
    left[0, 0] = 1.0
    _check_start(problem)


CERTAIN = Certainty(np.array([1.0]), np.array([3.0]), np.eye(1), {"a": "it is at a bound"})


def ended(rms: float) -> Any:
    """A problem with one free parameter and 20 samples of each of two signals."""
    return SimpleNamespace(
        free=[Free("a", "N", 1.0, 0.0, 5.0, 1.0)], values=lambda x: {"a": float(x[0])}, refusals=["Fs < Fc", "more"],
        rms=lambda x, held=False: {} if held else {"p": rms, "q": 2.0}, experiment=SimpleNamespace(law="Dahl"),
        windows=[SimpleNamespace(fitted=15), SimpleNamespace(fitted=5)], begun=lambda fitted, x: ended(rms),
    )  # fmt: skip


def test_fit_whose_values_cannot_be_simulated_has_not_converged() -> None:
    found = _result(ended(0.1), np.array([2.0]), True, "done", CERTAIN, ["a note"])
    one = found.parameters["a"]
    assert (one.value, one.low, one.high, one.unit) == (2.0, 1.0, 3.0, "N")
    assert found.converged and found.message == "done" and found.notes == ("a note",) and found.law == "Dahl"
    assert found.undetermined == {"a": "it is at a bound"} and found.hold_out_rms == {}
    broken = _result(ended(float("nan")), np.array([2.0]), True, "done", CERTAIN, [])
    assert not broken.converged and broken.message == "the fitted values cannot be simulated: Fs < Fc"


def test_interrupted_fit_has_the_best_until_then(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fitting, "certainty", lambda problem, x: CERTAIN)
    watch = Watch("fit")
    stopped = _interrupted(ended(0.1), ended(0.1), watch, ["a note"])
    assert str(stopped) == "interrupted" and stopped.finished is None
    # With what its windows begin with, which is none of the parameters.
    watch.see(np.array([4.0, 9.0]), 1.0)
    found: Any = _interrupted(ended(0.1), ended(0.1), watch, ["a note"]).finished
    assert found.values == {"a": 4.0} and found.x.tolist() == [4.0] and found.notes == ("a note",)
    assert not found.converged and found.message == "it was interrupted"

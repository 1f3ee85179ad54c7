"""Mistakes in a record of a whole rig, one at a time: how many are named rightly, before a fit or after it."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from named_mistakes import AFTER, COLUMNS, MISTAKES, record, said_after, said_before, tried, with_velocity
from numpy.typing import NDArray
from pneumatic_servo.identification.fitting import make_experiment
from pneumatic_servo.identification.plausibility import recorded
from pneumatic_servo.identification.table import Measured
from shared import faults
from test_identification_interrupt import stopping

Array = NDArray[np.float64]
ROOT = Path(__file__).parents[2]


def test_right_record_is_not_doubted() -> None:
    assert said_before(record()) == ""
    assert said_before(with_velocity(1.0)(record())) == ""
    assert said_after(record()) == "green: no sensor is doubted"


@pytest.mark.parametrize("name", MISTAKES)
def test_mistake_is_named(name: str) -> None:
    _, is_named, _, said = tried(name)
    assert is_named == "yes", said


def test_table_of_the_page_has_every_mistake() -> None:
    """The page and its table say when each is named; what is said before a fit is the same today."""
    with (ROOT / "docs" / "identification" / "mistakes.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.reader(stream))
    assert rows[0] == COLUMNS
    assert [row[0] for row in rows[1:]] == list(MISTAKES)
    page = (ROOT / "docs" / "identification" / "validation.md").read_text(encoding="utf-8")
    for name, is_named, when, said in rows[1:]:
        assert f"| {name} | {is_named} | {when} |" in page
        assert when == AFTER or said == said_before(MISTAKES[name].change(record()))
    count = sum(row[1] == "yes" for row in rows[1:])
    assert f"Of {len(MISTAKES)} mistakes" in page and f"{count} are named" in page and count >= 0.9 * len(MISTAKES)


def test_what_looks_like_a_fault_of_a_recorder_and_is_none_is_not_doubted() -> None:
    """Rest and stops without noise, a force that is exactly dry, a fast start, and a voltage at its end."""
    time = np.arange(0.0, 2.0, 1e-3)
    stopped = np.minimum(np.cumsum(np.maximum(np.sin(4.0 * time), 0.0)) * 1e-3, 0.3)
    dry = 7.0 * np.sign(np.cos(6.0 * time))
    coarse = 1e-4 * np.round(0.1 * np.sin(3.0 * time) / 1e-4)
    for course in (stopped, dry, coarse, np.full_like(time, 3.0)):
        assert not faults(chamberA__pressure=course)
    started = np.where(time < 1.0, 0.0, 50.0 * (time - 1.0) ** 2)
    for course in (stopped, coarse, started):
        assert not any("leaps" in text for text in faults(position=course))
    noisy = np.sin(3.0 * time) + 0.01 * np.random.default_rng(0).standard_normal(len(time))
    above, below = faults(chamberA__pressure=np.clip(noisy, -0.5, 0.8))
    assert "stays at 0.8 Pa" in above and "stays at -0.5 Pa" in below
    [leap] = faults(position=started + 0.5 * (time > 1.5))
    assert leap.startswith("row 1501 of position: position leaps by 0.55")


def test_missing_rows_are_noted() -> None:
    """Rows that are lost with their times do no harm; the notes say how many there were."""
    kept = np.delete(np.arange(1000), [100, 101, 500])
    signals = {name: course[:1000][kept] for name, course in record().items()}
    rig = make_experiment("rig", "Stribeck", None, ps.Options())
    rig.use(signals)
    [note] = recorded(rig, Measured("a table", signals, lambda signal, row: f"row {row} of {signal}"))
    assert (
        note
        == "a table: 3 samples are missing, the first before row 100 of time; single ones are bridged on straight lines"
    )


def test_supply_in_bar_is_refused() -> None:
    with pytest.raises(ValueError, match=r".") as caught:
        ps.fit(record(), experiment="rig", law="Stribeck", settings={"supplyPressure": 6}, progress=False)
    said = str(caught.value)
    assert "supplyPressure" in said and "did you mean 6 bar, which is 600000 Pa?" in said


def test_what_the_words_advise_is_right() -> None:
    """A position from the other end, and a voltage about 0, given as the warnings say: the same values are found."""
    data = record()
    given = {"experiment": "rig", "law": "Stribeck", "starts": 0, "progress": False, "fit": "friction.stribeck.Fc"}
    known = {"supplyPressure": 6e5, "valve.deadZone": 0.065, "valve.C": 4.4e-9, "friction.stribeck.Fs": 12.4,
             "friction.stribeck.vs": 0.018, "friction.stribeck.sigma2": 38.0}  # fmt: skip
    expected = ps.fit(data, settings=known, **given).values["friction.stribeck.Fc"]
    other = {**data, "position": 0.5 - data["position"], "valveVoltage": data["valveVoltage"] - 5.0}
    sensors = {"gain.position": -1.0, "offset.position": 0.5, "offset.valveVoltage": -5.0}
    found = ps.fit(other, settings={**known, **sensors}, **given).values["friction.stribeck.Fc"]
    assert found == pytest.approx(expected, rel=1e-4)


def test_sign_of_a_force_is_doubted() -> None:
    time = np.arange(0, 4, 0.005)
    speed = 0.1 * np.cos(3 * time)
    data: dict[str, Any] = {
        "time": time,
        "position": np.sin(3 * time) / 30,
        "force": -(9 * np.sign(speed) + 50 * speed),
    }
    with (
        pytest.warns(ps.PlantWarning, match="force works against friction.*force=-column"),
        pytest.raises(ps.Interrupted),
    ):
        ps.fit(data, experiment="force", law="Coulomb", starts=0, progress=stopping(0))


def test_fit_that_leaves_noise_is_not_asked_for_faults(monkeypatch: pytest.MonkeyPatch) -> None:
    """With residuals of noise only no fault can explain half, so that none is told."""

    def asked(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr("pneumatic_servo.identification.causes._told", asked)
    time = np.arange(0.0, 4.0, 2e-3)
    position = 1e-3 * np.sin(6.0 * time)
    friction = 7.0 * np.sign(np.append(0.0, np.diff(position))) + 0.05 * np.random.default_rng(0).standard_normal(2000)
    given = {"experiment": "motion", "law": "Coulomb", "fit": "friction.coulomb.Fc", "play": 0.0, "starts": 0,
             "settings": {"friction.coulomb.sigma2": 0.0}, "progress": False}  # fmt: skip
    data = {"time": time, "position": position, "frictionForce": friction}
    assert ps.fit(data, **given).doubt is None
    late = {**data, "frictionForce": np.append(np.full(5, friction[0]), friction[:-5])}
    with pytest.raises(AssertionError):
        _ = ps.fit(late, **given).doubt

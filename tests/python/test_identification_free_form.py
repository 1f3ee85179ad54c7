"""Free curves of friction: the gain that any law could still bring."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest
from test_identification import bench
from test_identification_force import axis
from test_identification_verdict import fit


def test_right_law_has_nothing_to_gain() -> None:
    found = fit(bench(), validation=0.0)
    assert found.free_form is not None and set(found.free_form.curves) == {"velocity", "velocity and position"}
    assert found.free_form.law == pytest.approx(0.05, rel=0.1)
    assert found.free_form.gain("velocity") < 0.03 and found.free_form.gain("velocity and position") < 0.03
    assert found.verdict.light == "green" and "could leave 0 % less" in found.verdict.text


def test_wrong_law_has_what_the_right_one_gains(tmp_path: Path) -> None:
    """Coulomb friction has no peak at low speed; a curve over velocity comes to about what the right law leaves."""
    right, wrong = (fit(bench(), law, validation=0.0) for law in ("Stribeck", "Coulomb"))
    assert wrong.free_form is not None and right.free_form is not None
    assert wrong.free_form.curves["velocity"] < 3.0 * right.free_form.law < 0.3 * wrong.free_form.law
    assert wrong.free_form.gain("velocity") > 0.7
    assert any(one.light == "yellow" and "a law of velocity could leave" in one.text for one in wrong.verdict.findings)
    wrong.to_report(tmp_path / "a.html")
    assert "What any law could still gain" in (tmp_path / "a.html").read_text(encoding="utf-8")


def test_curve_of_a_fit_is_handed_over_as_a_table() -> None:
    """The table of the fit with the wrong law has the steady friction of the right one, which made the data."""
    right, wrong = (fit(bench(), law, validation=0.0) for law in ("Stribeck", "Coulomb"))
    assert wrong.free_form is not None
    table = wrong.free_form.table()
    speeds = np.abs(wrong.free_form.velocity)
    for speed in np.quantile(speeds, [0.2, 0.5, 0.8]):
        drive = {"bench.drive": "PrescribedMotion", "driveVelocity": float(speed)}
        own = {name: value for name, value in right.settings.items() if name in ps.Model("FrictionBench").parameters}
        found, expected = (
            ps.Model("FrictionBench").simulate({**given, **drive}, stop=0.1, outputs=["frictionForce"])[
                "frictionForce"
            ][-1]
            for given in (table, own)
        )
        assert found == pytest.approx(expected, abs=0.15), speed


def test_load_and_place_are_told_apart() -> None:
    """Friction that grows less than the load does is a matter of load, one that grows along the stroke is none."""
    data = bench()
    load = np.repeat([1.0, 1.5, 2.0, 1.2, 1.8], 200)
    way = np.sign(np.append(0.0, np.diff(data["position"])))
    noise = 0.05 * np.random.default_rng(3).standard_normal(1000)
    given = {"rated": 1.0, "fit": "friction.coulomb.Fc", "settings": {"friction.coulomb.sigma2": 0.0}}
    of_load = {**data, "normalForce": load, "frictionForce": 7.0 * np.sqrt(load) * way + noise}
    found = fit(of_load, "Coulomb", validation=0.0, **given).free_form
    assert found is not None and found.family == "velocity and load"
    assert found.gain("velocity") < 0.3 < 0.6 < found.gain("velocity and load")
    of_place = {**data, "frictionForce": (7.0 + 50.0 * data["position"]) * way + noise}
    found = fit(of_place, "Coulomb", validation=0.0, **given).free_form
    assert found is not None
    assert found.gain("velocity") < 0.3 < 0.6 < found.gain("velocity and position")


def test_axis_that_a_force_moves_is_asked_too() -> None:
    data = {name: axis()[name] for name in ("time", "position", "force")}
    found = ps.fit(data, experiment="force", law="Coulomb", fit="mass,friction.coulomb.Fc,friction.coulomb.sigma2",
                   starts=0, progress=False).free_form  # fmt: skip
    assert found is not None and found.gain(found.family) < 0.5


def test_gas_alone_tells_no_friction() -> None:
    from test_identification import RIG, RIG_COLUMNS

    found = ps.fit(RIG, experiment="pneumatic", law="None", fit="valve.C", columns=RIG_COLUMNS, starts=0,
                   settings={"supplyPressure": 6e5}, progress=False)  # fmt: skip
    assert found.free_form is None

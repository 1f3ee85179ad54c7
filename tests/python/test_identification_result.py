"""Outputs of a fit: settings, JSON, a set of values, a page of a notebook and a text, each as a whole."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pneumatic_servo as ps
import pytest
from pneumatic_servo.identification.fitted import Estimate
from pneumatic_servo.identification.ranges import Ranges
from pneumatic_servo.identification.result import Fit
from pneumatic_servo.identification.signals import Units
from pneumatic_servo.identification.verdict import Finding, Verdict
from test_identification import RIG, RIG_COLUMNS

FC = "friction.coulomb.Fc"


def fitted(**given: Any) -> Fit:
    """A fit of a friction torque, a gain and a mass, of which the last has no upper end."""
    units = given.pop("units", Units(is_rotating=True))
    table = ps.Model("FrictionBench")
    experiment = SimpleNamespace(
        name="force", table=table, units=units, settings={"friction.coulomb.sigma2": 2.0, FC: 99.0, "incline": 0.1},
    )  # fmt: skip
    usual: dict[str, Any] = {
        "converged": True, "law": "Coulomb",
        "parameters": {
            FC: Estimate(1.23456789, 1.0, 1.5, "N.m"), "gain.force": Estimate(2.0, 1.9, 2.1, "N.m/A"),
            "mass": Estimate(0.5, 0.1, np.inf, "kg.m2"),
        },
        "rms": {"velocity": 0.0123456789, "position": np.nan}, "validation_rms": {"velocity": 0.5},
        "not_identifiable": {"mass": "it is at <a> bound"}, "aic": 1.0, "notes": ("1 < 2",),
        "problem": SimpleNamespace(experiment=experiment, windows=("one", "two"), begins=_begins),
        "x": None, "certainty": None,
    }  # fmt: skip
    found = Fit(**{**usual, **given})
    found.__dict__["ranges"] = Ranges({"force": (-1.0, 2.0), "velocity": (-3.0, 3.0)}, units)
    found.__dict__["verdict"] = Verdict((Finding("yellow", "Look."),))
    return found


def _begins(x: None) -> list[dict[str, float]]:
    """Start values of two segments."""
    return [{"position0": 0.1, "velocity0": -0.2}, {"position0": 0.3}]


def test_settings_are_those_of_the_model() -> None:
    """The fitted start of the first segment is among them, so that a run of them is the fitted one.

    What is fitted stands in place of what was known; sensors and inclines are none of a bench.
    """
    found = fitted()
    assert found.settings == {
        "friction.law": "Coulomb", "friction.coulomb.sigma2": 2.0, FC: 1.23456789, "mass": 0.5,
        "position0": 0.1, "velocity0": -0.2, "bench.drive": "Free",
    }  # fmt: skip
    assert found.values == {FC: 1.23456789, "gain.force": 2.0, "mass": 0.5} and found.beside == ["gain.force"]
    assert found.units.is_rotating


def test_json_has_all_and_null_for_what_is_not_finite(tmp_path: Path) -> None:
    fitted().to_json(tmp_path / "a.json")
    text = (tmp_path / "a.json").read_text(encoding="utf-8")
    expected = {
        "converged": True,
        "parameters": {
            FC: {"value": 1.23456789, "low": 1.0, "high": 1.5, "unit": "N.m"},
            "gain.force": {"value": 2.0, "low": 1.9, "high": 2.1, "unit": "N.m/A"},
            "mass": {"value": 0.5, "low": 0.1, "high": None, "unit": "kg.m2"},
        },
        "rms": {"velocity": 0.0123456789, "position": None},
        "validation_rms": {"velocity": 0.5},
        "not_identifiable": ["mass"],
        "law": "Coulomb",
        "ranges": {"force": [-1.0, 2.0], "velocity": [-3.0, 3.0]},
        "verdict": {"light": "yellow", "text": "Look at this before the values are used. Look."},
        "hold_out_rms": {"velocity": 0.5},
        "undetermined": ["mass"],
    }
    assert json.loads(text) == expected and list(json.loads(text)) == list(expected)
    assert text.startswith('{\n  "converged": true,\n') and text.endswith("}\n")
    validated: Any = SimpleNamespace(as_list=lambda: [{"left out": "a"}])
    assert fitted(cross_validation=validated).as_dict()["crossValidation"] == [{"left out": "a"}]


def test_earlier_names_work_and_say_what_they_are_called_now() -> None:
    found = fitted()
    with pytest.warns(ps.PlantWarning, match="hold_out_rms is now called validation_rms"):
        assert found.hold_out_rms == found.validation_rms == {"velocity": 0.5}
    with pytest.warns(ps.PlantWarning, match="undetermined is now called not_identifiable"):
        assert found.undetermined == found.not_identifiable
    given: dict[str, Any] = {"experiment": "motion", "law": "Coulomb"}
    with (
        pytest.warns(ps.PlantWarning, match="hold_out is now called validation"),
        pytest.raises(ValueError, match="30"),
    ):
        ps.fit({}, hold_out=30, **given)
    with (
        pytest.warns(ps.PlantWarning, match="window is now called segment"),
        pytest.raises(ValueError, match="segment=0"),
    ):
        ps.fit({}, window=0.0, **given)
    with pytest.raises(TypeError, match="give one of both"):
        ps.fit({}, hold_out=0.1, validation=0.1, **given)


def test_set_of_values_says_how_to_read_its_units(tmp_path: Path) -> None:
    for units, words in ((Units(), ""), (Units(is_rotating=True), ", of a rotating machine: read N.m for N, ")):
        fitted(units=units).to_ssv(tmp_path / "my values.ssv")
        root = ElementTree.parse(tmp_path / "my values.ssv").getroot()
        assert root.get("name") == "my values"
        described = root.get("description") or ""
        assert described.startswith(f"Fitted parameters of FrictionBench{words}") and bool(words) is (
            "N.m" in described
        )
        names = {one.get("name") for one in root.iter() if one.tag.endswith("}Parameter")}
        assert names == {
            "friction.law", "friction.coulomb.sigma2", FC, "mass", "position0", "velocity0", "bench.drive",
        }  # fmt: skip


def test_fit_is_shown_as_a_text_and_on_a_page() -> None:
    assert repr(fitted()).splitlines() == [
        "Coulomb: converged",
        "  friction.coulomb.Fc  1.23457 [1, 1.5] N.m",
        "  gain.force           2 [1.9, 2.1] N.m/A",
        "  mass                 0.5 [0.1, inf] kg.m2",
        "  rms of velocity: 0.0123457 rad/s",
        "  rms of position: nan rad",
        "  validation rms of velocity: 0.5 rad/s",
        "  not identifiable: mass: it is at <a> bound",
        "  note: 1 < 2",
    ]
    assert repr(fitted(parameters={}, rms={}, validation_rms={}, not_identifiable={}, notes=(), converged=False)) == (
        "Coulomb: not converged"
    )
    html = fitted(law="A&B")._repr_html_()

    def rows(*cells: tuple[str, ...]) -> str:
        return "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in cells)

    assert html.startswith("<p><b>A&amp;B</b>: converged</p><table")
    for row in (
        rows((FC, "1.23457", "1", "1.5", "N.m"), ("gain.force", "2", "1.9", "2.1", "N.m/A"),
             ("mass", "0.5", "0.1", "inf", "kg.m2")),
        rows(("velocity", "0.0123457", "rad/s"), ("position", "nan", "rad")),
    ):  # fmt: skip
        assert row in html
    heads = [f"<th>{cell}</th>" for cell in ("parameter", "value", "low", "high", "unit", "signal", "rms", "unit")]
    assert html.count("<th>") == len(heads) and "".join(heads[:5]) in html and "".join(heads[5:]) in html
    assert html.endswith("</table><ul><li>1 &lt; 2</li></ul>")


def test_what_lies_beyond_the_data_is_said_of_signals_that_are_known() -> None:
    found = fitted()
    assert found.beyond({"force": [0.0, 1.0]}) == ()
    assert found.beyond({"velocity": -5.0, "force": 3.0}) == (
        "velocity reaches 5 rad/s, of which up to 3 rad/s was fitted",
        "force reaches 3 N.m, of which up to 2 N.m was fitted",
    )
    with pytest.raises(ValueError, match=r"^asked pressure: this fit knows the ranges of force, velocity$"):
        found.beyond({"force": 1.0, "pressure": 1.0})


@pytest.mark.parametrize(
    ("experiment", "law", "fit", "inputs"),
    [
        ("rig", "Stribeck", "friction.stribeck.Fs=12.4,valve.C=4.4e-9", "held"),
        ("rig", "Stribeck", "friction.stribeck.Fs=12.4,valve.C=4.4e-9", "lines"),
        ("mechanical", "Stribeck", "friction.stribeck.Fs=12.4,friction.stribeck.Fc=7.6", "held"),
        ("rig", "Stribeck", "friction.stribeck.Fs=12.4,valve.C=4.4e-9", "smooth"),
        ("pneumatic", "None", "valve.deadZone=0.065,valve.C=4.4e-9", "held"),
    ],
)
def test_fit_is_replayed_as_it_was_fitted(experiment: str, law: str, fit: str, inputs: str) -> None:
    """With the fitted begin of each stretch, which the settings alone do not have, and its inputs: to the bit."""
    known: dict[str, Any] = {} if experiment == "mechanical" else {"supplyPressure": 6e5}
    found = ps.fit(RIG, experiment=experiment, law=law, fit=fit, columns=RIG_COLUMNS, settings=known, starts=0,
                   inputs=inputs, validation=0.2, progress=False)  # fmt: skip
    differences = found.problem.differences(found.x)
    for number in (0, len(found.problem.windows) - 1):
        window, run = found.problem.windows[number], found.simulate(number)
        for signal in found.problem.experiment.compared:
            seen = np.interp(window.record.time, run.time, run[signal])
            assert (window.record.signals[signal] - seen).tobytes() == differences[number][signal].tobytes()
        # The gas half has a carriage of 10 t, which `simulate` warns of.
        if experiment != "pneumatic":
            again = found.problem.experiment.simulated.simulate(
                run.settings, inputs=run, stop=run.time[-1], step=window.record.step, outputs=["position"]
            )
            assert again["position"].tobytes() == run["position"].tobytes()
    with pytest.raises(ValueError, match=r"segment = 9999 is refused: the data have"):
        found.simulate(9999)
    with pytest.raises(ValueError, match=r"there is no variable posiion"):
        found.simulate(outputs=["posiion"])

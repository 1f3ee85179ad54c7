"""Machines that rotate: torque, inertia and angle are taken by their units, and named by them everywhere."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest
from numpy.typing import NDArray
from pneumatic_servo.cli import main
from pneumatic_servo.identification.figures import against, friction_map, overlay, worst_misfit
from pneumatic_servo.ssv import read_ssv
from shared import is_styled
from test_identification_force import FREE, TRUE, chosen, fit, holds
from test_identification_force import axis as moved

Array = NDArray[np.float64]
COLUMNS = {"time": "time", "position": "position[rad]", "force": "force[N.m]"}
UNITS = {"mass": "kg.m2", "friction.coulomb.Fc": "N.m", "friction.coulomb.sigma2": "N.m.s/rad"}
OF_SLIDING = re.compile(r"(?<![A-Za-z.])(?:N|kg|mm|m|mm/s|m/s|N\.s/m)(?![A-Za-z./²\w])")


def turned() -> dict[str, Array]:
    return chosen("position", "force")


@cache
def found() -> ps.Fit:
    return fit(turned(), fit=FREE, columns=COLUMNS, validation=0.25, cross_validate="")


def test_numbers_are_those_of_the_machine_that_slides() -> None:
    """The equations are the same: so are the values, to the last bit."""
    sliding = fit(turned(), fit=FREE, validation=0.25)
    assert found().values == sliding.values and found().rms == sliding.rms
    holds(found(), TRUE, within=0.06)
    assert {name: one.unit for name, one in found().parameters.items()} == UNITS
    assert {name: one.unit for name, one in sliding.parameters.items()} == {
        "mass": "kg", "friction.coulomb.Fc": "N", "friction.coulomb.sigma2": "N.s/m"
    }  # fmt: skip


def test_everything_that_is_said_is_in_its_units(tmp_path: Path) -> None:
    told = [str(found()), found()._repr_html_(), str(found().verdict), str(found().free_form),
            *found().beyond({"velocity": 100.0, "force": 1e4})]  # fmt: skip
    found().to_report(tmp_path / "a.html")
    page = re.sub(r"data:image/png[^\"]*|<style>.*?</style>", "", (tmp_path / "a.html").read_text(encoding="utf-8"))
    told.append(page.replace(found().units.told, "").replace("read N.m for N, kg.m2 for kg, rad for m", ""))
    for text in told:
        assert not OF_SLIDING.search(text), (OF_SLIDING.search(text), text)
    assert " rad" in told[0] and " rad, " in told[2] and "N.m rms" in told[3] and "rad/s" in told[4]


def test_figures_are_in_its_units() -> None:
    residuals = found()._residuals
    figures = [overlay(residuals), worst_misfit(residuals), against(residuals), friction_map(found())]
    labels = [text for figure in figures if figure is not None for axis in figure.axes
              for text in (axis.get_xlabel(), axis.get_ylabel())]  # fmt: skip
    assert {"position (rad)", "velocity (rad/s)", "friction at load factor 1 (N.m)", "rest (rad)"} <= set(labels)
    assert not any(OF_SLIDING.search(label) for label in labels)
    assert all(is_styled(figure) for figure in figures)
    # Where the angle is drawn it is in rad, not a thousand times that.
    [angle] = [axis for axis in figures[0].axes if axis.get_ylabel() == "position (rad)"]
    assert max(np.max(np.abs(line.get_ydata()), initial=0.0) for line in angle.lines) == pytest.approx(
        np.max(np.abs(moved()["position"])), rel=1e-3
    )


def test_band_of_a_prediction_is_in_its_units() -> None:
    runs = ps.Model("FrictionBench").simulate_many(
        {"mass": [19.0, 21.0]}, common={"bench.drive": "Free"}, inputs={"appliedForce": 50.0}, stop=0.1,
        outputs=["position", "frictionForce", "velocity"],
    )  # fmt: skip
    figure = ps.Band(runs, found().units).plot()
    labels = [axis.get_ylabel() for axis in figure.axes]
    assert is_styled(figure) and labels == ["position (rad)", "frictionForce (N.m)", "velocity (rad/s)"]


def test_parameter_set_says_how_to_read_it(tmp_path: Path) -> None:
    """The FMU has units of a slide, which a tool compares; the description says what they stand for."""
    found().to_ssv(tmp_path / "a.ssv")
    assert "of a rotating machine: read N.m for N, kg.m2 for kg, rad for m" in (tmp_path / "a.ssv").read_text("utf-8")
    assert read_ssv(tmp_path / "a.ssv", "FrictionBench")["mass"] == found().values["mass"]


@pytest.mark.parametrize(
    "written",
    [
        {"settings": {"mass": "20 kg.m2"}, "fit": FREE[1:]},
        {"settings": {"mass": (2e8, "g.cm2")}, "fit": FREE[1:]},
        {"fit": ["mass=18 kg.m2", *FREE[1:]]},
        {"fit": ["mass:1 kg.m2:400 kg.m2", *FREE[1:]]},
        {"fit": FREE, "settings": {"friction.stribeck.vs": "1e-2 rad/s"}},
    ],
)
def test_unit_of_a_value_tells_that_it_rotates(written: dict[str, object]) -> None:
    """Arrays by name have no units; then the units of the values count."""
    other = fit(turned(), **written)
    assert other.units.is_rotating
    assert other.parameters["friction.coulomb.Fc"].unit == "N.m"
    holds(other, {name: TRUE[name] for name in FREE[1:]}, within=0.06)


def test_command_line_takes_degrees_and_newton_metres(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "axis.csv"
    rows = zip(moved()["time"], np.degrees(moved()["position"]), moved()["force"], strict=True)
    lines = "".join(f"{t:.3f},{x:.8f},{f:.6f}\n" for t, x, f in rows)
    file.write_text(f"t (s),phi (deg),M (Nm)\n{lines}", encoding="utf-8")
    given = ["fit", str(file), "--experiment", "force", "--law", "Coulomb", "--starts", "0", "--columns",
             "time=t,position=phi,force=M", "--json", str(tmp_path / "a.json")]  # fmt: skip
    assert main([*given, "--fit", "mass,friction.coulomb.Fc,friction.coulomb.sigma2"]) == 0
    values = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["parameters"]
    assert {name: one["unit"] for name, one in values.items()} == UNITS
    assert values["mass"]["value"] == pytest.approx(20.0, rel=0.02)
    assert "kg.m2" in capsys.readouterr().out
    assert (
        main([*given, "--set", "mass=20 kg.m2", "--fit", "friction.coulomb.Fc,friction.coulomb.sigma2=50 N.m.s/rad"])
        == 0
    )
    again = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["parameters"]
    assert again["friction.coulomb.Fc"]["value"] == pytest.approx(15.0, rel=0.03)


@pytest.mark.parametrize(
    ("angle", "gain", "mass"), [("position[rad]", "N.m/A", "20 kg.m2"), ("position[m]", "N/A", "20 kg")]
)
def test_current_of_a_motor_has_a_gain_with_its_unit(angle: str, gain: str, mass: str) -> None:
    data = chosen("position", "force", force=moved()["force"] / 50.0)
    columns = {**COLUMNS, "position": angle, "force": "force[A]"}
    free = [*FREE[1:], "gain.force", "offset.force"]
    other = fit(data, columns=columns, settings={"mass": mass}, fit=free)
    holds(other, {"gain.force": 50.0, **{name: TRUE[name] for name in FREE[1:]}}, within=0.06)
    assert other.parameters["gain.force"].unit == gain and other.parameters["offset.force"].unit == "A"
    known = fit(data, columns=columns, settings={"gain.force": f"50 {gain}"}, fit=FREE)
    holds(known, TRUE, within=0.06)


def test_torque_on_a_spindle_moves_a_slide() -> None:
    """A torque in N.m beside a position in m: what makes a force of it is a gain in 1/m, which has to be told."""
    columns = {**COLUMNS, "position": "position[m]"}
    with pytest.raises(ValueError, match=r"gain\.force has no default; it must be free, or fixed by settings"):
        fit(turned(), columns=columns, fit=FREE)
    other = fit(turned(), columns=columns, fit=FREE, settings={"gain.force": "1 1/m"})
    assert other.parameters["mass"].unit == "kg" and not other.units.is_rotating


@pytest.mark.parametrize(
    ("columns", "options", "words"),
    [
        ({"position": "position[rad]", "velocity": "velocity[m/s]"}, {}, ["velocity is in m/s", "position in rad"]),
        ({"position": "position[mm]"}, {"settings": {"mass": "2 kg.m2"}}, ["rotating", "position is in m"]),
        ({"position": "position[rad]"}, {"settings": {"mass": "20 kg"}}, ["mass", "unit kg is refused", "kg.m2"]),
        ({"position": "position[rad]"}, {"fit": ["mass=20 kg"]}, ["unit kg is refused", "kg.m2"]),
        ({"position": "position[rad]"}, {"settings": {"incline": 0.1}}, ["incline", "rotating machine has none"]),
        ({"position": "position[V]"}, {}, ["unit V is refused", "rad", "mm"]),
        ({"position": "position[rad]"}, {"experiment": "motion"}, ["position is in rad", "only the experiment force"]),
    ],
)
def test_units_that_do_not_go_together_are_refused(
    columns: dict[str, str], options: dict[str, object], words: list[str]
) -> None:
    data = chosen("position", "velocity", "force")
    given = {"time": "time", "force": "force", **columns}
    with pytest.raises(ValueError, match=r".") as caught:
        fit(data, columns=given, **{"fit": FREE, **options})
    assert all(word in str(caught.value) for word in words), str(caught.value)

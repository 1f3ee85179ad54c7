"""Figures of runs and comparisons: what is drawn, in which unit, and what is written beside it."""

from __future__ import annotations

import numpy as np
import pneumatic_servo as ps
import pytest
from shared import is_styled

OUTPUTS = [
    "position",
    "velocity",
    "frictionForce",
    "chamberA.pressure",
    "chamberB.pressure",
    "valveVoltage",
]


@pytest.fixture(scope="module")
def run() -> ps.Run:
    voltages = ([0.0, 0.1, 0.2], [5.0, 6.5, 3.5])
    return ps.Model().simulate(inputs={"valveVoltage": voltages}, stop=0.3, step=1e-3, outputs=OUTPUTS)


def test_panels_have_the_curves_of_a_unit(run: ps.Run) -> None:
    figure = run.plot("valveVoltage", "chamberA.pressure", "chamberB.pressure", "position")
    voltage, pressures, place = figure.axes
    assert is_styled(figure)
    assert voltage.get_ylabel() == "valveVoltage (V)" and pressures.get_ylabel() == "pressure (bar)"
    assert place.get_ylabel() == "position (mm)"
    assert [axis.get_xlabel() for axis in (voltage, pressures, place)] == ["", "", "time (s)"]
    one, other = pressures.get_lines()
    for line, name in ((one, "chamberA.pressure"), (other, "chamberB.pressure")):
        assert line.get_label() == name and np.array_equal(line.get_xdata(), run.time)
        assert np.array_equal(line.get_ydata(), 1e-5 * run[name])
    assert one.get_zorder() > other.get_zorder() and one.get_color() != other.get_color()
    assert [text.get_text() for text in pressures.get_legend().get_texts()] == [one.get_label(), other.get_label()]
    assert voltage.get_legend() is None and place.get_legend() is None
    # An input is held over a step, everything else moves.
    assert voltage.get_lines()[0].get_drawstyle() == "steps-post" and one.get_drawstyle() == "default"


def test_rest_is_shaded_over_the_whole_panel() -> None:
    given = {"inputs": {"valveVoltage": ([0.0, 0.1], [5.0, 6.5])}, "stop": 0.1, "step": 1e-3}
    run = ps.Model().simulate(outputs=["position", "sticking"], **given)
    [axis] = run.plot("position").axes
    [shade] = axis.collections
    assert run["sticking"][0] == 1.0 and shade.get_transform() == axis.get_xaxis_transform()
    ends = shade.get_paths()[0].get_extents()
    assert (ends.y0, ends.y1) == (0.0, 1.0)
    # The figure begins with the run, and ends where the mass breaks away.
    assert ends.x0 == 0.0 and ends.x1 == pytest.approx(run.time[np.flatnonzero(run["sticking"] > 0.5)[-1]], abs=1e-3)


def test_each_law_is_drawn_in_each_panel() -> None:
    laws = ["Stribeck", "LuGre", "Coulomb"]
    comparison = ps.Model().compare(laws, inputs={"valveVoltage": 6.5}, stop=0.1, step=1e-3, progress=False)
    figure = comparison.plot("position", "frictionForce")
    assert is_styled(figure)
    assert [axis.get_ylabel() for axis in figure.axes] == ["position (mm)", "frictionForce (N)"]
    assert [axis.get_xlabel() for axis in figure.axes] == ["", "time (s)"]
    for axis, name, factor in zip(figure.axes, ["position", "frictionForce"], [1e3, 1.0], strict=True):
        assert [line.get_label() for line in axis.get_lines()] == laws
        assert len({line.get_color() for line in axis.get_lines()}) == 3
        for line, law in zip(axis.get_lines(), laws, strict=True):
            assert np.array_equal(line.get_ydata(), factor * comparison[law][name])
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == laws


def test_samples_of_the_friction_that_are_far_apart_are_dots(run: ps.Run) -> None:
    """Dots are joined by a weak line through all samples; the strong one has gaps there, and only there."""
    figure = run.plot_friction()
    whole, near = figure.axes
    assert is_styled(figure)
    for axis in (whole, near):
        assert (axis.get_xlabel(), axis.get_ylabel()) == ("velocity (mm/s)", "friction force (N)")
    assert whole.get_title() == "friction force against velocity"
    assert near.get_title() == "the same near standstill; dots: samples"
    _, _, weak, strong, dots = whole.get_lines()
    assert np.array_equal(weak.get_ydata(), run["frictionForce"])
    is_joined = np.isfinite(np.asarray(strong.get_xdata()))
    assert 0 < len(dots.get_xdata()) == np.sum(~is_joined) < len(run)
    assert np.array_equal(dots.get_ydata(), run["frictionForce"][~is_joined])
    assert np.array_equal(np.asarray(strong.get_xdata())[is_joined], 1e3 * run["velocity"][is_joined])
    inside = run["frictionForce"][np.abs(run["velocity"]) <= np.max(np.abs(run["velocity"])) / 20.0]
    assert np.array_equal(near.get_lines()[1].get_ydata(), inside)

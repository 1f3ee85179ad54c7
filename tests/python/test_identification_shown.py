"""What results of identification show, and the parts that they are made of, by numbers and words."""

from __future__ import annotations

import re
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from pneumatic_servo.identification.cross_validation import Case
from pneumatic_servo.identification.experiments.base import Experiment
from pneumatic_servo.identification.experiments.motion import _pace
from pneumatic_servo.identification.figures import friction_map
from pneumatic_servo.identification.foretold import Foretold, _of_sensors
from pneumatic_servo.identification.free_form import PIECES, _splines
from pneumatic_servo.identification.kinds import kinds
from pneumatic_servo.identification.recorder import _check_repeats
from pneumatic_servo.identification.residuals import Residuals
from pneumatic_servo.identification.sampling import _r_hat
from pneumatic_servo.identification.signals import Units
from pneumatic_servo.identification.table import Measured
from pneumatic_servo.identification.telling import Telling, Trial
from test_identification import bench
from test_identification_verdict import fit


@pytest.fixture(scope="module")
def found() -> ps.Fit:
    return fit(bench())


def test_fit_is_shown_line_by_line(found: ps.Fit) -> None:
    first, *lines = repr(found).splitlines()
    assert first == "Stribeck: converged"
    assert repr(replace(found, converged=False)).splitlines()[0] == "Stribeck: not converged"
    assert [line.split()[0] for line in lines[:4]] == list(found.parameters)
    assert [line for line in lines if " rms of " in line] == [
        f"  rms of frictionForce: {found.rms['frictionForce']:.6g} N",
        f"  hold-out rms of frictionForce: {found.hold_out_rms['frictionForce']:.6g} N",
    ]
    noted = replace(found, notes=("5 V < 10 V",), undetermined={"friction.stribeck.vs": "too slow"})
    assert repr(noted).splitlines()[-2:] == [
        "  not determined: friction.stribeck.vs: too slow",
        "  note: 5 V < 10 V",
    ]


def test_notes_are_a_list_of_the_page_where_there_are_some(found: ps.Fit) -> None:
    assert replace(found, notes=())._repr_html_().endswith("</table>")
    assert replace(found, notes=("5 V < 10 V",))._repr_html_().endswith("</table><ul><li>5 V &lt; 10 V</li></ul>")
    two = replace(found, notes=("one", "two"))._repr_html_()
    assert two.endswith("</table><ul><li>one</li><li>two</li></ul>")
    for converged, verdict in ((True, "converged"), (False, "not converged")):
        html = replace(found, converged=converged)._repr_html_()
        assert html.startswith(f"<p><b>Stribeck</b>: {verdict}</p><table")


def test_report_says_yes_where_noise_is_left_and_no_elsewhere(tmp_path: Path) -> None:
    """Coulomb's law leaves the peak of the friction at reversals, and nothing but noise in fast motion."""
    fit(bench(), "Coulomb").to_report(tmp_path / "a.html")
    rows = re.findall(r"<tr>(.*?)</tr>", (tmp_path / "a.html").read_text(encoding="utf-8"))
    cells = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in rows]
    white = {row[0]: row[-1] for row in cells if len(row) == 6 and row[-1] in ("yes", "no")}
    assert white["at reversals"] == "no" and set(white.values()) <= {"yes", "no"}
    assert all(row[4] == "N" and int(row[2]) > 0 for row in cells if len(row) == 6 and row[0] in white)


def test_excitations_are_a_line_each() -> None:
    trials = tuple(
        Trial(name, "driveVelocity", np.zeros(1), np.zeros(1), distance)
        for name, distance in (("a ramp", 12.34), ("a sine", 0.5))
    )
    lines = ["        12.3  a ramp", "         0.5  a sine"]
    title = "excitations that tell Dahl from LuGre, with what is left in units of the noise:"
    assert repr(Telling("Dahl", "LuGre", trials)).splitlines() == [
        title,
        "        12.3  a ramp",
        "         0.5  a sine",
    ]
    weak = Telling("Dahl", "LuGre", trials[1:])
    assert repr(weak).splitlines()[1:] == [lines[1], "none of them tells both apart with these sensors"]


@pytest.mark.parametrize(("is_rotating", "unit"), [(False, "N"), (True, "N.m")])
def test_friction_of_a_case_has_the_unit_of_the_machine(is_rotating: bool, unit: str) -> None:
    units = Units(is_rotating)
    condition: Any = None
    case = Case(condition, 10, {}, {}, Foretold(10.0, 8.0, 12.0, 11.0, 10.5, 11.5, 0.1), ())
    assert case.said(units) == f"predicted 10 {unit} [8, 12], measured 11 {unit} [10.5, 11.5]"
    assert case.holds


def test_worst_misfit_is_counted_in_squares_of_the_noise() -> None:
    """1 N too much for 0.2 s, of which noise of 0.05 N and what the law makes of it change little."""
    data = bench()
    data["frictionForce"][420:440] += 1.0
    residuals = Residuals(fit(data, hold_out=0.0))
    worst = residuals.worst()
    noise = residuals.problem.sensors["frictionForce"].noise
    assert worst is not None and 0.8 < worst.size * noise**2 < 1.2


def test_motion_is_of_five_kinds_that_share_the_samples(found: ps.Fit) -> None:
    own = kinds(found.problem)
    assert list(own) == ["at rest", "at break-away", "at reversals", "in slow motion", "in fast motion"]
    for place, window in enumerate(found.problem.windows):
        assert np.array_equal(np.sum([masks[place] for masks in own.values()], axis=0), window.used.astype(int))


def test_pace_is_that_of_five_steps_at_an_end() -> None:
    path = 3.0 + np.arange(10.0) ** 2
    assert (_pace(path, 0.5, 0), _pace(path, 0.5, -1)) == (25.0 / 2.5, (81.0 - 16.0) / 2.5)
    assert _pace(path[:3], 0.5, -1) == 4.0 / 1.0


def test_splines_share_each_value() -> None:
    table = _splines(np.linspace(-2.0, 3.0, 101))
    # Cubic splines over pieces are three more than these; at each end one is left.
    assert table.shape == (101, PIECES + 3)
    assert_close(np.sum(table, axis=1), 1.0, within=4e-15, what="sum of splines")
    assert table[0, 0] == 1.0 and table[-1, -1] == 1.0
    assert _splines(np.ones(4)).tolist() == [[1.0]] * 4


def test_sensors_are_told_from_the_machine() -> None:
    names = ["gain.position", "friction.stribeck.Fs", "delay.position", "offset.frictionForce", "mass.moving", "lag.a"]
    problem: Any = SimpleNamespace(free=[SimpleNamespace(name=name) for name in names])
    assert _of_sensors(problem) == [0, 2, 3, 5]


def test_part_begins_at_the_rest_that_is_next() -> None:
    record: Any = SimpleNamespace(time=np.arange(10.0))
    experiment: Any = SimpleNamespace(resting=lambda record: np.isin(record.time, [3.0, 6.0]))
    cuts = [Experiment._cut(experiment, record, 4.6, within) for within in (2.0, 0.5)]
    # At 6 s the machine rests; without a rest that is near enough the next sample is taken.
    assert cuts == [6, 5]


def test_parts_share_the_length_of_the_record() -> None:
    """A record of 10 s in parts of about 3 s: three, of which the second and third begin after 3.3 and 6.7 s."""
    record: Any = SimpleNamespace(
        time=np.linspace(0.0, 10.0, 101), step=0.1, part=lambda first, last: (int(first), int(last))
    )
    experiment: Any = SimpleNamespace(
        options=SimpleNamespace(window=3.0), _cut=lambda record, time, within: np.searchsorted(record.time, time)
    )
    assert Experiment.windows(experiment, record) == [(0, 34), (34, 67), (67, 101)]


@pytest.mark.parametrize(("length", "is_told"), [(7, True), (8, False)])
def test_rows_that_repeat_for_long_are_a_rest(length: int, is_told: bool) -> None:
    """Two signals with noise, both of which hold their values twice, for so many steps."""
    columns = np.random.default_rng(0).standard_normal((2, 200))
    for begin in (50, 120):
        columns[:, begin : begin + length + 1] = columns[:, begin : begin + 1]
    signals = {"time": np.arange(200.0), "position": columns[0], "force": columns[1]}
    source = Measured("a table", signals, lambda signal, row: f"row {row}")
    words = f"a table: {2 * length} rows repeat the one before, the first row 51, "
    with pytest.warns(ps.PlantWarning, match=words) if is_told else nullcontext():
        _check_repeats(source)


def test_map_of_the_friction_names_its_curves(found: ps.Fit) -> None:
    figure = friction_map(found)
    assert figure is not None
    assert [line.get_label() for line in figure.axes[0].get_lines()] == ["data", "Stribeck, steady"]


def test_names_of_what_is_free_are_asked_for_by_their_argument() -> None:
    with pytest.raises(TypeError, match=r"^fit must be a list of names, but has 1$"):
        ps.fit(bench(), experiment="motion", law="Coulomb", fit=[1])  # type: ignore[list-item]


def test_default_of_a_boolean_is_one() -> None:
    variables = ps.Model().variables
    assert variables["balance.enabled"].default is False
    assert str(variables["balance.enabled"]).startswith("balance.enabled = False: ")
    assert str(variables["valve.deadZone"]).startswith("valve.deadZone = 0.08 (0 to 0.9): Dead zone ")


def test_inputs_of_a_model_are_open_on_a_page() -> None:
    parts = re.findall(r"<details( open)?><summary>(\w+): (\d+)</summary>", ps.Model()._repr_html_())
    model = ps.Model()
    of = (("Inputs", model.inputs), ("Parameters", model.parameters), ("Outputs", model.outputs))
    assert parts == [(" open" if title == "Inputs" else "", title, str(len(variables))) for title, variables in of]


def test_chains_that_wander_are_told_by_their_halves() -> None:
    """Halves 0, 2 and 4, 6: variances of 2 within and of 8 between their means, of two draws each."""
    assert _r_hat(np.array([[0.0, 2.0, 4.0, 6.0]])) == np.sqrt(0.5 + 8.0 / 2.0)
    assert _r_hat(np.ones((2, 4))) == np.inf

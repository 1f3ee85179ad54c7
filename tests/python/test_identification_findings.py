"""The whole text of each finding of a verdict and of what stands beside it, from where on it is said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification import report, telling
from pneumatic_servo.identification import verdict as judge
from pneumatic_servo.identification.cross_validation import Case
from pneumatic_servo.identification.doubts import Doubt, _most, _without
from pneumatic_servo.identification.evidence import COLUMNS, Evidence, Preference, evidence
from pneumatic_servo.identification.fitted import Estimate
from pneumatic_servo.identification.foretold import Foretold
from pneumatic_servo.identification.free_form import PENALTIES, FreeForm, _of_speed, _predicted
from pneumatic_servo.identification.parameters import Free
from pneumatic_servo.identification.regimes import Regime
from pneumatic_servo.identification.report import _conditions, _free_form, _image, _table
from pneumatic_servo.identification.signals import Units
from pneumatic_servo.identification.verdict import Finding, Verdict

Array = NDArray[np.float64]
ROUND = "other libraries of linear algebra round otherwise"
TURNING = Units(is_rotating=True)


def told(findings: Any) -> list[str]:
    return [f"{one.light}: {one.text}" for one in findings]


def fitted(**given: Any) -> Any:
    """A fit without anything to say."""
    free = (Free("mass", "kg", 1.0, 0.1, 10.0, 1.0), Free("area", "m2", 1.0, 0.1, 10.0, 1.0))
    problem = SimpleNamespace(free=free, bounds=(np.full(2, 0.1), np.full(2, 10.0)),
                              experiment=SimpleNamespace(name="motion"))  # fmt: skip
    usual: dict[str, Any] = {
        "converged": True, "message": "", "problem": problem, "x": np.ones(2), "undetermined": {}, "rms": {},
        "hold_out_rms": {}, "cross_validation": None, "units": TURNING,
        "parameters": {one.name: Estimate(1.0, 0.9, 1.1, one.unit) for one in free},
    }  # fmt: skip
    return SimpleNamespace(**{**usual, **given})


def test_search_is_judged_by_its_end_and_by_what_is_not_told() -> None:
    assert told(judge._of_search(fitted())) == []
    found = judge._of_search(
        fitted(converged=False, message="8 steps", undetermined={"spring": "", "mass": "", "gain.force": ""},
               x=np.array([10.0, 0.1]))
    )  # fmt: skip
    beyond = "the data draw it beyond. Widen the bound, or ask what else it stands for."
    assert told(found) == [
        "red: The search has not come to an end (8 steps).",
        "yellow: The data do not tell spring, gain.force: give it, or measure what tells it.",
        f"yellow: mass has run to its bound, 10 kg: {beyond}",
        f"yellow: area has run to its bound, 0.1 m2: {beyond}",
    ]


def left(**given: Any) -> Any:
    """What a fit leaves of an angle that swings by 2 rad, by a sensor of 0.1 rad; its rms is 1 rad."""
    course = SimpleNamespace(measured=np.array([2.0, -2.0]))
    usual = {
        "courses": lambda signal: [course, course], "noise": lambda signal: 0.1, "all": lambda signal: np.ones(4),
        "is_white": lambda signal: True, "worst": lambda: None,
    }  # fmt: skip
    return SimpleNamespace(**{**usual, **given})


QUIET = Regime("at rest", 50, 0.2, True)
OF = "What it leaves of position, 0.29 rad rms,"
LARGE = f"{OF} is about as large as the noise of its sensor, but"


@pytest.mark.parametrize(
    ("rms", "regimes", "is_white", "text"),
    [
        (1.01, [QUIET], True, "red: It leaves 1.01 rad rms of position, which varies by 2 rad: look at signs, units "
         "and what was assumed."),
        (np.nan, [QUIET, replace(QUIET, name="in slow motion", rms=1.51), replace(QUIET, rms=1.5)], True,
         "red: It leaves nan rad rms of position, which varies by 2 rad, most of it in slow motion (1.51): look at "
         "signs, units and what was assumed."),
        (0.99, [replace(QUIET, rms=1.49)], True, "yellow: It leaves 0.99 rad rms of position, 9.9 times the noise of "
         "its sensor: the law, or what is held fixed, misses something."),
        (0.31, [QUIET, replace(QUIET, name="at reversals", rms=1.6)], False,
         "yellow: It leaves 0.31 rad rms of position, 3.1 times the noise of its sensor, most of it at reversals "
         "(1.6): the law, or what is held fixed, misses something."),
        (0.29, [QUIET, Regime("a", 50, 0.31, False), Regime("b", 50, 0.4, True), Regime("c", 50, 0.4, False),
                Regime("d", 50, 0.29, False)], False,
         f"yellow: {LARGE} more a (0.31) and c (0.4): there the law misses something."),
        (0.29, [QUIET, replace(QUIET, name="a", is_white=False), replace(QUIET, name="b", is_white=False),
                replace(QUIET, name="c", is_white=False)], True, f"green: {LARGE} hangs together a, b and c."),
        (0.29, [QUIET, replace(QUIET, name="a", is_white=False)], True, f"green: {LARGE} hangs together a."),
        (0.29, [QUIET], False, f"green: {LARGE} hangs together."),
        (0.29, [QUIET, replace(QUIET, name="b", rms=1.6)], False,
         f"green: {LARGE} hangs together, most of it b (1.6)."),
        (0.29, [QUIET, replace(QUIET, rms=1.6)], True, f"green: {OF} looks like noise."),
        (0.29, [], True, f"green: {OF} looks like noise."),
    ],
)  # fmt: skip
def test_misfit_is_judged_by_spread_noise_and_kinds_of_motion(
    rms: float, regimes: list[Regime], is_white: bool, text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(judge, "regimes", lambda residuals, signal: tuple(regimes))
    residuals = left(is_white=lambda signal: is_white)
    assert told(judge._of_misfit(fitted(rms={"position": rms}), residuals)) == [text]


@pytest.mark.parametrize("size", [8.9, 9.1])
def test_place_of_the_worst_misfit_is_told_beyond_three_times_the_noise(size: float) -> None:
    record = SimpleNamespace(name="a.csv", begin=100.0, time=np.arange(5) * 0.5)
    worst = SimpleNamespace(signal="force", window=1, sample=3, size=size)
    residuals = left(worst=lambda: worst, windows=[None, SimpleNamespace(record=record)])
    expected = ["green: Most is missed of force at 101.5 s of a.csv."] if size > 9.0 else []
    assert told(judge._of_misfit(fitted(), residuals)) == expected


@pytest.mark.parametrize(
    ("held", "light", "times"),
    [
        (0.149, "green", "1.5"),
        (0.151, "yellow", "1.5"),
        (0.299, "yellow", "3"),
        (0.301, "red", "3"),
        (np.nan, "red", "nan"),
    ],
)
def test_prediction_is_judged_by_what_is_left_of_the_fitted(
    held: float, light: str, times: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(judge, "held_of", lambda problem, x: "held")
    ranges: Any = SimpleNamespace(beyond=lambda asked: {"a": "p reaches 2", "b": "q falls"} if asked == "held" else {})
    beyond = [f"yellow: What was predicted is an extrapolation: {text}." for text in ("p reaches 2", "q falls")]
    none = ["green: Nothing was held out, so that no prediction was tried."]
    assert told(judge._of_prediction(fitted(), ranges)) == none + beyond
    found = judge._of_prediction(fitted(rms={"force": 0.1}, hold_out_rms={"force": held}), ranges)
    assert told(found) == [
        f"{light}: Data held out are predicted to {held:.3g} N.m rms of force, {times} times what is left of those "
        "fitted.",
        *beyond,
    ]


def case(name: str, friction: Foretold | None, rms: float = 1.0) -> Case:
    condition: Any = SimpleNamespace(name=name)
    return Case(condition, 10, {"velocity": rms}, {"velocity": 1.0}, friction, ())


def test_conditions_are_judged_by_what_the_others_predict() -> None:
    foretold = Foretold(10.0, 8.0, 12.0, 11.0, 10.5, 11.5, 0.1)
    off, wide = replace(foretold, measured=13.0, spread=0.3), replace(foretold, low=1.0, high=40.0, spread=np.nan)
    cases = [case("1 bar", foretold), case("3 bar", off), case("5 bar", wide)]
    validated = SimpleNamespace(cases=cases, holds=2)
    assert told(judge._of_conditions(fitted())) == []
    assert told(judge._of_conditions(fitted(cross_validation=validated))) == [
        "red: The law does not hold at 3 bar: from the others friction is predicted 10 N.m [8, 12], measured 13 N.m "
        "[10.5, 11.5].",
        "yellow: The others hardly tell 5 bar: friction there is predicted as 1 to 40 N.m.",
        "green: Left out one after the other, 2 of 3 conditions are predicted as well as that is told; between them "
        "friction differs from the law by 20 %.",
    ]
    plain = SimpleNamespace(cases=[case("1 bar", None, 2.9), case("2 bar", None, 3.1)], holds=1)
    assert told(judge._of_conditions(fitted(cross_validation=plain))) == [
        "red: The law does not hold at 2 bar: from the others velocity is predicted to 3.1 rad/s rms, and fitted to 1.",
        "green: Left out one after the other, 1 of 2 conditions are predicted as well as that is told.",
    ]


FORM = FreeForm(2.0, {"velocity": 1.5, "velocity and load": 1.41, "velocity, load and position": 3.0}, "N.m")


def test_free_form_is_judged_where_friction_is_measured() -> None:
    said = (
        "Of friction in motion the law leaves 2 N.m rms, a free curve 1.5 N.m over velocity, 1.41 N.m over velocity "
        "and load, 3 N.m over velocity, load and position: a law of velocity and load could leave 30 % less."
    )
    assert told(judge._of_free_form(fitted(), FORM)) == [f"green: {said}"]
    curves = {**FORM.curves, "velocity and load": 1.39}
    [much] = judge._of_free_form(fitted(), replace(FORM, curves=curves))
    other = fitted(problem=SimpleNamespace(experiment=SimpleNamespace(name="force")))
    [less] = judge._of_free_form(other, replace(FORM, curves=curves))
    assert (much.light, less.light) == ("yellow", "green") and told(judge._of_free_form(fitted(), None)) == []
    assert FORM.gain("velocity, load and position") == 0.0 and replace(FORM, law=0.0).gain("velocity") == 0.0
    plain = FreeForm(2.0, {"velocity": 1.5, "velocity and position": 1.0})
    assert (plain.family, plain.gain("velocity and position")) == ("velocity", 0.5)
    assert str(plain).endswith("1 N over velocity and position: a law of velocity could leave 25 % less.")
    rows = [["the law", "2", ""], ["a free curve over velocity", "1.5", "25%"],
            ["a free curve over velocity and load", "1.41", "30%"],
            ["a free curve over velocity, load and position", "3", "0%"]]  # fmt: skip
    head = ["friction in motion", "rms (N.m)", "less than the law leaves"]
    assert _free_form(FORM) == ["<h2>What any law could still gain</h2>", _table(head, rows)]
    assert _free_form(None) == []


@pytest.mark.parametrize(
    ("name", "value", "unit", "text"),
    [
        ("gain.force", 1.23456, "1", "if force were 1.235 times what is read: free gain.force."),
        ("offset.force", 0.123456, "N", "if 0.123 N of force were an offset of its sensor: free offset.force."),
        ("offset.q", 0.5, "1", "if 0.5 of q were an offset of its sensor: free offset.q."),
        ("delay.chamberA.pressure", 0.0123, "s",
         "if chamberA.pressure were read 12 ms late: free delay.chamberA.pressure."),
        ("lag.position", 0.02, "s",
         "if position were read 20 ms late, or through a filter: free lag.position or delay.position."),
    ],
)  # fmt: skip
def test_fault_of_a_sensor_is_told_with_what_to_free(name: str, value: float, unit: str, text: str) -> None:
    found = Doubt(name, value, unit, 100.0, "velocity", 0.756)
    said = f"yellow: Of the squares of what is left of velocity 76 % would be gone {text}"
    assert told(judge._of_sensors(found)) == [said] and told(judge._of_sensors(None)) == []


def test_share_is_that_of_the_signal_that_gains_most() -> None:
    """Two windows of two signals, three and one samples of each."""
    problem: Any = SimpleNamespace(
        experiment=SimpleNamespace(compared=("position", "force")),
        windows=[SimpleNamespace(fitted=3), SimpleNamespace(fitted=1)],
    )
    left = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 1.0, 2.0])
    then = np.array([1.0, 1.0, 0.0, 1.0, 1.0, 2.0, 1.0, 2.0])
    assert _most(problem, left, then) == ("force", 1.0 - 10.0 / 16.0)
    basis = np.linalg.qr(np.random.default_rng(1).standard_normal((8, 2)))[0]
    rest = left - basis @ np.linalg.lstsq(basis, left)[0]
    assert_close(_without(basis, left), rest, within=5e-15, what="rest")


def test_verdict_begins_with_the_worst(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = {"search": "yellow", "misfit": "green", "prediction": "red", "conditions": "green", "free_form": "yellow",
             "sensors": "red"}  # fmt: skip
    for part, light in parts.items():
        monkeypatch.setattr(judge, f"_of_{part}", lambda *_, part=part, light=light: iter([Finding(light, part)]))
    none: Any = None
    found = judge.verdict(none, none, none, none, none)
    assert [one.text for one in found.findings] == [
        "prediction", "sensors", "search", "free_form", "misfit", "conditions",
    ]  # fmt: skip
    heads = ("The law describes the data as far as they tell.", "Look at this before the values are used.",
             "These values do not describe the machine.")  # fmt: skip
    for light, head in zip(("green", "yellow", "red"), heads, strict=True):
        verdict = Verdict((Finding(light, "A."), Finding("green", "B.")))
        assert (verdict.light, verdict.text, str(verdict)) == (light, f"{head} A. B.", f"{light}: {head} A. B.")
    assert Verdict(()).light == "green"


def test_table_of_the_evidence(tmp_path: Path) -> None:
    best = Preference("LuGre", 1234.56, 0.0, 0.0, False, np.array([0.1, 0.7]))
    alike = Preference("Dahl", 1230.0, 4.56, 3.21, False, np.array([0.71, 0.9, 0.2]))
    worse = Preference("Coulomb", 1000.0, 234.56, 12.3, True, np.array([0.2, 0.75]))
    lines = [
        "law                           elpd     less by        +-   k-hat",
        "LuGre                       1234.6         0.0       0.0    0.70",
        "Dahl                        1230.0         4.6       3.2    0.90",
        "Coulomb                     1000.0       234.6      12.3    0.75",
    ]
    trust = "is not to be trusted: {} stretches tell too much to be left out by weights"
    doubted = [f"the elpd of Dahl {trust.format(2)}", f"the elpd of Coulomb {trust.format(1)}"]
    every = Evidence((best, alike, worse))
    assert repr(every).splitlines() == [*lines, "the data cannot tell LuGre from Dahl", *doubted]
    two = Evidence((best, worse))
    assert repr(two).splitlines() == [*lines[:2], lines[3], "the data speak for LuGre", doubted[1]]
    assert repr(Evidence((best,))).splitlines() == lines[:2]
    assert repr(Evidence((best, alike, replace(alike, law="GMS")))).splitlines()[4] == (
        "the data cannot tell LuGre from Dahl, GMS"
    )
    assert every.untold == ("Dahl",) and every.doubtful == {"Dahl": 2, "Coulomb": 1}
    every.to_csv(tmp_path / "a.csv")
    head, first, *_, last = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert head.split(",") == COLUMNS
    assert COLUMNS == ["law", "elpd", "difference", "standard error", "is told from the first", "largest k-hat"]
    assert (first, last) == ("LuGre,1234.56,0.0,0.0,False,0.7", "Coulomb,1000.0,234.56,12.3,True,0.75")


def test_laws_without_predictions_are_no_evidence() -> None:
    fine: Any = SimpleNamespace(law="Dahl", rms={"force": 1.0})
    lost: Any = SimpleNamespace(law="LuGre", rms={"force": 1.0, "position": np.inf})
    with pytest.raises(
        ValueError, match=r"^LuGre: its fitted values cannot be simulated, so that it predicts nothing$"
    ):
        evidence([fine, lost])
    with pytest.raises(ValueError, match=r"^number = 99 is refused: it must be at least 100$"):
        evidence([fine], number=99)
    with pytest.raises(ValueError, match=r"^seed = -1 is refused: it must be at least 0$"):
        evidence([fine], seed=-1)
    labels = np.arange(4)
    problem = SimpleNamespace(free=[None], blocks=lambda number: labels if number == 20 else None)
    fine.problem = SimpleNamespace(trained=lambda: problem)
    text = "4 stretches of time are too few to leave one out; at least 5 are needed"
    with pytest.raises(ValueError, match=f"^{text}$"):
        evidence([fine], number=100)


def test_curve_predicts_stretches_that_it_has_not_seen() -> None:
    """By regressions with a penalty as rows below, without one stretch after the other."""
    rng = np.random.default_rng(3)
    table, stretches = rng.standard_normal((205, 4)), np.repeat(np.arange(10), [21, 20] * 5)
    rest = table @ [1.0, -0.2, 0.05, 0.0] + rng.standard_normal(205)
    unit = np.sum(table**2) / 4.0
    sums = []
    for penalty in PENALTIES:
        rows = np.sqrt(penalty * unit) * np.eye(4)
        total = 0.0
        for out in (stretches == one for one in range(10)):
            curve = np.linalg.lstsq(np.vstack([table[~out], rows]), np.append(rest[~out], np.zeros(4)))[0]
            total += np.sum((rest[out] - table[out] @ curve) ** 2)
        sums.append(total)
    assert 0 < np.argmin(sums) < len(PENALTIES) - 1
    assert_close(_predicted(table, rest), np.sqrt(min(sums) / 205.0), rel=1e-13, what="rms", why=ROUND)


def test_directions_have_curves_of_their_own() -> None:
    speed = np.array([-1.0, -0.25, 0.0, 0.25, 1.0])
    table = _of_speed(speed)
    forth, back = np.hsplit(table, 2)
    assert np.sum(forth, axis=1).round(12).tolist() == [0, 0, 0, 1, 1]
    assert np.sum(back, axis=1).round(12).tolist() == [1, 1, 0, 0, 0]
    assert np.array_equal(forth[3:], back[1::-1])
    # Closer where it is slow: a quarter of the speed is in the middle of the curve, which is symmetric about it.
    assert np.allclose(forth[3], forth[3][::-1]) and forth[4, -1] == 1.0


def test_table_of_a_page_is_safe() -> None:
    assert _table(["a<b", "c"], [["1", "2 & 3"], ["4", ""]]) == (
        "<table><tr><th>a&lt;b</th><th>c</th></tr><tr><td>1</td><td>2 &amp; 3</td></tr>"
        "<tr><td>4</td><td></td></tr></table>"
    )


def test_picture_of_a_page_is_in_it() -> None:
    def write(stream: Any, **given: Any) -> None:
        assert given == {"format": "png", "metadata": {"Software": None}}
        stream.write(b"\x89PNG")

    figure: Any = SimpleNamespace(savefig=write)
    assert _image(figure, 'a "b"') == '<p><img alt="a &quot;b&quot;" src="data:image/png;base64,iVBORw=="></p>'


def test_conditions_of_a_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pneumatic_servo.identification.report._image", lambda figure, text: f"{figure}: {text}")
    cases = [replace(case("1 bar", None), beyond=("p < q",)), case("2 bar", None)]
    found = SimpleNamespace(columns=["a"], texts=lambda: [["b"]], plot=lambda: "figure", cases=cases)
    assert _conditions(fitted(cross_validation=found)) == [
        "<h2>Each condition predicted by the others</h2>",
        "<table><tr><th>a</th></tr><tr><td>b</td></tr></table>",
        "<p>An extrapolation. 1 bar: p &lt; q.</p>",
        "figure: friction of each condition, predicted and measured",
    ]
    assert _conditions(fitted()) == []


@pytest.mark.parametrize("is_rotating", [False, True])
def test_page_of_a_fit_from_top_to_bottom(is_rotating: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """A fit of two parameters and two signals, of which one was held out; figures stand as their names."""
    names = ("friction_map", "worst_misfit", "overlay", "against")
    for name in names:
        monkeypatch.setattr(
            report, name, lambda of, name=name: name if of is (found if name == "friction_map" else residuals) else ""
        )
    monkeypatch.setattr(report, "_image", lambda figure, text: f"{figure}: {text}")
    monkeypatch.setattr(report, "regimes", lambda residuals, signal: [Regime(f"{signal} at rest", 7, 0.25, True)])
    found = fitted(
        law="A&B", message="<done>", rms={"position": 1e-3, "force": 2.5}, hold_out_rms={"force": 3.5},
        undetermined={"area": "it is <at> a bound"}, notes=("5 < 6", "two"), units=Units(is_rotating),
        parameters={"mass": Estimate(1.23456789, 0.9, 1.1, "kg"), "area": Estimate(1e-4, 0.0, np.inf, "m2")},
        certainty=SimpleNamespace(correlation=np.array([[1.0, -0.456], [-0.456, 1.0]])),
    )  # fmt: skip
    residuals: Any = SimpleNamespace(unit=lambda signal: f"unit of {signal}", is_white=lambda signal: signal == "force")
    verdict = Verdict((Finding("yellow", "x < y."),))
    head, _, body = report.page(found, residuals, verdict, FORM).partition("</style>")
    assert head.startswith("<!doctype html><meta charset=utf-8><title>A&amp;B</title><style>body{")
    told = "<p>Units are those of a rotating machine: read N.m for N, kg.m2 for kg, rad for m.</p>"
    white = _table(
        ["signal", "rms", "rms of data held out", "unit", "white"],
        [["position", "0.001", "", "unit of position", "no"], ["force", "2.5", "3.5", "unit of force", "yes"]],
    )
    kinds = _table(
        ["by kind of motion", "signal", "samples", "rms", "unit", "white"],
        [[f"{one} at rest", one, "7", "0.25", f"unit of {one}", "yes"] for one in ("position", "force")],
    )
    parameters = _table(
        ["parameter", "value", "low", "high", "unit"],
        [["mass", "1.23457", "0.9", "1.1", "kg"], ["area", "0.0001", "0", "inf", "m2"]],
    )
    correlations = _table(["", "mass", "area"], [["mass", "1.00", "-0.46"], ["area", "-0.46", "1.00"]])
    assert body.splitlines() == [
        "<h1>A&amp;B: fit to measured data</h1><p>The fit has converged. &lt;done&gt;</p>",
        told if is_rotating else "",
        "<p class=yellow><b>Yellow.</b> Look at this before the values are used. x &lt; y.</p>",
        "<h2>Parameters, with 95 % intervals</h2>", parameters,
        "<p class=warning>area is not determined: it is &lt;at&gt; a bound.</p>",
        "<h2>What remains</h2>", white, kinds,
        "overlay: measured and fitted signals",
        "<h2>Where it misses most</h2>worst_misfit: measured and fitted at the worst misfit",
        "against: what remains against velocity, position and lag",
        "<h2>Friction against velocity</h2>friction_map: friction against velocity",
        *_free_form(FORM),
        "<h2>Correlations of the errors</h2>", correlations,
        "<h2>What was done to the data</h2>",
        "<ul><li>5 &lt; 6</li><li>two</li></ul>",
    ]  # fmt: skip
    for name in names[:2]:
        monkeypatch.setattr(report, name, lambda of: None)
    found.converged, found.notes, found.undetermined = False, (), {}
    bare = report.page(found, residuals, verdict, None)
    assert "<p><b class=warning>The fit has not converged.</b> &lt;done&gt;</p>" in bare
    assert bare.endswith("<h2>What was done to the data</h2>\n<ul><li>Nothing.</li></ul>\n")
    for absent in ("Where it misses most", "Friction against velocity", "not determined", "free curve", "predicted by"):
        assert absent not in bare


def tried(distances: list[float | str | None], monkeypatch: pytest.MonkeyPatch, name: str = "motion") -> Any:
    """What excitations tell two laws apart that leave so much; None is an interrupt."""
    given = iter(distances)

    def distance(truth: str, rival: str, *of: Any) -> float | str:
        assert (truth, rival) == ("side of Dahl", "side of LuGre") and of[0] == "time" and of[2]["force"] == 2.0
        found = next(given)
        if found is None:
            raise KeyboardInterrupt
        return found

    courses = {f"course {k}": np.full(3, float(k)) for k in range(len(distances))}
    asked = ("motion", 1.0, 0.1, 0.2)
    monkeypatch.setattr(telling, "excitations", lambda *of: ("time", "driven", courses) if of == asked else None)
    monkeypatch.setattr(telling, "_side", lambda fit: f"side of {fit.law}")
    monkeypatch.setattr(telling, "_distance", distance)
    fits: list[Any] = [
        SimpleNamespace(law=law, problem=SimpleNamespace(experiment=SimpleNamespace(name=name)))
        for law in ("Dahl", "LuGre")
    ]
    return telling.telling(*fits, noise={"force": 2.0}, duration=1.0, step=0.1, stroke=0.2, progress=False)


def test_excitations_that_tell_most_come_first(monkeypatch: pytest.MonkeyPatch) -> None:
    found = tried([1.0, 7.0, "it diverges", 3.0], monkeypatch)
    assert [(one.name, one.distance, one.input) for one in found.trials] == [
        ("course 1", 7.0, "driven"), ("course 3", 3.0, "driven"), ("course 0", 1.0, "driven"),
    ]  # fmt: skip
    assert (found.first, found.second) == ("Dahl", "LuGre") and found.best is found.trials[0]
    assert found.best.course.tolist() == [1.0] * 3 and found.best.time == "time"
    with pytest.raises(ValueError, match=r"^no excitation could be simulated with these values; it diverges$"):
        tried(["it diverges", "it stops"], monkeypatch)
    with pytest.raises(ps.Interrupted) as caught:
        tried([1.0, 2.0, None], monkeypatch)
    assert [one.distance for one in caught.value.finished.trials] == [2.0, 1.0]
    with pytest.raises(ps.Interrupted) as caught:
        tried([None], monkeypatch)
    assert caught.value.finished is None
    text = "experiment='force': what tells laws apart can be planned for rig or motion"
    with pytest.raises(ValueError, match=f"^{text}$"):
        tried([1.0], monkeypatch, "force")

"""Plans against the closed form of a regression: a sine under Coulomb and viscous friction.

With ``n`` samples over whole periods of a speed of amplitude ``V`` and a noise ``s``

```text
sum |v| = 2/pi n V,  sum v^2 = n V^2/2
var(Fc) = s^2 (1/2)/(n q),  var(sigma2) = s^2/(n V^2 q),  q = 1/2 - 4/pi^2
```
"""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from pneumatic_servo.cli import main
from pneumatic_servo.identification.planning import NOISE, Candidate, Plan, excitations, imagined, sensed

ROOT = Path(__file__).parents[2]
LEVEL, VISCOUS = FREE = ["friction.coulomb.Fc", "friction.coulomb.sigma2"]
DEFAULTS = {name: float(ps.Model("FrictionBench").parameters[name].default) for name in FREE}
SPEED = 2.0 * np.pi * 0.5 * 0.05
"""Amplitude in m/s of 50 mm at 0.5 Hz."""
Q = 0.5 - 4.0 / np.pi**2


def of_sine(**options: object) -> Candidate:
    """A plan's sine of 50 mm at 0.5 Hz."""
    given = {"law": "Coulomb", "fit": FREE, "experiment": "motion", "step": 2e-3} | options
    found = ps.plan(**given)  # type: ignore[arg-type]
    return next(one for one in found.candidates if one.name == "a sine of 50 mm at 0.5 Hz")


def expected(samples: float = 5_000, noise: float = NOISE["frictionForce"], speed: float = SPEED) -> dict[str, float]:
    """Half intervals of 95 %; for the logarithm of Fc it goes up further than down."""
    level, viscous = noise * np.sqrt(0.5 / (samples * Q)), noise / speed / np.sqrt(samples * Q)
    return {LEVEL: DEFAULTS[LEVEL] * np.expm1(1.96 * level / DEFAULTS[LEVEL]), VISCOUS: 1.96 * viscous}


@pytest.mark.parametrize("name", FREE)
def test_intervals_to_expect_are_those_of_the_regression(name: str) -> None:
    """Fc is free by its logarithm, sigma2 by its value."""
    # Speeds are differences over 2 ms: the last of their errors, some millionths.
    assert_close(of_sine().half[name], expected()[name], rel=2e-5, what="half interval")


def test_information_is_the_logarithm_of_the_determinant() -> None:
    scale = DEFAULTS[LEVEL] * DEFAULTS[VISCOUS] * SPEED * 5_000 / NOISE["frictionForce"] ** 2
    assert_close(of_sine().information, np.log(scale**2 * Q), within=1e-4, what="information")


def test_noise_that_is_given_counts() -> None:
    plain, loud = of_sine(), of_sine(noise={"frictionForce": 100.0 * NOISE["frictionForce"]})
    assert_close(loud.half[VISCOUS], 100.0 * plain.half[VISCOUS], rel=1e-14, what="half interval of sigma2")
    assert_close(loud.half[LEVEL], expected(noise=5.0)[LEVEL], rel=2e-5, what="half interval of Fc")
    # Each of both parameters is told by 1/100.
    assert_close(loud.information, plain.information - 4.0 * np.log(100.0), within=2e-13, what="information")


def test_longer_and_denser_samples_tell_more() -> None:
    assert_close(of_sine(duration=20.0).half[VISCOUS], expected(10_000)[VISCOUS], rel=2e-5, what="longer")
    assert_close(of_sine(step=4e-3).half[VISCOUS], expected(2_500)[VISCOUS], rel=1e-4, what="less dense")


def test_stroke_is_the_largest_amplitude() -> None:
    found = ps.plan(law="Coulomb", fit=FREE, experiment="motion", stroke=0.2, duration=4.0, step=0.01)
    assert max(np.max(np.abs(one.course)) for one in found.candidates) == pytest.approx(0.2, rel=1e-3)


@pytest.mark.parametrize(
    ("experiment", "driven", "middle", "unit"),
    [("rig", "valveVoltage", 5.0, 1.0), ("motion", "prescribedPosition", 0.0, 1e-3)],
)
def test_courses_are_what_their_names_say(experiment: str, driven: str, middle: float, unit: float) -> None:
    """Amplitudes and frequencies as they are seen: by a fit of the sine, by envelopes, by zeros that are counted."""
    time, name, courses = excitations(experiment, 10.0, 1e-3, 0.05)
    assert name == driven and time[-1] == 10.0
    kinds, sines = [], set()
    for name, course in courses.items():
        swing = (course - middle) / unit
        moved = np.abs(swing) > 1e-9
        zeros = time[moved][1:][np.diff(np.sign(swing[moved])) != 0.0]
        sizes = [float(size) for size in re.findall(r"[0-9.e-]+(?= m?[mV]\b)", name)]
        hertz = [float(rate) for rate in re.findall(r"[0-9.]+(?= Hz| to 3 Hz)", name)]
        kinds.append(kind := "sweep" if "sweep" in name else "grows" if "grows" in name else "sine")
        if kind == "sine":
            waves = np.array([wave(2.0 * np.pi * hertz[0] * time) for wave in (np.sin, np.cos)]).T
            found, *_ = np.linalg.lstsq(waves, swing, rcond=None)
            sines.add((sizes[0], hertz[0]))
            assert np.hypot(*found) == pytest.approx(sizes[0], rel=1e-9), name
            assert np.max(np.abs(waves @ found - swing)) < 1e-9 * sizes[0], name
        elif kind == "sweep":
            # It comes through the middle twice in each period, and has as many of them as its mean frequency says.
            assert np.max(np.abs(swing)) == pytest.approx(sizes[0], rel=1e-4), name
            assert abs(len(zeros) - 2.0 * 10.0 * np.mean(hertz)) <= 1.0 and hertz == [0.2, 3.0], name
            assert sum(zeros <= 1.0) <= 2 and sum(zeros >= 9.0) >= 5, name
        else:
            assert abs(len(zeros) - 2.0 * 10.0 * hertz[0]) <= 1.0, name
            # The last crest of the slowest is a quarter of a period before the end, at 0.42 of the growth or more.
            period = 1.0 / hertz[0]
            assert 0.42 * sizes[-1] < np.max(np.abs(swing[time >= 10.0 - period])) <= sizes[-1], name
            # At first it is next to what it grows from, which is nothing where the name tells only its end.
            assert np.max(np.abs(swing[time <= 0.2])) <= (2.0 * sizes[0] if len(sizes) > 1 else 0.02 * sizes[0]), name
    named = (
        "a sine at 1 Hz that grows to 2 V" if experiment == "rig" else "a sine at 1 Hz that grows from 0.05 to 50 mm"
    )
    assert named in courses
    # Each amplitude with each frequency.
    each = [{pair[place] for pair in sines} for place in (0, 1)]
    assert each == ([{1.0, 2.0, 3.0}, {0.25, 0.5, 1.0, 2.0}] if experiment == "rig"
                    else [{0.05, 0.5, 5.0, 50.0}, {0.1, 0.5, 2.0}])  # fmt: skip
    assert len(sines) == len(each[0]) * len(each[1])
    assert {"sine", "grows"} <= set(kinds) and ("sweep" in kinds) == (experiment == "rig")


def test_record_of_a_rig_is_what_the_plant_does() -> None:
    """Imagined measurements are a run of the plant, bit for bit, or the reason why there is none."""
    time, driven, courses = excitations("rig", 2.0, 0.01, 0.05)
    course, kind = courses["a sine of 2 V at 1 Hz"], sensed("rig", "Coulomb", None)
    record = imagined(kind, time, course, DEFAULTS)
    assert not isinstance(record, str)
    names = ["position", "chamberA.pressure", "chamberB.pressure"]
    run = ps.Model().simulate(
        {"friction.law": "Coulomb", **DEFAULTS}, inputs={driven: (time, course)}, stop=2.0, step=0.01, outputs=names
    )
    assert np.array_equal(record.time, time) and np.array_equal(record.signals[driven], course)
    for name in names:
        assert np.array_equal(record.signals[name], run[name]), name
    refused = imagined(kind, time, np.full_like(course, np.nan), DEFAULTS)
    assert isinstance(refused, str) and driven in refused


def test_rig_does_not_tell_more_than_its_samples() -> None:
    """With a known beginning the covariance is the inverse of the information of all samples; from a measured one more
    is to be found, which widens it, and not beyond measure."""
    found = ps.plan(law="Coulomb", fit=FREE, duration=2.0, step=0.01)
    assert repr(found).splitlines()[0] == "excitations, the most informative first:"
    names = ["position", "chamberA.pressure", "chamberB.pressure"]
    for one in found.candidates[:3]:

        def seen(values: dict[str, float], one: Candidate = one) -> np.ndarray:
            inputs = {one.input: (one.time, one.course)}
            given = {"friction.law": "Coulomb", **values}
            run = ps.Model().simulate(given, inputs=inputs, stop=2.0, step=0.01, outputs=names)
            return np.concatenate([run[name] / NOISE[name] for name in names])

        slopes = []
        for name in FREE:
            step = 1e-4 * DEFAULTS[name]
            up, down = (seen(DEFAULTS | {name: DEFAULTS[name] + sign * step}) for sign in (1.0, -1.0))
            slopes.append((up - down) / (2.0 * step))
        least = 1.96 * np.sqrt(np.diag(np.linalg.inv(np.array(slopes) @ np.array(slopes).T)))
        for name, half in zip(FREE, least, strict=True):
            # Found: 1.2 to 2.0 times.
            assert 1.0 < one.half[name] / half < 3.0, (one.name, name)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"experiment": "motoin"}, "experiment='motoin': a plan can be made for rig or motion"),
        ({"experiment": "motion", "stroke": -0.5}, "stroke=-0.5 m: it must be positive"),
        ({"experiment": "motion", "stroke": np.inf}, "stroke = inf m is refused: it must be a finite number in m"),
        ({"step": 0.0}, "duration 10.0 s and step 0.0 s: there must be at least 100 samples"),
        ({"duration": 0.99, "step": 0.01}, "duration 0.99 s and step 0.01 s: there must be at least 100 samples"),
        ({"duration": "1 m"}, "duration: the unit m is refused"),
        ({"step": "soon"}, "step = 'soon' is refused: it must be a finite number of seconds"),
        ({"noise": {"chamberA.pressure": 2e5}}, "at most 100000 Pa, .* did you mean 200000.0 bar?"),
    ],
)
def test_what_cannot_be_planned_is_named(given: dict[str, object], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ps.plan(law="Coulomb", **given)  # type: ignore[arg-type]


def test_what_is_known_is_not_planned_for() -> None:
    found = ps.plan(law="Coulomb", experiment="motion", settings={LEVEL: 5.0}, duration=4.0, step=0.01)
    assert list(found.values) == [VISCOUS]


def test_nothing_is_learned_of_what_makes_up_for_one_another() -> None:
    """Twice the gain of the force is as good as half of all friction."""
    found = ps.plan(law="Coulomb", fit=[*FREE, "gain.frictionForce"], experiment="motion", duration=4.0, step=0.01)
    assert found.determined == dict.fromkeys([*FREE, "gain.frictionForce"], False)
    assert set(found.best.half.values()) == {np.inf}


def test_progress_counts_the_candidates() -> None:
    told: list[tuple[int, int]] = []

    def tell(done: int, total: int) -> None:
        told.append((done, total))

    found = ps.plan(law="Coulomb", experiment="motion", duration=4.0, step=0.01, progress=tell)
    count = len(found.candidates)
    assert told == [(done, count) for done in range(1, count + 1)]


def test_interrupt_leaves_a_plan_of_what_is_judged() -> None:
    def stop(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    given = {"law": "Coulomb", "fit": FREE, "experiment": "motion", "duration": 4.0, "step": 0.01}
    with pytest.raises(ps.Interrupted, match=r"^interrupted$") as caught:
        ps.plan(**given, progress=stop)  # type: ignore[arg-type]
    found, whole = caught.value.finished, ps.plan(**given, progress=False)  # type: ignore[arg-type]
    assert isinstance(found, Plan) and (found.values, found.units) == (whole.values, whole.units)
    # The first two, the more telling one before the other.
    names = {one.name: one.information for one in whole.candidates}
    assert {one.name: one.information for one in found.candidates}.items() <= names.items()
    assert len(found.candidates) == 2 and found.candidates[0].information > found.candidates[1].information


def test_verdict_is_half_of_the_value() -> None:
    half = {"told": 0.49, "untold": 0.51, "offset": 3.0, "blind": np.inf}
    values = {"told": -1.0, "untold": 1.0, "offset": 0.0, "blind": 0.0}
    best = Candidate("a sine", "valveVoltage", np.zeros(2), np.zeros(2), half, 1.0)
    verdict = Plan((best,), values, dict.fromkeys(half, "N"))
    assert verdict.determined == {"told": True, "untold": False, "offset": True, "blind": False}
    assert repr(verdict).splitlines() == [
        "excitations, the most informative first:",
        "         1.0  a sine",
        "with a sine, half of the 95 % interval will be about:",
        "  told = -1 +- 0.49 N",
        "  untold = 1 +- 0.51 N   not identifiable",
        "  offset = 0 +- 3 N",
        "  blind = 0 +- inf N   not identifiable",
    ]


def test_command_takes_noise_in_units(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    given = ["plan", "--experiment", "motion", "--law", "Coulomb", "--fit", ",".join(FREE), "--duration", "4",
             "--step", "0.01"]  # fmt: skip
    printed = []
    for noise in ([], ["--noise", "frictionForce=0.05[kN]"]):
        assert main([*given, *noise]) == 0
        printed.append(capsys.readouterr().out)
    assert "not identifiable" not in printed[0] and "not identifiable" in printed[1]
    # The best candidate without noise is the best with more of it.
    assert printed[0].splitlines()[1].split("  ")[-1] == printed[1].splitlines()[1].split("  ")[-1]


def test_page_says_how_plans_were_kept() -> None:
    """The page has the numbers of its table, and every spread is within 25 % of the prediction, as it says."""
    with (ROOT / "docs" / "identification" / "plans.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    page = (ROOT / "docs" / "identification" / "validation.md").read_text(encoding="utf-8")
    achieved = ("of the fits (%)", "of the values (%)")
    for row in rows:
        assert (
            f"| `{row['parameter']}` | {row['predicted (%)']} | {' | '.join(row[name] for name in achieved)} |" in page
        )
    intervals, values = ([float(row[name]) / float(row["predicted (%)"]) for row in rows] for name in achieved)
    assert f"All {len(rows)} spreads are within 25 %" in page and all(0.75 < ratio < 1.25 for ratio in values)
    beyond = {row["parameter"]: ratio for row, ratio in zip(rows, intervals, strict=True) if abs(ratio - 1.0) > 0.25}
    assert {name: f"{ratio - 1.0:.0%}" for name, ratio in beyond.items()} == {"friction.stribeck.Fs": "32%"}

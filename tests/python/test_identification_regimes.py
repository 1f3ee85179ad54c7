"""Verdicts on kinds of motion, bounds and ranges."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification.figures import against, friction_map, overlay, worst_misfit
from pneumatic_servo.identification.regimes import is_white, regimes
from pneumatic_servo.identification.residuals import Residuals
from test_identification import bench
from test_identification_verdict import fit

Array = NDArray[np.float64]


def test_noise_is_white_and_what_hangs_together_is_not() -> None:
    random = np.random.default_rng(0)
    doubted = [not is_white([random.standard_normal(200) for _ in range(5)]) for _ in range(200)]
    assert sum(doubted) <= 2
    for _ in range(20):
        steps = random.standard_normal(1000)
        tied = np.zeros(1000)
        for k in range(1, 1000):
            tied[k] = 0.5 * tied[k - 1] + steps[k]
        assert not is_white([tied[:500], tied[500:]])
    # An offset hangs together, too; a course of zeros has nothing that could.
    assert not is_white([0.5 + 0.5 * random.standard_normal(300)])
    assert is_white([np.zeros(300)])


def test_pairs_over_gaps_do_not_count() -> None:
    """Every other sample is NaN, or each course has a single one: no pair of neighbours is left."""
    tied = np.repeat(np.random.default_rng(0).standard_normal(500), 2)
    assert not is_white([tied])
    assert is_white([np.where(np.arange(1000) % 2 == 0, tied, np.nan)])
    assert is_white([tied[k : k + 1] for k in range(100)])


def test_what_is_missed_at_reversals_does_not_drown() -> None:
    """A force of eight times the noise for 0.05 s after each reversal, unseen in the rms of the record."""
    data = bench()
    speed = np.append(0.0, np.diff(data["position"]))
    turns = np.flatnonzero(np.sign(speed[1:]) != np.sign(speed[:-1])) + 1
    for turn in turns:
        data["frictionForce"][turn : turn + 5] += 0.4 * np.sign(speed[min(turn + 2, 999)])
    found = fit(data)
    assert found.rms["frictionForce"] < 3.0 * 0.05
    own = {one.name: one for one in regimes(Residuals(found), "frictionForce")}
    assert not own["at reversals"].is_white
    assert own["in fast motion"].rms < 1.5 * 0.05 < 3.0 * 0.05 < own["at reversals"].rms
    assert found.verdict.light == "yellow"
    assert any("but more at reversals (" in finding.text for finding in found.verdict.findings)


def test_regimes_share_the_samples() -> None:
    found = fit(bench())
    own = regimes(Residuals(found), "frictionForce")
    used = sum(int(np.sum(window.used)) for window in found.problem.windows)
    assert sum(one.samples for one in own) == used
    assert {"at reversals", "in slow motion", "in fast motion"} <= {one.name for one in own}
    assert all(one.is_white for one in own if one.name != "at reversals")


def test_parameter_at_its_bound_is_named() -> None:
    free = [f"friction.stribeck.{name}" for name in ("Fs", "Fc", "vs")]
    found = fit(bench(), fit=[*free, "friction.stribeck.sigma2=8:0:10"])
    assert found.verdict.light == "yellow"
    [finding] = [one for one in found.verdict.findings if "has run to its bound" in one.text]
    assert "friction.stribeck.sigma2 has run to its bound, 10 N.s/m" in finding.text
    assert not any("not identifiable" in one.text for one in found.verdict.findings)


def test_data_held_out_beyond_the_fitted_are_told() -> None:
    slow, fast = bench(), bench(1)
    fast["position"] = 3.0 * fast["position"]
    speed = np.append(0.0, np.diff(fast["position"]) / 0.01)
    fast["frictionForce"] = np.sign(speed) * (7.0 + 4.0 * np.exp(-((speed / 0.012) ** 2))) + 25.0 * speed
    found = fit(slow, validation=0.0, validation_data=[fast])
    assert any("extrapolation: velocity reaches" in one.text for one in found.verdict.findings)
    inside = fit(slow, validation=0.0, validation_data=[bench(1)])
    assert not any("extrapolation" in one.text for one in inside.verdict.findings)


def test_what_is_asked_beyond_the_range_is_said() -> None:
    found = fit(bench(), validation=0.0)
    low, high = found.ranges.limits["velocity"]
    assert low == -high and 0.04 < high < 0.07
    assert found.beyond({"velocity": 0.9 * high}) == () == found.beyond({"velocity": np.linspace(-high, high, 50)})
    [text] = found.beyond({"velocity": -2.0 * high})
    assert text.startswith("velocity reaches") and f"up to {high:.4g} m/s was fitted" in text
    with pytest.raises(ValueError, match=r"asked speed.*velocity"):
        found.beyond({"speed": 1.0})
    assert found.as_dict()["ranges"]["velocity"] == [low, high]


def test_pressure_below_the_fitted_falls() -> None:
    data = {**bench(), "pressure": 1e5 * np.linspace(3.0, 5.0, 1000)}
    data["force"] = data.pop("frictionForce") + 4.9e-4 * data["pressure"]
    found = ps.fit(data, experiment="motion", law="Stribeck", fit="friction.stribeck.Fc,area", play=0.0, starts=0,
                   settings={"friction.stribeck.Fs": 11.0, "friction.stribeck.vs": 0.012}, progress=False)  # fmt: skip
    assert found.beyond({"pressure": 4e5}) == ()
    [text] = found.beyond({"pressure": 1e5})
    # The first sample, at 3 bar, does not move.
    assert text == "pressure falls to 1e+05 Pa, of which down to 3.002e+05 Pa was fitted"


def test_windows_of_a_signal_follow_each_other_in_time() -> None:
    """Four windows of a record of 10 s that begins at 100 s, each with a time of its own."""
    data = bench()
    data["time"] = data["time"] + 100.0
    found = fit(data, validation=0.0, segment=2.5)
    courses = list(Residuals(found).courses("frictionForce"))
    assert len(courses) == 4
    time = np.concatenate([course.time for course in courses])
    assert_close(np.diff(time), 0.01, within=2e-14, what="from sample to sample")


def test_figure_of_a_fit_shows_measured_fitted_and_the_rest() -> None:
    data = bench()
    residuals = Residuals(fit(data, validation=0.0))
    figure = overlay(residuals)
    upper, lower = figure.axes
    assert (upper.get_ylabel(), lower.get_ylabel()) == ("frictionForce (N)", "rest (N)")
    assert lower.get_xlabel() == "time (s), records one after the other"
    measured, fitted, *named = upper.get_lines()
    [rest] = lower.get_lines()
    assert set(np.asarray(measured.get_ydata())) <= set(data["frictionForce"]) and len(measured.get_xydata()) == 1000
    left = np.asarray(measured.get_ydata()) - np.asarray(fitted.get_ydata())
    is_compared = np.isfinite(left)
    assert is_compared.sum() > 900 and np.array_equal(is_compared, np.isfinite(np.asarray(rest.get_ydata())))
    assert_close(left[is_compared], np.asarray(rest.get_ydata())[is_compared], within=2e-15, what="rest")
    # The legend has the colours of the curves, which differ.
    colours = {line.get_label(): line.get_color() for line in named}
    assert colours == {"measured": measured.get_color(), "fitted": fitted.get_color()}
    assert measured.get_color() != fitted.get_color()


def test_rest_is_drawn_against_velocity_position_and_lag() -> None:
    residuals = Residuals(fit(bench(), validation=0.0))
    of_velocity, of_position, of_lag = against(residuals).axes
    labels = [axis.get_xlabel() for axis in (of_velocity, of_position, of_lag)]
    assert labels == ["velocity (mm/s)", "position (mm)", "lag (samples)"]
    assert (of_velocity.get_ylabel(), of_lag.get_ylabel()) == ("rest of frictionForce (N)", "autocorrelation")
    [white] = of_lag.get_lines()
    # The residuals are white: 1 at no lag, and within the band elsewhere but for one in twenty.
    lags, correlation = np.asarray(white.get_xdata()), np.asarray(white.get_ydata())
    assert lags[0] == 0 and correlation[0] == 1.0
    limit = residuals.limit("frictionForce")
    assert np.mean(np.abs(correlation[1:]) > limit) < 0.1
    [band] = of_lag.patches
    assert (band.get_y(), band.get_y() + band.get_height()) == (-limit, limit)
    # Of a path of 24 mm and speeds of up to 65 mm/s.
    [dots] = of_position.get_lines()
    assert 20.0 < np.max(np.abs(np.asarray(dots.get_xdata()))) < 25.0
    [dots] = of_velocity.get_lines()
    assert 50.0 < np.max(np.abs(np.asarray(dots.get_xdata()))) < 70.0


def test_map_of_the_friction_shows_what_was_measured() -> None:
    """Against velocity, at a load level of 1: each point is a sample, and the law goes through their middle."""
    data = bench()
    figure = friction_map(fit(data, validation=0.0))
    assert figure is not None
    points, curve = (np.asarray(line.get_xydata()) for line in figure.axes[0].get_lines())
    assert len(points) > 900 and set(points[:, 1]) <= set(data["frictionForce"])
    fast = np.abs(points[:, 0]) > 0.5 * np.max(np.abs(points[:, 0]))
    left = points[fast, 1] - np.interp(points[fast, 0], curve[:, 0], curve[:, 1])
    # Noise of 0.05 N.
    assert abs(np.mean(left)) < 0.02 and 0.04 < np.std(left) < 0.06


def test_worst_misfit_is_found_and_drawn(tmp_path: Path) -> None:
    """A force that is 1 N too large from 4.2 to 4.4 s, in a record that begins at 100 s."""
    data = bench()
    data["frictionForce"][420:440] += 1.0
    data["time"] = data["time"] + 100.0
    found = fit(data, validation=0.0)
    worst = Residuals(found).worst()
    assert worst is not None and worst.signal == "frictionForce"
    assert 420 <= worst.sample < 440 and worst.size > 9.0
    assert re.search(r"The residual of frictionForce is largest at 104\.[2-4]\d? s of ", found.verdict.text)
    figure = worst_misfit(Residuals(found))
    assert figure is not None
    measured, fitted = (np.asarray(line.get_ydata()) for line in figure.axes[0].get_lines()[:2])
    assert 0.5 < np.max(measured - fitted) < 1.3
    found.to_report(tmp_path / "a.html")
    assert "Largest residual" in (tmp_path / "a.html").read_text(encoding="utf-8")
    figure.savefig(tmp_path / "a.png")


def test_noise_has_no_place() -> None:
    assert "is largest at" not in fit(bench(), validation=0.0).verdict.text

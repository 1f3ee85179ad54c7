"""Evidence for one of several laws: against a closed form, and where the data do not distinguish them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from pneumatic_servo.cli import main
from scipy.stats import multivariate_normal
from test_identification import COLUMNS, bench, write
from test_identification_posterior import line

GIVEN: dict[str, Any] = {"experiment": "motion", "play": 0.0, "starts": 0, "progress": False}


def test_elpd_of_a_line_is_that_of_its_regression() -> None:
    data, design = line()
    ranking = ps.compare_fits(data, ["Coulomb"], **GIVEN)
    [found] = ranking.evidence(number=2000).laws
    problem = ranking.best.problem
    used, noise = problem.windows[0].used, problem.sensors["frictionForce"].noise
    rows, force = design[used], data["frictionForce"][used]
    elpd = 0.0
    # Twenty stretches of equal length, but for the last.
    for block in np.split(np.arange(len(force)), np.arange(-(-len(force) // 20), len(force), -(-len(force) // 20))):
        seen = np.setdiff1d(np.arange(len(force)), block)
        spread = noise**2 * np.linalg.inv(rows[seen].T @ rows[seen])
        mean = rows[block] @ np.linalg.lstsq(rows[seen], force[seen])[0]
        covariance = noise**2 * np.eye(len(block)) + rows[block] @ spread @ rows[block].T
        elpd += multivariate_normal(mean, covariance).logpdf(force[block])
    # 2000 draws tell the density of each stretch to some thousandths.
    assert_close(found.elpd, elpd, within=0.01, what="elpd")
    assert np.all(found.shapes < 0.7)


def test_law_that_made_the_data_is_told_from_others(tmp_path: Path) -> None:
    found = ps.compare_fits(bench(), ["Coulomb", "Stribeck"], **GIVEN).evidence()
    assert [one.law for one in found.laws] == ["Stribeck", "Coulomb"] and found.not_distinguished == ()
    assert "the data speak for Stribeck" in repr(found)
    first, second = found.laws
    assert first.difference == first.error == 0.0 and second.difference > 10.0 * second.error > 0.0
    found.to_csv(tmp_path / "evidence.csv")
    lines = (tmp_path / "evidence.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("law,elpd,difference") and lines[1].startswith("Stribeck,")


def test_laws_that_fit_alike_are_not_told() -> None:
    """In fast motion two laws of the same steady friction differ by nothing that the noise does not hide."""
    found = ps.compare_fits(
        line()[0], ["Coulomb", "Stribeck"], **GIVEN,
        settings_of={"Stribeck": {"friction.stribeck.vs": 1e-4}},
        fit_of={"Stribeck": "friction.stribeck.Fs,friction.stribeck.Fc,friction.stribeck.sigma2"},
    ).evidence()  # fmt: skip
    assert len(found.not_distinguished) == 1
    assert f"the data do not distinguish {found.laws[0].law} from {found.laws[1].law}" in repr(found)


def test_draws_are_as_many_as_are_asked_for_and_those_of_the_seed() -> None:
    ranking = ps.compare_fits(line()[0], ["Coulomb"], **GIVEN)
    first, again, other, more = (
        ranking.evidence(number, seed).laws[0].elpd for number, seed in ((200, 1), (200, 1), (200, 2), (400, 1))
    )
    assert first == again and first != other and first != more
    with pytest.raises(ValueError, match="number = 10 is refused: it must be at least 100"):
        ranking.evidence(10)


def test_experiment_that_tells_laws_apart_is_found(tmp_path: Path) -> None:
    ranking = ps.compare_fits(bench(), ["Coulomb", "Stribeck"], **GIVEN)
    options: dict[str, Any] = {"duration": 5.0, "step": 0.005, "progress": False}
    found = ranking.telling("Stribeck", "Coulomb", **options)
    assert found.best.distance > 100.0
    # Coulomb is Stribeck without a peak, so that Stribeck can follow it.
    turned = ranking.telling("Coulomb", "Stribeck", **options)
    assert max(trial.distance for trial in turned.trials) < 0.1 * found.best.distance
    # Ten times the noise leaves a tenth, where what is fitted does not change with it.
    loud = ranking.telling("Stribeck", "Coulomb", **options, noise={"frictionForce": 0.5})
    assert_close(loud.best.distance, 0.1 * found.best.distance, rel=1e-9, what="distance")
    found.to_csv(tmp_path / "tell.csv")
    assert (tmp_path / "tell.csv").read_text(encoding="utf-8").startswith("time,prescribedPosition\n")
    with pytest.raises(KeyError, match="Dahl was not fitted"):
        ranking.telling("Stribeck", "Dahl")
    with pytest.raises(ValueError, match="there must be at least 100 samples"):
        ranking.telling("Stribeck", "Coulomb", duration=0.01)


def test_command_says_what_the_data_tell(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write(tmp_path / "bench.csv", bench())
    given = ["fit", str(file), "--experiment", "motion", "--columns", COLUMNS, "--play", "0", "--starts", "0"]
    assert main([*given, "--law", "Stribeck,Coulomb", "--evidence"]) == 0
    assert "the data speak for Stribeck" in capsys.readouterr().out
    assert main([*given, "--law", "Stribeck", "--evidence"]) == 2
    assert "--evidence compares laws" in capsys.readouterr().err


def test_package_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    ranking = ps.compare_fits(line()[0], ["Coulomb"], **GIVEN)
    monkeypatch.setitem(sys.modules, "arviz", None)
    with pytest.raises(ps.MissingPackage, match=r"needs ArviZ: pip install 'pneumatic-servo\[posterior\]'"):
        ranking.evidence()

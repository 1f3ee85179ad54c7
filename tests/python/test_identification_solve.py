"""The search of a fit: no more starts and steps than are needed."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.cli import main
from pneumatic_servo.identification.compression import ROWS, triangle
from pneumatic_servo.identification.fitting import _check_size
from pneumatic_servo.identification.solve import Reached, search
from pneumatic_servo.identification.watch import Watch
from test_identification import COLUMNS, RIG, bench, write

Array = NDArray[np.float64]

GIVEN = {"experiment": "motion", "play": 0.0}


@pytest.mark.parametrize("rows", [7, ROWS - 1, ROWS, 3 * ROWS + 17])
def test_triangle_has_the_products_of_the_columns(rows: int) -> None:
    matrix = np.random.default_rng(rows).standard_normal((rows, 5))
    found = triangle(matrix)
    assert found.shape == (5, 5) and np.array_equal(found, np.triu(found))
    assert_close(found.T @ found, matrix.T @ matrix, within=1e-14 * rows, what="products")


def test_start_that_leaves_only_noise_needs_no_others() -> None:
    told: list[str] = []
    found = ps.fit(bench(), **GIVEN, law="Stribeck", starts=1000, progress=told.append)
    assert found.converged and not [word for word in told if word.startswith("start")]


def test_search_ends_where_two_starts_meet() -> None:
    """A law that leaves more than noise, with a single minimum: no third start is refined."""
    told: list[str] = []
    ps.fit(bench(), **GIVEN, law="Coulomb", starts=32, progress=told.append)
    first = told.index("start 32 of 32")
    costs = [float(word.split()[1]) for word in told if word.startswith("cost")]
    # Of two searches each begins higher than the one before ended; the last fits go on from their end.
    searches = 1 + sum(later > 1.5 * earlier for earlier, later in pairwise(costs))
    assert first > 0 and searches == 2


def hurried(*given: Any) -> Reached:
    """A last search that gives up at its first vector."""
    reached = search(*given)
    assert reached is not None and reached.best is not None
    return reached._replace(best=replace(reached.best, converged=False, message="80 parameter vectors were evaluated"))


def test_fit_that_does_not_come_to_an_end_fails_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("pneumatic_servo.identification.fitting.search", hurried)
    file, result = write(tmp_path / "bench.csv", bench()), tmp_path / "a.json"
    given = ["--experiment", "motion", "--law", "Stribeck", "--columns", COLUMNS, "--starts", "0"]
    assert main(["fit", str(file), *given, "--json", str(result)]) == 1
    assert "error: the fit has not converged" in capsys.readouterr().err
    assert json.loads(result.read_text(encoding="utf-8"))["converged"] is False


def unknown_rig() -> dict[str, Array]:
    """The usual first measurement: voltage and position, of a machine whose supply and pressures nobody wrote down."""
    table = np.genfromtxt(RIG, delimiter=",", names=True)
    return {"time": table["t"], "valveVoltage": table["u"], "position": 1e-3 * table["x_mm"]}


def test_fit_of_a_model_that_does_not_describe_the_data_comes_to_an_end() -> None:
    """Along its valley bristles become all damping, where a run takes a thousand times the steps of the first."""
    told: list[str] = []
    with pytest.warns(ps.PlantWarning) as caught:
        found = ps.fit(unknown_rig(), experiment="rig", law="LuGre", starts=1, progress=told.append)
    warned = [str(one.message) for one in caught]
    assert (
        "supplyPressure = 500000 Pa is assumed, since it was neither measured nor given; give it by settings, for "
        "example supplyPressure = 6 bar"
    ) in warned
    # The early word stands before the first vector that is looked at.
    early = next(
        index
        for index, text in enumerate(told)
        if text.startswith("not identifiable at the start values: ") and "friction.lugre.vd" in text
    )
    looked = [index for index, text in enumerate(told) if text.startswith("cost")]
    assert early < looked[0]
    assert any("not identifiable at the start" in note and "friction.lugre.vd" in note for note in found.notes)
    names = told[early].partition(": ")[2].partition(";")[0].split(", ")
    assert set(names) <= set(found.values) and told[early] == (
        f"not identifiable at the start values: {', '.join(names)}; what is found may be anything; where a value is "
        "known, give it by settings"
    )
    assert "friction.lugre.vd" in found.not_identifiable
    # Each search but the last one goes on only as long as eight vectors gain a fiftieth; their priors may hide some.
    searches: list[list[float]] = [[]]
    for text in told[: told.index("last refinement")]:
        if text.startswith("cost"):
            searches[-1].append(float(text.split()[1]))
        else:
            searches.append([])
    assert sum(len(costs) > 9 for costs in searches) > 1
    for costs in searches:
        best = np.minimum.accumulate(costs) if costs else np.zeros(0)
        assert np.all(best[8:-1] < 0.99 * best[:-9]), costs
    most = found.problem.trained().bounded().most
    assert most is not None and most < 20 * 4000


def test_run_of_too_many_steps_is_given_up() -> None:
    settings = {"friction.law": "LuGre", "friction.lugre.sigma1": 3e6, "friction.lugre.sigma0": 2e5}
    given = {"common": {}, "inputs": {"valveVoltage": 6.0}, "stop": 0.5, "step": 1e-3, "outputs": ["position"]}
    runs = ps.Model()._run_many([{}, settings], **given, most=20_000)
    assert list(runs.failures) == [1]
    assert "was given up after" in runs.failures[1] and "solver steps of 20000" in runs.failures[1]
    assert np.all(np.isfinite(runs["position"][0])) and np.isnan(runs["position"][1, -1])
    assert not ps.Model()._run_many([settings], **given).failures


def test_early_word_names_only_what_noise_alone_would_hide() -> None:
    told: list[str] = []
    found = ps.fit(bench(), **GIVEN, law="Stribeck", starts=0, progress=told.append)
    assert not [text for text in told if "not identifiable" in text] and not found.not_identifiable


@pytest.mark.parametrize(("signals", "free", "is_enough"), [(1, 4, True), (1, 5, False), (3, 12, True), (3, 13, False)])
def test_each_parameter_needs_five_numbers_of_all_signals(signals: int, free: int, is_enough: bool) -> None:
    """Two windows of 10 samples are 20 numbers of each signal that is compared."""
    window = SimpleNamespace(fitted=10, record=None)
    resting = {"is_steady": False, "resting": lambda record: np.array([False])}
    experiment = SimpleNamespace(compared=("p", "q", "r")[:signals], **resting)
    problem: Any = SimpleNamespace(windows=[window] * 2, experiment=experiment, free=[None] * free, measured=dict)
    if is_enough:
        _check_size(problem)
    else:
        text = f"^too short: {20 * signals} samples to compare for {free} free parameters$"
        with pytest.raises(ValueError, match=text):
            _check_size(problem)


def test_all_that_the_data_do_not_tell_is_named() -> None:
    said: list[str] = []
    watch = Watch("fit")
    watch.told_by(lambda text: None, said.append)
    assert watch.still_hidden() == []
    watch.hidden(["area", "spring"])
    text = (
        "not identifiable at the start values: area, spring; what is found may be anything; where a value is known, "
        "give it by settings"
    )
    assert said == watch.still_hidden() == [text]
    assert watch.still_hidden({}) == []
    assert "spring" not in watch.still_hidden(["area"])[0]

"""Input as typed in notebooks and scripts: inputs, attributes, runs and tables mean what they look like."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pneumatic_servo as ps
import pytest

T, U = [0.0, 0.1, 0.2], [5.0, 8.0, 6.0]
SHORT: dict[str, Any] = {"stop": 0.2, "step": 1e-3, "outputs": ["valveVoltage", "position", "velocity"]}


def run(voltage: object, **options: Any) -> ps.Run:
    return ps.Model().simulate({"supplyPressure": 6e5}, inputs={"valveVoltage": voltage}, **{**SHORT, **options})


def many(voltage: object) -> ps.Runs:
    return ps.Model().simulate_many(number=2, inputs={"valveVoltage": voltage}, progress=False, **SHORT)


def given(run: ps.Run) -> np.ndarray:
    """The input of each step."""
    return run["valveVoltage"][1:]


def test_points_are_held_or_joined_by_name() -> None:
    held, lines = given(run({"hold": (T, U)})), given(run({"lines": (T, U)}))
    assert held.tolist() == [5.0] * 100 + [8.0] * 100
    assert np.array_equal(lines, given(run((T, U))))
    assert lines[50] == pytest.approx(6.5)
    # Times with rounding errors of their own: each value counts from the step of its number on.
    t = np.cumsum(np.full(200, 1e-3)) - 1e-3
    u = 5 + np.arange(200) / 100
    assert np.array_equal(given(run({"hold": (t, u)})), u)


@pytest.mark.parametrize("wrong", [{"held": (T, U)}, {"hold": 6.0}, {"hold": (T, U), "lines": (T, U)}, {}])
def test_other_forms_of_points_are_refused(wrong: object) -> None:
    with pytest.raises(ValueError, match=r"valveVoltage: an input .* is refused"):
        run(wrong)


@pytest.mark.parametrize("index", [
    pandas.to_timedelta(T, unit="s"),
    pandas.Timestamp("2026-03-01 12:00") + pandas.to_timedelta(T, unit="s"),
    pandas.Timestamp("2026-03-01 12:00", tz="Europe/Berlin") + pandas.to_timedelta(T, unit="s"),
])  # fmt: skip
def test_series_over_clock_times_is_one_over_seconds(index: Any) -> None:
    expected = run((T, U))["position"]
    assert np.array_equal(run(pandas.Series(U, index=index))["position"], expected)
    assert np.array_equal(run({"hold": pandas.Series(U, index=index)})["position"], run({"hold": (T, U)})["position"])


@pytest.mark.parametrize(("wrong", "told"), [
    (lambda: run((T, np.ma.masked_array(U, [False, True, False]))), "valveVoltage: value 1 is masked"),
    (lambda: run((T, np.array([True, False, True]))), "the values are true and false; they must be numbers in V"),
    (lambda: run((T, np.array(U) + 1j)), "the values are complex"),
    (lambda: many(np.array([True, False])), "the values are true and false"),
    (lambda: many((6, 7)), r"valveVoltage = \(6, 7\) is refused: points are arrays .* several runs is a list"),
    (lambda: run((0, 7)), "points are arrays of times and values"),
])  # fmt: skip
def test_arrays_that_are_no_numbers_are_refused(wrong: Callable[[], object], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        wrong()


def test_table_of_a_run_is_what_pandas_keeps_of_it(tmp_path: Path) -> None:
    first = run((T, U))
    frame = first.to_pandas()
    assert frame["valveVoltage"].iloc[100] == 8.0
    frame.to_csv(tmp_path / "by_pandas.csv")
    edited = frame.copy()
    edited["valveVoltage"] = edited["valveVoltage"] + 0.0
    for table in (frame, edited.reset_index(), tmp_path / "by_pandas.csv"):
        again = ps.Model().simulate({"supplyPressure": 6e5}, inputs=table, **SHORT)  # type: ignore[arg-type]
        assert np.array_equal(again["position"], first["position"])


def test_attributes_that_would_do_nothing_are_refused() -> None:
    plant = ps.Model()
    simulation = plant.start()
    with pytest.raises(AttributeError, match=r"no attribute valveVoltage; write simulation\['valveVoltage'\]"):
        simulation.valveVoltage = 7  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match=r"write simulation\['position'\]"):
        _ = simulation.position
    with pytest.raises(AttributeError, match="supplyPressure is set for a run"):
        plant.supplyPressure = 6e5  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match="no attribute anything"):
        plant.anything = 1  # type: ignore[attr-defined]

    class Own(ps.Model):
        pass

    own = Own()
    own.label = "mine"  # type: ignore[attr-defined]


def test_enumeration_reads_as_a_name() -> None:
    simulation = ps.Model().start({"friction.law": "LuGre"})
    assert simulation["friction.law"] == "LuGre"
    assert ps.Model().start({"friction.law": simulation["friction.law"]})["friction.law"] == "LuGre"


def test_run_is_a_mapping_of_its_variables() -> None:
    done = run(6.0)
    assert "position" in done and "pressure" not in done
    assert list(done) == ["valveVoltage", "position", "velocity"]
    assert np.array_equal(dict(done)["position"], done["position"])
    part = done[["position", "velocity"]]
    assert list(part) == ["position", "velocity"] and np.array_equal(part["velocity"], done["velocity"])
    with pytest.raises(KeyError, match="did you mean position"):
        done[["positon"]]
    labels = [[axis.get_ylabel() for axis in done.plot(*names).axes] for names in (["position"], [["position"]])]
    assert labels[0] == labels[1] and len(labels[0]) == 1


def test_figure_can_be_shown() -> None:
    import matplotlib.pyplot as plt

    before = plt.get_fignums()
    figure = run(6.0).plot()
    figure.show()
    [number] = set(plt.get_fignums()) - set(before)
    assert plt.figure(number) is figure
    plt.close(figure)


def test_pyplot_shows_figures_where_it_has_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """As ``plt.show()`` does, which knows the figures of pyplot; without windows nobody would close them."""
    import matplotlib as mpl
    import matplotlib.pyplot as plt

    plt.close("all")
    run(6.0).plot()
    assert plt.get_fignums() == []
    monkeypatch.setattr(mpl, "get_backend", lambda: "TkAgg")
    figure = run(6.0).plot()
    assert [plt.figure(number) for number in plt.get_fignums()] == [figure]
    plt.close("all")


def test_part_of_a_study_keeps_its_numbers() -> None:
    runs = many([6.0, 7.0])
    part = runs.of([1])
    assert part.to_pandas().index.get_level_values("run").unique().tolist() == [1]
    assert part.of([0]).numbers == [1]


def test_thinned_rows_keep_the_end() -> None:
    every, thin = run(6.0), run(6.0, every=7)
    assert thin.time.tolist() == [*every.time[:-1:7].tolist(), every.time[-1]]
    assert np.array_equal(thin["position"], [*every["position"][:-1:7], every["position"][-1]])
    runs = ps.Model().simulate_many(number=2, inputs={"valveVoltage": 6.0}, progress=False, **{**SHORT, "every": 7})
    assert len(runs.time) == len(thin)
    smooth = {"valve.hysteresis": 0.0, "supplyPressure": 6e5}
    gradients = []
    for rows in (1, 7):
        moved = ps.Model().simulate(smooth, inputs={"valveVoltage": 8.0}, **{**SHORT, "every": rows})
        end = np.append(np.zeros(len(moved) - 1), 1.0)
        gradients.append(moved.vjp({"position": end}).inputs["valveVoltage"])
    assert np.isfinite(gradients[0]).all() and np.array_equal(*gradients)


@pytest.mark.parametrize("given", [
    {"parameters": {"supplyPressure": [6e5, -1.0]}},
    {"parameters": {"friction.law": ["Dahl", "Dal"]}},
    {"inputs": {"supplyPressure": [6e5, float("nan")]}},
])  # fmt: skip
def test_bad_value_of_many_runs_is_named_with_its_number(given: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="run 1 of 2: "):
        ps.Model().simulate_many(**given, progress=False, **SHORT)

"""Arguments of the package whose effect no other test is about."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pneumatic_servo.envs as envs
import pytest
from bounds import assert_close
from test_identification import bench

STEP = 2e-3
"""Not the models' own, which are taken without one."""
GIVEN: dict[str, Any] = {"inputs": {"valveVoltage": 6.5}, "stop": 0.1, "step": STEP, "outputs": ["position"]}


@pytest.fixture(scope="module")
def plant() -> ps.Model:
    return ps.Model()


def test_runs_start_at_the_time_that_is_given(plant: ps.Model) -> None:
    simulation = plant.start(time=2.0)
    simulation.step(0.5)
    assert simulation.time == 2.5
    ramp = {"valveVoltage": ([2.0, 2.1], [5.0, 10.0])}
    given = GIVEN | {"inputs": ramp, "start": 2.0, "stop": 2.1, "outputs": ["valveVoltage", "position"]}
    later, many = plant.simulate(**given), plant.simulate_many([{}], **given, progress=False)
    assert later.time[0] == many.time[0] == 2.0
    # Held since a step before the end.
    assert_close(later["valveVoltage"][-1], 10.0 - 50.0 * STEP, rel=5e-15, what="voltage")
    assert many["position"][0].tobytes() == later["position"].tobytes()


def test_many_runs_share_what_is_common_and_are_thinned_alike(plant: ps.Model) -> None:
    told: list[tuple[int, int]] = []
    runs = plant.simulate_many(
        [{}, {"friction.law": "Dahl"}], common={"mass.moving": 2.0}, every=20, **GIVEN,
        progress=lambda done, total: told.append((done, total)),
    )  # fmt: skip
    assert told[-1] == (2, 2)
    for run, law in zip(runs, ("Stribeck", "Dahl"), strict=True):
        alone = plant.simulate({"friction.law": law, "mass.moving": 2.0}, every=20, **GIVEN)
        assert run["position"].tobytes() == alone["position"].tobytes() and len(run) == 4
        assert list(run.variables) == ["position"]
        assert run.settings["mass.moving"] == 2.0
    with pytest.raises(ValueError, match="3 runs"):
        plant.simulate_many([{}], number=3, **GIVEN, progress=False)
    assert len(plant.simulate_many(number=3, **GIVEN, progress=False)) == 3


def test_comparison_has_the_run_of_each_law_alone(plant: ps.Model) -> None:
    told: list[tuple[int, int]] = []
    parameters = {"mass.moving": 2.0}
    given = GIVEN | {"outputs": ["chamberA.pressure"]}
    compared = plant.compare(["Dahl", "LuGre"], parameters, **given, progress=lambda *counts: told.append(counts))
    assert told[-1] == (2, 2)
    for law in ("Dahl", "LuGre"):
        names = [*compared.runs.variables]
        alone = plant.simulate({"friction.law": law, **parameters}, **GIVEN | {"outputs": names})
        assert alone.time.tobytes() == compared[law].time.tobytes()
        for name in ("valveVoltage", "position", "chamberA.pressure"):
            assert compared[law][name].tobytes() == alone[name].tobytes(), name
    assert [axis.get_ylabel() for axis in compared.plot("velocity", "chamberA.pressure").axes] == [
        "velocity (mm/s)",
        "chamberA.pressure (bar)",
    ]


def test_without_trim_the_point_is_that_of_a_start(plant: ps.Model) -> None:
    at = {"velocity": 0.05, "valve.hysteresis": 0.0}
    found = plant.linearise(at=at, trim=False)
    start = plant.start({"velocity0": 0.05, "valve.hysteresis": 0.0})
    assert found.x.tolist() == start.get(found.states).tolist() and found.u.tolist() == [5.0]
    assert plant.linearise(at=at).u[0] > 5.4
    with pytest.warns(ps.PlantWarning, match="valveVoltage = 5 V: it has no effect here, B is 0"):
        few = plant.linearise(at=at, states=["velocity", "position"], trim=False)
    assert few.states == ("velocity", "position")


def test_values_are_set_by_a_mapping_and_by_keywords_and_read_in_order(plant: ps.Model) -> None:
    simulation = plant.start()
    simulation.set({"supplyPressure": 7e5}, valveVoltage=6.0)
    assert simulation.get(["valveVoltage", "supplyPressure"]).tolist() == [6.0, 7e5]


def test_variables_are_found_by_all_words(plant: ps.Model) -> None:
    found = plant.parameters.matching("DEAD zone")
    assert "valve.deadZone" in found and "chamberA.deadVolume" not in found and len(found) < 5
    assert len(plant.parameters.matching("dead")) > len(found)


def test_fmus_are_copied_where_one_wants_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fmus: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from pneumatic_servo.cli import main

    monkeypatch.setattr("pneumatic_servo.bundled.FOLDER", fmus)
    copied = ps.fmus(tmp_path)
    assert {file.parent for file in copied} == {tmp_path} and (tmp_path / "PneumaticServoCylinder.fmu") in copied
    assert all(file.read_bytes() == (fmus / file.name).read_bytes() for file in copied)
    assert {file.parent for file in ps.fmus()} == {fmus}
    (tmp_path / "own").mkdir()
    assert main(["fmu", "--out", str(tmp_path / "own")]) == 0
    assert [Path(line).parent for line in capsys.readouterr().out.splitlines()] == [tmp_path / "own"] * len(copied)
    with pytest.raises(FileNotFoundError, match="is not a folder"):
        ps.fmus(tmp_path / "none")


FIT: dict[str, Any] = {"experiment": "motion", "law": "Stribeck", "play": 0.0, "starts": 0,
                       "fit": ["friction.stribeck.Fc", "friction.stribeck.sigma2"],
                       "settings": {"friction.stribeck.Fs": 11.0, "friction.stribeck.vs": 0.012}}  # fmt: skip


def test_levels_are_normal_forces_over_the_rated_one() -> None:
    """Twice the rated force doubles what the law is found to have at level 1."""
    data = bench()
    data["normalForce"] = np.full_like(data["time"], 4.0)
    law = {"experiment": "motion", "law": "Coulomb", "fit": "friction.coulomb.Fc", "play": 0.0, "starts": 0,
           "settings": {"friction.coulomb.sigma2": 0.0}}  # fmt: skip
    of_two, of_four = (ps.fit(data, rated=rated, **law).values["friction.coulomb.Fc"] for rated in (2.0, 4.0))
    assert_close(of_four, 2.0 * of_two, rel=4e-9, what="Fc")


def test_play_hides_motion() -> None:
    data = bench()
    moving = [np.sum(ps.fit(data, **FIT | {"play": play}).problem.windows[0].used) for play in (0.0, 2e-3)]
    assert moving[0] == 999 and moving[1] < 0.95 * moving[0]


def test_starts_are_as_many_as_are_asked_for_and_drawn_from_the_seed() -> None:
    """Of the wrong law, which leaves more than noise."""
    given = FIT | {"law": "Coulomb", "fit": "friction.coulomb.Fc", "settings": {"friction.coulomb.sigma2": 0.0}}
    told: list[str] = []
    ps.fit(bench(), **given | {"starts": 5}, progress=told.append)
    assert [word for word in told if word.startswith("start")] == ["start 5 of 5"]


def test_seed_draws_the_blocks_of_the_bootstrap() -> None:
    data = bench()
    ends = [
        ps.fit(data, **FIT, intervals="bootstrap", seed=seed).parameters["friction.stribeck.Fc"] for seed in (1, 1, 2)
    ]
    assert ends[0] == ends[1] and ends[0].low != ends[2].low
    plain = ps.fit(data, **FIT).parameters["friction.stribeck.Fc"]
    profile = ps.fit(data, **FIT, intervals="profile").parameters["friction.stribeck.Fc"]
    assert plain.low != ends[0].low and plain.low != profile.low


def test_width_smooths_what_velocities_are_made_from() -> None:
    """The mechanical half needs an acceleration of the carriage; a wider parabola follows its jerks less."""
    from test_identification import RIG, RIG_COLUMNS

    given = {"experiment": "mechanical", "law": "Coulomb", "fit": "mass.moving", "columns": RIG_COLUMNS, "starts": 0}
    narrow, wide = (ps.fit(RIG, width=width, segment=0.5, **given).values["mass.moving"] for width in (0.01, 0.2))
    assert narrow != wide


class Workers(Executor):
    """Interface of a Dask client for a fit: an executor, here one that does everything at once."""

    def __init__(self) -> None:
        self.tasks = 0

    def get_executor(self) -> Executor:
        return self

    def submit(self, function: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        self.tasks += 1
        done: Future[Any] = Future()
        done.set_result(function(*given, **named))
        return done


def test_cluster_does_the_work_that_it_is_given_for() -> None:
    cluster, executor = Workers(), Workers()
    ps.fit(bench(), **FIT | {"starts": 40}, cluster=cluster)
    ps.fit(bench(), **FIT | {"starts": 40}, executor=executor)
    assert cluster.tasks == executor.tasks > 1


@pytest.mark.parametrize(
    ("laws", "words"),
    [(["Stribeck", "LuGre", "Stribeck"], "laws has Stribeck twice"), ([], "laws is empty: name at least one")],
)
def test_laws_to_compare_are_some_and_different_ones(plant: ps.Model, laws: list[str], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        plant.compare(laws, **GIVEN)


def test_settings_of_single_laws_are_for_those_alone() -> None:
    known = {"Stribeck": {"friction.stribeck.Fs": 12.5}}
    ranking = ps.compare_fits(bench(), ["Coulomb", "Stribeck"], experiment="motion", play=0.0, starts=0,
                              settings_of=known)  # fmt: skip
    assert ranking["Stribeck"].settings["friction.stribeck.Fs"] == 12.5
    assert "friction.stribeck.Fs" not in ranking["Stribeck"].parameters
    assert "friction.stribeck.Fs" not in ranking["Coulomb"].settings


@pytest.mark.parametrize("word", ["gain.frictionForce", "gain.frictionForce:0.5:2", "gain.frictionForce=1.2:0.5:2"])
def test_what_is_known_of_a_single_law_is_free_of_the_others(word: str) -> None:
    ranking = ps.compare_fits(
        bench(), ["Coulomb", "Stribeck"], experiment="motion", play=0.0, starts=0, fit=word,
        fit_of={"Coulomb": "friction.coulomb.Fc", "Stribeck": "friction.stribeck.Fs"},
        settings_of={"Coulomb": {"gain.frictionForce": 1.0}},
    )  # fmt: skip
    assert "gain.frictionForce" not in ranking["Coulomb"].parameters
    assert "gain.frictionForce" in ranking["Stribeck"].parameters


def test_what_is_free_of_single_laws_is_for_those_alone() -> None:
    own = {"Stribeck": "friction.stribeck.Fs"}
    ranking = ps.compare_fits(bench(), ["Coulomb", "Stribeck"], experiment="motion", play=0.0, starts=0, fit_of=own)
    free = {law: list(ranking[law].parameters) for law in ("Coulomb", "Stribeck")}
    assert free == {"Coulomb": ["friction.coulomb.Fc", "friction.coulomb.sigma2"], "Stribeck": ["friction.stribeck.Fs"]}


def test_ranking_is_written(tmp_path: Path) -> None:
    ranking = ps.compare_fits(bench(), ["Coulomb"], experiment="motion", play=0.0, starts=0)
    ranking.to_csv(tmp_path / "a.csv")
    header, row = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert header == "law,converged,free,rms,validation rms,AIC" and row.startswith("Coulomb,True,2,1.0,,")
    assert row.endswith(repr(ranking.best.aic))


def test_environments_keep_how_they_are_drawn() -> None:
    """Modes that they cannot draw are refused by name."""
    for kind, modes in (
        (envs.Positioning, (None, "human", "rgb_array")),
        (envs.VectorPositioning, (None, "rgb_array")),
    ):
        assert tuple(kind(render_mode=mode).render_mode for mode in modes) == modes
        with pytest.raises(ValueError, match="render_mode = 'ansi' is refused: it must be None or"):
            kind(render_mode="ansi")
    with pytest.raises(ValueError, match="render_mode = 'human' is refused: it must be None or 'rgb_array'"):
        envs.VectorPositioning(render_mode="human")

"""Ways to fit that are chosen by an option: other intervals, windows, a cluster; and the end by Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from clusters import cluster
from dask.distributed import Client
from pneumatic_servo.identification.solve import jacobian
from test_identification import RIG, RIG_COLUMNS, TRUE_FRICTION, bench, write
from test_package_cli import COMMAND

FREE = ["friction.stribeck.Fc", "friction.stribeck.sigma2"]
KNOWN: dict[str, ps.Value] = {"friction.stribeck.Fs": 11.0, "friction.stribeck.vs": 0.012}


@pytest.mark.parametrize("method", ["profile", "bootstrap"])
def test_other_intervals_agree_where_everything_is_nearly_linear(method: str) -> None:
    plain, other = (
        ps.fit(bench(), experiment="motion", law="Stribeck", fit=FREE, settings=KNOWN, play=0.0, starts=0,
               intervals=chosen).parameters
        for chosen in ("jacobian", method)
    )  # fmt: skip
    for name, estimate in plain.items():
        # Twenty blocks tell a width to a sixth; two such widths are compared. Six halvings find an end to a 64th.
        rel = 0.5 if method == "bootstrap" else 0.05
        assert_close(other[name].high - other[name].low, estimate.high - estimate.low, rel=rel, what=method)
        assert other[name].low < estimate.value < other[name].high


def test_windows_start_anew_from_what_was_measured() -> None:
    """As records of closed loops need it, in which errors of an open-loop simulation would grow."""
    free = [f"friction.stribeck.{name}" for name in ("Fc", "sigma2")] + ["valve.C"]
    known: dict[str, ps.Value] = {"supplyPressure": 6e5, "valve.deadZone": 0.065, "friction.stribeck.Fs": 12.4,
                                  "friction.stribeck.vs": 0.018}  # fmt: skip
    found = ps.fit(RIG, experiment="rig", law="Stribeck", fit=free, columns=RIG_COLUMNS, settings=known, starts=0,
                   segment=0.6)  # fmt: skip
    assert len(found.problem.windows) == 5
    truth = {"valve.C": 4.4e-9} | {name: TRUE_FRICTION[name.rpartition(".")[2]] for name in free[:2]}
    for name, value in truth.items():
        estimate = found.parameters[name]
        # Each window begins with a closed valve, whose opening, 3 ms, costs some of the certainty.
        assert abs(estimate.value - value) < estimate.high - estimate.low < 0.1 * value, (name, estimate)


def test_cluster_finds_the_same() -> None:
    given = {"experiment": "motion", "law": "Stribeck", "fit": FREE, "settings": KNOWN, "play": 0.0, "starts": 40}
    here = ps.fit(bench(), **given)
    with cluster(workers=1) as started, Client(started) as client:
        there = ps.fit(bench(), **given, cluster=client)
    # Where the cost changes by less than a millionth, both are at its bottom but for this.
    assert there.values.keys() == here.values.keys()
    assert_close(list(there.values.values()), list(here.values.values()), rel=1e-10, what="values")


@pytest.mark.parametrize("experiment", ["motion", "rig"])
def test_exact_jacobian_is_that_of_differences(experiment: str) -> None:
    """On a bench with an imposed motion, whose input does not depend on parameters, and on a rig that sticks."""
    given: dict[str, Any] = {"law": "Stribeck", "fit": FREE, "settings": KNOWN, "starts": 0}
    if experiment == "rig":
        given |= {"columns": RIG_COLUMNS, "settings": {**KNOWN, "supplyPressure": 6e5, "valve.deadZone": 0.065}}
    data = bench() if experiment == "motion" else RIG
    found = ps.fit(data, experiment=experiment, play=0.0, jac="exact", **given)
    problem = found.problem
    x = np.concatenate([found.x[: len(problem.free)], np.zeros(sum(problem.loose))])
    exact, other = (jacobian(replace(problem, jac=jac), x) for jac in ("exact", "differences"))
    for column, expected in zip(exact.T, other.T, strict=True):
        # The root of the mean square: a sample beside an event differs by what the difference straddles.
        assert_close(
            float(np.linalg.norm(column - expected)) / float(np.linalg.norm(expected)),
            0.0,
            within=2e-2,
            what=experiment,
        )
    plain = ps.fit(data, experiment=experiment, play=0.0, **given)
    for name, estimate in plain.parameters.items():
        width = estimate.high - estimate.low
        assert abs(found.values[name] - estimate.value) < 0.05 * width, (name, found.values[name], estimate)


def test_exact_jacobian_names_what_has_no_derivative() -> None:
    """A break-away exponent up to one half leaves open how the carriage leaves its rest."""
    known = {**KNOWN, "supplyPressure": 6e5, "valve.deadZone": 0.065, "friction.stribeck.delta": 0.5}
    told = r"differences of runs are taken by .*friction\.stribeck\.Fc, .* by which a run has no derivative"
    with pytest.warns(ps.PlantWarning, match=told):
        ps.fit(RIG, experiment="rig", law="Stribeck", fit=FREE, columns=RIG_COLUMNS, settings=known, starts=0, play=0.0,
               jac="exact")  # fmt: skip


def test_other_jacobians_are_refused() -> None:
    with pytest.raises(ValueError, match=r"jac='2-point': it must be differences or exact"):
        ps.plan(law="Stribeck", jac="2-point")


@pytest.mark.skipif(os.name == "nt", reason="interrupts are sent differently there")
def test_interrupt_leaves_no_file(tmp_path: Path) -> None:
    file = write(tmp_path / "data.csv", bench())
    outputs = [f"--{kind}={tmp_path / 'result'}.{kind}" for kind in ("out", "json", "report")]
    command = [*COMMAND, "fit", str(file), "--experiment", "motion",
               "--law", "GMS,Leuven,LuGre,Dahl,ElastoPlastic", "--columns", "time=t,position=x[mm],frictionForce=f",
               *outputs]  # fmt: skip
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(timeout=3.0)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=20.0)
    assert process.returncode == 130 and told.endswith("error: interrupted\n"), told
    assert [left.name for left in tmp_path.iterdir()] == ["data.csv"]

"""Work that an executor does: the same bits as here, and Ctrl-C keeps what is done."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from clusters import cluster
from dask.distributed import Client
from test_identification import bench
from test_package_arguments import Workers
from test_package_closed_loop import MANY, Integral, Telling, integrating, proportional

TIMES = np.arange(0, 0.1, 1e-3)
RUN = {"inputs": {"valveVoltage": (TIMES, 5.0 + 2.0 * np.sin(20.0 * TIMES))}, "stop": 0.1, "step": 1e-3,
       "progress": False}  # fmt: skip
PLAN = {"law": "Coulomb", "experiment": "motion", "duration": 4.0, "step": 0.01, "progress": False}
FIT = {"experiment": "motion", "play": 0.0, "starts": 40, "progress": False}
"""More starts than one task simulates."""


# First, and in this file: processes are forked, which neither Dask nor JAX likes once their threads run.
def test_many_loops_in_python_are_divided_among_processes() -> None:
    plant = ps.Model()
    controllers: list[Any] = [proportional, Telling, Integral(), integrating]
    for controller in controllers:
        record = ["error", "sum"] if controller is Telling else []
        here = plant.simulate_many(controller=controller, record=record, **MANY)
        there = plant.simulate_many(controller=controller, record=record, workers=2, **MANY)
        assert np.array_equal(here._values, there._values) and list(there.variables) == list(here.variables)
    with ThreadPoolExecutor(2) as threads:
        assert np.array_equal(plant.simulate_many(controller=Integral(), executor=threads, **MANY)["position"],
                              plant.simulate_many(controller=Integral(), **MANY)["position"])  # fmt: skip
    with pytest.raises(TypeError, match="cannot be sent to other processes"):
        plant.simulate_many(controller=integrating(), workers=2, **MANY)


@pytest.fixture(scope="module", params=["processes", "Dask"])
def executor(request: pytest.FixtureRequest) -> Iterator[Executor]:
    if request.param == "processes":
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
            yield pool
    else:
        with cluster(workers=2) as started, Client(started) as client:
            yield client.get_executor()


def test_runs_have_the_same_bits(executor: Executor) -> None:
    settings = {"valve.deadZone": np.linspace(0.04, 0.1, 5)}
    runs = ps.Model().simulate_many(settings, executor=executor, **RUN)
    assert runs["position"].tobytes() == ps.Model().simulate_many(settings, **RUN)["position"].tobytes()


def test_comparison_has_the_same_bits(executor: Executor) -> None:
    there, here = (ps.Model().compare(["Stribeck", "LuGre"], executor=who, **RUN) for who in (executor, None))
    assert there["LuGre"]["position"].tobytes() == here["LuGre"]["position"].tobytes()


def test_executor_does_the_work_that_it_is_given_for() -> None:
    plant, workers = ps.Model(), [Workers() for _ in range(3)]
    plant.simulate_many(number=3, executor=workers[0], **RUN)
    plant.compare(["Stribeck", "LuGre"], executor=workers[1], **RUN)
    candidates = ps.plan(executor=workers[2], **PLAN).candidates
    assert [one.tasks for one in workers] == [3, 2, len(candidates)]


def test_plan_is_the_same(executor: Executor) -> None:
    there, here = (ps.plan(executor=who, **PLAN) for who in (executor, None))
    assert repr(there) == repr(here) and len(there.candidates) > 10
    for one, other in zip(there.candidates, here.candidates, strict=True):
        assert (one.half, one.information) == (other.half, other.information)


def test_fits_are_the_same(executor: Executor) -> None:
    there, here = (ps.compare_fits(bench(), ["Coulomb", "Stribeck"], executor=who, **FIT) for who in (executor, None))
    assert [fit.law for fit in there.fits] == [fit.law for fit in here.fits] == ["Stribeck", "Coulomb"]
    for law in ("Coulomb", "Stribeck"):
        # The last search begins where the best of the rough ones ended, here perhaps before all of them were made.
        values, expected = ([*ranking[law].values.values()] for ranking in (there, here))
        # A value that the data draw to its bound, which is 0, is rounding.
        assert_close(values, expected, rel=2e-9, within=1e-18, what="values")


INTERRUPTED = '''
"""Long work of two processes that reports its progress, and the processes left after Ctrl-C."""
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pneumatic_servo as ps


def tell(done, *_):
    if not isinstance(done, str) and done >= 2 or isinstance(done, str) and "refined" in done:
        print("go", flush=True)


def simulate_many(pool):
    runs = ps.Model().simulate_many([{}] * 400, stop=20.0, step=1e-3, every=1000, outputs=["position"],
                                    executor=pool, progress=tell)


def compare(pool):
    laws = list(ps.Model().parameters["friction.law"].items)
    ps.Model().compare(laws, stop=40.0, step=1e-3, executor=pool,
                       progress=tell)


def plan(pool):
    ps.plan(law="LuGre", duration=10.0, executor=pool, progress=tell)


def fit(pool):
    t = np.arange(0.0, 20.0, 1e-3)
    force = 7.0 * np.sign(np.cos(6.0 * t)) + np.sin(20.0 * t)
    ps.fit({"time": t, "position": 1e-3 * np.sin(6.0 * t), "frictionForce": force}, experiment="motion", law="LuGre",
           starts=64, executor=pool, progress=tell)


if __name__ == "__main__":
    pool = ProcessPoolExecutor(2, mp_context=get_context("fork"))
    try:
        globals()[sys.argv[1]](pool)
    except ps.Interrupted as interrupted:
        found = interrupted.finished
    if isinstance(found, ps.Runs):
        print("kept", int(found.is_complete.sum()), len(found), flush=True)
    elif isinstance(found, ps.Comparison):
        assert found.laws[0] in repr(found)
        print("kept", int(found.runs.is_complete.sum()), 24, flush=True)
    elif isinstance(found, ps.Plan):
        print("kept", len(found.candidates), 18, flush=True)
    else:
        print("kept", int(all(np.isfinite(list(found.rms.values())))), 2, flush=True)
    # The end of a pool whose workers were interrupted is Python's, and may wait for one that never answers.
    os._exit(0)
'''


@pytest.mark.skipif(os.name == "nt", reason="interrupts are sent differently there")
@pytest.mark.parametrize("work", ["simulate_many", "compare", "plan", "fit"])
def test_interrupt_of_all_processes_keeps_what_is_done(tmp_path: Path, work: str) -> None:
    """As a terminal sends it: to the workers, too, which may end by it."""
    (tmp_path / "work.py").write_text(INTERRUPTED, encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, tmp_path / "work.py", work], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    )  # fmt: skip
    try:
        assert process.stdout is not None and process.stdout.readline() == "go\n"
        os.killpg(process.pid, signal.SIGINT)
        process.wait(timeout=120.0)
    finally:
        # Workers may be left, which hold the pipes open.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        told, errors = process.communicate()
    assert process.returncode == 0, errors
    kept, number = map(int, told.splitlines()[-1].removeprefix("kept ").split())
    assert 0 < kept < number


def test_plan_that_is_interrupted_keeps_what_was_judged() -> None:
    def tell(done: int, total: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(ps.Interrupted) as caught:
        ps.plan(**PLAN | {"progress": tell})
    found = caught.value.finished
    assert isinstance(found, ps.Plan)
    whole = {one.name: one.information for one in ps.plan(**PLAN).candidates}
    assert len(found.candidates) == 3
    assert all(whole[one.name] == one.information for one in found.candidates)


def test_plan_that_is_interrupted_before_anything_is_judged_keeps_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def press(*_: object) -> None:
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr("pneumatic_servo.identification.planning.imagined", press)
    with pytest.raises(ps.Interrupted) as caught:
        ps.plan(**PLAN)
    assert caught.value.finished is None

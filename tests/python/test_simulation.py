"""Runs through FMPy, as a host makes them."""

from pathlib import Path

import numpy as np
import pytest
from bounds import assert_close
from client import Client
from experiment import laws_of, simulate
from fmpy import simulate_fmu
from shared import LAWS, run, sine


def test_every_law_is_run(fmu: Path) -> None:
    assert laws_of(fmu) == LAWS
    assert len(LAWS) == 26


def test_every_law_runs_with_every_status_ok(fmu: Path) -> None:
    """The client raises an exception for every status other than OK."""
    for law in laws_of(fmu):
        columns = simulate(fmu, law).columns
        assert columns["time"][-1] == 3.0, law
        for name, column in columns.items():
            assert np.all(np.isfinite(column)), f"{law}: {name}"
        assert np.ptp(columns["position"]) > 0.1, law
        assert np.all(columns["chamberA.pressure"] > 5e4), law
        assert np.all(columns["chamberB.pressure"] > 5e4), law


@pytest.mark.parametrize("law", LAWS)
def test_simulate_fmu_agrees_with_the_step_by_step_run(fmu: Path, law: str) -> None:
    """Both hold the input for 1 ms, which FMPy takes from its table at the sample."""
    with Client(fmu) as client:
        number = client.items("friction.law")[law]
    time = np.arange(3001) * 1e-3
    signal = np.array([(t, sine(t)) for t in time], dtype=[("time", float), ("valveVoltage", float)])
    result = simulate_fmu(
        str(fmu),
        start_values={"friction.law": number},
        input=signal,
        output_interval=1e-3,
        relative_tolerance=1e-6,
        output=["position", "chamberA.pressure", "chamberB.pressure"],
    )
    columns = simulate(fmu, law).columns
    assert len(result) == len(columns["time"])
    for name in ("position", "chamberA.pressure", "chamberB.pressure"):
        assert result[name].tobytes() == columns[name].tobytes(), name


@pytest.mark.parametrize("law", LAWS)
def test_results_do_not_depend_on_the_communication_step(fmu: Path, law: str) -> None:
    """One input for all: held for 50 ms."""
    ends = {}
    for step in (1e-3, 1e-2, 5e-2):
        with Client(fmu) as client:
            client.start({"friction.law": law, "valveVoltage": sine(0.0)})
            steps_per_hold = round(5e-2 / step)
            for index in range(20 * steps_per_hold):
                if index % steps_per_hold == 0:
                    client.set({"valveVoltage": sine(index * step)})
                client.advance((index + 1) * step)
            ends[step] = client.get(["position", "chamberA.pressure", "chamberB.pressure"])
    for step in (1e-3, 1e-2):
        assert_close(ends[step][0], ends[5e-2][0], within=1e-7, what="position")
        assert_close(ends[step][1:], ends[5e-2][1:], within=0.15, what="pressures")


@pytest.mark.parametrize("step", [1e-3, 5e-2])
def test_stiction_under_load_does_not_drift(fmu: Path, step: float) -> None:
    with Client(fmu) as client:
        client.start({"friction.law": "Stribeck", "externalForce": 8.0})
        before = client.get(["position"])
        for index in range(round(10.0 / step)):
            client.advance((index + 1) * step)
        assert client.get(["position", "velocity", "sticking"]) == [*before, 0.0, 1.0]


def test_carriage_rests_at_each_reversal(fmu: Path) -> None:
    """With the defaults the carriage sticks for about 95 ms in each half period of 1 Hz."""
    columns = simulate(fmu, "Stribeck").columns
    late = columns["time"] >= 1.0
    sticking = columns["sticking"][late] > 0.5
    starts = np.flatnonzero(np.diff(sticking.astype(int)) == 1)
    stops = np.flatnonzero(np.diff(sticking.astype(int)) == -1)
    rests = [(stops[stops > start][0] - start) * 1e-3 for start in starts if np.any(stops > start)]
    assert len(rests) in (3, 4)
    assert np.mean(rests) == pytest.approx(0.095, abs=0.005)
    assert all(0.075 < rest < 0.11 for rest in rests), rests


def test_statistics_count_up(client: Client) -> None:
    client.start()
    names = ["solver.steps", "solver.events"]
    before = client.get(names)
    for _ in run(client, 0.5, 1e-3):
        pass
    steps, events = np.subtract(client.get(names), before)
    assert steps >= 500
    assert events >= 1

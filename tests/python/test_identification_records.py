"""Records: where they are split, and where not."""

from __future__ import annotations

import numpy as np
import pneumatic_servo as ps
from pneumatic_servo.identification.records import load
from test_identification import RIG, TRUE_FRICTION, bench


def test_gap_splits_a_record_and_lost_samples_do_not() -> None:
    data = bench()
    without = {
        lost: {name: np.delete(values, slice(400, 400 + lost)) for name, values in data.items()} for lost in (3, 30)
    }
    [whole], notes = load([without[3]], {})
    assert len(whole.time) == 997 and not notes
    (first, second), notes = load([without[30]], {})
    assert (len(first.time), len(second.time)) == (400, 570) and second.begin == data["time"][430]
    assert notes == ["record 1: split at 1 gaps, 0 pieces too short to use"]


def test_rig_that_lost_a_third_of_its_samples_is_simulated_in_one_go() -> None:
    """At 1 kHz that leaves gaps of up to 9 ms; anew after each, the simulation would begin with a closed valve."""
    table = np.genfromtxt(RIG, delimiter=",", names=True)
    kept = np.sort(np.random.default_rng(0).choice(len(table), 2000, replace=False))
    scales = {"time": ("t", 1.0), "valveVoltage": ("u", 1.0), "position": ("x_mm", 1e-3),
              "chamberA.pressure": ("pa_bar", 1e5), "chamberB.pressure": ("pb_bar", 1e5)}  # fmt: skip
    data = {signal: scale * table[column][kept] for signal, (column, scale) in scales.items()}
    assert 5e-3 < np.max(np.diff(data["time"])) < 0.02
    free = [f"friction.stribeck.{name}" for name in ("Fc", "sigma2")]
    known: dict[str, ps.Value] = {"supplyPressure": 6e5, "valve.deadZone": 0.065, "valve.C": 4.4e-9,
                                  "friction.stribeck.Fs": 12.4, "friction.stribeck.vs": 0.018}  # fmt: skip
    found = ps.fit(data, experiment="rig", law="Stribeck", fit=free, settings=known, starts=0)
    assert len(found.problem.windows) == 1
    for name in free:
        estimate, true = found.parameters[name], TRUE_FRICTION[name.rpartition(".")[2]]
        # Twice the interval of 95 % holds both but for one time in 5,000.
        assert abs(estimate.value - true) < estimate.high - estimate.low < 0.005 * true, (name, estimate)

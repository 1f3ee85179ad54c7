"""Records: where they are split, and where not."""

from __future__ import annotations

import numpy as np
import pneumatic_servo as ps
from bounds import assert_close
from numpy.typing import NDArray
from test_identification import RIG, TRUE_FRICTION

FREE = [f"friction.stribeck.{name}" for name in ("Fc", "sigma2")]
KNOWN: dict[str, ps.Value] = {"supplyPressure": 6e5, "valve.deadZone": 0.065, "valve.C": 4.4e-9,
                              "friction.stribeck.Fs": 12.4, "friction.stribeck.vs": 0.018}  # fmt: skip


def rig(kept: NDArray[np.int64]) -> dict[str, NDArray[np.float64]]:
    """Some of the samples of the rig, which were taken at 1 kHz."""
    table = np.genfromtxt(RIG, delimiter=",", names=True)[kept]
    scales = {"time": ("t", 1.0), "valveVoltage": ("u", 1.0), "position": ("x_mm", 1e-3),
              "chamberA.pressure": ("pa_bar", 1e5), "chamberB.pressure": ("pb_bar", 1e5)}  # fmt: skip
    return {signal: scale * table[column] for signal, (column, scale) in scales.items()}


def test_rig_that_lost_a_third_of_its_samples_is_simulated_in_one_go() -> None:
    """That leaves gaps of up to 9 ms; anew after each, the simulation would begin with a closed valve."""
    data = rig(np.sort(np.random.default_rng(0).choice(3001, 2000, replace=False)))
    assert 5e-3 < np.max(np.diff(data["time"])) < 0.02
    found = ps.fit(data, experiment="rig", law="Stribeck", fit=FREE, settings=KNOWN, starts=0)
    assert len(found.problem.windows) == 1
    for name in FREE:
        estimate, true = found.parameters[name], TRUE_FRICTION[name.rpartition(".")[2]]
        # Twice the interval of 95 % holds both but for one time in 5,000.
        assert abs(estimate.value - true) < estimate.high - estimate.low < 0.005 * true, (name, estimate)


def test_voltage_that_is_recorded_too_seldom_is_on_straight_lines() -> None:
    """Each tenth sample: a voltage that is held between them comes 5 ms late."""
    data = rig(np.arange(0, 3001, 10))
    held, lines = (
        ps.fit(data, experiment="rig", law="Stribeck", fit=FREE, settings=KNOWN, starts=0, inputs=inputs)
        for inputs in ("held", "lines")
    )
    assert lines.rms["position"] < 2e-4 < 8e-4 < held.rms["position"]
    assert_close(lines.values["friction.stribeck.sigma2"], 38.0, rel=0.01, what="sigma2")
    assert abs(held.values["friction.stribeck.sigma2"] / 38.0 - 1.0) > 0.02

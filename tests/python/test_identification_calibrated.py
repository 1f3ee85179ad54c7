"""Readings of transducers in volts, milliamperes and counts, converted by two points of a calibration."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas
import pneumatic_servo as ps
import pytest

TIME = np.arange(0.0, 2.0, 1e-3)
VOLTAGE = 5.0 + 2.0 * np.sin(2.0 * np.pi * TIME)
SETTINGS = {"supplyPressure": 6e5, "friction.law": "Stribeck"}


@pytest.fixture(scope="module")
def run() -> ps.Run:
    outputs = ["position", "chamberA.pressure", "chamberB.pressure"]
    return ps.Model().simulate(SETTINGS, inputs={"valveVoltage": (TIME, VOLTAGE)}, stop=2.0, step=1e-3, outputs=outputs)


def readings(run: ps.Run) -> dict[str, np.ndarray]:
    """Return what a data logger with transducers of 10 V, 4 to 20 mA and 12 bits stores."""
    noise = np.random.default_rng(3)
    position = run["position"] + 2e-5 * noise.standard_normal(len(run.time))
    pressures = [run[f"chamber{name}.pressure"] + 300.0 * noise.standard_normal(len(run.time)) for name in "AB"]
    return {
        "t": run.time,
        "U1": position / 0.5 * 10.0,
        "I1": 4.0 + 16.0 * (pressures[0] - 101325.0) / 1e6,
        "n": pressures[1] / 1e6 * 4095.0,
        "u": VOLTAGE[: len(run.time)] if len(run.time) <= len(VOLTAGE) else np.append(VOLTAGE, VOLTAGE[-1]),
    }


CALIBRATED = {
    "time": "t",
    "valveVoltage": "u",
    "position": "U1[0..10 V = 0..500 mm]",
    "chamberA.pressure": "I1[4..20 mA = 0..10 barg]",
    "chamberB.pressure": "n[0..4095 = 0..10 bar]",
}


def test_readings_of_transducers_are_those_of_the_quantities(run: ps.Run, tmp_path: Path) -> None:
    table = readings(run)
    quantities = {
        "time": table["t"],
        "valveVoltage": table["u"],
        "position": table["U1"] * 0.05,
        "chamberA.pressure": 101325.0 + (table["I1"] - 4.0) / 16.0 * 1e6,
        "chamberB.pressure": table["n"] / 4095.0 * 1e6,
    }
    options = {"law": "Stribeck", "settings": {"supplyPressure": 6e5}, "starts": 0, "progress": False}
    plain = ps.fit(quantities, experiment="rig", **options)
    calibrated = ps.fit(table, experiment="rig", columns=CALIBRATED, **options)
    file = tmp_path / "rig.csv"
    header = "t,U1 [V],I1 [mA],n,u [V]"
    np.savetxt(file, np.column_stack(list(table.values())), delimiter=",", header=header, comments="", fmt="%.17g")
    of_file = ps.fit(file, experiment="rig", columns=CALIBRATED, **options)
    for found in (calibrated, of_file):
        for name, value in plain.values.items():
            assert found.values[name] == pytest.approx(value, rel=1e-6, abs=1e-12), name
    assert plain.values["friction.stribeck.Fc"] == pytest.approx(8.5, rel=0.2)


def test_a_gain_that_is_estimated_corrects_the_calibration(run: ps.Run) -> None:
    table = readings(run)
    wrong = {**CALIBRATED, "position": "U1[0..10 V = 0..490 mm]"}
    found = ps.fit(
        table, experiment="rig", columns=wrong, law="Stribeck", settings={"supplyPressure": 6e5}, starts=0,
        progress=False, fit=["friction.stribeck.Fs", "friction.stribeck.Fc", "gain.position"],
    )  # fmt: skip
    gain = found["gain.position"]
    assert gain.low < 500.0 / 490.0 < gain.high
    assert gain.high - gain.low < 0.02


@pytest.mark.parametrize(
    ("columns", "problem"),
    [
        ({"position": "U1[0..10 V]"}, r"position=U1\[0..10 V\]'?.*the calibration 0..10 V is refused: a calibration"),
        ({"position": "U1[0..10 V = 0..500]"}, "the quantity has no unit"),
        ({"position": "U1[0..10 V = 0..5 bar]"}, "the unit bar is refused; it must be one of m, cm, mm"),
        ({"position": "U1[0..10 mm = 0..5 mm]"}, "readings are in V, mV, A, mA, % or, without a unit, in counts"),
        ({"position": "U1[V]"}, "readings in V need a calibration, such as 4..20 mA = 0..10 bar"),
        ({"position": "U1[3..3 V = 0..5 mm]"}, "its two points must differ"),
    ],
)
def test_a_wrong_calibration_is_refused(run: ps.Run, columns: dict[str, str], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        ps.fit(readings(run), experiment="rig", columns={**CALIBRATED, **columns}, law="Stribeck", progress=False)


def test_a_table_in_another_unit_than_the_calibration_is_refused(run: ps.Run) -> None:
    table = {("U1 [mV]" if name == "U1" else name): values for name, values in readings(run).items()}
    with pytest.raises(ValueError, match=r"the table says mV, but the calibration .* reads V; which is it\?"):
        ps.fit(table, experiment="rig", columns=CALIBRATED, law="Stribeck", progress=False)


def test_inputs_of_a_simulation_take_calibrations(run: ps.Run) -> None:
    table = pandas.DataFrame({"t": TIME, "I": 4.0 + 1.6 * VOLTAGE, "u": VOLTAGE})
    of_current = ps.Model().simulate(
        SETTINGS, inputs=table, columns="time=t,valveVoltage=I[4..20 mA = 0..10 V]", stop=1.0, step=1e-3
    )
    of_voltage = ps.Model().simulate(SETTINGS, inputs=table, columns="time=t,valveVoltage=u",
                                     stop=1.0, step=1e-3)  # fmt: skip
    assert of_current["position"] == pytest.approx(of_voltage["position"], abs=1e-9)

"""From the numbers of data sheets to parameters."""

from __future__ import annotations

import subprocess
import sys
import warnings
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from pneumatic_servo.data_sheet import DataSheet, laws_without_levels, nominal_flow

COMMAND = [sys.executable, "-c", "import sys; from pneumatic_servo.cli import main; sys.exit(main())"]
NAMESPACE = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
CYLINDER = {"bore": 32.0, "rod": 12.0, "stroke": 200.0, "mass": 5.0}


def conductance(**flow: float) -> float:
    entries = DataSheet(**CYLINDER, **flow).entries()  # type: ignore[arg-type]
    return next(entry.value for entry in entries if entry.name == "valve.C")


def test_default_valve_has_a_nominal_flow_of_100_litres_per_minute() -> None:
    defaults = ps.Model().parameters
    flow = nominal_flow(defaults["valve.C"].default, defaults["valve.b"].default)
    assert_close(flow * 60_000.0, 100.0, rel=1e-3, what="flow")


def test_nominal_flow_is_what_the_model_lets_through() -> None:
    """The valve fully open between 6 and 5 bar above ambient, into a chamber too large to fill."""
    settings = {
        "valve.C": conductance(qn=700.0),
        "valve.leakage": 0.0,
        "thermal.model": "Isothermal",
        "friction.law": "CoulombStiction",
        "friction.coulombStiction.Fs": 1e6,
        "chamberA.deadVolume": 1.0,
        "chamberA.pressure0": 5e5 + 101_325.0,
        "supplyPressure": 6e5 + 101_325.0,
        "valveVoltage": 10.0,
    }
    with pytest.warns(ps.PlantWarning, match=r"chamberA.deadVolume = 1 m3: usual values"):
        run = ps.Model().simulate(settings, stop=0.05, outputs=["chamberA.massFlow"])
    # The chamber of a cubic metre gains some 100 Pa meanwhile.
    assert_close(run["chamberA.massFlow"][-1] / 1.185 * 60_000.0, 700.0, rel=1e-3, what="flow")


def test_flows_are_stated_in_different_ways() -> None:
    assert_close(conductance(conductance=1.5), 1.5e-8, rel=1e-14, what="C")
    # A square millimetre lets 2.3606 g/s of air at 10 bar and 20 degC through.
    assert_close(conductance(area=1.0), 1.992e-9, rel=1e-4, what="area")
    # 1 US gallon per minute at 1 psi is 0.865 m3/h at 1 bar.
    assert_close(conductance(cv=1.0), conductance(kv=0.865), rel=1e-4, what="Cv")
    # Water and air through the same hole: 1/3600 m3/s*sqrt(1000 kg/m3*7.146 kg/m3), in kg/s.
    flow = nominal_flow(conductance(kv=1.0), 0.3)
    assert_close(flow * 1.185, (1000.0 * 6.01325e5 / (287.05 * 293.15)) ** 0.5 / 3600.0, rel=1e-14, what="Kv")


def test_rotary_drive_turns_by_its_displacement() -> None:
    """At 6 bar above ambient on 20 cm3 per rad a torque of 12 N.m turns 0.02 kg.m2, and the angle ends at the stop."""
    sheet = DataSheet.rotary(20.0, 180.0, 0.02, qn=200.0, supply=6.0, response=5.0)
    assert_close(sheet.settings["valve.bandwidth"], 68.4, rel=1e-12, what="bandwidth")
    assert "valve.bandwidth" not in sheet.kept
    held = {"friction.law": "CoulombStiction", "friction.coulombStiction.Fs": 1e3, "chamberB.open": True}
    run = ps.Model().simulate({**sheet.settings, **held, "valveVoltage": 10.0}, stop=1.0)
    assert_close(run["pressureForce"][-1], 6e5 * 20e-6, rel=1e-3, what="torque")
    free = ps.Model().simulate({**sheet.settings, "friction.law": "None", "valveVoltage": 10.0}, stop=2.0)
    assert_close(free["position"][-1], np.pi, rel=1e-2, what="angle at the stop")


def test_small_rotary_drive_has_a_small_bore() -> None:
    sheet = DataSheet.rotary(0.2, 90.0, 5e-5, conductance=0.1, supply=6.0)
    run = ps.Model().simulate(sheet, inputs={"valveVoltage": 7.0}, stop=0.1)
    assert np.all(np.isfinite(run["position"]))


@pytest.mark.parametrize(
    ("given", "words"),
    [((0.0, 90.0, 1.0), "displacement = 0.0 is refused"), ((20.0, float("nan"), 1.0), "angle = nan is refused")],
)
def test_rotary_drive_that_makes_no_sense_is_refused(given: tuple[float, ...], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        DataSheet.rotary(*given, qn=200.0)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, "exactly one of qn, kv, cv, conductance, area"),
        ({"qn": 1.0, "kv": 1.0}, "exactly one of"),
        ({"qn": -1.0}, "qn = -1.0: it must be positive"),
        ({"qn": 1.0, "rod": 32.0}, "rod = 32.0: it must be smaller than the bore"),
        ({"qn": 1.0, "rod": -1.0}, "rod = -1.0: it must not be negative"),
        ({"qn": 1.0, "rod_a": float("nan")}, "rod_a = nan: it must not be negative"),
        ({"qn": 1.0, "critical_ratio": 1.0}, "critical_ratio = 1.0: it must be at least 0 and below 1"),
        ({"qn": 1.0, "critical_ratio": -0.1}, "critical_ratio = -0.1: it must be at least 0 and below 1"),
        ({"qn": 1.0, "hysteresis": -1.0}, "hysteresis = -1.0 %: it must be at least 0 and below 50"),
        ({"qn": 1.0, "spring": (60.0, 20.0)}, "spring = \\(60.0, 20.0\\): its force must be at least 0 and grow"),
        ({"qn": 1.0, "spring": 20.0}, "spring = 20.0 is refused: it must be forces in N"),
        ({"qn": 1.0, "cushion": (250.0, 0.1)}, "cushion = .* at most the stroke, 200 mm"),
        ({"qn": 1.0, "cushion": (20.0, 0.0)}, "the conductance of its needle above 0"),
        ({"qn": 1.0, "cushion": 20.0}, "cushion = 20.0 is refused: it must be a length in mm and a conductance"),
        ({"qn": 1.0, "rebound": (120.0, 0.5)}, "rebound = .* at most 100 %"),
        ({"qn": 1.0, "bumper": 0.0}, "bumper = 0.0: it must be positive"),
        ({"qn": 1.0, "leak": (0.2, 0.5)}, "its pressure at least 1 bar above ambient"),
        ({"qn": 1.0, "response": 0.0}, "response = 0.0 ms: it must be from"),
        ({"area": 1e-6}, "did you give it in m2\\? that would be 1 mm2$"),
        ({"qn": 1.0, "min_pressure": 0.0}, "min_pressure = 0.0: it must be positive"),
        ({"qn": 1.0, "bore": 0.032}, "from 1 to 1000 mm; did you give it in m\\? that would be 32 mm$"),
        ({"qn": 1.0, "supply": 7e5}, "from 0.1 to 100 bar; did you give it in Pa\\? that would be 7 bar$"),
        ({"qn": 1.0, "stroke": 1e5}, "stroke = 100000 mm is refused: it must be from 1 to 20000 mm$"),
    ],
)
def test_sheet_that_makes_no_sense_is_refused(values: dict[str, float], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        DataSheet(**CYLINDER | values)  # type: ignore[arg-type]


@pytest.mark.parametrize(("flow", "assumed"), [({"qn": 700.0}, True), ({"conductance": 2.75}, False)])
def test_critical_ratio_is_an_assumption_where_only_a_nominal_flow_is_known(
    flow: dict[str, float], assumed: bool
) -> None:
    entry = next(one for one in DataSheet(**CYLINDER, **flow).entries() if one.name == "valve.b")
    assert (entry.formula, entry.standard, bool(entry.assumption)) == ("b", "ISO 6358", assumed)


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, "configure", *arguments], cwd=folder, capture_output=True, text=True, check=False)


def test_command_prints_formulas_and_writes_what_a_run_starts_with(tmp_path: Path) -> None:
    given = "--bore 32 --rod 12 --stroke 200 --mass 5 --qn 700 --hose 4x1500 --min-pressure 0.3 --supply 6 --out my.ssv"
    done = run(tmp_path, *given.split())
    assert done.returncode == 0, done.stderr
    for words in ["valve.C = 2.75009e-08 m3/(s.Pa)", "[ISO 6358, ISO 8778 (ANR)]", "assumed: both hoses are alike"]:
        assert words in done.stdout
    parameters = ElementTree.parse(tmp_path / "my.ssv").getroot().iter(f"{NAMESPACE}Parameter")
    values = {one.attrib["name"]: float(one[0].attrib["value"]) for one in parameters}
    assert values["hoseB.length"] == 1.5 and values["supplyPressure"] == 701_325.0
    ps.Model().simulate(values, stop=0.01)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("--bore 32 --stroke 200 --mass 5 --qn 700 --hose 4", "hose = '4' is refused: it must be inner diameter"),
        ("--bore 32 --stroke 200 --mass 5 --qn 700 --kv 1", "not allowed with argument"),
        ("--bore 32 --stroke 200 --mass 5 --qn 700 --b 0.4", "unrecognized arguments: --b 0.4"),
        ("--bore 32 --stroke 200 --mass 5 --qn 700 -b 1", "critical_ratio = 1.0: it must be at least 0"),
        ("--bore 32 --stroke 20000 --mass 5 --qn 700", "cylinder.stroke = 20 m is refused: it must be 0.001 to 10 m"),
    ],
)
def test_command_refuses_by_name(tmp_path: Path, given: str, words: str) -> None:
    done = run(tmp_path, *given.split())
    assert done.returncode == 2
    assert words in done.stderr


RIG: dict[str, float] = {"bore": 32.0, "rod": 12.0, "stroke": 200.0, "mass": 5.0, "qn": 700.0, "supply": 6.0}


def test_friction_of_a_sheet_is_that_of_every_law_that_has_levels() -> None:
    """After the same break-away pressure all these laws start to slide: 0.4 bar on 8.04 cm2 are 32 N."""
    sheet = DataSheet(**RIG, min_pressure=0.4)  # type: ignore[arg-type]
    model = ps.Model()
    levels = ("static friction", "Coulomb friction")
    without = set(laws_without_levels())
    assert without == {"Bristle", "ResetIntegrator", "MaxwellSlip", "DNLRX", "BlimanSorine", "Table"}
    with warnings.catch_warnings():
        warnings.simplefilter("error", ps.PlantWarning)
        for law in set(model.parameters["friction.law"].items) - without - {"None"}:
            started = model.start({**sheet.settings, "friction.law": law})
            own = {
                v.meaning: started[v.name] for v in model.parameters.values()
                if v.counts_for == ("friction.law", law) and v.meaning in levels
            }  # fmt: skip
            assert own, law
            assert all(
                value == pytest.approx(32.17 if of == levels[0] else 24.13, rel=1e-3) for of, value in own.items()
            )
        runs = model.compare(["Stribeck", "LuGre"], sheet, inputs={"valveVoltage": 6.0}, stop=0.3, progress=False).runs
    forces = [float(np.max(run["frictionForce"])) for run in runs]
    assert forces[0] == pytest.approx(forces[1], rel=0.02)
    with pytest.warns(
        ps.PlantWarning, match="friction.law = MaxwellSlip: it has no Coulomb friction and static friction"
    ):
        model.start({**sheet.settings, "friction.law": "MaxwellSlip"})


def test_sheet_serves_as_parameters() -> None:
    sheet = DataSheet(**RIG)  # type: ignore[arg-type]
    run, same = (ps.Model().simulate(given, stop=0.01, step=1e-3) for given in (sheet, sheet.settings))
    assert np.array_equal(run["position"], same["position"])
    assert {"valve.deadZone", "chamberB.pressure0", "friction.lugre.Fs"} <= set(sheet.kept)
    assert not set(sheet.kept) & set(sheet.settings)


@pytest.mark.parametrize(("wrong", "told"), [
    ({"hose": (4, 2)}, r"hose = \(4, 2\) is refused: .* did you mean 4x2000, which is 2 m long"),
    ({"hose": (0.004, 2)}, "did you mean 4x2000"),
    ({"hose": "4"}, "inner diameter and length in mm"),
    ({"hose": 4}, "inner diameter and length in mm"),
    ({"bore": "32"}, "bore = '32' is refused: it must be a number in mm"),
    ({"bore": "32 kg"}, "bore: the unit kg is refused; it must be one of m, cm, mm"),
    ({"supply": "6 bar"}, "supply = '6 bar' is refused: a pressure of a sheet is above ambient, and bar is absolute; "
                          "write barg"),
    ({"leak": (0.2, (87, "psi"))}, "leak = .* is refused: .* psi is absolute; write psig"),
    ({"spring": ("20 N", "60 mm")}, "spring: the unit mm is refused; it must be one of N"),
    ({"mass": [5]}, "mass = .* must be a number in kg"),
    ({"qn": None, "conductance": 1.5e-8}, r"did you give it in m3/\(s.Pa\)"),
])  # fmt: skip
def test_numbers_of_a_sheet_are_refused_by_their_fields(wrong: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        DataSheet(**{**RIG, **wrong})


def test_hose_is_written_as_on_the_command_line() -> None:
    assert DataSheet(**RIG, hose="4x1500").settings == DataSheet(**RIG, hose=(4, 1500)).settings  # type: ignore[arg-type]


def test_sheet_takes_keywords_only() -> None:
    with pytest.raises(TypeError):
        DataSheet(32, 200, 5, qn=700)  # type: ignore[misc]


def test_spring_has_its_forces_at_both_ends() -> None:
    """Without pressure in the chambers an external force as large as the spring's holds the carriage."""
    sheet = DataSheet(**CYLINDER, qn=700.0, spring=(20.0, 60.0))
    for position, force in [(0.0, 20.0), (0.2, 60.0)]:
        settings = {**sheet.settings, "position0": position, "friction.law": "None"}
        plant = ps.Model().start({**settings, "externalForce": force})
        assert abs(plant["acceleration"]) < 1e-9, f"{force} N at {position} m"


def test_sheet_with_a_spring_is_of_a_single_acting_cylinder() -> None:
    """Its row opens the chamber of the spring, which has neither hose nor leak; nothing of it is without effect."""
    sheet = DataSheet(**CYLINDER, qn=700.0, spring=(20.0, 60.0), hose=(4.0, 1500.0), leak=(0.2, 6.0))
    assert sheet.settings["chamberB.open"] == 1.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plant = ps.Model().start(sheet)
    assert plant["chamberB.pressure"] == 101_325.0


def test_leak_is_what_flows_at_its_pressure() -> None:
    sheet = DataSheet(**CYLINDER, qn=700.0, leak=(0.2, 6.0))
    settings = {**sheet.settings, "chamberA.pressure0": 6e5 + 101_325.0, "valve.leakage": 0.0}
    flow = ps.Model().start({**settings, "valveVoltage": 5.0})["chamberA.massFlow"]
    assert_close(flow / 1.185 * 60_000.0, -0.2, rel=1e-9, what="l/min (ANR)")


def test_needle_is_what_lets_air_out_of_a_cushion() -> None:
    """A piston that is held within the cushion, before a valve so wide that the needle is choked."""
    sheet = DataSheet(**CYLINDER, qn=700.0, cushion=(20.0, 0.2), supply=6.0)
    held = {"friction.law": "CoulombStiction", "friction.coulombStiction.Fs": 1e4, "position0": 0.19}
    start = {**sheet.settings, **held, "chamberB.pressure0": 701_325.0, "valveVoltage": 10.0}
    run = ps.Model().simulate(start, stop=0.02, step=1e-3)
    flow, pressure, temperature = (run[f"chamberB.{name}"][-1] for name in ("massFlow", "pressure", "temperature"))
    assert pressure > 3e5
    assert_close(flow, -0.2e-8 * 1.185 * pressure * (293.15 / temperature) ** 0.5, rel=1e-3, what="kg/s")


@pytest.mark.parametrize(("resilience", "speed"), [(45.0, 0.5), (90.0, 1.5), (100.0, 0.5)])
def test_bumper_gives_back_its_share_of_the_energy(resilience: float, speed: float) -> None:
    """A free mass without gas and friction: the share does not depend on mass and stiffness."""
    for mass, bumper in [(5.0, 200.0), (0.8, 3000.0)]:
        sheet = DataSheet(bore=32, stroke=200, mass=mass, qn=700.0, bumper=bumper, rebound=(resilience, speed))
        free = {"friction.law": "None", "chamberA.open": True, "chamberB.open": True}
        start = {"position0": 0.199, "velocity0": speed}
        run = ps.Model().simulate({**sheet.settings, **free, **start}, stop=0.1, step=1e-3)
        assert run["position"].max() > 0.2
        assert_close((run["velocity"][-1] / speed) ** 2, resilience / 100.0, rel=1e-4, what="share")


def test_area_has_the_ratio_of_a_nozzle_and_hysteresis_its_half_width() -> None:
    found = DataSheet(**CYLINDER, area=5.0, hysteresis=0.8).settings
    assert_close(found["valve.b"], 0.5283, rel=1e-4, what="b")
    assert_close(found["valve.hysteresis"], 0.008, rel=1e-14, what="half of the width")
    assert DataSheet(**CYLINDER, area=5.0, critical_ratio=0.4).settings["valve.b"] == 0.4


def test_numbers_may_have_units_of_their_own() -> None:
    metric = DataSheet(
        bore=31.75, rod=12.7, stroke=203.2, mass=2.26796185, qn=28.7083778481, supply=6, response=5, hysteresis=0.5,
        hose=(4, 1500), spring=(20, 60), leak=(0.2, 6), clearance=5,
    )  # fmt: skip
    imperial = DataSheet(
        bore="1.25 in", rod=(0.5, "in"), stroke="8 in", mass="5 lb", qn="1 SCFM", supply="87.02264263 psig",
        response="5 ms", hysteresis="0.5 %", hose=("4 mm", "1.5 m"), spring=("20 N", "0.06 kN"),
        leak=("0.2 l/min", "6 barg"), clearance="0.5 cm",
    )  # type: ignore[arg-type]  # fmt: skip
    for name, value in metric.settings.items():
        assert_close(imperial.settings[name], value, rel=1e-9, what=name)
    drive = DataSheet.rotary("20 cm3", "3.14159265359 rad", "200 kg.cm2", qn=200)  # type: ignore[arg-type]
    for name, value in DataSheet.rotary(20, 180, 0.02, qn=200).settings.items():
        # Without a rod.
        if value != 0.0:
            assert_close(drive.settings[name], value, rel=1e-9, what=name)


def test_command_takes_units(tmp_path: Path) -> None:
    given = ["--bore", "1.25 in", "--stroke", "8 in", "--mass", "5 lb", "--qn", "25 SCFM", "--supply", "87 psig"]
    done = subprocess.run([*COMMAND, "configure", *given], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "cylinder.bore = 0.03175 m" in done.stdout and "mass.moving = 2.26796 kg" in done.stdout

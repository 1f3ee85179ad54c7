"""Every option of the command line does what the package does with the argument that it stands for."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.cli import main
from pneumatic_servo.data_sheet import DataSheet
from test_identification import COLUMNS, bench, write

Array = NDArray[np.float64]
TABLE = "time,valveVoltage\n0,5\n0.1,6.5\n0.25,4\n"
VOLTAGE = {"valveVoltage": ([0.0, 0.1, 0.25], [5.0, 6.5, 4.0])}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder of the commands, with a table of the voltage."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.csv").write_text(TABLE, encoding="utf-8")
    return tmp_path


def columns_of(file: Path) -> dict[str, Array]:
    with file.open(encoding="utf-8", newline="") as stream:
        header, *rows = csv.reader(stream)
    return dict(zip(header, np.array(rows, dtype=float).T, strict=True))


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        ([], {}),
        (["--law", "LuGre"], {"parameters": {"friction.law": "LuGre"}}),
        (["--set", "mass.moving=2", "--set", "valve.C=5e-9"], {"parameters": {"mass.moving": 2.0, "valve.C": 5e-9}}),
        (["--stop", "0.1"], {"stop": 0.1}),
        (["--step", "0.01"], {"step": 0.01}),
        (["--every", "25"], {"every": 25}),
        (["--outputs", "velocity,position"], {"outputs": ["velocity", "position"]}),
    ],
)
def test_simulate(folder: Path, options: list[str], arguments: dict[str, object]) -> None:
    assert main(["simulate", "my.csv", "--out", "a.csv", *options]) == 0
    run = ps.Model().simulate(inputs=VOLTAGE, **{"stop": 0.25, "step": 1e-3} | arguments)  # type: ignore[arg-type]
    found = columns_of(folder / "a.csv")
    assert list(found) == ["time", *run.variables]
    assert found["time"].tobytes() == run.time.tobytes()
    assert all(found[name].tobytes() == written(run, name).tobytes() for name in run.variables)


def written(run: ps.Run, name: str) -> np.ndarray:
    """A column of a table of a run: an input is written as it was given, and holds from its row on."""
    is_input = run.variables[name].role == "input"
    return np.append(run[name][1:], run[name][-1:]) if is_input else run[name]


def test_simulate_and_compare_another_model(folder: Path) -> None:
    (folder / "my.csv").write_text("time,driveVelocity\n0,0.1\n0.1,-0.1\n", encoding="utf-8")
    bench = ps.Model("FrictionBench")
    given = {"inputs": {"driveVelocity": ([0.0, 0.1], [0.1, -0.1])}, "stop": 0.1, "step": 1e-3}
    assert main(["simulate", "my.csv", "--model", "FrictionBench", "--out", "a.csv"]) == 0
    run = bench.simulate(**given)  # type: ignore[arg-type]
    found = columns_of(folder / "a.csv")
    assert found.keys() == {"time", *run.variables} and all(
        found[name].tobytes() == written(run, name).tobytes() for name in run.variables
    )
    assert main(["compare", "my.csv", "--model", "FrictionBench", "--laws", "Dahl,None", "--out", "b.csv"]) == 0
    assert rows_of(folder / "b.csv") == compared(bench.compare(["Dahl", "None"], progress=False, **given))  # type: ignore[arg-type]


def rows_of(file: Path) -> list[tuple[str, ...]]:
    with file.open(encoding="utf-8", newline="") as stream:
        return [tuple(row) for row in csv.reader(stream)][1:]


def compared(comparison: ps.Comparison) -> list[tuple[str, ...]]:
    return [(law, *(repr(fact) for fact in facts)) for law, *facts in comparison.rows()]


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        ([], {}),
        (["--set", "mass.moving=2"], {"parameters": {"mass.moving": 2.0}}),
        (["--stop", "0.1"], {"stop": 0.1}),
        (["--step", "0.01"], {"step": 0.01}),
    ],
)
def test_compare(folder: Path, options: list[str], arguments: dict[str, object]) -> None:
    laws = ["LuGre", "Stribeck"]
    assert main(["compare", "my.csv", "--laws", ",".join(laws), "--out", "a.csv", *options]) == 0
    given = {"inputs": VOLTAGE, "stop": 0.25, "step": 1e-3, "progress": False} | arguments
    assert rows_of(folder / "a.csv") == compared(ps.Model().compare(laws, **given))  # type: ignore[arg-type]


@pytest.mark.parametrize("command", [["simulate", "my.csv"], ["compare", "my.csv", "--laws", "Dahl,GMS"]])
@pytest.mark.parametrize("name", ["a.png", "a.svg"])
def test_figure_is_of_the_format_of_its_ending(folder: Path, command: list[str], name: str) -> None:
    assert main([*command, "--plot", name]) == 0
    start = {"a.png": b"\x89PNG", "a.svg": b"<?xml"}[name]
    assert (folder / name).read_bytes().startswith(start) and (folder / name).stat().st_size > 10_000


POINT = {"velocity": 0.05, "valve.hysteresis": 0.0}
AT = ["--at", "velocity=0.05,valve.hysteresis=0"]


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        (AT, {"at": POINT}),
        ([*AT, "--law", "LuGre"], {"at": POINT | {"friction.law": "LuGre"}}),
        ([*AT, "--set", "mass.moving=2"], {"at": POINT | {"mass.moving": 2.0}}),
        ([*AT, "--no-trim"], {"at": POINT, "trim": False}),
        ([*AT, "--inputs", "externalForce,valveVoltage"], {"at": POINT, "inputs": ["externalForce", "valveVoltage"]}),
        ([*AT, "--outputs", "frictionForce"], {"at": POINT, "outputs": ["frictionForce"]}),
    ],
)
def test_linearise(
    folder: Path, capsys: pytest.CaptureFixture[str], options: list[str], arguments: dict[str, object]
) -> None:
    assert main(["linearise", "--out", "a.npz", *options]) == 0
    expected = ps.Model().linearise(**arguments)  # type: ignore[arg-type]
    assert capsys.readouterr().out == f"{expected}\n"
    with np.load(folder / "a.npz") as found:
        for name in ("A", "B", "C", "D", "x", "u", "y"):
            assert found[name].tobytes() == np.ascontiguousarray(getattr(expected, name)).tobytes(), name
        for name in ("states", "inputs", "outputs"):
            assert tuple(found[name].tolist()) == getattr(expected, name)


def test_linearise_in_nominal_units(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By hand: each entry times the unit of its column over the unit of its row."""
    assert main(["linearise", *AT, "--scaled", "--out", "a.npz"]) == 0
    plant = ps.Model()
    plain = plant.linearise(at=POINT)
    assert capsys.readouterr().out == f"{plain.scaled()}\n"
    row, column = plain.states.index("velocity"), plain.states.index("chamberA.pressure")
    units = [plant.variables[name].nominal for name in ("chamberA.pressure", "velocity")]
    with np.load(folder / "a.npz") as found:
        assert_close(found["A"][row, column], plain.A[row, column] * units[0] / units[1], rel=1e-14, what="A")
        assert_close(found["x"][column], plain.x[column] / units[0], rel=1e-14, what="x")


def test_linearise_another_model(capsys: pytest.CaptureFixture[str]) -> None:
    model = ps.Model("FrictionBench")
    [driven, *_] = model.inputs
    command = ["linearise", "--model", "FrictionBench", "--at", "friction.law=LuGre", "--inputs", driven, "--no-trim"]
    assert main([*command, "--outputs", "frictionForce"]) == 0
    expected = model.linearise({"friction.law": "LuGre"}, inputs=[driven], outputs=["frictionForce"], trim=False)
    assert capsys.readouterr().out == f"{expected}\n"


SHEET = {"bore": 32.0, "rod": 12.0, "stroke": 200.0, "mass": 5.0, "qn": 700.0}


@pytest.mark.parametrize(
    ("option", "argument", "parameter"),
    [
        (["--bore", "40"], {"bore": 40.0}, "cylinder.bore"),
        (["--rod", "16"], {"rod": 16.0}, "cylinder.rod"),
        (["--rod-a", "10"], {"rod_a": 10.0}, "cylinder.rodA"),
        (["--stroke", "150"], {"stroke": 150.0}, "cylinder.stroke"),
        (["--mass", "3"], {"mass": 3.0}, "mass.moving"),
        (["--qn", "350"], {"qn": 350.0}, "valve.C"),
        (["--kv", "0.5"], {"kv": 0.5}, "valve.C"),
        (["--cv", "0.5"], {"cv": 0.5}, "valve.C"),
        (["-C", "2"], {"conductance": 2.0}, "valve.C"),
        (["-b", "0.4"], {"critical_ratio": 0.4}, "valve.b"),
        (["--hose", "4x1500"], {"hose": (4.0, 1500.0)}, "hoseB.length"),
        (["--clearance", "8"], {"clearance": 8.0}, "chamberA.deadVolume"),
        (["--min-pressure", "0.3"], {"min_pressure": 0.3}, "friction.stribeck.Fs"),
        (["--supply", "7"], {"supply": 7.0}, "supplyPressure"),
    ],
)
def test_configure(folder: Path, option: list[str], argument: dict[str, object], parameter: str) -> None:
    flows = {"qn", "kv", "cv", "conductance"}
    # Of the flow there is exactly one.
    sheet = {name: value for name, value in SHEET.items() if not (name in flows and flows & argument.keys())}
    plain = [word for name, value in sheet.items() if name not in argument for word in (f"--{name}", str(value))]
    assert main(["configure", *plain, *option, "--out", "a.ssv"]) == 0
    given = {entry.name: entry.value for entry in DataSheet(**sheet | argument).entries()}  # type: ignore[arg-type]
    assert values_of(folder / "a.ssv") == given
    assert given[parameter] != {entry.name: entry.value for entry in DataSheet(**SHEET).entries()}.get(parameter)  # type: ignore[arg-type]


def values_of(file: Path) -> dict[str, float]:
    """The real values of a set of parameters."""
    elements = [one for one in ElementTree.parse(file).getroot().iter() if one.tag.endswith("}Parameter")]
    return {one.attrib["name"]: float(one[0].attrib["value"]) for one in elements if one[0].tag.endswith("}Real")}


FREE = ["friction.stribeck.Fc", "friction.stribeck.sigma2"]
KNOWN = {"friction.stribeck.Fs": 11.0, "friction.stribeck.vs": 0.012}


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        ([], {}),
        (["--fit", "friction.stribeck.Fc=8:1:20"], {"fit": "friction.stribeck.Fc=8:1:20"}),
        (["--validation", "0.4"], {"validation": 0.4}),
        (["--segment", "2"], {"segment": 2.0}),
        (["--play", "1e-4"], {"play": 1e-4}),
        (["--loss", "cauchy"], {"loss": "cauchy"}),
        (["--intervals", "bootstrap", "--seed", "3"], {"intervals": "bootstrap", "seed": 3}),
        (["--intervals", "profile"], {"intervals": "profile"}),
    ],
)
def test_fit(folder: Path, options: list[str], arguments: dict[str, object]) -> None:
    """Each changes what is written, and to what the package finds with it."""
    data = bench()
    file = write(folder / "bench.csv", data)
    assert fit(file, *options) == expected_fit(file, **arguments)
    if options:
        assert fit(file, *options) != fit(file)


def fit(file: Path, *options: str) -> dict[str, object]:
    known = ",".join(f"{name}={value}" for name, value in KNOWN.items())
    given = ["--experiment", "motion", "--law", "Stribeck", "--fit", ",".join(FREE), "--set", known, "--columns",
             COLUMNS, "--starts", "0"]  # fmt: skip
    if "--play" not in options:
        given += ["--play", "0"]
    assert main(["fit", str(file), *given, *options, "--json", "a.json"]) == 0
    return dict(json.loads(Path("a.json").read_text(encoding="utf-8")))


def expected_fit(file: Path, **arguments: object) -> dict[str, object]:
    given = {"experiment": "motion", "law": "Stribeck", "fit": FREE, "settings": KNOWN, "columns": COLUMNS,
             "starts": 0, "play": 0.0} | arguments  # fmt: skip
    return ps.fit(file, **given).as_dict()  # type: ignore[arg-type]


def test_options_of_a_fit_reach_it(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Options whose effect needs other data, by the arguments of the call."""
    called: list[dict[str, object]] = []
    found = ps.fit(bench(), experiment="motion", law="Coulomb", play=0.0, starts=0)

    def recorded(_: object, **given: object) -> ps.Fit:
        called.append(given)
        return found

    monkeypatch.setattr("pneumatic_servo.identification.fit", recorded)
    options = {"starts": 7, "rated": 2.5, "width": 0.1, "inputs": "lines", "law_error": 0.5}
    words = [word for name, value in options.items() for word in (f"--{name.replace('_', '-')}", str(value))]
    command = ["fit", "my.csv", "--experiment", "motion", "--law", "Coulomb", "--columns", COLUMNS, *words]
    assert main(command) == 0
    assert {name: called[0][name] for name in options} == options


def test_options_of_a_plan_reach_it(capsys: pytest.CaptureFixture[str]) -> None:
    known = {"friction.lugre.sigma0": 2e5}
    given = {"law": "LuGre", "experiment": "motion", "fit": "friction.lugre.Fc", "duration": 2.0, "step": 0.01,
             "stroke": 0.02}  # fmt: skip
    words = [word for name, value in given.items() for word in (f"--{name}", str(value))]
    assert main(["plan", *words, "--set", "friction.lugre.sigma0=2e5"]) == 0
    assert capsys.readouterr().out == f"{ps.plan(**given, settings=known)}\n"  # type: ignore[arg-type]
    assert f"{ps.plan(**given)}" != f"{ps.plan(**given, settings=known)}"  # type: ignore[arg-type]


def test_variables(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["variables", "drive", "velocity", "--model", "FrictionBench"]) == 0
    shown = capsys.readouterr().out
    bench = ps.Model("FrictionBench")
    for variables in (bench.inputs, bench.parameters, bench.outputs):
        matching = variables.matching("drive velocity")
        for variable in variables.values():
            assert (f"  {variable}\n" in shown) is (variable.name in matching), variable.name
    assert "driveVelocity" in shown


def test_play(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    page = folder / "index.html"
    page.write_text("<html>", encoding="utf-8")
    opened: list[str] = []
    monkeypatch.setattr("pneumatic_servo.playground.PAGE", page)
    monkeypatch.setattr("webbrowser.open", opened.append)
    assert main(["play", "--show-file"]) == 0 and not opened
    assert main(["play"]) == 0 and opened == [page.as_uri()]
    assert capsys.readouterr().out == f"{page}\n" * 2
    assert ps.play(browser=False) == page and len(opened) == 1

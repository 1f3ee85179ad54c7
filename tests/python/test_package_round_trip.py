"""Files that the package writes are read again, and tables of other programs."""

from __future__ import annotations

import re
import sys
import zipfile
from pathlib import Path

import numpy as np
import pandas
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.cli import main
from pneumatic_servo.tables import read_table
from scipy.io import savemat

Array = NDArray[np.float64]

STEP = 1e-3
TIMES = np.arange(0, 0.3, STEP)
VOLTAGES = 5.0 + 2.0 * np.sin(20.0 * TIMES)
INPUTS = {"valveVoltage": (TIMES, VOLTAGES)}


@pytest.fixture(scope="module")
def plant() -> ps.Model:
    return ps.Model()


@pytest.fixture(scope="module")
def run(plant: ps.Model) -> ps.Run:
    return plant.simulate({"supplyPressure": "6 bar"}, inputs=INPUTS, stop=0.3, step=STEP)


def test_parameters_are_read_from_the_file_they_were_written_to(plant: ps.Model, tmp_path: Path) -> None:
    sheet = ps.DataSheet(bore=32, rod=12, stroke=200, mass=5, qn=700, supply=6)
    file = tmp_path / "machine.ssv"
    sheet.to_ssv(file)
    assert ps.read_ssv(file) == sheet.settings
    arguments = {"inputs": INPUTS, "stop": 0.3, "step": STEP, "outputs": ["position"]}
    expected = plant.simulate(sheet.settings, **arguments)["position"].tobytes()
    for given in (file, str(file)):
        assert plant.simulate(given, **arguments)["position"].tobytes() == expected
    assert plant.start(file)["cylinder.bore"] == 0.032


def test_command_line_reads_what_it_wrote(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert (
        main(["configure", *["--bore", "32", "--stroke", "200", "--mass", "5", "--qn", "700", "--out", "my.ssv"]]) == 0
    )
    Path("u.csv").write_text("time,valveVoltage\n0,5\n0.1,7\n0.3,4\n", encoding="utf-8")
    again = ["--set", "my.ssv", "--set", "supplyPressure=6 bar,friction.law=LuGre", "--stop", "0.3"]
    assert main(["simulate", "u.csv", *again, "--out", "a.csv"]) == 0
    assert main(["simulate", "a.csv", *again, "--out", "b.csv"]) == 0
    assert Path("a.csv").read_bytes() == Path("b.csv").read_bytes()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<a/>", "it is no SSV"),
        ("time,u\n", "it is no XML"),
    ],
)
def test_file_that_is_no_ssv_is_named(plant: ps.Model, tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "a.ssv").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=rf"a\.ssv: {words}"):
        plant.start(tmp_path / "a.ssv")


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ('"nan"', "nan is not finite"),
        ('"1e999"', "1e999 is not finite"),
        ('"32" unit="mm"', "factor of mm: 'x' is no number"),
        ('"1e300" unit="km"', "inf is not finite"),
    ],
)
def test_number_of_a_file_that_is_none_is_named(plant: ps.Model, tmp_path: Path, value: str, words: str) -> None:
    ps.DataSheet(bore=32, stroke=200, mass=5, qn=700).to_ssv(tmp_path / "a.ssv")
    units = "".join(
        f'<ssc:Unit name="{unit}"><ssc:BaseUnit m="1" factor="{factor}"/></ssc:Unit>'
        for unit, factor in [("mm", "x"), ("km", "1e300")]
    )
    text = (tmp_path / "a.ssv").read_text(encoding="utf-8").replace('"0.032" unit="m"', value, 1)
    text = text.replace("</ssv:Parameters>", f"</ssv:Parameters><ssv:Units>{units}</ssv:Units>")
    (tmp_path / "a.ssv").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=re.escape(f"a.ssv: cylinder.bore: {words}")):
        plant.start(tmp_path / "a.ssv")


def test_cell_that_is_too_long_names_the_file(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(f'time,"{"a" * 200_000}"\n0,1\n', encoding="utf-8")
    with pytest.raises(ValueError, match=r"a\.csv:1, column 2: its name has 200000 characters"):
        ps.Model().simulate(inputs=tmp_path / "a.csv", stop=1)


def test_unknown_variable_of_a_file_is_answered(plant: ps.Model, tmp_path: Path) -> None:
    ps.DataSheet(bore=32, stroke=200, mass=5, qn=700).to_ssv(tmp_path / "a.ssv")
    text = (tmp_path / "a.ssv").read_text(encoding="utf-8").replace("cylinder.bore", "cylinder.bor")
    (tmp_path / "a.ssv").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"cylinder\.bor: .*did you mean cylinder\.bore"):
        plant.start(tmp_path / "a.ssv")


def test_run_is_replayed_bit_for_bit(plant: ps.Model, run: ps.Run, tmp_path: Path) -> None:
    run.to_csv(tmp_path / "run.csv")
    for given in (run, tmp_path / "run.csv", run.to_pandas()):
        again = plant.simulate({"supplyPressure": 6e5}, inputs=given, stop=0.3, step=STEP)
        assert again["position"].tobytes() == run["position"].tobytes()


def world(form: str) -> str:
    """A table of time, voltage and supply, in a form that somebody's tool writes."""
    rows = [(time, volt, 6.0) for time, volt in zip(TIMES.tolist(), VOLTAGES.tolist(), strict=True)]
    if form == "semicolons":
        lines = ["time;valveVoltage;supplyPressure[bar]", *(";".join(map(repr, row)).replace(".", ",") for row in rows)]
    elif form == "tabs":
        lines = ["time\tvalveVoltage\tsupplyPressure (bar)", *("\t".join(map(repr, row)) for row in rows)]
    elif form == "units":
        lines = ["time,valveVoltage,supplyPressure", "s,V,bar", *(",".join(map(repr, row)) for row in rows)]
    elif form == "comments":
        lines = ["# rig 3", "", "time,valveVoltage,supplyPressure [bar]", *(",".join(map(repr, row)) for row in rows)]
    else:
        lines = ["time valveVoltage supplyPressure[bar]", *("  ".join(map(repr, row)) for row in rows)]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("form", ["semicolons", "tabs", "units", "comments", "blanks"])
def test_tables_of_the_world_are_understood(plant: ps.Model, run: ps.Run, tmp_path: Path, form: str) -> None:
    (tmp_path / "a.csv").write_text(world(form), encoding="utf-8-sig")
    found = plant.simulate(inputs=tmp_path / "a.csv", stop=0.3, step=STEP)
    assert found["position"].tobytes() == run["position"].tobytes()


def test_time_in_ms_is_read_as_such(plant: ps.Model, run: ps.Run, tmp_path: Path) -> None:
    rows = (f"{1e3 * time!r},{volt!r}" for time, volt in zip(TIMES.tolist(), VOLTAGES.tolist(), strict=True))
    (tmp_path / "a.csv").write_text("\n".join(["time[ms],valveVoltage", *rows]), encoding="utf-8")
    found = plant.simulate({"supplyPressure": 6e5}, inputs=tmp_path / "a.csv", stop=0.3, step=STEP)
    assert np.allclose(found["position"], run["position"], atol=1e-7)


def test_tables_of_matlab_are_read(plant: ps.Model, run: ps.Run, tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"time": TIMES, "valveVoltage": VOLTAGES})
    found = plant.simulate({"supplyPressure": 6e5}, inputs=tmp_path / "a.mat", stop=0.3, step=STEP)
    assert found["position"].tobytes() == run["position"].tobytes()


def test_parquet_of_a_run_is_replayed_and_fitted_as_the_run(plant: ps.Model, run: ps.Run, tmp_path: Path) -> None:
    """Its inputs stand a row later than they were given, which the file has to tell."""
    file = tmp_path / "run.parquet"
    run.to_pandas().to_parquet(file)
    again = plant.simulate({"supplyPressure": 6e5}, inputs=file, stop=0.3, step=STEP)
    assert again["position"].tobytes() == run["position"].tobytes()
    run.to_csv(tmp_path / "run.csv")
    given = {"experiment": "rig", "law": "Stribeck", "fit": "valve.C=3e-9", "settings": {"supplyPressure": "6 bar"}}
    found = [ps.fit(data, starts=0, progress=False, **given) for data in (file, run, tmp_path / "run.csv")]
    values = [one.values["valve.C"] for one in found]
    assert values[0] == values[1] == values[2]
    # The record is a run of the default valve, without noise: the fit finds it but for rounding.
    assert_close(values[0], plant.parameters["valve.C"].default, rel=1e-14, what="valve.C")


def test_parquet_of_a_rig_has_its_units(plant: ps.Model, run: ps.Run, tmp_path: Path) -> None:
    columns = {"time [ms]": 1e3 * TIMES, "valveVoltage": VOLTAGES, "supplyPressure (bar)": 0.0 * TIMES + 6.0}
    pandas.DataFrame(columns).to_parquet(tmp_path / "a.parquet")
    found = plant.simulate(inputs=tmp_path / "a.parquet", stop=0.3, step=STEP)
    assert_close(found["position"], run["position"], within=5e-15, what="position")


def test_parquet_that_is_none_and_missing_packages_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "a.parquet"
    with pytest.raises(FileNotFoundError, match=r"a\.parquet: there is no such file"):
        read_table(file)
    file.write_text("time,valveVoltage\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"a\.parquet: it cannot be read"):
        read_table(file)
    for package in ("pyarrow", "pandas"):
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(ps.MissingPackage, match=rf"{package}.*: pip install 'pneumatic-servo\[parquet\]'"):
            read_table(file)


def test_line_with_another_separator_says_so(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time;valveVoltage\n0;5\n1,5\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"a\.csv:3: 1 values.* separated by semicolons, but this line has commas"):
        read_table(tmp_path / "a.csv")


def test_sets_of_the_fmu_are_at_hand(plant: ps.Model, fmus: Path) -> None:
    sets = ps.parameter_sets()
    with zipfile.ZipFile(fmus / "PneumaticServoCylinder.fmu") as archive:
        names = {Path(name).stem for name in archive.namelist() if name.startswith("resources/") and ".json" in name}
    assert set(sets) == names
    assert plant.start(sets["SlidingValvePolito"])["friction.polito.Fs"] == 4.2


def test_all_runs_are_one_table(plant: ps.Model) -> None:
    runs = plant.simulate_many(number=2, inputs={"valveVoltage": [6, 7]}, stop=0.01, step=STEP, progress=False)
    frame = runs.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and frame.index.names == ["run", "time"]
    assert frame.loc[1, "position"].to_numpy().tolist() == runs[1]["position"].tolist()


def test_notebooks_show_tables_and_complete_keys(plant: ps.Model, run: ps.Run) -> None:
    runs = plant.simulate_many(number=2, stop=0.01, step=STEP, progress=False)
    laws = plant.compare(["Stribeck", "LuGre"], stop=0.01, step=STEP, progress=False)
    for shown, word in [(plant, "valveVoltage"), (run, "position"), (runs, "position"), (laws, "LuGre")]:
        html = shown._repr_html_()
        assert "<table>" in html and word in html and html.count("<td") == html.count("</td>")
    assert "position" in run._ipython_key_completions_() and "position" in runs._ipython_key_completions_()
    assert "friction.law" in plant.parameters._ipython_key_completions_()
    assert laws._ipython_key_completions_() == ["Stribeck", "LuGre"]


def test_package_shows_what_it_has() -> None:
    names = dir(ps)
    assert {"fit", "plan", "Fit", "compare_fits", "linearise", "Options", "DataSheet", "read_ssv"} <= set(names)
    assert not {"Any", "TYPE_CHECKING", "find_spec"} & set(names)
    assert all(getattr(ps, name) is not None for name in ps.__all__)
    assert ps.__version__[0].isdigit()


def test_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0 and capsys.readouterr().out == f"pneumatic-servo {ps.__version__}\n"

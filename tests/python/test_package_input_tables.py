"""Tables of inputs whose columns somebody names, and that begin at any time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest

TIME = np.round(np.arange(0.0, 0.2, 1e-2), 6)
VOLTAGE = np.round(5.0 + np.sin(20.0 * TIME), 6)
SUPPLY = 6e5 + 1e5 * TIME
SPAN = {"stop": 0.15, "step": 1e-3}
MODEL = ps.Model()


@pytest.fixture(scope="module")
def wanted() -> ps.Run:
    return MODEL.simulate(inputs={"valveVoltage": (TIME, VOLTAGE), "supplyPressure": (TIME, SUPPLY)}, **SPAN)


def written(file: Path, begin: float = 0.0, every: int = 1) -> Path:
    rows = [
        f"{1e3 * (t + begin):g};{-u:g};{p / 1e5 if k % every == 0 else ''};on"
        for k, (t, u, p) in enumerate(zip(TIME, VOLTAGE, SUPPLY, strict=True))
    ]
    file.write_text("\n".join(["Zeit [ms];u;p / bar;state", *rows, ""]), encoding="utf-8")
    return file


COLUMNS = "time=Zeit,valveVoltage=-u,supplyPressure=p"


def test_columns_say_which_are_the_inputs(tmp_path: Path, wanted: ps.Run) -> None:
    """Units of the header count, a minus turns the sign, and other columns need not be numbers."""
    run = MODEL.simulate(inputs=written(tmp_path / "a.csv"), columns=COLUMNS, **SPAN)
    np.testing.assert_allclose(run["position"], wanted["position"], atol=1e-12)
    said = {"time": "Zeit", "valveVoltage": "-u[V]", "supplyPressure": "p / bar"}
    runs = MODEL.simulate_many(
        [{}, {"mass.moving": 5.0}], inputs=tmp_path / "a.csv", columns=said, progress=False, **SPAN
    )
    assert runs["position"][0].tobytes() == run["position"].tobytes()


def test_table_that_begins_later_is_counted_from_its_first_time(tmp_path: Path, wanted: ps.Run) -> None:
    file = written(tmp_path / "a.csv", begin=12.5)
    with pytest.warns(ps.PlantWarning, match=r"its first time is 12\.5 s, which counts as 0 s, where the run starts"):
        run = MODEL.simulate(inputs=file, columns=COLUMNS, **SPAN)
    np.testing.assert_allclose(run["position"], wanted["position"], atol=1e-9)
    # A run that starts there takes the times as they are.
    late = MODEL.simulate(inputs=file, columns=COLUMNS, start=12.5, stop=12.65, step=1e-3)
    np.testing.assert_allclose(late["position"], wanted["position"], atol=1e-9)


def test_slow_channel_has_its_own_samples(tmp_path: Path, wanted: ps.Run) -> None:
    """The supply runs on one straight line, so that every fourth sample tells as much."""
    run = MODEL.simulate(inputs=written(tmp_path / "a.csv", every=4), columns=COLUMNS, **SPAN)
    np.testing.assert_allclose(run["position"], wanted["position"], atol=1e-12)


def test_table_of_modelica_drives_the_run_that_wrote_it(tmp_path: Path, wanted: ps.Run) -> None:
    wanted.to_combi_table(tmp_path / "a.txt")
    run = MODEL.simulate(inputs=tmp_path / "a.txt", **SPAN)
    # Recorded inputs are those up to each row, one step late.
    np.testing.assert_allclose(run["position"], wanted["position"], atol=1e-4)


@pytest.mark.parametrize(
    ("columns", "refusal"),
    [
        ("time=Zeit", "no column is given for an input; the inputs are valveVoltage"),
        ("time=Zeit,valveVoltage=v", "there is no column v for valveVoltage"),
        ("time=Zeit,position=u", "there is no signal position"),
        ("time=Zeit,supplyPressure=u[mm]", "mm"),
        ("time=Zeit,valveVoltage=state", "is no number"),
    ],
)
def test_wrong_columns_are_refused(tmp_path: Path, columns: str, refusal: str) -> None:
    with pytest.raises(ValueError, match=refusal):
        MODEL.simulate(inputs=written(tmp_path / "a.csv"), columns=columns, **SPAN)


def test_columns_without_a_table_are_refused() -> None:
    with pytest.raises(ValueError, match="columns: these inputs are no table"):
        MODEL.simulate(inputs={"valveVoltage": 6}, columns="time=t,valveVoltage=u", **SPAN)


def test_mapping_of_arrays_takes_columns_as_a_table_does() -> None:
    time = np.arange(0, 1, 0.01)
    arrays = {"t [ms]": 1e3 * time, "F": 0.02 * np.sin(6.0 * time)}
    given = {"stop": 0.5, "step": 0.01, "outputs": ["velocity"]}
    bench = ps.Model("FrictionBench")
    run = bench.simulate({"bench.drive": "Free"}, inputs=arrays, columns="time=t,appliedForce=F[kN]", **given)
    same = bench.simulate({"bench.drive": "Free"}, inputs={"appliedForce": (time, 1e3 * arrays["F"])}, **given)
    assert np.max(np.abs(run["velocity"] - same["velocity"])) < 1e-12 < np.max(np.abs(run["velocity"]))

"""Files of a run for MATLAB and Modelica, read back by others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest
from pneumatic_servo.run_files import structures
from pneumatic_servo.tables import read_table
from scipy.io import loadmat

NAMES = ["valveVoltage", "position", "chamberA.pressure", "chamberB.pressure"]


@pytest.fixture(scope="module")
def run() -> ps.Run:
    return ps.Model().simulate(inputs={"valveVoltage": 6.0}, stop=0.02, step=1e-3, outputs=NAMES)


def test_mat_has_vectors_and_structures(run: ps.Run, tmp_path: Path) -> None:
    run.to_mat(tmp_path / "a.mat")
    found = loadmat(tmp_path / "a.mat", simplify_cells=True)
    np.testing.assert_array_equal(found["time"], run.time)
    np.testing.assert_array_equal(found["position"], run["position"])
    np.testing.assert_array_equal(found["chamberA"]["pressure"], run["chamberA.pressure"])
    # And it is a table here.
    assert read_table(tmp_path / "a.mat").names == ["time", *NAMES]


def test_combi_table_is_what_modelica_reads(run: ps.Run, tmp_path: Path) -> None:
    run.to_combi_table(tmp_path / "a.txt", name="rig")
    first, second, *rows = (tmp_path / "a.txt").read_text(encoding="utf-8").splitlines()
    assert first == "#1" and second.startswith(f"double rig({len(run.time)},5) # time, valveVoltage, position")
    values = np.array([[float(cell) for cell in row.split()] for row in rows])
    np.testing.assert_array_equal(values, np.array([run.time, *(run.given(name) for name in NAMES)]).T)
    with pytest.raises(ValueError, match="name='my run' is refused"):
        run.to_combi_table(tmp_path / "b.txt", name="my run")
    with pytest.raises(ValueError, match=r"b\.mat"):
        run.to_combi_table(tmp_path / "b.mat")


def test_names_that_are_both_a_column_and_a_structure_are_refused() -> None:
    one = np.zeros(2)
    assert structures({"a.b": one, "k[1]": one}).keys() == {"a", "k_1"}
    for names in (["a", "a.b"], ["a.b", "a"]):
        with pytest.raises(ValueError, match="record one of both"):
            structures(dict.fromkeys(names, one))

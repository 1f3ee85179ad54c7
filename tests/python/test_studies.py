"""The studies, run as a user runs them, at a small size."""

import csv
import subprocess
import sys
from pathlib import Path

from clusters import cluster

STUDIES = Path(__file__).parents[2] / "studies"


def run(study: str, *arguments: str | Path) -> str:
    done = subprocess.run([sys.executable, STUDIES / study, *arguments], text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_study_tells_how_to_get_dask(tmp_path: Path) -> None:
    without = (
        "import runpy, sys; sys.modules['dask.distributed'] = None; del sys.argv[0]; "
        "runpy.run_path(sys.argv[0], run_name='__main__')"
    )
    command = [sys.executable, "-c", without, STUDIES / "parameters.py", "--scheduler", "tcp://127.0.0.1:8786"]
    done = subprocess.run(command, text=True, capture_output=True, check=False, cwd=tmp_path)
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert "needs Dask" in done.stderr and "pip install 'dask[distributed]'" in done.stderr
    assert not list(tmp_path.iterdir())


def rows_of(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_explicit_euler_fails_at_a_millisecond_where_implicit_euler_does_not(tmp_path: Path) -> None:
    printed = run("integration_schemes.py", "--output", tmp_path).splitlines()
    [header] = [line for line in printed if "position deviation (m)" in line]
    [row] = [line for line in printed if line.split()[:2] == ["ExplicitEuler", "1e-05"]]
    assert len(header) == len(row), "the columns have no common width"
    assert (tmp_path / "integration_schemes.png").stat().st_size > 10_000
    rows = {(row["scheme"], float(row["step (s)"])): row for row in rows_of(tmp_path / "integration_schemes.csv")}
    assert float(rows["ExplicitEuler", 1e-3]["reached (s)"]) < 1.0
    complete = [("ExplicitEuler", 1e-5), ("ImplicitEuler", 1e-3), ("ImplicitEuler", 1e-5), ("RK4", 1e-4)]
    assert all(float(rows[run]["reached (s)"]) == 3.0 for run in complete)
    # Of first order: 10 us are a hundred times better than 1 ms, within a factor of two. The travel is 0.2 m.
    fine = float(rows["ExplicitEuler", 1e-5]["position deviation (m)"])
    coarse = float(rows["ImplicitEuler", 1e-3]["position deviation (m)"])
    assert fine < 2e-5 and 50 < coarse / fine < 200


def test_parameter_study_gives_the_same_rows_on_any_cluster(tmp_path: Path) -> None:
    laws = ["--laws", "Stribeck", "LuGre"]
    run("parameters.py", *laws, "--workers", "2", "--output", tmp_path / "own")
    with cluster(workers=2) as started:
        run("parameters.py", *laws, "--scheduler", started.scheduler_address, "--output", tmp_path / "given")
    run("parameters.py", *laws, "--processes", "2", "--output", tmp_path / "processes")
    rows = rows_of(tmp_path / "own" / "parameters.csv")
    assert rows == rows_of(tmp_path / "given" / "parameters.csv") == rows_of(tmp_path / "processes" / "parameters.csv")
    assert len(rows) == 2 * 9
    assert (tmp_path / "own" / "parameters.png").stat().st_size > 10_000
    # A wider valve moves the carriage further, under every law and dead zone.
    strokes = [float(row["stroke"]) for row in rows]
    assert all(a < b < c for a, b, c in zip(strokes[::3], strokes[1::3], strokes[2::3], strict=True))


def test_the_moving_picture_of_the_readme_is_what_its_study_draws(tmp_path: Path) -> None:
    run("moving_picture.py", tmp_path / "picture.svg")
    drawn = (tmp_path / "picture.svg").read_bytes()
    assert drawn == (STUDIES.parent / "docs" / "images" / "stick_slip.svg").read_bytes()
    assert len(drawn) < 1_000_000


def test_error_follows_the_tolerance(tmp_path: Path) -> None:
    printed = run("tolerance_ladder.py", "--output", tmp_path).splitlines()
    slopes = {line[:16].strip(): [float(cell) for cell in line[16:].split()] for line in printed[1:-1]}
    assert len(slopes) == 6 and (tmp_path / "tolerance_ladder.png").stat().st_size > 10_000
    # The jump is that from the midpoint rule, of order 2, to the classical method, of order 4.
    for law, (position, friction, *jumps) in slopes.items():
        assert 0.7 < position < 1.3 and 0.7 < friction < 1.3, law
        assert max(jumps) < 30.0, law
    rows = rows_of(tmp_path / "tolerance_ladder.csv")
    assert len(rows) == 6 * 25
    # Dahl, the stiffest, lacks 680 N times the tolerance.
    for row in rows:
        assert float(row["position error (m)"]) < float(row["tolerance"]), row
        assert float(row["friction force error, rms (N)"]) < 1000.0 * float(row["tolerance"]), row


def test_costliest_steps_are_counted(tmp_path: Path) -> None:
    run("costly_steps.py", "--laws", "Stribeck", "Dahl", "--output", tmp_path)
    stribeck, dahl = rows_of(tmp_path / "costly_steps.csv")
    assert stribeck["attempts median"] == dahl["attempts median"] == "1"
    worst = [int(row["attempts worst"]) for row in (stribeck, dahl)]
    # A stop takes some steps; a stiff bristle that turns back, some tens.
    assert 2 <= worst[0] <= 12 and 20 <= worst[1] <= 60, worst


def test_plans_are_held_against_what_is_then_found(tmp_path: Path) -> None:
    run("plans_kept.py", "--laws", "Coulomb", "--repetitions", "2", "--duration", "1", "--output", tmp_path)
    rows = rows_of(tmp_path / "plans.csv")
    assert [row["parameter"] for row in rows] == [
        "friction.coulomb.Fc",
        "friction.coulomb.sigma2",
        "valve.deadZone",
        "valve.C",
    ]
    # One second and the wider of two intervals: within a half.
    assert all(0.75 < float(row["of the fits (%)"]) / float(row["predicted (%)"]) < 1.5 for row in rows)
    assert (tmp_path / "plans.png").stat().st_size > 10_000


def test_gallery_draws_a_law_and_the_drive_follows_its_reference(tmp_path: Path) -> None:
    run("gallery.py", "--laws", "LuGre", "Stribeck", "--output", tmp_path)
    drawn = {file.relative_to(tmp_path).as_posix() for file in tmp_path.rglob("*.png")}
    laws = {f"{model}/{name}.png" for model in ("FrictionBench", "Festoon") for name in ("laws", "LuGre", "Stribeck")}
    assert laws | {"PositionController/PositionController.png"} <= drawn
    printed = run("drive.py", "--output", tmp_path)
    assert printed.count("rms error") == 2 and (tmp_path / "PneumaticServoDrive/PneumaticServoDrive.png").is_file()

"""The studies, run as a user runs them, at a small size."""

import csv
import subprocess
import sys
from pathlib import Path

from clusters import cluster

STUDIES = Path(__file__).parents[2] / "docs/studies"


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
    assert drawn == (STUDIES.parent / "images" / "stick_slip.svg").read_bytes()
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


def test_observer_compensates_friction_where_a_filtered_derivative_hunts(tmp_path: Path) -> None:
    run("friction_compensation.py", "--small", "--output", tmp_path)
    assert (tmp_path / "FrictionCompensation.png").stat().st_size > 10_000
    rows = {row["loop"]: row for row in rows_of(tmp_path / "FrictionCompensation.csv")}
    best, plain = rows["observer, compensated"], rows["filtered derivative"]
    assert float(best["RMS error (mm)"]) < 0.9 * float(plain["RMS error (mm)"])
    # With an integral part and stiction the loop hunts for ever; with the friction that is estimated it rests.
    assert int(plain["reversals at rest"]) > 0 and float(plain["hunting (mm)"]) > 1.0
    assert int(best["reversals at rest"]) == 0 and float(best["hunting (mm)"]) < 0.01
    assert abs(float(best["mean error at rest (mm)"])) < 0.5


def test_observer_knows_its_errors_under_each_law(tmp_path: Path) -> None:
    run("observer.py", "--small", "--output", tmp_path)
    assert (tmp_path / "Observer.png").stat().st_size > 10_000
    rows = rows_of(tmp_path / "Observer_laws.csv")
    kinds = [(row["law"], row["filter"]) for row in rows]
    assert kinds == [(law, own) for law in ("Stribeck", "LuGre", "MaxwellSlip") for own in ("extended", "unscented")]
    for row in rows:
        assert float(row["velocity within twice 95 %"]) > 0.95 and float(row["friction within twice 95 %"]) > 0.95
        assert float(row["velocity (mm/s rms)"]) < 0.1 * float(row["filtered derivative (mm/s rms)"])


def test_needle_of_a_cushion_has_one_best_setting(tmp_path: Path) -> None:
    run("cushions.py", "--small", "--output", tmp_path)
    assert (tmp_path / "Cushions.png").stat().st_size > 10_000
    rows = [
        {name: float(value or "nan") for name, value in row.items()}
        for row in rows_of(tmp_path / "Cushions.csv")
        if row["mass (kg)"] == "20.0"
    ]
    needles, blows, bounces, times = (
        [row[name] for row in rows] for name in ("needle (dm3/(s.bar))", "blow (m/s)", "bounce (mm)", "at rest (s)")
    )
    # Of the settings without a bounce the most closed one is softest, and soonest at rest of all.
    smooth = [place for place, bounce in enumerate(bounces) if bounce < 0.1]
    assert blows[smooth[0]] == min(blows[place] for place in smooth) < 0.5 * rows[0]["entry (m/s)"]
    assert times[smooth[0]] == min(times)
    # Wide open there is no cushion; nearly closed it is a spring of air.
    assert abs(blows[-1] / rows[-1]["entry (m/s)"] - 1.0) < 0.1
    assert bounces == sorted(bounces, reverse=True) and any(2.0 < bounce < 9.0 for bounce in bounces)
    assert all(row["reversals"] >= 2 for row in rows if row["bounce (mm)"] > 2.0)
    assert needles == sorted(needles)


def test_film_lags_at_its_own_frequencies_and_outlasts_a_stop(tmp_path: Path) -> None:
    run("film.py", "--small", "--output", tmp_path)
    assert (tmp_path / "Film.png").stat().st_size > 10_000
    areas: dict[str, list[float]] = {}
    for row in rows_of(tmp_path / "Film.csv"):
        areas.setdefault(row["law"], []).append(float(row["area (mN.m/s)"]))
    # The film has a frequency at which it lags most; bristles lag the more, the faster.
    film, bristles = areas["RevisedLuGre"], areas["LuGre"]
    peak = film.index(max(film))
    assert film[: peak + 1] == sorted(film[: peak + 1]) and 0 < peak < len(film) - 2
    assert film[peak:-1] == sorted(film[peak:-1], reverse=True) and bristles == sorted(bristles)
    for row in rows_of(tmp_path / "Film_rests.csv"):
        closed = float(row["film in closed form"])
        assert abs(float(row["film"]) - closed) < 2e-6
        # Pulled at 1 mm/s, at which the Stribeck curve has fallen by 1 % and a grown film starts to go.
        assert abs(float(row["break-away (N)"]) - 11.0 * (1.0 - closed)) < 0.15


def test_drift_is_identified_and_a_rest_is_remembered(tmp_path: Path) -> None:
    run("drift.py", "--small", "--output", tmp_path)
    assert (tmp_path / "Drift.png").stat().st_size > 10_000
    true = {row["record"]: row for row in rows_of(tmp_path / "Drift_true.csv")}
    for row in rows_of(tmp_path / "Drift.csv"):
        # One cycle, with one reversal that sticks each way.
        assert abs(float(row["value"]) / float(true[row["record"]][row["parameter"]]) - 1.0) < 0.02, row
        assert row["moves"] == "True"
    courses: dict[str, list[tuple[float, float]]] = {}
    for row in rows_of(tmp_path / "Drift_rests.csv"):
        courses.setdefault(row["law"], []).append((float(row["rest (s)"]), float(row["break-away (N)"])))
    # By the equation of the law, less what the spring needs to be stretched.
    assert all(abs(force - (11.0 + 7.0 * rest / (rest + 43_200.0))) < 0.03 for rest, force in courses["Stribeck"])
    for law, course in courses.items():
        growth = course[-1][1] - course[0][1]
        assert growth > 0.05 if law != "CoulombStiction" else abs(growth) < 1e-6, f"{law}: {growth} N in 10 minutes"


def test_sensitivities_of_random_runs_are_those_of_differences(tmp_path: Path) -> None:
    run("slopes.py", "--draws", "8", "--seed", "5", "--workers", "2", "--output", tmp_path)
    rows = rows_of(tmp_path / "slopes.csv")
    verdicts = [row["verdict"] for row in rows]
    assert len({row["number"] for row in rows}) == 8 and verdicts.count("right") >= 16, verdicts
    assert not [row for row in rows if row["verdict"] == "wrong"]
    assert all(row["reason"] for row in rows if row["verdict"] == "refused")

"""Draws from the posterior: against closed forms, by seed, on to ArviZ and to bands around predictions."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

import arviz
import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.cli import main
from test_identification import COLUMNS, bench, write

Array = NDArray[np.float64]
FC, SIGMA2 = "friction.coulomb.Fc", "friction.coulomb.sigma2"
GIVEN: dict[str, Any] = {"experiment": "motion", "law": "Coulomb", "play": 0.0, "starts": 0, "progress": False}


def line(seed: int = 0, hanging: float = 0.0) -> tuple[dict[str, Array], Array]:
    """Coulomb friction with noise, of which a share hangs together, and the two courses that it is made of."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 10.0, 0.01)
    position = 0.02 * np.sin(2.0 * np.pi * 0.31 * time)
    speed = np.append(0.0, np.diff(position) / 0.01)
    noise = rng.standard_normal(len(time))
    for k in range(1, len(noise)):
        noise[k] = hanging * noise[k - 1] + np.sqrt(1.0 - hanging**2) * noise[k]
    design = np.column_stack([np.sign(speed), speed])
    force = design @ [7.0, 25.0] + 0.5 * noise
    return {"time": time, "position": position, "frictionForce": force}, design


@cache
def fitted() -> ps.Fit:
    """The fit with a posterior that most tests look at: its sampling takes the time."""
    return ps.fit(line()[0], **GIVEN, posterior=True)


def test_draws_of_a_line_are_those_of_its_regression() -> None:
    data, design = line()
    found = fitted()
    assert found.posterior is not None and found.posterior.converged
    # Most proposals are of a t about the solution, which is near to what is drawn from: most are taken, not all.
    assert 0.3 < found.posterior.acceptance < 1.0
    # Without motion the experiment compares nothing.
    moving = found.problem.windows[0].used
    rows, force = design[moving], data["frictionForce"][moving]
    best, squares, *_ = np.linalg.lstsq(rows, force)
    deviations = np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)) * squares[0] / len(force))
    for name, mean, deviation in zip((FC, SIGMA2), best, deviations, strict=True):
        draws = found.posterior.draws[name]
        # 1000 independent draws tell a mean to 3 % of a deviation; four times that.
        assert abs(np.mean(draws) - mean) < 0.13 * deviation, name
        # Never narrower than of independent residuals; twenty blocks make it up to 1.5 times as wide.
        assert 0.93 * deviation < np.std(draws) < 1.5 * deviation, name
        # 1000 independent draws tell a width to a twentieth.
        low, high = found.posterior.interval(name)
        one = found.parameters[name]
        assert_close(high - low, one.high - one.low, rel=0.1, what=name)


def test_residuals_that_hang_together_widen_the_draws() -> None:
    white, hanging = fitted().posterior, ps.fit(line(hanging=0.9)[0], **GIVEN, posterior=True).posterior
    assert white is not None and hanging is not None
    # The sum of n such residuals varies by sqrt(1.9/0.1) = 4.4 times as much; twenty blocks tell it to a half.
    assert np.std(hanging.draws[FC]) > 2.0 * np.std(white.draws[FC])
    low, high = hanging.interval(FC)
    assert low < 7.0 < high


def test_draws_are_those_of_the_seed_whoever_makes_them() -> None:
    first, again, other = (ps.fit(line()[0], **GIVEN, posterior=True, seed=seed).posterior for seed in (1, 1, 2))
    with ThreadPoolExecutor(2) as executor:
        there = ps.fit(line()[0], **GIVEN, posterior=True, seed=1, executor=executor).posterior
    assert first is not None and again is not None and other is not None and there is not None
    assert np.array_equal(first.draws[FC], again.draws[FC])
    # Searches with and without an executor end in the same digits but for the last ones.
    assert_close(there.interval(FC), first.interval(FC), rel=1e-14, what="interval")
    assert not np.array_equal(first.draws[FC], other.draws[FC])


def test_arviz_reads_the_draws() -> None:
    found = fitted().posterior
    assert found is not None
    table = arviz.summary(found.to_inference_data(), round_to="none")
    assert list(table.index) == [FC, SIGMA2]
    assert_close(table["mean"][FC], float(np.mean(found.draws[FC])), rel=1e-14, what="mean")
    assert float(table["r_hat"].max()) < 1.05 and float(table["ess_bulk"].min()) > 500.0
    # Two ways to tell how many draws count, from chains that are not wholly independent.
    assert_close(table["ess_bulk"][FC], found.effective[FC], rel=0.5, what="independent draws")


def test_band_around_a_prediction_has_the_spread_of_its_draws(tmp_path: Path) -> None:
    found = fitted().posterior
    assert found is not None
    common = {"bench.drive": "PrescribedMotion", "driveVelocity": 0.1, "position0": 0.0}
    band = found.predict(number=400, common=common, stop=0.1, step=0.01, outputs=["frictionForce"], progress=False)
    low, middle, high = band.of("frictionForce")
    # While it slides at 0.1 m/s friction is Fc + 0.1 sigma2.
    expected = np.quantile(found.draws[FC] + 0.1 * found.draws[SIGMA2], [0.025, 0.5, 0.975])
    assert_close([low[-1], middle[-1], high[-1]], expected, rel=5e-3, what="band")
    assert high[-1] - low[-1] > 0.5 * (expected[2] - expected[0]) > 0.0
    assert low[-1] < 9.5 < high[-1]
    band.to_csv(tmp_path / "band.csv")
    table = np.genfromtxt(tmp_path / "band.csv", delimiter=",", names=True, deletechars="")
    assert table.dtype.names == ("time", "frictionForce.low", "frictionForce", "frictionForce.high")
    assert np.array_equal(table["frictionForce.high"], high)
    narrow = band.of("frictionForce", level=0.5)
    assert low[-1] < narrow[0][-1] < narrow[1][-1] < narrow[2][-1] < high[-1]
    band.to_csv(tmp_path / "narrow.csv", level=0.5)
    half = np.genfromtxt(tmp_path / "narrow.csv", delimiter=",", names=True, deletechars="")
    assert np.array_equal(half["frictionForce.low"], narrow[0])
    figure = band.plot("frictionForce", level=0.5)
    assert "50 % of draws" in [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert figure.axes[0].get_ylabel() == "frictionForce (N)"
    [drawn] = figure.axes[0].collections
    # Its outline begins and ends with a point of its own.
    assert set(drawn.get_paths()[0].vertices[1:-1, 1]) == {*narrow[0], *narrow[2]}


def test_band_beyond_the_data_is_told(recwarn: pytest.WarningsRecorder) -> None:
    found = fitted()
    assert found.posterior is not None
    _, fastest = found.ranges.limits["velocity"]
    given = {"number": 5, "stop": 0.1, "step": 0.01, "progress": False}
    for outputs in (["velocity"], ["position"]):
        common = {"bench.drive": "PrescribedMotion", "position0": 0.0}
        found.posterior.predict(**given, common={**common, "driveVelocity": 0.9 * fastest}, outputs=outputs)
        assert not [one for one in recwarn if "extrapolation" in str(one.message)]
        with pytest.warns(ps.PlantWarning, match="is an extrapolation: velocity reaches"):
            found.posterior.predict(**given, common={**common, "driveVelocity": 2.0 * fastest}, outputs=outputs)


def test_command_writes_the_draws(tmp_path: Path) -> None:
    file = write(tmp_path / "bench.csv", bench())
    code = main([
        "fit", str(file), "--experiment", "motion", "--law", "Stribeck", "--columns", COLUMNS, "--play", "0",
        "--starts", "0", "--posterior", str(tmp_path / "draws.csv"),
    ])  # fmt: skip
    assert code == 0
    names = [f"friction.stribeck.{name}" for name in ("Fs", "Fc", "vs", "sigma2")]
    table = np.genfromtxt(tmp_path / "draws.csv", delimiter=",", names=True, deletechars="")
    assert table.dtype.names == ("chain", "draw", *names)
    assert len(table) >= 1000 and all(np.ptp(table[name]) > 0.0 for name in names)


def test_interrupt_leaves_the_fit() -> None:
    def tell(text: str) -> None:
        if text == "posterior":
            raise KeyboardInterrupt

    with pytest.raises(ps.Interrupted) as caught:
        ps.fit(line()[0], **GIVEN | {"progress": tell}, posterior=True)
    found = caught.value.finished
    assert isinstance(found, ps.Fit) and found.converged and found.posterior is None


def test_what_cannot_be_drawn_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="loss huber"):
        ps.fit(line()[0], **GIVEN, posterior=True, loss="huber")
    found = fitted().posterior
    assert found is not None
    with pytest.raises(KeyError, match=r"friction\.stribeck\.Fs is not free"):
        found.interval("friction.stribeck.Fs")
    with pytest.raises(ValueError, match=r"level = 95 is refused"):
        found.interval(FC, 95)
    with pytest.raises(ValueError, match=r"number = 0 is refused"):
        found.predict(number=0)
    with pytest.raises(ValueError, match=r"number = 1000000 is refused: there are"):
        found.predict(number=1_000_000)
    with pytest.raises(ValueError, match=r"friction\.coulomb\.Fc is refused: it is drawn"):
        found.predict(common={FC: 3.0})
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(ps.MissingPackage, match=r"needs emcee: pip install 'pneumatic-servo\[posterior\]'"):
        ps.fit(line()[0], **GIVEN, posterior=True)

"""Sampling of posteriors: densities, proposals and starting points, of problems that are known as a whole."""

from __future__ import annotations

import re
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.figures import BLUE
from pneumatic_servo.identification import sampling
from pneumatic_servo.identification.band import Band
from pneumatic_servo.identification.intervals import Linearised
from pneumatic_servo.identification.posterior import Posterior, _asked
from pneumatic_servo.identification.problem import FAILED
from pneumatic_servo.identification.ranges import Ranges
from pneumatic_servo.identification.sampling import Density, _By, _inside, _root, density
from pneumatic_servo.identification.signals import Units
from scipy.stats import norm
from scipy.stats import t as student

Array = NDArray[np.float64]
ROUND = "other libraries of linear algebra round otherwise"

RNG = np.random.default_rng(11)
SLOPES, MEASURED = RNG.standard_normal((40, 3)), RNG.standard_normal(40)
"""Of two parameters and of what a window begins with."""
PULL = np.array([0.5, 0.0, 0.0])
BOUND = np.array([3.0, 3.0, np.inf])


def linear() -> Any:
    """A problem whose residuals are straight; the first parameter is drawn to 0, both are bounded by 3 either way."""
    return SimpleNamespace(
        free=[None, None], bounds=(-BOUND, BOUND), pull=PULL, pulls=lambda x: PULL * x,
        residuals=lambda vectors: np.array([SLOPES @ x - MEASURED for x in vectors]),
    )  # fmt: skip


def solution() -> Array:
    rows = np.vstack([SLOPES, np.diag(PULL)])
    return np.asarray(np.linalg.lstsq(rows, np.append(MEASURED, np.zeros(3)))[0])


def test_density_is_that_of_a_regression_with_the_beginning_fitted_along() -> None:
    x = solution()
    basis = np.linalg.qr(SLOPES[:, 2:])[0]
    target = Density(linear(), x, np.array([1.0, 2.0]), basis)
    places = [x[:2] + step for step in ([0.0, 0.0], [0.1, -0.3], [-0.2, 0.05])]
    found = target(places)
    expected = []
    for place in places:
        # The second is stretched: what is half as far off counts.
        own = x[:2] + (place - x[:2]) / [1.0, 2.0]
        rest = MEASURED - SLOPES[:, :2] @ own
        [cost] = np.linalg.lstsq(SLOPES[:, 2:], rest)[1]
        expected.append(-0.5 * (cost + (0.5 * own[0]) ** 2))
    assert_close(found, expected, rel=1e-13, what="density", why="of sums of squares")


def test_what_is_beyond_bounds_or_cannot_be_simulated_has_no_density() -> None:
    problem = linear()
    target = Density(problem, solution(), np.ones(2), np.zeros((40, 0)))
    assert target([np.array([3.1, 0.0]), np.array([0.0, -3.1])]).tolist() == [-np.inf] * 2
    on, off, inside = target([np.array([3.0, -3.0]), np.array([0.0, 3.1]), np.zeros(2)])
    assert np.isfinite(on) and off == -np.inf and np.isfinite(inside)
    # One sample that failed, in either direction.
    plain = problem.residuals
    for worst in (FAILED, -FAILED):
        problem.residuals = lambda vectors, worst=worst: np.array([
            np.where(np.arange(40) == 7, worst, row) if x[0] > 1.0 else row
            for x, row in zip(vectors, plain(vectors), strict=True)
        ])  # fmt: skip
        broken, fine = target([np.array([2.0, 0.0]), np.array([0.0, 0.0])])
        assert broken == -np.inf and fine == inside


@pytest.mark.parametrize("begins", [0, 1])
def test_covariance_is_that_of_a_regression_as_wide_as_the_intervals(
    begins: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Intervals of one parameter three times as wide, and of the other narrower, which is not believed."""
    problem, x = linear(), solution()[: 2 + begins]
    rows = np.vstack([SLOPES[:, : 2 + begins], np.diag(PULL[: 2 + begins])])
    normal = np.linalg.inv(rows.T @ rows)[:2, :2]
    slopes = SLOPES[:, : 2 + begins]
    lines = Linearised(slopes, MEASURED, np.zeros(40, dtype=int), np.zeros(40, dtype=int))
    monkeypatch.setattr(sampling, "linearised", lambda of, at: lines if of is problem and at is x else None)
    monkeypatch.setattr(sampling, "jacobian", lambda of, at: slopes if of is problem and at is x else None)
    factor = student.ppf(0.975, 9)
    wide = np.diag(normal) * (np.array([3.0, 0.5]) * norm.ppf(0.975) / factor) ** 2
    monkeypatch.setattr(sampling, "covariance", lambda of: (np.diag(wide), np.full(2, factor)))
    target, spread = density(problem, x)
    assert_close(target.stretch, [3.0, 1.0], rel=1e-13, what="stretch", why=ROUND)
    assert_close(spread, normal * np.outer([3.0, 1.0], [3.0, 1.0]), rel=1e-13, what="covariance", why="of an inverse")
    assert target.problem is problem and target.x is x and target.basis.shape == (40, begins)
    if begins:
        beside = slopes[:, 2] / np.linalg.norm(slopes[:, 2])
        assert_close(np.abs(target.basis[:, 0] @ beside), 1.0, rel=1e-13, what="basis", why=ROUND)


def test_root_has_its_matrix_as_square() -> None:
    mixed = np.random.default_rng(12).standard_normal((3, 3))
    matrix = mixed @ mixed.T
    assert_close(_root(matrix) @ _root(matrix).T, matrix, within=1e-13, what="matrix", why="of eigenvalues")
    # A direction that is not told is one magnitude wide.
    found = _root(np.diag([4.0, 1e-17, 9.0]))
    assert_close(np.diag(found @ found.T), [4.0, 1.0, 9.0], rel=1e-13, what="squares", why=ROUND)


def test_starts_beyond_bounds_are_drawn_half_the_way_back() -> None:
    middle = np.array([1.0, 0.0])
    places = np.array([[2.0, 2.0], [9.0, 1.0], [1.0, -20.0], [-3.0, 3.0]])
    found = _inside(linear(), places, middle)
    # From 9 by 8, 4 and 2 to 3; from -20 by 20, 10, 5 and 2.5. On a bound is within.
    assert found.tolist() == [[2.0, 2.0], [3.0, 0.25], [1.0, -2.5], [-3.0, 3.0]]


def test_executor_looks_at_as_many_pieces_on_each() -> None:
    looked: list[int] = []

    def target(vectors: list[Array]) -> Array:
        looked.append(len(vectors))
        return np.array([x[0] for x in vectors])

    vectors = np.arange(22.0).reshape(11, 2)
    with ThreadPoolExecutor(1) as executor:
        assert _By(executor, target)(vectors).tolist() == vectors[:, 0].tolist()  # type: ignore[arg-type]
        assert looked == [2, 2, 2, 1, 1, 1, 1, 1]
        looked.clear()
        assert _By(executor, target)(vectors[:3]).tolist() == [0.0, 2.0, 4.0]  # type: ignore[arg-type]
        assert looked == [1, 1, 1]


def test_pieces_that_wait_are_given_up_with_the_one_that_fails() -> None:
    tasks: list[Future[Array]] = []

    class Waiting(Executor):
        def submit(self, *_: Any, **__: Any) -> Any:
            tasks.append(Future())
            if len(tasks) == 1:
                tasks[0].set_exception(KeyboardInterrupt())
            return tasks[-1]

    none: Any = None
    with pytest.raises(KeyboardInterrupt):
        _By(Waiting(), none)(np.zeros((8, 1)))
    assert len(tasks) == 8 and all(task.cancelled() for task in tasks[1:])


FC = "friction.coulomb.Fc"


def posterior(**given: Any) -> Posterior:
    """Two chains of three draws of a friction force and of a gain, which the bench does not have."""
    draws = {FC: np.array([[1.0, 2.0, 3.0], [10.0, 20.0, 30.0]]), "gain.force": np.full((2, 3), 0.5)}
    usual: dict[str, Any] = {
        "draws": draws, "units": {FC: "N", "gain.force": "1"}, "log_density": -np.arange(6.0).reshape(2, 3),
        "effective": {FC: 1000.0, "gain.force": 1234.5}, "r_hat": {FC: 1.0, "gain.force": 1.0499},
        "acceptance": 0.5, "model": "FrictionBench", "settings": {"friction.law": "Coulomb"}, "ranges": Ranges({}),
    }  # fmt: skip
    return Posterior(**{**usual, **given})


def test_posterior_is_shown_line_by_line() -> None:
    assert repr(posterior()).splitlines() == [
        "posterior: 2 chains of 3 draws, converged",
        # Quantiles 2.5 % of six values are an eighth of the way from the first to the second.
        "  friction.coulomb.Fc  11 [1.125, 28.75] N  R-hat 1.000, 1000 independent draws",
        "  gain.force           0.5 [0.5, 0.5] 1  R-hat 1.050, 1234 independent draws",
    ]
    assert posterior().interval(FC, 0.2) == (3.0, 10.0)
    for changed in ({"r_hat": {FC: 1.0, "gain.force": 1.051}}, {"effective": {FC: 999.9, "gain.force": 2000.0}}):
        assert repr(posterior(**changed)).startswith("posterior: 2 chains of 3 draws, not converged")


def test_draws_are_written_chain_by_chain(tmp_path: Path) -> None:
    posterior().to_csv(tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines() == [
        f"chain,draw,{FC},gain.force",
        *(f"{chain},{draw},{(draw + 1.0) * 10.0**chain},0.5" for chain in range(2) for draw in range(3)),
    ]


def test_draws_are_spread_over_chains_and_steps() -> None:
    assert {name: values.tolist() for name, values in posterior().settings_of(6).items()} == {
        FC: [1.0, 10.0, 2.0, 20.0, 3.0, 30.0]
    }
    assert posterior().settings_of(3)[FC].tolist() == [1.0, 2.0, 30.0] and posterior().settings_of(1)[FC] == [1.0]
    with pytest.raises(ValueError, match=r"^number = 7 is refused: there are 6 draws$"):
        posterior().settings_of(7)


def test_prediction_runs_each_draw_with_what_all_share() -> None:
    """While it slides at 0.1 m/s friction is what was drawn; sigma2 of the fit gives way to what is asked."""
    known = {"friction.law": "Coulomb", "friction.coulomb.sigma2": 99.0}
    given = {"bench.drive": "PrescribedMotion", "driveVelocity": 0.1, "friction.coulomb.sigma2": 20.0}
    turning = Units(is_rotating=True)
    with pytest.warns(ps.PlantWarning, match=r"^this prediction is an extrapolation: ") as told:
        band = posterior(settings=known, ranges=Ranges({"frictionForce": (0.0, 10.0)}, turning)).predict(
            number=6, common=given, stop=0.5, step=0.1, outputs=["frictionForce"], progress=False
        )
    assert len(told) == 1 and "frictionForce reaches" in str(told[0].message)
    assert_close(band.runs["frictionForce"][:, -1], 2.0 + np.array([1.0, 10.0, 2.0, 20.0, 3.0, 30.0]), rel=1e-6,
                 what="friction", why="of a run")  # fmt: skip
    assert band.units is turning
    with pytest.raises(ValueError, match=rf"^common {re.escape(FC)} is refused: it is drawn from the posterior$"):
        posterior().predict(number=6, common={FC: 1.0})


class Recorded(dict[str, Array]):
    """Runs with what they have recorded."""

    time = np.array([0.0, 0.1, 0.2])

    @property
    def variables(self) -> list[str]:
        return list(self)


def test_what_is_asked_are_numbers_and_courses() -> None:
    """The velocity is the slope of the position, unless it was recorded."""
    position, none = np.array([[0.0, 1.0, 2.0], [0.0, -2.0, -4.0]]), (np.zeros(2), np.zeros(2))
    runs: Any = Recorded(position=position)
    asked = _asked(runs, {"supplyPressure": 6, "valveVoltage": none, "balance.enabled": True})
    assert asked.keys() == {"supplyPressure", "position", "velocity"} and asked["supplyPressure"] == 6.0
    assert_close(asked["velocity"], np.outer([10.0, -20.0], np.ones(3)), rel=1e-14, what="velocity")
    runs["velocity"] = np.ones((2, 3))
    assert np.all(_asked(runs, {})["velocity"] == 1.0)


@pytest.mark.parametrize(("units", "label", "factor"), [(Units(), "mm", 1e3), (Units(is_rotating=True), "rad", 1.0)])
def test_band_is_drawn_between_its_quantiles(units: Units, label: str, factor: float, tmp_path: Path) -> None:
    """Of five draws the middle half is from the second to the fourth."""

    class Drawn(Recorded):
        @property
        def variables(self) -> Any:
            return {name: ps.Model("FrictionBench").variables[name] for name in self}

    position = np.arange(5.0)[:, None] * [0.0, 1.0, 2.0]
    runs: Any = Drawn(position=position, frictionForce=position + 10.0)
    band = Band(runs, units)
    assert np.array_equal(band.of("position", 0.5), np.outer([1.0, 2.0, 3.0], [0.0, 1.0, 2.0]))
    band.to_csv(tmp_path / "a.csv", 0.5)
    assert (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines() == [
        "time,position.low,position,position.high,frictionForce.low,frictionForce,frictionForce.high",
        "0.0,0.0,0.0,0.0,10.0,10.0,10.0", "0.1,1.0,2.0,3.0,11.0,12.0,13.0", "0.2,2.0,4.0,6.0,12.0,14.0,16.0",
    ]  # fmt: skip
    upper, lower = band.plot(level=0.5).axes
    force = "N.m" if units.is_rotating else "N"
    assert [axis.get_ylabel() for axis in (upper, lower)] == [f"position ({label})", f"frictionForce ({force})"]
    assert [axis.get_xlabel() for axis in (upper, lower)] == ["", "time (s)"] and lower.get_legend() is None
    assert [text.get_text() for text in upper.get_legend().get_texts()] == ["50 % of draws", "median"]
    [median] = upper.get_lines()
    assert_close(median.get_xydata()[1:], np.column_stack([[0.1, 0.2], factor * np.array([2.0, 4.0])]), rel=1e-14,
                 what="median")  # fmt: skip
    outline = upper.collections[0].get_paths()[0].vertices
    assert {round(y / factor, 9) for y in outline[:, 1]} == {0.0, 1.0, 2.0, 3.0, 6.0}
    assert median.get_color() == BLUE and len(band.plot("frictionForce").axes) == 1
    assert upper.get_shared_x_axes().joined(upper, lower)

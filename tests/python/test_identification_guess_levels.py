"""Starts of the parameters of all laws, from friction that is known in closed form."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification.experiments import Experiment, Options, Values, Window
from pneumatic_servo.identification.fitting import make_experiment
from pneumatic_servo.identification.guess import _area, _elements, _length, _levels, deflection, springs
from pneumatic_servo.identification.parameters import parse, usual

Array = NDArray[np.float64]


class Mapped(Experiment):
    """A bench of which no more is known than speed, friction and load level at some samples."""

    seen: tuple[Array, Array, Array]

    def forces(self, window: Window, values: Values) -> tuple[Array, Array, Array] | None:
        return self.seen


def mapped(law: str, *, known: Sequence[str] = (), level: float = 1.0, peak: float = 4.0, viscous: float = 20.0) -> Any:
    """A problem of a stroke of 5 cm, sliding at 10 N and 20 N.s/m up to 0.1 m/s, which slowly takes 4 N more."""
    kind = make_experiment("motion", law, {}, Options())
    kind.__class__ = Mapped
    speed = np.clip(np.linspace(-0.11, 0.11, 2001), -0.1, 0.1)
    pace = np.abs(speed)
    force = 10.0 + viscous * pace + peak * (pace < 0.03)
    kind.seen = speed, np.sign(speed) * level * force, np.full(2001, level)
    every = [name for name in usual(law, kind.table, {}) if name.rpartition(".")[2] not in known]
    free = [parse(name, kind.table, ["frictionForce"]) for name in every]
    window = SimpleNamespace(record=SimpleNamespace(signals={"position": np.array([0.01, -0.02, 0.03])}))
    return SimpleNamespace(experiment=kind, free=free, windows=[window])


def by_element(**courses: Array) -> dict[str, float]:
    return {f"{name}[{k}]": value for name, course in courses.items() for k, value in enumerate(course.tolist(), 1)}


# Presliding ends at a fiftieth of the stroke, 1 mm; what is a function of speed has faded at a tenth of the fastest.
SLIDING = {"Fc": 10.0, "sigma2": 20.0}
CURVE = SLIDING | {"Fs": 14.0, "vs": 0.01}
# At the fastest speed the damping of bristles is a tenth of their force.
BRISTLE = {"sigma0": 10.0 / 1e-3, "sigma1": 0.1 * 10.0 / 0.1}


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        ("Coulomb", SLIDING),
        ("CoulombStiction", SLIDING | {"Fs": 14.0}),
        ("Stribeck", CURVE),
        ("SmoothCoulomb", SLIDING | {"vd": 0.1}),
        # Both ways have their own.
        ("Polito", {"Fs": 14.0, "vs": 0.01, "Fc1": 10.0, "Fc2": 10.0, "c1": 20.0, "c2": 20.0}),
        ("LuGre", CURVE | BRISTLE | {"vd": 0.1}),
        ("Dahl", SLIDING | {"sigma0": 1e4}),
        ("ElastoPlastic", CURVE | BRISTLE),
        ("StickSlipCreep", CURVE | {"sigma1": BRISTLE["sigma1"], "vd": 0.1, "Delta": 1e-3}),
        # Excess of static over sliding friction.
        ("Armstrong", SLIDING | BRISTLE | {"FsInf": 4.0, "vs": 0.01}),
        # A fast and a slow part, whose difference slides at 10 N.
        ("BlimanSorine", {"sigma2": 20.0, "f1": 30.0, "f2": 20.0, "xe": 1e-3}),
        # Twenty bristles are bent by two thirds on average.
        ("Bristle", {"sigma2": 20.0, "sigma0": 1.5 * 10.0 / (20.0 * 1e-3), "deltaS": 1e-3}),
        ("ResetIntegrator", {"sigma2": 20.0, "z0": 1e-3} | BRISTLE),
        # Six tenths of it with the curve, three with the length, of presliding.
        ("Leuven", CURVE | {"f1": 6.0, "f2": 3.0 / 1e-3, "k1": 3.0 / 1e-3, "sigma1": 10.0}),
        # Four elements of a quarter each.
        ("MaxwellSlip", {"sigma2": 20.0} | by_element(W=np.full(4, 2.5), k=np.full(4, 2.5e3))),
    ],
)  # fmt: skip
@pytest.mark.parametrize("level", [1.0, 0.5])
def test_levels_of_a_map_are_those_of_its_friction(law: str, expected: dict[str, float], level: float) -> None:
    """At any load, since they are divided by its level."""
    found = {name.rpartition(".")[2]: value for name, value in _levels(mapped(law, level=level), {}).items()}
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        assert_close(found[name], value, rel=2e-14, what="start")


def test_levels_stay_in_proportion() -> None:
    """Break-away at 1.1 to 3 times sliding friction, which is below a break-away that is known; some friction grows."""
    for peak, static in ((0.5, 11.0), (50.0, 30.0)):
        found = _levels(mapped("Stribeck", peak=peak), {})
        assert_close(found["friction.stribeck.Fs"], static, rel=1e-14, what="break-away")
    found = _levels(mapped("Stribeck", known=["Fs"]), {})
    default = float(ps.Model("FrictionBench").parameters["friction.stribeck.Fs"].default)
    assert_close(found["friction.stribeck.Fc"], 0.8 * default, rel=1e-14, what="sliding friction")
    # Without viscous friction that is free the middle is what slides, and a line that falls is none of it.
    level = _levels(mapped("Stribeck", known=["sigma2"], viscous=0.0), {})
    falling = _levels(mapped("Stribeck", viscous=-20.0), {})
    assert level["friction.stribeck.Fc"] == 10.0 and "friction.stribeck.sigma2" not in level
    # The middle of all that slides: at 55 mm/s.
    assert_close(falling["friction.stribeck.Fc"], 10.0 - 20.0 * 0.055, rel=0.02, what="middle of a falling line")
    assert_close(
        falling["friction.stribeck.sigma2"], 0.05 * falling["friction.stribeck.Fc"] / 0.1, rel=1e-14, what="least"
    )


def test_nothing_is_guessed_of_a_map_that_tells_nothing() -> None:
    problem = mapped("Stribeck")
    speed, force, level = problem.experiment.seen
    # Not even where a few samples move.
    still = np.where(np.arange(2001) < 15, speed, 0.0)
    for seen in (
        (0.0 * speed, force, level),
        (still, force, level),
        (speed, force, 0.0 * level),
        (speed[:9], force[:9], level[:9]),
    ):
        problem.experiment.seen = seen
        assert _levels(problem, {}) == {}
    problem.free = []
    problem.experiment.seen = speed, force, level
    assert _levels(problem, {}) == {}


WAY = 1e-3 * np.concatenate([np.arange(80.0), np.arange(80.0, 0.0, -1.0), np.arange(81.0)])
"""Up by 80 mm, down, and up again, 1 mm each time."""
LEG = np.repeat([0, 1, 2], [80, 80, 81])


def deflected(end: float) -> Array:
    """An element follows until it slips, and does so anew after each turn, from where it is then."""
    top = min(end, 0.08)
    bottom = max(top - 0.08, -end)
    legs = [np.minimum(WAY, end), np.maximum(top - 0.08 + WAY, -end), np.minimum(bottom + WAY, end)]
    return np.select([LEG == 0, LEG == 1, LEG == 2], legs)


def driven(law: str, ends: Array, stiffness: Array, *, known: Sequence[str] = (), level: float = 1.0) -> Any:
    """A problem of elements that slip, beside a constant force of -1.5 N; a part of the samples is none of it."""
    problem = mapped(law, known=known)
    force = np.full(len(WAY), -1.5)
    for end, one in zip(ends, stiffness, strict=True):
        force += level * one * deflected(end)
    used, held = np.arange(len(WAY)) % 7 != 0, np.arange(len(WAY)) > 220
    problem.experiment.use(["time", "position", "frictionForce"])
    problem.experiment.seen = force[used & ~held], force[used & ~held], np.full(np.sum(used & ~held), level)
    grid = 0.01 * np.arange(len(WAY))
    record = SimpleNamespace(time=grid, grid=grid, signals={"position": WAY})
    problem.windows = [SimpleNamespace(driven={"position": WAY}, record=record, used=used, held=held)]
    return problem


@pytest.mark.parametrize("end", [5e-4, 0.01, 0.07])
def test_element_follows_until_it_slips(end: float) -> None:
    [window] = driven("MaxwellSlip", np.zeros(0), np.zeros(0)).windows
    assert_close(deflection(window, end), deflected(end), within=3e-16, what="deflection")


@pytest.mark.parametrize("level", [1.0, 0.5])
def test_springs_are_those_that_the_force_was_made_of(level: float) -> None:
    ends, stiffness = np.array([0.002, 0.005, 0.02]), np.array([300.0, 0.0, 50.0])
    found, offset = springs(driven("MaxwellSlip", ends, stiffness, level=level), ends, {})
    assert_close(found, stiffness, within=4e-12, what="stiffness")
    assert_close(offset, -1.5, within=2e-14, what="constant force")


# A hundredth of the stroke of 80 mm to all of it, with the same ratio from each to the next.
ENDS = 8e-4 * 100.0 ** (np.arange(4) / 3.0)
STIFFNESS = np.array([4e3, 500.0, 100.0, 20.0])
LIMITS = ENDS * STIFFNESS


@pytest.mark.parametrize(
    ("law", "known", "expected"),
    [
        ("MaxwellSlip", [], by_element(k=STIFFNESS, W=LIMITS)),
        ("DNLRX", [], by_element(chi0=STIFFNESS, limit=ENDS)),
        # The shares are of a level that stays, which is all that the law has of it; or they make one.
        ("GMS", [], by_element(k=STIFFNESS, alpha=LIMITS / 8.3) | {"Fs": 1.02 * 8.3}),
        ("GMS", ["Fc"], by_element(k=STIFFNESS, alpha=LIMITS / np.sum(LIMITS)) | {"Fs": 1.02 * np.sum(LIMITS)}),
    ],
)
def test_elements_are_those_that_the_force_was_made_of(law: str, known: list[str], expected: dict[str, float]) -> None:
    problem = driven(law, ENDS, STIFFNESS)
    if known:
        problem.free.append(parse("friction.gms.Fc", problem.experiment.table, ["frictionForce"]))
    found = _elements(problem, {})
    own = {free.name: found[free.name] for free in problem.free if free.name in found}
    for name, value in expected.items():
        [full] = [full for full in found if full.rpartition(".")[2] == name]
        assert_close(found[full], value, rel=1e-11, what=law, why="what least squares lose")
        assert full in own
    assert_close(found["offset.frictionForce"], -1.5, within=2e-14, what="constant force")


def test_smooth_presliding_is_that_of_ten_elements() -> None:
    ends = np.geomspace(8e-4, 0.08, 10)
    stiffness = np.linspace(100.0, 10.0, 10)
    found = _elements(driven("Leuven", ends, stiffness), {})
    total = stiffness @ ends
    expected = {"k1": 550.0, "Fc": total, "Fs": 1.02 * total, "f1": 0.05 * total, "f2": 1.0 / 0.08, "n": 5.0}
    for name, value in expected.items():
        assert_close(found[f"friction.leuven.{name}"], value, rel=1e-11, what=name, why="what least squares lose")
    assert len(found) == 7 and _elements(driven("Stribeck", ends, stiffness), {}) == {}


def test_element_that_the_data_do_not_need_keeps_a_little() -> None:
    found = _elements(driven("MaxwellSlip", ENDS, np.array([4e3, 0.0, 0.0, 0.0])), {})
    assert_close(found["friction.maxwellSlip.k[3]"], 4e3 / 1e4, rel=1e-14, what="stiffness")


def test_elements_of_no_force_keep_a_little() -> None:
    found = _elements(driven("MaxwellSlip", ENDS, np.zeros(4)), {})
    assert [found[f"friction.maxwellSlip.k[{number}]"] for number in (1, 2, 3, 4)] == [1e-4] * 4


def test_area_is_what_the_force_grows_with_the_pressure() -> None:
    """Over all records, of the samples that move."""
    used = np.array([True, True, True, False])
    pressures = np.array([[1e5, 2e5, 3e5, 5e5], [2e5, 4e5, 6e5, 1e5]])
    friction = np.array([[3.0, 3.0, -3.0, 700.0], [-5.0, -5.0, 5.0, 900.0]])
    windows = [
        SimpleNamespace(used=used, record=SimpleNamespace(signals={"pressure": p, "force": 2e-4 * p + f}))
        for p, f in zip(pressures, friction, strict=True)
    ]
    problem: Any = SimpleNamespace(windows=windows)
    assert_close(_area(problem), 2e-4, rel=1e-14, what="area")
    problem.windows = [
        SimpleNamespace(used=used, record=SimpleNamespace(signals={"pressure": np.zeros(4), "force": used}))
    ]
    assert _area(problem) == 0.0


def test_presliding_is_a_fiftieth_of_the_longest_stroke() -> None:
    strokes = [{"position": np.array([0.0, 0.01])}, {"position": np.array([0.03, -0.02])}, {"velocity": np.ones(2)}]
    problem: Any = SimpleNamespace(windows=[SimpleNamespace(record=SimpleNamespace(signals=one)) for one in strokes])
    assert_close(_length(problem), 1e-3, rel=1e-14, what="length")
    problem.windows = problem.windows[2:]
    assert_close(_length(problem), 2e-5, rel=1e-14, what="length of no stroke that is measured")

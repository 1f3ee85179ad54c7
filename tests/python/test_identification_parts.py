"""Parts that fits are made of, each alone: smoothing, records, compression, profiles, and what a search tells."""

from __future__ import annotations

import re
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification import profile as profiles
from pneumatic_servo.identification import watch as watching
from pneumatic_servo.identification.compression import compressed
from pneumatic_servo.identification.profile import profile
from pneumatic_servo.identification.records import Record, load
from pneumatic_servo.identification.smoothing import fastest, follow, low_pass, noise, slope, smooth
from pneumatic_servo.identification.table import Measured
from pneumatic_servo.identification.watch import Watch, told
from scipy.signal import TransferFunction, lsim

Array = NDArray[np.float64]


def test_noise_is_that_of_a_normal_sensor_whatever_moves() -> None:
    time = np.linspace(0.0, 1.0, 20000)
    white = 2.0 * np.random.default_rng(1).standard_normal(len(time))
    assert_close(noise(50.0 * time**2 + white), 2.0, rel=0.03, what="white")
    jumps = white + 1e3 * (time > 0.5)
    assert_close(noise(jumps), noise(white), rel=1e-3, what="with a jump")
    # A converter of 0.3 whose steps are rare; of less than eight samples nothing is said.
    stairs = 0.3 * np.floor(np.arange(100) / 20.0)
    assert_close(noise(stairs), 0.3 / np.sqrt(12.0), rel=1e-14, what="stairs", why="0.3 is rounded")
    assert noise(stairs[17:24]) == 0.0 < noise(stairs[17:25]) and noise(np.full(50, 3.0)) == 0.0


def test_fastest_leaves_out_two_of_a_hundred() -> None:
    speed = np.arange(101.0) * (-1.0) ** np.arange(101)
    assert fastest(speed) == 98.0 and fastest(np.zeros(0)) == 0.0


@pytest.mark.parametrize(
    ("width", "values", "slopes"),
    [
        # What A. Savitzky and M. J. E. Golay have printed for parabolas over five and seven points.
        (0.0, np.array([-3.0, 12.0, 17.0, 12.0, -3.0]) / 35.0, np.array([-2.0, -1.0, 0.0, 1.0, 2.0]) / 10.0),
        (0.04, np.array([-3.0, 12.0, 17.0, 12.0, -3.0]) / 35.0, np.array([-2.0, -1.0, 0.0, 1.0, 2.0]) / 10.0),
        (0.06, np.array([-2.0, 3.0, 6.0, 7.0, 6.0, 3.0, -2.0]) / 21.0, np.arange(-3.0, 4.0) / 28.0),
    ],
)
def test_parabolas_are_those_of_the_printed_tables(width: float, values: Array, slopes: Array) -> None:
    pulse, half = np.zeros(31), len(values) // 2
    pulse[15] = 1.0
    around = slice(15 - half, 16 + half)
    for found, expected in ((smooth(pulse, 0.01, width), values), (slope(pulse, 0.01, width), -100.0 * slopes)):
        assert_close(found[around], expected, within=1e-12, what="weights", why="of solved equations")
        assert np.all(np.abs(np.delete(found, np.arange(15 - half, 16 + half))) < 1e-12)
    # Through three or four samples, which a parabola over five has not.
    short = np.array([1.0, 4.0, 9.0, 16.0])
    assert_close(smooth(short[:3], 0.01, width), short[:3], rel=1e-13, what="three samples", why="of solved equations")
    assert_close(smooth(short, 0.01, width), short, rel=1e-13, what="four samples", why="of solved equations")


def test_filter_is_that_of_its_equation() -> None:
    time = np.arange(50) * 0.01
    course = 3.0 + np.random.default_rng(2).standard_normal(50)
    _, expected, _ = lsim(TransferFunction([1.0], [0.03, 1.0]), course - course[0], time)
    assert_close(low_pass(course, 0.01, 0.03), course[0] + expected, rel=1e-13, what="course", why="of an exponential")


def test_what_follows_with_a_play_rests_within_it() -> None:
    course = np.array([1.0, 1.5, 0.5, 3.0, 2.5, 1.5, 0.5, 0.0])
    assert follow(course, 0.5).tolist() == [1.0, 1.0, 1.0, 2.5, 2.5, 2.0, 1.0, 0.5]
    assert follow(course, 0.0) is course


def measured(**signals: Array) -> Measured:
    return Measured("a.csv", signals, lambda signal, row: "")


def test_records_are_split_at_gaps() -> None:
    """A gap of five intervals is bridged, one of more is none; nor are 20 ms, however short the intervals are."""
    index = np.arange(200)
    time = 3.0 + 0.01 * index
    time[60:] += 0.03
    time[120:] += 0.1
    time[160:] += 0.05
    records, notes = load([measured(time=time, position=index * 1.0)])
    assert notes == ["a.csv: split at 2 gaps, 2 pieces too short to use"]
    [found] = records
    assert (found.name, found.begin, len(found.time)) == ("a.csv", 3.0, 120)
    assert_close(found.time, time[:120] - 3.0, within=1e-14, what="time")
    assert np.array_equal(found.signals["position"], index[:120]) and "time" not in found.signals
    quick = 1e-3 * np.arange(200)
    quick[100:] += 0.018
    assert load([measured(time=quick, force=quick)])[1] == []
    quick[100:] += 0.003
    two, notes = load([measured(time=quick, force=quick)])
    assert notes == ["a.csv: split at 1 gaps, 0 pieces too short to use"]
    assert [len(one.time) for one in two] == [100, 100]
    assert_close([two[1].begin, two[1].time[0], two[1].time[-1]], [0.121, 0.0, 0.099], within=1e-15, what="times")


def test_record_is_on_the_grid_of_its_usual_interval() -> None:
    record = Record("a", np.array([0.0, 0.5, 1.0, 2.2, 2.5]), 7.0, {"force": np.array([0.0, 1.0, 2.0, 8.0, 11.0])})
    assert record.step == 0.5 and record.grid.tolist() == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]
    assert_close(record.on_grid("force"), [0.0, 1.0, 2.0, 4.5, 7.0, 11.0], within=1e-13, what="force", why="of lines")
    part = record.part(1, 4)
    assert (part.name, part.begin, part.signals["force"].tolist()) == ("a", 7.5, [1.0, 2.0, 8.0])
    assert_close(part.time, [0.0, 0.5, 1.7], within=1e-14, what="time")


T = np.arange(100) * 0.01


@pytest.mark.parametrize(
    ("signals", "text"),
    [
        ({"position": T}, "a.csv: there is no time"),
        ({"time": T, "position": T[:50]}, "a.csv: position has the shape (50,), time (100,)"),
        ({"time": T.reshape(50, 2), "position": T.reshape(50, 2)}, "a.csv: time has the shape (50, 2), time (50, 2)"),
        ({"time": T, "force": np.where(T > 0.5, -np.inf, T)}, "a.csv: force is -inf at sample 51"),
        ({"time": np.where(T > 0.5, 0.25, T), "force": T}, "a.csv: time must rise, but 0.25 s follows 0.5 s"),
        ({"time": T[:1]}, "a.csv: too short, a single sample; at least 50 are needed"),
        ({"time": T[:49]}, "a.csv: too short, 49 samples without a gap; at least 50 are needed"),
        ({"time": T, "velocity": np.ones(100)},
         "velocity never changes: all at rest, so that nothing can be learned of friction"),
    ],
)  # fmt: skip
def test_arrays_that_are_no_signals_are_refused(signals: dict[str, Array], text: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(text)}$"):
        load([measured(**signals)])


def test_record_at_rest_beside_one_that_moves_is_taken() -> None:
    records, _ = load([measured(time=T[:50], position=np.ones(50)), measured(time=T, position=T)])
    assert [len(record.time) for record in records] == [50, 100]


def test_compressed_residuals_have_the_same_squares_and_slopes() -> None:
    rng = np.random.default_rng(3)
    table, right = rng.standard_normal((500, 3)), rng.standard_normal(500)
    for sign in (1.0, -1.0):
        short, slopes = compressed(lambda x, sign=sign: sign * (table @ x - right), lambda x, sign=sign: sign * table)
        x = rng.standard_normal(3)
        residuals, own = short(x), slopes(x)
        assert residuals.shape == (4,) and own.shape == (4, 3)
        rest = table @ x - right
        assert_close(residuals @ residuals, rest @ rest, rel=1e-14, what="squares")
        assert_close(own.T @ residuals, table.T @ rest, rel=1e-12, what="slope", why="of a decomposition")
        assert_close(own.T @ own, table.T @ table, within=1e-11, what="products", why="of a decomposition")


@dataclass(frozen=True)
class Straight:
    """A linear problem, of which parameters may be held."""

    free: tuple[Any, ...]
    experiment: Any
    slopes: Array
    right: Array
    bounds: tuple[Array, Array]
    pull: float = 0.0

    def residuals(self, vectors: list[Array]) -> Array:
        names = {one.name: place for place, one in enumerate(self.free)}
        held = self.experiment.held
        whole = [np.array([held.get(name, x[names[name]] if name in names else 0.0) for name in "ab"]) for x in vectors]
        return np.array([self.slopes @ x - self.right for x in whole])

    def pulls(self, x: Array) -> Array:
        return self.pull * x


class Held:
    def __init__(self, held: dict[str, float]) -> None:
        self.held = held

    def with_value(self, name: str, value: float) -> Held:
        return Held({**self.held, name: value})


def straight(low: float = -np.inf, high: float = np.inf) -> tuple[Straight, Array]:
    rng = np.random.default_rng(4)
    slopes, right = rng.standard_normal((30, 2)) @ [[1.0, 0.7], [0.0, 1.0]], rng.standard_normal(30)
    free = tuple(SimpleNamespace(name=name, outer=lambda inner: inner) for name in "ab")
    problem = Straight(free, Held({}), slopes, right, (np.array([low, -np.inf]), np.array([high, np.inf])))
    return problem, np.linalg.lstsq(slopes, right)[0]


def fit_rest(problem: Straight, start: Array) -> Any:
    """The rest of a linear problem in closed form; half the sum of squares is its cost."""
    [name] = problem.experiment.held
    place = "ab".index(name)
    right = problem.right - problem.slopes[:, place] * problem.experiment.held[name]
    assert len(start) == 1 and [one.name for one in problem.free] == ["ba"[place]]
    [cost] = np.linalg.lstsq(problem.slopes[:, [1 - place]], right)[1]
    return SimpleNamespace(cost=0.5 * cost)


@pytest.mark.parametrize("share", [1.0, 0.3, 0.04])
def test_profile_of_a_linear_problem_has_its_ends(share: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the cost has risen by four units: two deviations off. A search begins nearer, and doubles its distance."""
    monkeypatch.setattr(profiles, "refine", fit_rest)
    problem, x = straight()
    deviations = np.sqrt(np.diag(np.linalg.inv(problem.slopes.T @ problem.slopes)))
    low, high = profile(problem, x, 2.0 * share * deviations, share * deviations)  # type: ignore[arg-type]
    # Six halvings of twice the distance.
    assert_close((x - low) / deviations, 2.0, within=2.0 * 2.0 / 64.0, what="below", why="search by halves")
    assert_close((high - x) / deviations, 2.0, within=2.0 * 2.0 / 64.0, what="above", why="search by halves")
    assert np.all(x - low >= 1.999 * deviations) and np.all(high - x >= 1.999 * deviations)


def test_profile_ends_at_bounds_and_where_nothing_rises(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(profiles, "refine", fit_rest)
    problem, x = straight()
    deviations = np.sqrt(np.diag(np.linalg.inv(problem.slopes.T @ problem.slopes)))
    near, _ = straight(x[0] - 0.5 * deviations[0], x[0] + 0.7 * deviations[0])
    low, high = profile(near, x, 2.0 * deviations, deviations)  # type: ignore[arg-type]
    assert low[0] == near.bounds[0][0] and high[0] == near.bounds[1][0] and high[1] - x[1] > 1.9 * deviations[1]
    # What has no effect has no end, nor has what the Jacobian tells nothing of.
    monkeypatch.setattr(profiles, "refine", lambda problem, start: SimpleNamespace(cost=0.0))
    low, high = profile(problem, x, np.array([1.0, np.inf]), np.ones(2))  # type: ignore[arg-type]
    assert low.tolist() == [-np.inf] * 2 and high.tolist() == [np.inf] * 2


def test_profile_of_a_single_parameter_needs_no_search(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(profiles, "refine", None)
    problem, _ = straight()
    alone = Straight(
        problem.free[:1], Held({}), problem.slopes, problem.right, (np.full(1, -np.inf), np.full(1, np.inf))
    )
    x = np.linalg.lstsq(problem.slopes[:, :1], problem.right)[0]
    deviation = 1.0 / np.linalg.norm(problem.slopes[:, 0])
    low, high = profile(alone, x, np.array([2.0 * deviation]), np.array([deviation]))  # type: ignore[arg-type]
    assert_close(
        [x[0] - low[0], high[0] - x[0]], 2.0 * deviation, rel=0.04, what="half interval", why="search by halves"
    )


def test_search_tells_how_far_it_is() -> None:
    """Its best is that of its stage, in times of the noise."""
    said: list[str] = []
    watch = Watch("fit")
    watch.see(np.zeros(1), 9.0)
    with told(said.append, watch):
        watch.see(np.array([1.0]), 4.0)
        watch.see(np.array([2.0]), 16.0)
        assert watch.best is not None and watch.best.tolist() == [1.0]
        watch.stage("refinement")
        watch.see(np.array([3.0]), 25.0)
        watch.done("half")
        watch.say("at once")
    assert said == [
        "cost 4 (the best leaves 2 times the noise; first search, 2 runs)",
        "cost 16 (the best leaves 2 times the noise; first search, 3 runs)",
        "refinement",
        "cost 25 (the best leaves 5 times the noise; refinement, 4 runs)",
        "half",
        "at once",
    ]
    assert watch.best.tolist() == [3.0]
    # A vector of another length is of another problem.
    watch.see(np.array([4.0, 5.0]), 36.0)
    assert watch.best.tolist() == [4.0, 5.0]
    kept = np.array([6.0, 7.0])
    watch.see(kept, 25.0)
    kept[:] = 0.0
    assert watch.best.tolist() == [6.0, 7.0]


def test_lines_are_written_now_and_then(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    times = iter([100.0, 105.0, 110.0, 119.0, 121.0])
    monkeypatch.setattr(watching.time, "monotonic", lambda: next(times))
    watch = Watch("fit")
    with told(True, watch):
        for text in ("a", "b", "c", "d"):
            watch.done(text)
        watch.say("now")
    assert capsys.readouterr().err.splitlines() == ["fit: b [10 s]", "fit: d [21 s]", "fit: now"]
    with told(False, Watch("fit")):
        watch = Watch("fit")
        watch.done("e")
    assert capsys.readouterr() == ("", "")

"""The environments for Gymnasium."""

from __future__ import annotations

import warnings
from pathlib import Path

import gymnasium
import numpy as np
import pint
import pneumatic_servo as ps
import pneumatic_servo.envs as envs
import pytest
from bounds import assert_close, largest
from pneumatic_servo.envs.drawing import Drawing
from pneumatic_servo.envs.task import Task, rewards, voltages

NAME = "pneumatic_servo/Positioning-v0"


@pytest.mark.parametrize("law", ["Stribeck", "LuGre"])
def test_checker_of_gymnasium_is_content(law: str) -> None:
    from gymnasium.utils.env_checker import check_env

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(NAME, law=law).unwrapped)


def test_seed_reproduces_bits() -> None:
    def play() -> list[np.ndarray]:
        fleet = gymnasium.make_vec(NAME, num_envs=8, laws=["Stribeck", "GMS"], ranges=envs.RANDOM, duration=0.05)
        seen = [fleet.reset(seed=5)[0]]
        random = np.random.default_rng(0)
        for _ in range(120):
            seen.append(fleet.step(random.uniform(-1, 1, (8, 1)).astype(np.float32))[0])
        return seen

    for one, other in zip(play(), play(), strict=True):
        assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"laws": "LuGre"}, TypeError, "laws must be a list of names, not the text 'LuGre'"),
        ({"workers": -1}, ValueError, "workers = -1 is refused: it must be at least 1"),
        ({"num_envs": 2.5}, ValueError, "num_envs = 2.5 is refused: it must be a whole number"),
        ({"substeps": 0.5}, ValueError, "substeps = 0.5 is refused: it must be a whole number"),
    ],
)
def test_wrong_argument_is_named(arguments: dict[str, object], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        envs.VectorPositioning(**arguments)


def test_actions_are_voltages_and_end_with_their_range() -> None:
    assert voltages(np.array([-7.0, -1.0, 0.0, 0.5, 1.0, 1.5])).tolist() == [0.0, 0.0, 5.0, 7.5, 10.0, 10.0]


def test_observations_are_in_units_of_the_stroke_that_is_set() -> None:
    plant = gymnasium.make(NAME, parameters={"cylinder.stroke": 0.8}, targets=(0.1, 0.7))
    (error, position, *_), info = plant.reset(seed=3)
    # Drawn in one go, uniformly between the targets.
    target, start = np.random.default_rng(3).uniform(0.1, 0.7, 2)
    assert info["target"] == target
    assert_close([0.8 * position, 0.8 * error], [start, target - start], within=1e-7, what="observation")


def test_vector_of_plants_does_what_single_ones_do() -> None:
    fleet = gymnasium.make_vec(NAME, num_envs=3, law="LuGre")
    observations, _ = fleet.reset(seed=[11, 12, 13])
    singles = [gymnasium.make(NAME, law="LuGre").unwrapped for _ in range(3)]
    # Both draw from NumPy's default generator, seeded alike.
    alone = [single.reset(seed=seed)[0] for single, seed in zip(singles, [11, 12, 13], strict=True)]
    assert np.array(alone).tobytes() == observations.tobytes()
    actions = np.array([[0.3], [-0.2], [0.0]], dtype=np.float32)
    for _ in range(50):
        observations, rewards, *_ = fleet.step(actions)
        steps = [single.step(action) for single, action in zip(singles, actions, strict=True)]
        assert np.array([step[0] for step in steps]).tobytes() == observations.tobytes()
        assert [step[1] for step in steps] == rewards.tolist()


def test_vector_of_plants_does_what_single_ones_do_beyond_the_end_of_an_episode() -> None:
    """A single plant is reset where the vector begins the next episode by itself, at a step without reward."""
    task = {"duration": 0.02, "laws": ["Stribeck", "LuGre"], "ranges": envs.RANDOM}
    fleet = gymnasium.make_vec(NAME, num_envs=2, **task)
    fleet.reset(seed=[11, 12])
    singles = [gymnasium.make(NAME, **task).unwrapped for _ in range(2)]
    for single, seed in zip(singles, [11, 12], strict=True):
        single.reset(seed=seed)
    actions = np.array([[0.9], [-0.7]], dtype=np.float32)
    begun = 0
    over = np.zeros(2, dtype=bool)
    for _ in range(65):
        observations, rewards, _, truncated, info = fleet.step(actions)
        for index, single in enumerate(singles):
            if over[index]:
                (seen, own), reward, end = single.reset(), 0.0, False
                begun += 1
            else:
                seen, reward, _, end, own = single.step(actions[index])
            assert seen.tobytes() == observations[index].tobytes()
            assert (reward, end, own["target"]) == (rewards[index], truncated[index], info["target"][index])
        over = truncated
    assert begun == 2 * 3


def test_reward_is_worked_out_by_hand() -> None:
    """10 for each metre, and the weight times the square of an action, of which what is beyond 1 counts as 1."""
    seen = np.array([[place, 9.0, 9e5, 9e5] for place in (0.2, 0.3, 0.3, 0.3)])
    found = rewards(Task(effort=0.5), seen, np.array([0.25, 0.25, 0.3, 0.3]), np.array([0.4, -0.4, -3.0, 1.5]))
    # -0.5 - 0.08, -0.5 - 0.08, -0 - 0.5, -0 - 0.5
    assert_close(found, np.array([-0.58, -0.58, -0.5, -0.5]), rel=1e-14, what="reward")


def test_reward_of_a_step_is_that_of_where_it_ends() -> None:
    environment = gymnasium.make(NAME, effort=0.25).unwrapped
    environment.reset(seed=1)
    (error, *_), reward, *_ = environment.step(np.array([-0.8], dtype=np.float32))
    # The error is in units of the stroke, 0.5 m, in single precision.
    expected = -10.0 * 0.5 * abs(float(error)) - 0.25 * 0.8**2
    assert_close(reward, expected, within=3e-7, what="reward")


def test_substeps_divide_the_period() -> None:
    """Four steps of 1 ms at one action are one of 4 ms in four substeps, bit for bit; in one it is nearly the same."""
    ends = {}
    for period, substeps, steps in ((1e-3, 1, 400), (4e-3, 4, 100), (4e-3, 1, 100)):
        environment = gymnasium.make(NAME, law="LuGre", period=period, substeps=substeps).unwrapped
        environment.reset(seed=2)
        for step in range(steps):
            action = 0.5 * np.sin(2.0 * np.pi * 4e-3 * (step * 100 // steps) * np.ones(1, dtype=np.float32))
            seen, *_ = environment.step(action)
        ends[period, substeps] = seen
    assert ends[4e-3, 4].tobytes() == ends[1e-3, 1].tobytes()
    assert_close(ends[4e-3, 1], ends[4e-3, 4], within=1e-7, what="observation")


@pytest.mark.parametrize(
    ("changed", "word"),
    [({"law": "LuGre"}, "law"), ({"parameters": {"mass.moving": 2.0}}, "parameters"), ({"period": 2e-3}, "period")],
)
def test_task_changes_the_motion(changed: dict[str, object], word: str) -> None:
    ends = []
    for task in ({}, changed):
        environment = gymnasium.make(NAME, **task).unwrapped
        environment.reset(seed=4)
        for _ in range(50):
            seen, *_ = environment.step(np.ones(1, dtype=np.float32))
        ends.append(seen)
    assert largest(ends[0] - ends[1]) > 1e-4, word


def test_number_of_threads_changes_no_bit() -> None:
    ends = []
    for workers in (1, 3):
        fleet = envs.VectorPositioning(num_envs=5, workers=workers)
        fleet.reset(seed=6)
        for _ in range(20):
            seen, *_ = fleet.step(np.full((5, 1), 0.7, dtype=np.float32))
        ends.append(seen.tobytes())
    assert ends[0] == ends[1]


GAINS = {"gain.position": 10.0, "feedForward.gain": 5.0, "gain.velocity": 0.0, "gain.integral": 0.0,
         "valve.deadZone": 0.0}  # fmt: skip
"""A controller without memory: 50 V for each metre."""
ASIDE = np.array([[0.04, 0.5, 0.0, 0.1, 0.1]], dtype=np.float32)
"""An observation at rest, 4 % of the stroke aside."""


@pytest.mark.parametrize("stroke", [None, 0.8])
def test_baseline_is_the_controller_of_its_parameters(stroke: float | None) -> None:
    baseline = envs.PositionControllers(1, parameters=GAINS, stroke=stroke)
    # A digital controller answers the sample before.
    actions = [baseline(ASIDE) for _ in range(3)]
    # In units of 5 V.
    expected = 50.0 * 0.04 * (stroke or 0.5) / 5.0
    assert_close(actions[-1], np.full((1, 1), expected), rel=5e-7, what="action")


def test_baseline_runs_for_its_period_at_each_call() -> None:
    """Ten calls of 5 ms are fifty of 1 ms, as the integral part shows."""
    ends = {}
    for period, calls in ((5e-3, 10), (1e-3, 50), (1e-3, 10)):
        baseline = envs.PositionControllers(1, period, GAINS | {"gain.integral": 20.0})
        ends[period, calls] = [baseline(ASIDE) for _ in range(calls)][-1]
    assert ends[5e-3, 10].tobytes() == ends[1e-3, 50].tobytes()
    assert float(ends[1e-3, 10][0, 0]) < 0.9 * float(ends[1e-3, 50][0, 0])


def test_episodes_end_and_begin_anew() -> None:
    fleet = gymnasium.make_vec(NAME, num_envs=2, duration=0.003)
    fleet.reset(seed=1)
    still = np.zeros((2, 1), dtype=np.float32)
    ends = [fleet.step(still)[3].tolist() for _ in range(8)]
    # Three steps, and one that only begins the next episode.
    assert ends == [[False] * 2, [False] * 2, [True] * 2, [False] * 2] * 2


def test_laws_and_parameters_vary_within_their_ranges() -> None:
    environment = gymnasium.make(NAME, laws=["Stribeck", "LuGre"], ranges={"mass.moving": (1.0, 2.0)})
    drawn = [environment.reset(seed=seed)[1] for seed in range(20)]
    assert {info["friction.law"] for info in drawn} == {"Stribeck", "LuGre"}
    masses = [info["mass.moving"] for info in drawn]
    assert 1.0 <= min(masses) < max(masses) <= 2.0


@pytest.mark.parametrize("stroke", [None, 0.8])
def test_baseline_solves_the_task(stroke: float | None) -> None:
    task = {} if stroke is None else {"parameters": {"cylinder.stroke": stroke}}
    fleet = gymnasium.make_vec(NAME, num_envs=16, laws=["Stribeck", "LuGre", "GMS"], ranges=envs.RANDOM, **task)
    baseline = envs.PositionControllers(16, stroke=stroke)
    observations, _ = fleet.reset(seed=3)
    before = np.abs(observations[:, 0]).mean()
    for _ in range(1500):
        observations, *_ = fleet.step(baseline(observations))
    # In units of the stroke, 0.5 m by default: from 80 mm on average to a few millimetres.
    assert before > 0.1 and np.abs(observations[:, 0]).mean() < 0.01


@pytest.mark.parametrize(
    ("task", "word"),
    [
        ({"law": "Lugre"}, "Lugre"),
        ({"targets": (0.4, 0.1)}, "targets"),
        ({"duration": -1.0}, "duration"),
        ({"ranges": {"mass.moving": (2.0, 1.0)}}, "mass.moving"),
        ({"ranges": {"cylinder.stroke": (0.5, 0.8)}}, "cylinder.stroke"),
        ({"parameters": {"valve.c": 1.0}}, "valve.c"),
    ],
)
def test_bad_tasks_are_refused(task: dict[str, object], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        gymnasium.make(NAME, **task)


def test_each_environment_has_spaces_of_its_own() -> None:
    one, other = (gymnasium.make(NAME).unwrapped for _ in range(2))
    fleet = gymnasium.make_vec(NAME, num_envs=2)
    assert one.action_space is not other.action_space and one.observation_space is not other.observation_space
    assert fleet.single_action_space is not one.action_space
    other.action_space.seed(5)
    expected = other.action_space.sample()
    other.action_space.seed(5)
    for space in (one.action_space, fleet.single_action_space):
        space.seed(1)
        space.sample()
    assert other.action_space.sample() == expected


def test_seeds_are_one_for_all_or_one_for_each() -> None:
    fleet = gymnasium.make_vec(NAME, num_envs=3)
    expected = fleet.reset(seed=[4, 5, 6])[1]["target"].tolist()
    for seed in (4, np.int64(4), np.array([4, 5, 6])):
        assert fleet.reset(seed=seed)[1]["target"].tolist() == expected
    for seed in ([1, 2], [1, 2, 3, 4]):
        with pytest.raises(ValueError, match=f"seed has {len(seed)} numbers, but there are 3 plants"):
            fleet.reset(seed=seed)
    # A refused step has changed nothing.
    fleet.step(np.zeros((3, 1), dtype=np.float32))
    single = gymnasium.make(NAME).unwrapped
    assert single.reset(seed=np.int64(4))[1]["target"] == expected[0]


def test_targets_and_parts_may_be_asked_for() -> None:
    single = gymnasium.make(NAME)
    assert single.reset(seed=1, options={"target": 0.3})[1]["target"] == 0.3
    fleet = gymnasium.make_vec(NAME, num_envs=3)
    assert fleet.reset(seed=1, options={"target": [0.1, 0.2, 0.3]})[1]["target"].tolist() == [0.1, 0.2, 0.3]
    before = fleet.step(np.ones((3, 1), dtype=np.float32))[0]
    after, info = fleet.reset(options={"target": 0.4, "reset_mask": np.array([True, False, False])})
    assert info["target"].tolist() == [0.4, 0.2, 0.3]
    assert (after[0] != before[0]).any() and after[1:].tobytes() == before[1:].tobytes()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"targt": 0.3}, "options: there is no targt; did you mean target"),
        ({"target": 0.7}, "target = 0.7 is refused: it must be within the stroke, 0 to 0.5 m"),
        ({"target": "far"}, "target = 'far' is refused"),
    ],
)
def test_options_that_are_not_known_are_refused(options: dict[str, object], words: str) -> None:
    for environment in (gymnasium.make(NAME), gymnasium.make_vec(NAME, num_envs=2)):
        with pytest.raises(ValueError, match=words):
            environment.reset(seed=1, options=options)


def test_transitions_are_those_of_the_steps_to_come() -> None:
    """Bit for bit the transitions of each plant alone; and the steps are the same as without transitions."""
    names, outputs = ["valve.C"], ["position", "chamberA.pressure"]
    task = {"laws": ["Stribeck", "LuGre", "CoulombStiction"], "period": 4e-3, "substeps": 2}
    fleet, other = (envs.VectorPositioning(6, workers=workers, **task) for workers in (3, 1))
    with pytest.raises(gymnasium.error.ResetNeeded, match="transitions was called before reset"):
        fleet.transitions(np.zeros((6, 1), np.float32))
    fleet.reset(seed=1), other.reset(seed=1)
    model, random, inner = ps.Model(), np.random.default_rng(2), fleet._fleet
    alone = [model.start({**inner.task.settings(model), **own}) for own in inner.settings]
    for _ in range(10):
        actions = random.uniform(-0.5, 0.5, (6, 1)).astype(np.float32)
        found = fleet.transitions(actions, parameters=names, outputs=outputs)
        assert fleet.step(actions)[0].tobytes() == other.step(actions)[0].tobytes()
        for plant, voltage, steps in zip(alone, voltages(np.float64(actions[:, 0])), found, strict=True):
            plant.set_one("valveVoltage", float(voltage))
            assert len(steps) == 2
            for step in steps:
                expected = plant.transition(2e-3, parameters=names, outputs=outputs)
                assert (step.states, step.outputs, step.parameters) == (expected.states, tuple(outputs), tuple(names))
                for matrix in ("A", "B", "C", "D", "P", "Q"):
                    assert getattr(step, matrix).tobytes() == getattr(expected, matrix).tobytes(), matrix
    assert len({steps[0].states for steps in found}) > 1, "states differ from law to law"
    with pytest.raises(ValueError, match="there is no variable posiion; did you mean position"):
        fleet.transitions(actions, outputs=["posiion"])


def test_fleet_of_one_does_what_one_does() -> None:
    fleet, single = envs.VectorPositioning(1, laws=["Stribeck", "LuGre"]), envs.Positioning(laws=["Stribeck", "LuGre"])
    (seen, info), (alone, own) = fleet.reset(seed=5), single.reset(seed=5)
    assert seen[0].tobytes() == alone.tobytes()
    assert {name: info[name].tolist() for name in own} == {name: [value] for name, value in own.items()}


def test_actions_of_the_baseline_are_those_of_the_space() -> None:
    fleet = gymnasium.make_vec(NAME, num_envs=2)
    seen, _ = fleet.reset(seed=1)
    actions = envs.PositionControllers(2)(seen)
    assert actions.dtype == fleet.action_space.dtype and actions in fleet.action_space


def test_what_is_wrong_with_a_call_is_named() -> None:
    fleet, actions = envs.VectorPositioning(2), np.zeros((2, 1), dtype=np.float32)
    for mask in ([1, 0], [True]):
        with pytest.raises(ValueError, match="options: reset_mask must be true or false for each of 2 plants, not "):
            fleet.reset(options={"reset_mask": mask})
    for environment in (fleet, envs.Positioning()):
        with pytest.raises(ValueError, match="seed"):
            environment.reset(seed=-1)
    fleet.reset(seed=1)
    for name in ("parameters", "outputs"):
        with pytest.raises(TypeError, match=f"^{name}"):
            fleet.transitions(actions, **{name: "position"})
    with pytest.raises(gymnasium.error.ResetNeeded, match="render was called before reset"):
        envs.Positioning(render_mode="rgb_array").render()


def test_step_needs_a_reset() -> None:
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.Positioning().step(np.zeros(1, dtype=np.float32))
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.VectorPositioning(2).step(np.zeros((2, 1), dtype=np.float32))


@pytest.mark.parametrize(
    ("task", "words"),
    [
        ({"laws": ["Stribeck", "Lugre"]}, "did you mean LuGre"),
        ({"targets": (0.1, 0.6)}, "targets = .* the stroke ends at 0.5 m"),
        ({"targets": "300 mm"}, "targets = '300 mm' is refused: it must be a pair"),
        ({"targets": (300, "mm")}, "targets = .300, 'mm'. is refused: it must be a pair"),
        ({"targets": ("1 bar", "2 bar")}, "targets: .*unit bar"),
        ({"ranges": {"supplyPressure": 6e5}}, "ranges: supplyPressure = 600000.0 is refused: it must be a pair"),
        ({"period": "1 mm"}, "period: .*unit mm"),
        ({"ranges": {"mass.movin": (1.0, 2.0)}}, "did you mean mass.moving"),
        ({"ranges": {"valve.b": (0.5, 2.0)}}, "valve.b = 2"),
    ],
)
def test_task_is_refused_before_anything_is_drawn(task: dict[str, object], words: str) -> None:
    for make in (envs.Positioning, envs.VectorPositioning):
        with pytest.raises(ValueError, match=words):
            make(**task)


def test_task_takes_units() -> None:
    plain = {"ranges": {"supplyPressure": (5e5, 7e5), "mass.moving": (0.9, 1.2)}, "targets": (0.1, 0.3), "period": 5e-3}
    expected = gymnasium.make(NAME, **plain).reset(seed=3)[1]
    forms = [
        {"supplyPressure": ("5 bar", "7 bar"), "mass.moving": ("900 g", 1.2)},
        {"supplyPressure": ([5, 7], "bar"), "mass.moving": [(900, "g"), (1200, "g")]},
        {"supplyPressure": (pint.Quantity(5, "bar"), pint.Quantity(700, "kPa")), "mass.moving": np.array([0.9, 1.2])},
    ]
    for ranges, targets in zip(forms, [("100 mm", "300 mm"), ([100, 300], "mm"), (0.1, "30 cm")], strict=True):
        task = {"ranges": ranges, "targets": targets, "period": "5 ms", "duration": (1500, "ms")}
        single = gymnasium.make(NAME, **task)
        assert single.reset(seed=3)[1] == pytest.approx(expected, rel=1e-15)
        assert single.unwrapped._fleet.task.steps == 300
    assert single.reset(seed=3, options={"target": "250 mm"})[1]["target"] == 0.25
    fleet = gymnasium.make_vec(NAME, num_envs=2)
    assert fleet.reset(seed=3, options={"target": ["250 mm", 0.2]})[1]["target"].tolist() == [0.25, 0.2]


def test_info_of_many_plants_has_their_settings() -> None:
    fleet = gymnasium.make_vec(NAME, num_envs=4, laws=["Stribeck", "GMS"], ranges={"mass.moving": (1.0, 2.0)})
    info = fleet.reset(seed=2)[1]
    assert info["mass.moving"].shape == (4,) and set(info["friction.law"]) <= {"Stribeck", "GMS"}
    assert info["_mass.moving"].all()


def dark_columns(frame: np.ndarray) -> np.ndarray:
    """Columns of the piston and of the ends of the barrel: dark for a third of the height at least."""
    return np.flatnonzero((frame.max(axis=2) < 0x50).sum(axis=0) > frame.shape[0] / 3)


def test_pictures_show_where_the_carriage_is() -> None:
    environment = gymnasium.make(NAME, render_mode="rgb_array", duration=9.0)
    environment.reset(seed=1, options={"target": 0.3})
    places, pistons = [], []
    for action in (0.5, -0.5):
        for _ in range(400):
            seen, *_ = environment.step(np.array([action], dtype=np.float32))
        frame = environment.render()
        assert frame.shape == (180, 640, 3) and frame.dtype == np.uint8
        places.append(float(seen[1]))
        # The piston is the dark block that is neither an end of the barrel.
        inside = dark_columns(frame)
        pistons.append(float(np.mean(inside[(inside > inside[0] + 4) & (inside < inside[-1] - 4)])))
    assert np.array_equal(environment.render(), environment.render())
    # A stroke is 0.96/2.45 of 640 dots wide; the piston's middle is found to a dot.
    assert_close(pistons[0] - pistons[1], 640 * 0.96 / 2.45 * (places[0] - places[1]), within=1.0, what="dots")
    assert abs(pistons[0] - pistons[1]) > 20.0


def test_drawing_is_to_scale_and_says_its_numbers() -> None:
    """Lengths in strokes of 0.5 m; chambers in the colour of air, the fuller the stronger, from 10 bar on in full."""
    drawing = Drawing()
    assert [text.get_text() for text in drawing.figure.texts] == [""]
    drawing.show(0.5, np.array([0.2, 0.0, 4e5, 20e5]), 0.3, "LuGre")
    [axes] = drawing.figure.axes
    barrel, a, b, rod, piston, load = axes.patches
    ends = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in (barrel, a, b, rod, piston, load)]
    expected = [(-0.04, 1.04), (-0.04, 0.38), (0.42, 1.04), (0.4, 1.5), (0.38, 0.42), (1.5, 1.62)]
    assert_close(np.array(ends), np.array(expected), within=2e-14, what="ends")
    assert all(patch.get_y() == -patch.get_height() / 2 for patch in axes.patches), "all are on the axis"
    assert (a.get_alpha(), b.get_alpha()) == (0.4, 1.0)
    [target] = axes.get_lines()
    assert_close(np.asarray(target.get_xdata()), np.full(2, 1.7), within=2e-14, what="target")
    [title] = drawing.figure.texts
    assert title.get_text() == "LuGre  position  200.0 mm, target  300.0 mm, A 4.00 bar, B 20.00 bar"
    drawing.show(0.5, np.array([0.2, 0.0, -1e5, 0.0]), 0.3, "LuGre")
    assert (a.get_alpha(), b.get_alpha()) == (0.0, 0.0)


def test_pictures_of_many_plants_are_those_of_single_ones() -> None:
    fleet = gymnasium.make_vec(NAME, num_envs=2, render_mode="rgb_array")
    fleet.reset(seed=[4, 5])
    single = gymnasium.make(NAME, render_mode="rgb_array")
    single.reset(seed=5)
    one, other = fleet.render()
    assert np.array_equal(other, single.render()) and not np.array_equal(one, other)
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.Positioning(render_mode="rgb_array").render()


def test_window_shows_as_many_pictures_as_a_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[str] = []

    class Window:
        def __init__(self) -> None:
            self.drawing = Drawing()

        def update(self) -> None:
            shown.append(self.drawing._title.get_text())

        def close(self) -> None:
            shown.append("closed")

    monkeypatch.setattr("pneumatic_servo.envs.positioning.Window", Window)
    environment = envs.Positioning(render_mode="human", law="LuGre")
    environment.reset(seed=1)
    for _ in range(1000):
        environment.step(np.array([0.4], dtype=np.float32))
    environment.close()
    # At the reset and every 40 ms.
    assert len(shown) == 1 + 25 + 1 and shown[-1] == "closed" and shown[0].startswith("LuGre  position")
    assert len(set(shown)) > 20


def test_page_has_the_spaces_as_they_are() -> None:
    text = (Path(__file__).parents[2] / "docs" / "environments.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if line.startswith("| ")]
    numbers = [(int(row[0]), float(row[2]), float(row[3])) for row in rows if row[0].isdigit()]
    environment = envs.Positioning()
    expected = [
        (number, float(low), float(high))
        for space in (environment.action_space, environment.observation_space)
        for number, (low, high) in enumerate(zip(space.low, space.high, strict=True))
    ]
    assert numbers == expected
    # In the units that the page names: of a stroke, m/s, and 10 bar.
    seen, info = environment.reset(seed=8)
    plant = environment._fleet.native.observe()[0]
    scale = np.array([0.5, 1.0, 10e5, 10e5])
    assert seen[2] == plant[1] == 0.0
    assert_close((seen[1:] * scale)[[0, 2, 3]], plant[[0, 2, 3]], rel=2e-7, what="observation")
    assert_close(0.5 * float(seen[0]), info["target"] - plant[0], within=1e-7, what="error")

"""Runs as functions that JAX and PyTorch differentiate.

PyTorch is tested where it is installed: its wheels of PyPI bring gigabytes of CUDA along, so that the lists of what the
tests need leave it out.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from pneumatic_servo.differentiable import Trajectory

STEPS = 30
GIVEN: dict[str, Any] = {
    "parameters": ["valve.C", "friction.coulombStiction.Fs"],
    "inputs": ["valveVoltage"],
    "outputs": ["position", "velocity"],
    "given": {"friction.law": "CoulombStiction", "solver.relativeTolerance": 1e-9},
    "stop": 0.3,
    "step": 1e-2,
}
"""Rest, break-away and motion."""
SCALES = np.array([1e-8, 1.0])
"""Of the parameters: what is differenced must be of like size."""


def voltage() -> np.ndarray:
    """Rising, so that the hysteresis of the valve is not at its edge."""
    return np.linspace(6.0, 7.0, STEPS)[None]


def start(plant: ps.Model) -> np.ndarray:
    return np.array([float(plant.parameters[name].default) for name in GIVEN["parameters"]])  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def plant() -> ps.Model:
    return ps.Model()


def test_carriage_breaks_away(plant: ps.Model) -> None:
    """The differentiated run goes through an event."""
    run = plant.simulate(
        GIVEN["given"], inputs={"valveVoltage": (np.arange(STEPS) * 1e-2, voltage()[0])}, stop=0.3, step=1e-2,
        outputs=["sticking"],
    )  # fmt: skip
    assert run["sticking"][0] == 1.0 and run["sticking"][-1] == 0.0


def test_push_and_pull_agree(plant: ps.Model) -> None:
    made = Trajectory(plant, **GIVEN)
    rng = np.random.default_rng(3)
    seeds = rng.standard_normal(2) * SCALES, rng.standard_normal((1, STEPS))
    weights = rng.standard_normal((2, STEPS + 1))
    pushed = made.push(start(plant), voltage(), *seeds)
    pulled = made.pull(start(plant), voltage(), weights)
    found, expected = (weights * pushed).sum(), sum((seed * one).sum() for seed, one in zip(seeds, pulled, strict=True))
    assert abs(found - expected) < 1e-10 * abs(expected)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"parameters": ["valve.D"]}, "parameters: valve.D is no parameter"),
        ({"parameters": ["friction.law"]}, "parameters: friction.law is no real number"),
        ({"parameters": ["valve.C", "valve.b", "valve.C"]}, "parameters: valve.C is given twice"),
        ({"inputs": ["valveVoltage", "valveVoltage"]}, "inputs: valveVoltage is given twice"),
        ({"inputs": ["valveVoltag"]}, "inputs: valveVoltag is not an input; did you mean valveVoltage"),
        ({"outputs": ["sticking"]}, "outputs: sticking is no real number"),
        ({"given": {"valve.C": 1e-8}}, "valve.C is given twice"),
    ],
)
def test_names_that_do_not_fit_are_refused(plant: ps.Model, change: dict[str, Any], problem: str) -> None:
    with pytest.raises(ValueError, match=problem.replace(".", r"\.")):
        Trajectory(plant, **{**GIVEN, **change})


@pytest.fixture
def jax() -> Iterator[Any]:
    """JAX with 64 bits, where it is installed."""
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    yield jax
    jax.config.update("jax_enable_x64", False)


def test_jax_gradients_are_those_of_differences(plant: ps.Model, jax: Any) -> None:
    from jax.test_util import check_grads
    from pneumatic_servo.jax import trajectory

    run = trajectory(plant, **GIVEN)

    def scaled(p: Any, u: Any) -> Any:
        return run(start(plant) + SCALES * p, u)[:, ::10]

    # Differences of runs with errors of 1e-9 over 1e-4 of a volt.
    check_grads(scaled, (np.zeros(2), voltage()), order=1, modes=["fwd", "rev"], eps=1e-4, atol=2e-4, rtol=2e-3)


def test_jax_transforms(plant: ps.Model, jax: Any) -> None:
    from pneumatic_servo.jax import trajectory

    run = trajectory(plant, **GIVEN)
    p, u = start(plant), voltage()
    assert (run.parameters, run.inputs, run.outputs, run.steps) == (
        GIVEN["parameters"],
        GIVEN["inputs"],
        GIVEN["outputs"],
        STEPS,
    )
    plain = run(p, u)
    assert plain.shape == (2, STEPS + 1) == (2, len(run.times))
    assert (jax.jit(run)(p, u) == plain).all(), "jit calls back"

    def end(u: Any) -> Any:
        return run(p, u)[0, -1]

    gradient = jax.grad(end)(u)
    assert (jax.jit(jax.grad(end))(u) == gradient).all()
    seed = np.ones_like(u)
    value, slope = jax.jvp(end, (u,), (seed,))
    assert value == plain[0, -1] and abs(slope - gradient.sum()) < 1e-10 * abs(slope)
    many = np.stack([u, u + 0.1])
    assert (jax.vmap(end)(many) == np.array([end(u), end(u + 0.1)])).all()
    assert np.allclose(jax.vmap(jax.grad(end))(many)[0], gradient, rtol=1e-12)
    # Forwards, along the first two samples of the input, which stand along the last axis.
    seeds = np.eye(u.size, 2).reshape(*u.shape, 2)

    def along(seed: Any) -> Any:
        return jax.jvp(end, (u,), (seed,))[1]

    for transform in (lambda function: function, jax.jit):
        slopes = transform(jax.vmap(along, in_axes=u.ndim))(seeds)
        assert np.allclose(slopes, gradient.ravel()[:2], rtol=1e-9)
    with pytest.raises(ValueError, match=r"inputs have the shape \(30,\); it must be \(1, 30\)"):
        run(p, u[0])


def test_jax_needs_64_bits(plant: ps.Model) -> None:
    jax = pytest.importorskip("jax")
    from pneumatic_servo.jax import trajectory

    assert not jax.config.jax_enable_x64
    with pytest.raises(TypeError, match="64 bits"):
        trajectory(plant, **GIVEN)(start(plant), voltage())


@pytest.mark.filterwarnings("ignore::FutureWarning", "ignore::DeprecationWarning")
def test_torch_gradients_are_those_of_differences(plant: ps.Model) -> None:
    torch = pytest.importorskip("torch")
    from pneumatic_servo.torch import trajectory

    run = trajectory(plant, **GIVEN)
    scales, first = torch.tensor(SCALES), torch.tensor(start(plant))
    p = torch.zeros(2, dtype=torch.float64, requires_grad=True)
    u = torch.tensor(voltage(), requires_grad=True)

    def scaled(p: Any, u: Any) -> Any:
        return run(first + scales * p, u)[:, ::10]

    assert torch.autograd.gradcheck(
        scaled, (p, u), eps=1e-4, atol=2e-4, rtol=2e-3, check_forward_ad=True, nondet_tol=0.0
    )
    with pytest.raises(ValueError, match=r"inputs have the shape \(30,\)"):
        run(first, u[0])


@pytest.mark.parametrize("at_rest", ["mean", "zero"])
def test_push_and_pull_agree_where_the_voltage_rests(plant: ps.Model, at_rest: str) -> None:
    made = Trajectory(plant, **GIVEN, at_rest=at_rest)
    rng = np.random.default_rng(4)
    held = np.repeat(np.linspace(6.0, 7.0, 6), 5)[None]
    seeds = rng.standard_normal(2) * SCALES, rng.standard_normal((1, STEPS))
    weights = rng.standard_normal((2, STEPS + 1))
    pushed = made.push(start(plant), held, *seeds)
    pulled = made.pull(start(plant), held, weights)
    # Of a voltage that is held for steps the last before it changes is no better off.
    assert pulled[1].any() == (at_rest == "mean")
    # Runs nearby differ by microvolts a step from the one whose steps have a derivative.
    along = sum(float(np.sum(one * other)) for one, other in zip(seeds, pulled, strict=True))
    assert along == pytest.approx(float(np.sum(weights * pushed)), rel=1e-4)
    refused = Trajectory(plant, **GIVEN, at_rest="refuse")
    for call in (lambda: refused.push(start(plant), held, *seeds), lambda: refused.pull(start(plant), held, weights)):
        with pytest.raises(ps.NoDerivative, match="see at_rest"):
            call()


def test_what_has_no_slope_is_named(plant: ps.Model, monkeypatch: pytest.MonkeyPatch) -> None:
    """Messages name the input and its time, or the parameter, at which the plant finds no number."""
    made = Trajectory(plant, parameters=["valve.C", "mass.moving"], inputs=["valveVoltage"], outputs=["position"],
                      given=None, stop=0.03, step=0.01)  # fmt: skip
    slopes = np.zeros((len(plant.inputs), 3))

    def gradient(*_: object) -> tuple[np.ndarray, None, list[float]]:
        return slopes, None, [1.0, np.nan]

    monkeypatch.setattr("pneumatic_servo._native.gradient", gradient)
    arguments = np.array([1e-8, 1.0]), np.full((1, 3), 5.0), np.ones((1, 3))
    with pytest.raises(ps.NoDerivative) as caught:
        made.pull(*arguments)
    told = "at mass.moving: what follows depends on it in another way to either side"
    assert str(caught.value).endswith(told) and "t = 0 s" in str(caught.value)
    slopes[list(plant.inputs).index("valveVoltage"), 2] = np.nan
    with pytest.raises(ps.NoDerivative, match=r"t = 0\.02 s on, at valveVoltage: "):
        made.pull(*arguments)


@pytest.mark.filterwarnings("ignore:friction.stribeck.Fc = ")
def test_what_follows_a_parameter_is_differentiated_along(plant: ps.Model) -> None:
    """Sliding friction gives way to a low static friction, in proportion."""
    name, level, offset = "friction.stribeck.Fs", 7.0, 1e-4
    settings = {"friction.law": "Stribeck", "solver.relativeTolerance": 1e-10}
    given: dict[str, Any] = {"inputs": {"valveVoltage": 6.5}, "stop": 0.1, "step": 1e-3, "outputs": ["position"]}

    def run(level: float, **more: Any) -> ps.Run:
        return plant.simulate({**settings, name: level}, **given, **more)

    expected = (run(level + offset)["position"][-1] - run(level - offset)["position"][-1]) / (2 * offset)
    alone = run(level, sensitivities=[name])
    last = np.zeros((1, 101))
    last[0, -1] = 1.0
    made = Trajectory(plant, parameters=[name], inputs=["valveVoltage"], outputs=["position"],
                      given={**settings, "valve.hysteresis": 0.0}, stop=0.1, step=1e-3)  # fmt: skip
    arguments = np.array([level]), np.full((1, 100), 6.5)
    pushed = made.push(*arguments, np.ones(1), np.zeros((1, 100)))[0, -1]
    pulled = made.pull(*arguments, last)[0][0]
    # With its play the spool is elsewhere, and has the same slopes by friction as soon as it rests.
    assert pushed == pytest.approx(pulled, rel=1e-9)
    assert alone.sensitivities["position", name][-1] == pytest.approx(expected, rel=1e-5)
    assert alone.vjp({"position": last[0]}, parameters=[name]).parameters[name] == pytest.approx(expected, rel=1e-5)
    values = [made.values(np.array([level + sign * offset]), arguments[1])[0, -1] for sign in (1, -1)]
    assert pushed == pytest.approx((values[0] - values[1]) / (2 * offset), rel=1e-5)

"""Laws whose friction depends on deflections before, fitted at the defaults; the data are integrated by themselves."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pneumatic_servo as ps
import pytest
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEP, SUBSTEPS = 1e-3, 40
BENCH = {"Fs": 10.5, "Fc": 7.0, "vs": 0.02, "sigma2": 30.0, "sigma0": 1e5, "sigma1": 300.0, "vd": 0.1}
PUBLISHED = {"Fs": 20.0, "Fc": 5.0, "vs": 0.07, "sigma2": 35.0, "sigma0": 133.3e3, "sigma1": 600.0, "vd": math.inf}
"""A set of the literature, whose damping does not decay."""


def pushed(
    law: dict[str, float], mass: float, duration: float, force: Callable[[float, float, float], float],
    inputs: str = "held",
) -> dict[str, Array]:  # fmt: skip
    """Integrate a mass with one LuGre bristle by the classical Runge-Kutta method.

    Between samples forces are held, run on straight lines, or are what they are.
    """
    number, step = round(duration / STEP), STEP / SUBSTEPS
    position, applied = np.zeros(number), np.zeros(number)

    def rates(state: tuple[float, ...], push: float) -> tuple[float, ...]:
        _, v, z = state
        level = law["Fc"] + (law["Fs"] - law["Fc"]) * math.exp(-((v / law["vs"]) ** 2))
        bending = v - law["sigma0"] * abs(v) / level * z
        damping = law["sigma1"] * math.exp(-((v / law["vd"]) ** 2))
        return v, (push - law["sigma0"] * z - damping * bending - law["sigma2"] * v) / mass, bending

    def moved(state: tuple[float, ...], rate: tuple[float, ...], time: float) -> tuple[float, ...]:
        return tuple(s + time * r for s, r in zip(state, rate, strict=True))

    def push(sample: int, share: float) -> float:
        if inputs == "smooth":
            return force((sample + share) * STEP, *state[:2])
        slope = force((sample + 1) * STEP, *state[:2]) - applied[sample] if inputs == "lines" else 0.0
        return float(applied[sample] + share * slope)

    state: tuple[float, ...] = (0.0, 0.0, 0.0)
    for k in range(number):
        applied[k] = force(k * STEP, state[0], state[1])
        position[k] = state[0]
        for part in range(SUBSTEPS):
            begin, middle, end = (push(k, (part + share) / SUBSTEPS) for share in (0.0, 0.5, 1.0))
            first = rates(state, begin)
            second = rates(moved(state, first, 0.5 * step), middle)
            third = rates(moved(state, second, 0.5 * step), middle)
            fourth = rates(moved(state, third, step), end)
            mean = tuple(
                (a + 2.0 * b + 2.0 * c + d) / 6.0 for a, b, c, d in zip(first, second, third, fourth, strict=True)
            )
            state = moved(state, mean, step)
    noise = 1e-7 * np.random.default_rng(0).standard_normal(number)
    return {"time": STEP * np.arange(number), "position": position + noise, "force": applied}


def held_back(time: float, position: float, velocity: float) -> float:
    """Return the force of a controller that follows two sines."""
    target = 0.02 * math.sin(1.4 * math.pi * time) + 0.004 * math.sin(4.6 * math.pi * time)
    return 2000.0 * (target - position) - 50.0 * velocity


def given(time: float, position: float, velocity: float) -> float:
    """Return a force that knows nothing of the motion."""
    return 26.0 * math.sin(math.pi * time) + 8.0 * math.sin(3.4 * math.pi * time)


@pytest.mark.parametrize(
    ("law", "mass", "duration", "force"), [(BENCH, 1.0, 4.0, held_back), (PUBLISHED, 5.0, 10.0, given)]
)
def test_exact_force_gives_the_bristle_at_the_defaults(
    law: dict[str, float], mass: float, duration: float, force: Callable[[float, float, float], float]
) -> None:
    """Records are not cut into segments, which would begin without the deflection."""
    data = pushed(law, mass, duration, force)
    found = ps.fit(data, experiment="force", law="LuGre", settings={"mass": mass}, progress=False)
    told = {name: value for name, value in law.items() if math.isfinite(value)}
    for name, value in told.items():
        assert found.values[f"friction.lugre.{name}"] == pytest.approx(value, rel=2e-3), name
    assert found.converged and found.rms["position"] < 1.1e-7
    # Damping that does not decay has no velocity at which it would.
    assert found.verdict.light == ("green" if len(told) == len(law) else "yellow")
    assert set(found.not_identifiable) == {f"friction.lugre.{name}" for name in law.keys() - told.keys()}


@pytest.mark.parametrize("inputs", ["lines", "smooth"])
def test_force_that_varies_between_samples_gives_the_bristle_at_the_defaults(inputs: str) -> None:
    """Held from sample to sample it is half a sample late, which moves the mass by 300 times the noise."""
    data = pushed(PUBLISHED, 5.0, 3.0, given, inputs)
    known = {"mass": 5.0, "friction.lugre.vd": 0.0}
    found = ps.fit(data, experiment="force", law="LuGre", settings=known, progress=False)
    for name in PUBLISHED.keys() - {"vd"}:
        assert found.values[f"friction.lugre.{name}"] == pytest.approx(PUBLISHED[name], rel=2e-4), name
    assert found.problem.experiment.options.inputs == inputs and found.verdict.light == "green"
    assert found.rms["position"] < 1.1e-7 and any("between samples" in note for note in found.notes)


def test_exact_pressures_give_the_bristle_at_the_defaults() -> None:
    """Pressures run on a smooth curve; in steps of their means they leave more than noise."""
    data = pushed(PUBLISHED, 5.0, 3.0, given, "smooth")
    force, behind = data.pop("force"), 3e5
    piston, rod, ambient = 0.25 * math.pi * 0.032**2, 0.25 * math.pi * 0.012**2, 101_325.0
    data["chamberA.pressure"] = (force + behind * (piston - rod) + ambient * rod) / piston
    data["chamberB.pressure"] = np.full_like(force, behind)
    known = {"mass.moving": 5.0, "cylinder.bore": 0.032, "cylinder.rod": 0.012, "ambientPressure": ambient,
             "friction.kappaA": 0.0, "friction.kappaB": 0.0, "friction.lugre.vd": 0.0}  # fmt: skip
    found = ps.fit(data, experiment="mechanical", law="LuGre", settings=known, progress=False)
    for name in PUBLISHED.keys() - {"vd"}:
        assert found.values[f"friction.lugre.{name}"] == pytest.approx(PUBLISHED[name], rel=2e-4), name
    assert found.verdict.light == "green" and found.rms["position"] < 1.1e-7


def test_form_of_the_law_that_is_held_is_noted_and_the_other_one_is_tried() -> None:
    """A default counts where nobody gives or frees `vd`: damping that decays, or, with 0, as first published."""
    data = pushed(PUBLISHED, 5.0, 1.0, given)
    free = [f"friction.lugre.{name}" for name in PUBLISHED if name != "vd"]
    for known, item, other in (({}, "0.01", "0"), ({"friction.lugre.vd": 0.0}, "0", "0.01")):
        found = ps.fit(data, experiment="force", law="LuGre", settings={"mass": 5.0, **known}, fit=free, starts=0,
                       progress=False)  # fmt: skip
        assert any("friction.lugre.vd = 0.01 m/s" in note for note in found.notes) is not bool(known)
        assert found.problem.native.choices() == [("friction.lugre.vd", item, [other])]
    freed = ps.fit(data, experiment="force", law="LuGre", settings={"mass": 5.0}, starts=0, progress=False)
    assert "friction.lugre.vd" in freed.values and freed.problem.native.choices() == []


def test_form_of_the_law_that_short_segments_hide_is_named() -> None:
    """Segments of a smoothed force leave no more than noise under damping that decays, too; whole records do not."""
    data = pushed(PUBLISHED, 5.0, 3.0, given)
    free = [f"friction.lugre.{name}" for name in PUBLISHED if name != "vd"]
    known = {"mass": 5.0, "friction.lugre.vd": 0.01}
    found = ps.fit(data, experiment="force", law="LuGre", settings=known, fit=free, starts=0, progress=False)
    [cause] = found.causes
    assert (cause.name, cause.given, cause.estimate, cause.is_sensor) == ("friction.lugre.vd", "0.01", "0", False)
    assert found.verdict.light != "green" and cause.text in found.verdict.text and found.suspect == cause


def exact(law: str, duration: float) -> dict[str, Array]:
    """A bench that is simulated ten times as often as its smooth force is sampled."""
    number = round(duration / STEP)
    often = np.arange(10 * number + 1) * 0.1 * STEP

    def force(time: Array) -> Array:
        wave = np.sin(1.4 * np.pi * time) * (0.5 + 0.15 * time)
        return np.asarray(14.0 * wave + 6.0 * np.sin(4.6 * np.pi * time))

    run = ps.Model("FrictionBench").simulate(
        {"friction.law": law, "mass": 2.0, "bench.drive": "Free"},
        # Each value is held for a tenth of a sample: in its middle it is right.
        inputs={"appliedForce": (often, force(often + 0.05 * STEP))}, stop=duration, step=0.1 * STEP,
    )  # fmt: skip
    noise = 1e-7 * np.random.default_rng(0).standard_normal(number + 1)
    return {"time": often[::10], "force": force(often[::10]), "position": run["position"][::10] + noise}


@pytest.mark.parametrize("law", ["Coulomb", "Stribeck", "ElastoPlastic"])
def test_exact_force_that_varies_gives_the_law_at_the_defaults(law: str) -> None:
    """By segments, or, where these leave more than noise, by whole records that go on from them."""
    found = ps.fit(exact(law, 3.0), experiment="force", law=law, settings={"mass": 2.0}, progress=False)
    defaults = ps.Model("FrictionBench").parameters
    for name, value in found.values.items():
        assert value == pytest.approx(defaults[name].default, rel=5e-3), name
    assert found.verdict.light == "green" and found.rms["position"] < 1.1e-7


@pytest.mark.parametrize(("law", "has_best"), [("Coulomb", True), ("LuGre", False)])
def test_interrupt_among_whole_records_keeps_what_segments_gave(law: str, has_best: bool) -> None:
    def stop(text: str) -> None:
        if "whole records, inputs smooth" in text:
            raise KeyboardInterrupt

    with pytest.raises(ps.Interrupted) as caught:
        ps.fit(exact(law, 1.0), experiment="force", law=law, settings={"mass": 2.2}, starts=0, progress=stop)
    found = caught.value.finished
    assert (found is not None) is has_best
    if has_best:
        assert found.message == "it was interrupted" and found.rms["position"] < 1e-4


def test_noisy_force_that_varies_between_samples_is_not_half_a_sample_late() -> None:
    """Held, it moves the friction by ten of its intervals, of which twice one holds all but for one time in 2,000."""
    data = exact("Coulomb", 3.0)
    rng = np.random.default_rng(1)
    data["position"] += 1e-6 * rng.standard_normal(len(data["time"]))
    data["force"] += 0.2 * rng.standard_normal(len(data["time"]))
    found = ps.fit(data, experiment="force", law="Coulomb", settings={"mass": 2.0}, starts=0, progress=False)
    bench = ps.Model("FrictionBench")
    for name, one in found.parameters.items():
        assert abs(one.value - bench.parameters[name].default) < one.high - one.low < 0.03 * one.value, (name, one)
    assert any("between samples" in note for note in found.notes)


def test_runs_of_a_fit_under_an_exact_force_are_repeated_and_tables_warn() -> None:
    """By its settings alone the bench is free, and a held force half a sample late."""
    data = exact("Coulomb", 1.0)
    found = ps.fit(data, experiment="force", law="Coulomb", settings={"mass": 2.0}, segment=10.0, starts=0,
                   progress=False)  # fmt: skip
    run, bench = found.simulate(), ps.Model("FrictionBench")
    assert run.has_lines and run[["position", "appliedForce"]].has_lines
    given = {"stop": run.time[-1], "step": STEP, "outputs": ["position"]}
    several = bench.simulate_many([run.settings, run.settings], inputs=run, **given)
    assert np.max(np.abs(several["position"] - run["position"])) < 1e-12
    plain = bench.simulate(found, inputs={"appliedForce": (data["time"], data["force"])}, **given)
    assert 1e-6 < np.max(np.abs(plain["position"] - run["position"])) < 5e-4
    with pytest.warns(ps.PlantWarning, match="on straight lines from row to row"):
        run.to_pandas()
    again = bench.simulate(run.settings, inputs=run, **given)
    with pytest.raises(ValueError, match="with inputs held over each step"):
        again.vjp({"position": 1.0})

"""FMUs as models of the Python package: the bits of the native model, and refusals of what the interface cannot do."""

from __future__ import annotations

import copy
import pickle
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest

TIME = np.linspace(0, 0.2, 201)
DRIVE = {"driveVelocity": (TIME, 0.02 * np.sin(40 * TIME))}
OUTPUTS = ["position", "frictionForce", "friction.deflection", "sticking", "solver.steps"]
SETTINGS = {"friction.law": "LuGre", "bench.drive": "PrescribedMotion", "mass": "2 kg"}


@pytest.fixture(scope="module")
def bench(fmus: Path) -> ps.Model:
    """The friction bench in an FMU."""
    return ps.Model(fmus / "FrictionBench.fmu")


def test_an_fmu_has_the_variables_of_its_model(bench: ps.Model) -> None:
    native = ps.Model("FrictionBench")
    for mine, its in ((bench.inputs, native.inputs), (bench.outputs, native.outputs)):
        assert list(mine) == list(its)
    # Integers that stand for the names of enumerations are for tools that know no names.
    for name, variable in native.parameters.items():
        own = bench.parameters[name]
        assert (own.unit, own.default, own.minimum, own.maximum, own.kind) == (
            variable.unit, variable.default, variable.minimum, variable.maximum, variable.kind,
        ), name  # fmt: skip
    assert (bench.stop, bench.step) == (native.stop, native.step)


def test_runs_and_steps_have_the_bits_of_the_native_model(bench: ps.Model) -> None:
    runs = [
        model.simulate(SETTINGS, inputs=DRIVE, stop=0.2, step=1e-3, outputs=OUTPUTS)
        for model in (bench, ps.Model("FrictionBench"))
    ]
    for name in OUTPUTS:
        assert np.array_equal(runs[0][name], runs[1][name]), name
    both = [model.start(SETTINGS) for model in (bench, ps.Model("FrictionBench"))]
    for simulation in both:
        simulation["driveVelocity"] = "10 mm/s"
        for _ in range(10):
            simulation.step(1e-3)
    assert both[0]["friction.law"] == "LuGre"
    of, to = ["frictionForce", "der(friction.deflection)"], ["driveVelocity", "friction.deflection"]
    assert np.array_equal(both[0].jacobian(of, to), both[1].jacobian(of, to))


def test_warnings_of_the_fmu_are_told(bench: ps.Model) -> None:
    with pytest.warns(
        ps.PlantWarning, match=r"^friction.dahl.sigma0 has no effect: it counts only with friction.law = Dahl"
    ):
        bench.start({"friction.law": "LuGre", "friction.dahl.sigma0": 7e6})


def test_a_state_is_saved_copied_and_restored(bench: ps.Model) -> None:
    simulation = pickle.loads(pickle.dumps(bench)).start(SETTINGS)
    simulation.step(1e-3)
    saved, other = simulation.save(), copy.copy(simulation)
    for run in (simulation, other):
        run.step(0.01)
    assert simulation["position"] == other["position"] != 0.0
    end = simulation["position"]
    simulation.restore(saved)
    assert simulation.time == 1e-3
    simulation.step(0.01)
    assert simulation["position"] == end


def test_laws_of_an_fmu_are_compared(bench: ps.Model) -> None:
    runs = bench.simulate_many(
        [{"friction.law": law} for law in ("LuGre", "Stribeck")], inputs={"driveVelocity": 0.01}, stop=0.1, step=1e-3,
        progress=False,
    )  # fmt: skip
    alone = ps.Model("FrictionBench").simulate(
        {"friction.law": "Stribeck"}, inputs={"driveVelocity": 0.01}, stop=0.1, step=1e-3
    )
    assert np.array_equal(runs[1]["position"], alone["position"])


def test_what_an_fmu_cannot_do_is_refused_by_name(bench: ps.Model, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"mass = -1 kg is refused: it must be 0\.001 to 10000 kg"):
        bench.start({"mass": -1})
    with pytest.raises(ValueError, match="must be one of"):
        bench.start({"friction.law": "Unheard"})
    simulation = bench.start()
    with pytest.raises(ValueError, match="python_module!"):
        simulation.transition(1e-3)
    with pytest.raises(ValueError, match="python_module!"):
        simulation.move_states({"position": 0.1})
    with pytest.raises(ValueError, match="python_module!"):
        bench.simulate(stop=0.1, sensitivities=["mass"])
    text = tmp_path / "text.fmu"
    text.write_text("no archive", encoding="utf-8")
    with pytest.raises(ValueError, match=r"text\.fmu is no FMU"):
        ps.Model(text)
    foreign = tmp_path / "foreign.fmu"
    with zipfile.ZipFile(foreign, "w") as archive:
        archive.writestr("modelDescription.xml", '<fmiModelDescription fmiVersion="2.0" generationTool="another"/>')
    with pytest.raises(ValueError, match="no FMU of this library; FMPy runs others"):
        ps.Model(foreign)


@pytest.fixture(scope="module")
def controller(fmus: Path) -> str:
    """The controller in an FMU."""
    return str(fmus / "PositionController.fmu")


LOOP: dict[str, Any] = {
    "inputs": {"referencePosition": lambda t: 0.25 + 0.04 * np.sin(9.0 * t), "externalForce": lambda t: 20.0 * t},
    "stop": 0.2, "step": 1e-3, "outputs": ["position", "valveVoltage"], "record": ["integral", "positionError"],
}  # fmt: skip


@pytest.mark.parametrize(
    "options", [{}, {"period": 3e-3, "every": 7}, {"period": 2e-3, "delay": 5e-3}, {"start": 0.7, "stop": 1.1}],
    ids=["each step", "every third", "late", "another clock"],
)  # fmt: skip
def test_an_fmu_as_controller_has_the_bits_of_its_model(controller: str, options: dict[str, Any]) -> None:
    gains = {"gain.velocity": 6.0}
    own, packed = (
        ps.Model().simulate({"position0": "250 mm"}, controller=(name, gains), **{**LOOP, **options})
        for name in ("PositionController", controller)
    )
    for name in own:
        assert own[name].tobytes() == packed[name].tobytes(), name
    assert np.ptp(packed["integral"][1:]) > 0.0
    # It is given back as it is at the end, and goes on alike.
    for run in (own, packed):
        run.controller.set({"position": 0.2})
        run.controller.step(options.get("period", 1e-3))
    assert own.controller["valveVoltage"] == packed.controller["valveVoltage"] != packed["valveVoltage"][-1]


def test_loops_with_an_fmu_as_controller_run_on_all_cores(controller: str) -> None:
    masses = {"mass.moving": np.linspace(0.8, 1.6, 6)}
    own, packed = (
        ps.Model().simulate_many(masses, controller=name, workers=workers, progress=False, **LOOP)
        for name, workers in (("PositionController", 1), (controller, 3))
    )
    for name in LOOP["outputs"] + LOOP["record"]:
        assert own[name].tobytes() == packed[name].tobytes(), name


def test_what_an_fmu_as_controller_refuses_and_warns_of_is_told(controller: str) -> None:
    plant, short = ps.Model(), {**LOOP, "inputs": {"referencePosition": 0.3}, "stop": 0.01}
    with pytest.raises(ValueError, match=r"gain\.position = -1 .*is refused"):
        plant.simulate(controller=(controller, {"gain.position": -1.0}), **short)
    with pytest.raises(ValueError, match=r"referencePosition = nan"):
        plant.simulate(
            controller=controller, **{**short, "inputs": {"referencePosition": lambda t: 0.3 if t < 5e-3 else np.nan}}
        )
    with pytest.raises(ValueError, match=r"record: the controller has no variable eror"):
        plant.simulate(controller=controller, **{**short, "record": ["eror"]})


def test_settings_are_all_or_none(controller: str) -> None:
    simulation = ps.Model(controller).start()
    before = simulation["referencePosition"]
    with pytest.raises(ValueError, match="is refused"):
        simulation.set({"referencePosition": 0.123, "position": float("nan")})
    assert simulation["referencePosition"] == before
    simulation.set({"referencePosition": 0.123, "position": 0.2})
    assert simulation["referencePosition"] == 0.123

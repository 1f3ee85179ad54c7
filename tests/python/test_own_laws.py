"""A user's laws in the Python package: the module that `examples/own/law` makes with the feature `python`."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere maturin links a module")


@pytest.fixture(scope="module")
def module(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the module."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "examples/own/target"))
    build = ["cargo", "build", "--locked", "--quiet", "--profile=quick", "--package=own-law", "--features=python"]
    subprocess.run([*build, "--target-dir", target], check=True, cwd=ROOT / "examples/own")
    folder = tmp_path_factory.mktemp("module")
    shutil.copy(target / "quick/libown_law.so", folder / "own_law.abi3.so")
    return folder


def answer(module: Path, program: str) -> str:
    """Output of a program that finds the module."""
    path = os.pathsep.join([str(module), os.environ.get("PYTHONPATH", "")])
    run, environment = [sys.executable, "-W", "error", "-c", program], {**os.environ, "PYTHONPATH": path}
    return subprocess.run(run, env=environment, check=True, text=True, stdout=subprocess.PIPE).stdout


def test_the_package_simulates_and_fits_laws_of_ones_own(module: Path) -> None:
    """Data of a law with a state are simulated, and its parameters found from them."""
    program = """
import numpy as np, own_law, pneumatic_servo as ps
t = np.linspace(0, 1, 1001)
known = {"friction.law": "RateAndState", "bench.drive": "PrescribedMotion", "friction.rateAndState.Fc": 7.0}
drive = {"driveVelocity": (t, 0.02 * np.sin(12 * t))}
outputs = ["position", "frictionForce", "friction.rateAndState.theta"]
run = ps.Model("FrictionBench").simulate(known, inputs=drive, stop=1, step=1e-3, outputs=outputs)
theta = run["friction.rateAndState.theta"]
assert theta[0] == 0.01 and theta[-1] < 0.01
data = {name: run[name] for name in ("time", "position", "frictionForce")}
found = ps.fit(data, experiment="motion", law="RateAndState", fit="friction.rateAndState.Fc", starts=2, progress=False)
print(found.values["friction.rateAndState.Fc"])
"""
    assert abs(float(answer(module, program)) - 7.0) < 0.05


def test_linearisations_transitions_and_child_processes_know_the_laws(module: Path) -> None:
    program = """
import subprocess, sys
import own_law, pneumatic_servo as ps
settings = {"friction.law": "WarmBristle", "valve.hysteresis": 0}
linear = ps.linearise({"velocity": 0.05, **settings})
assert linear.states[-2:] == ("friction.warmBristle.bristle", "friction.warmBristle.temperature")
simulation = ps.Model("PneumaticServoCylinder").start(settings)
simulation.set(valveVoltage=6.5)
simulation.step(0.1)
step = simulation.transition(1e-3, outputs=["frictionForce"])
assert step.C[0, step.states.index("friction.warmBristle.temperature")] < 0, "it fades"
child = "import pneumatic_servo as ps; ps.Model('PneumaticServoCylinder').start({'friction.law': 'LaggedBristle'})"
subprocess.run([sys.executable, "-c", child], check=True)
print("known")
"""
    assert answer(module, program) == "known\n"


def test_a_module_that_comes_after_the_package_is_refused(module: Path) -> None:
    program = """
import pneumatic_servo
try:
    import own_law
except ImportError as error:
    print(error)
"""
    assert answer(module, program) == "import own_law before pneumatic_servo, which has its models already\n"

"""Hosts with small stacks, and hosts that trap floating-point exceptions, as OpenFOAM and Delphi do by default.

`strict_host.c` measures each call of the packaged libraries; what is promised is promised of them.
"""

from __future__ import annotations

import platform
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest
from fmpy import extract, read_model_description
from fmpy.model_description import ScalarVariable
from shared import LAWS

CYLINDER = "PneumaticServoCylinder"
KINDS = {2: ("steps", "exchange"), 3: ("steps", "events", "exchange")}

OPTIONS: dict[str, dict[str, float]] = {
    "hoses": {"hoseA.length": 1.0, "hoseB.length": 0.5},
    "vessel": {"supply.volume": 1e-3},
    "open": {"chamberB.open": 1},
    "flow controls": {"hoseA.length": 0.1, "hoseB.length": 0.1, "throttleA.C": 1e-9, "throttleB.C": 1e-9},
    "cushions": {"hoseA.length": 0.1, "hoseB.length": 0.1, "cushion.length": 0.01},
    "spring": {"load.stiffness": 100.0, "load.rest": 0.25},
    "sensors": {f"sensor.{of}.{what}": 1e-3 for of in ("position", "force") for what in ("lag", "noise", "sampleTime")},
    "regulator": {"actuation": 2},
    "switching valves": {"actuation": 3},
    "coils": {"actuation": 3, "switching.command": 3, "coil[1]": 1, "coil[4]": 1},
    "polytropic": {"thermal.model": 3},
    "servo": {"thermal.model": 4, "balance.enabled": 0},
    "balance": {"balance.enabled": 1},
    "everything": {
        "hoseA.length": 1.0,
        "hoseB.length": 0.5,
        "supply.volume": 1e-3,
        "sensor.position.lag": 1e-3,
        "sensor.force.lag": 1e-3,
        "actuation": 3,
        "balance.enabled": 1,
    },
    **{f"scheme {scheme}": {"solver.scheme": scheme} for scheme in (2, 3, 4, 5)},
}
"""Options of the cylinder, each with the law GMS, which has the most states."""

pytestmark = pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="stacks and traps need glibc")


class Packed(NamedTuple):
    """An unpacked FMU."""

    library: Path
    token: str
    variables: dict[str, ScalarVariable]
    version: int
    step: float
    states: int
    indicators: int


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The host, compiled."""
    program = tmp_path_factory.mktemp("host") / "strict_host"
    source = Path(__file__).with_name("strict_host.c")
    compiler = ["gcc", "-std=gnu11", "-O2", "-Wall", "-Wextra", "-Werror"]
    subprocess.run([*compiler, "-o", program, source, "-ldl", "-lm", "-lpthread"], check=True)
    return program


@pytest.fixture(scope="module")
def packed(fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, int], Packed]:
    """All FMUs by model and version."""
    found = {}
    for version, folder in ((2, fmus), (3, fmus / "fmi3")):
        for file in folder.glob("*.fmu"):
            description = read_model_description(str(file))
            room = tmp_path_factory.mktemp(f"{file.stem}{version}")
            extract(str(file), str(room))
            [library] = (room / "binaries").glob(f"*/{file.stem}.so")
            found[file.stem, version] = Packed(
                library,
                description.guid if version == 2 else description.instantiationToken,
                {variable.name: variable for variable in description.modelVariables},
                version,
                float(description.defaultExperiment.stepSize),
                description.numberOfContinuousStates,
                description.numberOfEventIndicators,
            )
    return found


def setting(packed: Packed, name: str, value: float) -> str:
    """Line for the host that sets a parameter, or an input for good."""
    variable = packed.variables[name]
    letter = {"Real": "r", "Float64": "r", "Boolean": "b"}.get(variable.type, "e" if packed.version == 3 else "i")
    if variable.type in ("Integer", "Int32"):
        letter = "i"
    return f"{letter}:{variable.valueReference}:{value}"


def settings(packed: Packed, parameters: dict[str, float], kind: str, steps: int, swing: float) -> list[str]:
    """Parameters, inputs that swing, and outputs to look at."""
    given = [setting(packed, name, value) for name, value in parameters.items()]
    for number, variable in enumerate(packed.variables.values()):
        if variable.causality == "input" and variable.type != "Boolean":
            amplitude = swing * float(variable.nominal or 1.0) * (0.1 if variable.name == "supplyPressure" else 1.0)
            frequency = 2.0 + 0.3 * (number % 5)
            given.append(f"u:{variable.valueReference}:{float(variable.start)}:{amplitude}:{frequency}")
    outputs = [it for it in packed.variables.values() if it.causality == "output" and it.type in ("Real", "Float64")]
    given += [f"y:{variable.valueReference}" for variable in outputs[:8]]
    # A host that integrates by Euler's method needs short steps.
    size = 1e-6 if kind == "exchange" else packed.step
    return [*given, f"states:{packed.states}:{packed.indicators}", f"steps:{steps}:{size}"]


def call(program: Path, packed: Packed, kind: str, mode: str, given: list[str]) -> dict[str, tuple[int, int]]:
    """Stack and exceptions of each function."""
    command = [str(program), str(packed.library), str(packed.version), kind, mode, packed.token, *given]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, f"{done.returncode} {done.stderr} of {' '.join(command)}"
    rows = [line.split() for line in done.stdout.splitlines()]
    return {name: (int(stack), int(flags)) for name, stack, flags in rows}


def check(program: Path, packed: Packed, parameters: dict[str, float], steps: int = 40, swing: float = 0.6) -> None:
    """Every function of every kind has a small stack and raises nothing."""
    for kind in KINDS[packed.version]:
        if kind == "exchange" and not packed.states:
            continue
        for function, (stack, flags) in call(
            program, packed, kind, "flags", settings(packed, parameters, kind, steps, swing)
        ).items():
            assert stack <= 64 * 1024, f"{function} ({kind}) takes {stack} bytes with {parameters}"
            assert flags == 0, f"{function} ({kind}) raises {flags} with {parameters}"


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    "model", [CYLINDER, "FrictionBench", "PositionController", "DrivenSlider", "VibroImpact", "Festoon"]
)
def test_every_law_gets_by_with_a_small_stack_and_raises_nothing(
    program: Path, packed: dict[tuple[str, int], Packed], model: str, version: int
) -> None:
    fmu = packed[model, version]
    laws = range(1, len(LAWS) + 1) if "friction.law" in fmu.variables else [None]
    for law in laws:
        check(program, fmu, {} if law is None else {"friction.law": law})


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("option", OPTIONS)
def test_every_option_gets_by_with_a_small_stack_and_raises_nothing(
    program: Path, packed: dict[tuple[str, int], Packed], option: str, version: int
) -> None:
    check(program, packed[CYLINDER, version], {"friction.law": LAWS.index("GMS") + 1, **OPTIONS[option]})


@pytest.mark.parametrize("law", LAWS)
def test_host_that_traps_exceptions_is_not_stopped(
    program: Path, packed: dict[tuple[str, int], Packed], law: str
) -> None:
    """Two seconds of a motion that sticks and slides."""
    fmu = packed[CYLINDER, 3]
    given = settings(fmu, {"friction.law": LAWS.index(law) + 1}, "steps", 2000, 0.4)
    assert call(program, fmu, "steps", "traps", given)

"""The same run through other hosts than FMPy: libcosim, Ecos, and the checker of the FMU manipulation toolbox.

All hold the input over steps of 1 ms. They compute the times of the steps in different ways (products, sums, integer
nanoseconds), which differ in the last bits; so may the results, by a thousand times that.

Besides, hosts that load and unload libraries again and again.
"""

from __future__ import annotations

import _ctypes
import ctypes
import platform
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from bounds import assert_close
from client import Client
from fmpy import extract, read_model_description

VOLTAGE = 7.0
STEPS = 200
OUTPUTS = ["position", "velocity", "chamberA.pressure", "chamberB.pressure", "frictionForce"]
ROUNDING = 1e-9
"""Relative."""


LAWS = {"by default": 0, "Dahl": 10, "LuGre": 14}
"""Numbers of laws; 0 leaves the choice to the enumeration, which is at Stribeck."""


@pytest.fixture(scope="module")
def expected(fmu: Path) -> dict[str, list[float]]:
    """Results of FMPy under each law, chosen by its name.

    After 5 V while initializing, 7 V move the carriage through the middle of its stroke.
    """
    return {law: found_by_fmpy(fmu, "Stribeck" if number == 0 else law) for law, number in LAWS.items()}


def found_by_fmpy(fmu: Path, law: str) -> list[float]:
    with Client(fmu) as client:
        client.start({"friction.law": law})
        client.set({"valveVoltage": VOLTAGE})
        for step in range(STEPS):
            client.advance((step + 1) * 1e-3)
        return client.get(OUTPUTS)


def test_laws_are_told_apart(expected: dict[str, list[float]]) -> None:
    """By a hundred thousand times what the hosts may differ: positions by 0.1 mm and more."""
    positions = sorted(found[0] for found in expected.values())
    assert min(b - a for a, b in pairwise(positions)) > 1e-4, positions


@pytest.mark.parametrize("law", LAWS)
def test_libcosim_gives_the_same_results(fmu: Path, expected: dict[str, list[float]], law: str) -> None:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    with Client(fmu) as client:
        names = ["friction.lawNumber", "valveVoltage", *OUTPUTS]
        number, voltage, *outputs = [client.variables[name].valueReference for name in names]
    execution = CosimExecution.from_step_size(step_size=1_000_000)  # ns
    plant = execution.add_local_slave(CosimLocalSlave(fmu_path=str(fmu), instance_name="plant"))
    assert execution.integer_initial_value(plant, number, LAWS[law])
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    execution.add_manipulator(manipulator)
    execution.add_observer(observer)
    manipulator.slave_real_values(plant, [voltage], [VOLTAGE])
    for _ in range(STEPS):
        assert execution.step()
    assert_close(
        observer.last_real_values(plant, outputs),
        expected[law],
        rel=ROUNDING,
        what="outputs",
        why="hosts count time differently",
    )


@pytest.mark.parametrize("law", LAWS)
def test_ecos_gives_the_same_results(fmu: Path, expected: dict[str, list[float]], law: str) -> None:
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        structure.add_model("plant", fmu)
        structure.add_parameter_set("law", {"plant::friction.lawNumber": LAWS[law]})
        with EcosSimulation(structure=structure, step_size=1e-3) as simulation:
            simulation.init(parameter_set="law")
            simulation.set_real("plant::valveVoltage", VOLTAGE)
            for _ in range(STEPS):
                simulation.step()
            found = [simulation.get_real(f"plant::{name}") for name in OUTPUTS]
    assert_close(found, expected[law], rel=ROUNDING, what="outputs", why="hosts count time differently")


@pytest.mark.parametrize("model", ["PneumaticServoCylinder", "PositionController"])
def test_toolbox_finds_no_error(fmu: Path, model: str) -> None:
    tool = Path(sys.executable).with_name("fmutool")
    answer = subprocess.run(
        [tool, "-input", fmu.with_name(f"{model}.fmu"), "-check"], capture_output=True, text=True, check=True
    )
    text = answer.stdout + answer.stderr
    assert "seems to be compliant with FMI-2.0" in text, text
    assert "No semantic error" in text, text
    assert "ERROR" not in text, text


CYCLES = 500
LEFT = 4096
"""Bytes that a cycle may leave behind."""


class Heap(ctypes.Structure):
    """Size of the heap of the main thread by `mallinfo2` of glibc."""

    _fields_ = [
        ("unused", 4 * ctypes.c_size_t),
        ("mapped", ctypes.c_size_t),
        ("unused_too", 2 * ctypes.c_size_t),
        ("allocated", ctypes.c_size_t),
        ("free", 2 * ctypes.c_size_t),
    ]


def used() -> int:
    """Bytes that are allocated now."""
    mallinfo = ctypes.CDLL(None).mallinfo2
    mallinfo.restype = Heap
    heap = mallinfo()
    return int(heap.allocated + heap.mapped)


def load_and_unload(library: Path, token: bytes, version: int) -> None:
    """Make an instance with a freshly loaded library, free it, and unload the library."""
    handle = _ctypes.dlopen(str(library), ctypes.DEFAULT_MODE)
    text, pointer, flag = ctypes.c_char_p, ctypes.c_void_p, ctypes.c_bool
    if version == 2:
        make = ctypes.CFUNCTYPE(pointer, text, ctypes.c_int, text, text, pointer, ctypes.c_int, ctypes.c_int)(
            _ctypes.dlsym(handle, "fmi2Instantiate")
        )
        instance = make(b"a", 1, token, None, None, 0, 0)
    else:
        settings = [text, text, text, flag, flag, flag, flag, pointer, ctypes.c_size_t, pointer, pointer, pointer]
        make = ctypes.CFUNCTYPE(pointer, *settings)(_ctypes.dlsym(handle, "fmi3InstantiateCoSimulation"))
        instance = make(b"a", token, None, False, False, False, False, None, 0, None, None, None)
    assert instance
    ctypes.CFUNCTYPE(None, pointer)(_ctypes.dlsym(handle, f"fmi{version}FreeInstance"))(instance)
    _ctypes.dlclose(handle)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="the heap is asked through glibc")
@pytest.mark.parametrize("version", [2, 3])
def test_library_leaves_no_memory_behind_when_it_is_unloaded(fmus: Path, tmp_path: Path, version: int) -> None:
    """A study loads and unloads FMUs of several models in turn, some thousand times."""
    loaded = []
    for file in sorted((fmus if version == 2 else fmus / "fmi3").glob("*.fmu")):
        description = read_model_description(str(file))
        extract(str(file), str(tmp_path / file.stem))
        [library] = (tmp_path / file.stem / "binaries").glob(f"*/{file.stem}.so")
        token = description.guid if version == 2 else description.instantiationToken
        loaded.append((library, token.encode()))
    assert len(loaded) > 5

    def cycle() -> None:
        for library, token in loaded:
            load_and_unload(library, token, version)

    for _ in range(10):
        cycle()
    before = used()
    for number in range(1, CYCLES + 1):
        cycle()
        assert used() - before < LEFT * max(number, 50)

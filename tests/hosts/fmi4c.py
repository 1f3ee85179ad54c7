"""Runs a configured cylinder in fmi4c, whose library is built from its sources, in both versions of FMI.

    cmake -S fmi4c -B build && cmake --build build --target fmi4c
    python tests/hosts/fmi4c.py build/libfmi4c.so

It compares each sample with a run of the Python package to the bit, and ends with 1 where one differs.
"""

from __future__ import annotations

import ctypes
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps

FMUS = Path(__file__).resolve().parents[2] / "target" / "fmu"
MACHINE = {"friction.law": "LuGre", "mass.moving": 3.1, "position0": 0.1, "supplyPressure": 6.5e5}
NAMES = ["position", "velocity", "chamberA.pressure", "chamberB.pressure", "frictionForce"]
STEP, STEPS, VOLTAGE = 2.0**-10, 400, 6.5
CO_SIMULATION = 1

Real, Size, Pointer = ctypes.c_double, ctypes.c_size_t, ctypes.c_void_p
LOGGER = ctypes.CFUNCTYPE(None, Pointer)


def function(library: ctypes.CDLL, name: str, result: Any, *arguments: Any) -> Callable[..., Any]:
    called = getattr(library, name)
    called.restype, called.argtypes = result, arguments
    return called  # type: ignore[no-any-return]


def references(library: ctypes.CDLL, fmu: int, version: int) -> dict[str, int]:
    by_name = function(library, f"fmi{version}_getVariableByName", Pointer, Pointer, ctypes.c_char_p)
    prefix = "fmi2_getVariableValueReference" if version == 2 else "fmi3_getVariableValueReference"
    reference = function(library, prefix, ctypes.c_uint if version == 3 else ctypes.c_long, Pointer)
    return {name: reference(by_name(fmu, name.encode())) for name in [*NAMES, "valveVoltage"]}


def run(library: ctypes.CDLL, file: Path, version: int) -> list[list[float]]:
    """The samples after each step."""
    load = function(library, "fmi4c_loadFmu", Pointer, ctypes.c_char_p, ctypes.c_char_p)
    fmu = load(str(file).encode(), b"axis7")
    assert fmu, "fmi4c does not load the FMU"
    number = references(library, fmu, version)
    silent = LOGGER(lambda _: None)
    boolean = ctypes.c_int if version == 2 else ctypes.c_bool
    doubles, unsigned = ctypes.POINTER(Real), ctypes.POINTER(ctypes.c_uint)
    if version == 2:
        c = ctypes.CDLL(None)
        arguments = [Pointer, ctypes.c_int, LOGGER, Pointer, Pointer, Pointer, Pointer, boolean, boolean]
        instantiate = function(library, "fmi2_instantiate", Pointer, *arguments)
        memory = [ctypes.cast(called, Pointer) for called in (c.calloc, c.free)]
        plant = instantiate(fmu, CO_SIMULATION, silent, *memory, None, None, False, False)
        setup = function(library, "fmi2_setupExperiment", ctypes.c_int, Pointer, boolean, Real, Real, boolean, Real)
        assert setup(plant, False, 0.0, 0.0, False, 0.0) == 0
        enter = function(library, "fmi2_enterInitializationMode", ctypes.c_int, Pointer)
        entered = enter(plant)
    else:
        flags = [ctypes.c_bool] * 4
        arguments = [Pointer, *flags, unsigned, Size, Pointer, LOGGER, Pointer]
        instantiate = function(library, "fmi3_instantiateCoSimulation", Pointer, *arguments)
        plant = instantiate(fmu, False, False, False, False, None, 0, None, silent, None)
        arguments = [Pointer, boolean, Real, Real, boolean, Real]
        enter = function(library, "fmi3_enterInitializationMode", ctypes.c_int, *arguments)
        entered = enter(plant, False, 0.0, 0.0, False, 0.0)
    assert plant and entered == 0, "the FMU refuses"
    several = [] if version == 2 else [Size]
    kind = "Real" if version == 2 else "Float64"
    put = function(library, f"fmi{version}_set{kind}", ctypes.c_int, Pointer, unsigned, Size, doubles, *several)
    get = function(library, f"fmi{version}_get{kind}", ctypes.c_int, Pointer, unsigned, Size, doubles, *several)
    assert put(plant, (ctypes.c_uint * 1)(number["valveVoltage"]), 1, (Real * 1)(VOLTAGE), *[1][: len(several)]) == 0
    leave = function(library, f"fmi{version}_exitInitializationMode", ctypes.c_int, Pointer)
    assert leave(plant) == 0
    told = [ctypes.POINTER(ctypes.c_bool)] * 3 + [doubles] if version == 3 else []
    step = function(library, f"fmi{version}_doStep", ctypes.c_int, Pointer, Real, Real, boolean, *told)
    wanted = (ctypes.c_uint * len(NAMES))(*(number[name] for name in NAMES))
    found, samples = (Real * len(NAMES))(), []
    for index in range(STEPS):
        answers = [ctypes.byref(ctypes.c_bool()) for _ in range(3)] + [ctypes.byref(Real())] if version == 3 else []
        assert step(plant, index * STEP, STEP, True, *answers) == 0
        assert get(plant, wanted, len(NAMES), found, *[len(NAMES)][: len(several)]) == 0
        samples.append(list(found))
    return samples


def main() -> None:
    library = ctypes.CDLL(str(Path(sys.argv[1]).resolve()))
    fmus = Path(sys.argv[2]) if len(sys.argv) > 2 else FMUS
    own = ps.Model().simulate(MACHINE, inputs={"valveVoltage": VOLTAGE}, stop=STEPS * STEP, step=STEP, outputs=NAMES)
    expected = np.column_stack([own[name] for name in NAMES])[1:]
    for version, folder in ((2, fmus), (3, fmus / "fmi3")):
        with tempfile.TemporaryDirectory() as place:
            source = folder / "PneumaticServoCylinder.fmu"
            (file,) = ps.export_fmu(Path(place) / "axis7.fmu", MACHINE, preset="minimal", source=source)
            samples = np.array(run(library, file, version))
        assert np.ptp(samples[:, 0]) > 1e-3
        same = np.array_equal(samples, expected)
        print(f"FMI {version}.0: {STEPS} steps, {'the bits of the package' if same else 'other values'}", flush=True)
        if not same:
            sys.exit(1)


if __name__ == "__main__":
    main()

"""Fixtures: the packaged FMU, an instance of it, and the default experiment."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from client import Client
from fmpy import read_model_description
from fmpy.model_description import ModelDescription

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session", autouse=True)
def _interrupts() -> None:
    """Let tests send interrupts: what a shell runs in the background ignores them, and so do its children."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def fmus() -> Path:
    """The folder of the packaged FMUs; `cargo xtask package` makes them."""
    folder = os.environ.get("FMU_FOLDER")
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return Path(folder) if folder else target / "fmu"


@pytest.fixture(scope="session")
def fmu(fmus: Path) -> Path:
    """The FMU that most tests are about."""
    file = fmus / "PneumaticServoCylinder.fmu"
    assert file.is_file(), f"{file} is missing: run `cargo xtask package` first"
    return file


@pytest.fixture(scope="session")
def description(fmu: Path) -> ModelDescription:
    """The model description as FMPy reads it."""
    return read_model_description(str(fmu))


@pytest.fixture
def client(fmu: Path) -> Iterator[Client]:
    """An instance that is not initialized yet."""
    with Client(fmu) as client:
        yield client

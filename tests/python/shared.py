"""Fixtures of several tests: the friction laws, and runs with the input of the default experiment."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NoReturn
from xml.etree import ElementTree

import numpy as np
import pytest
from client import Client
from experiment import signals

DESCRIPTION = Path(__file__).parents[2] / "modelDescription" / "PneumaticServoCylinder.xml"

LAWS = [item.get("name", "") for item in ElementTree.parse(DESCRIPTION).iterfind(".//*[@name='FrictionLaw']//Item")]
"""Every friction law, by the committed description."""

sine = signals("PneumaticServoCylinder")["valveVoltage"]
"""Valve voltage of the default experiment in V: 1 Hz, 5 +- 2 V."""


def is_styled(figure: Any) -> bool:
    """Whether a figure looks as all of the package do: fine, with an open frame."""
    return bool(figure.dpi == 120) and not any(axis.spines["top"].get_visible() for axis in figure.axes)


def faults(**signals: Any) -> list[str]:
    """What is said of a recorder that wrote these signals, by default 1 ms apart; two underscores are a dot."""
    from pneumatic_servo import Options
    from pneumatic_servo.identification.fitting import make_experiment

    rig = make_experiment("rig", "Stribeck", None, Options())
    rig.use(("time", "valveVoltage", "position", "chamberA.pressure", "chamberB.pressure"))
    given = {
        name.replace("__", "."): np.ascontiguousarray(course, dtype=np.float64) for name, course in signals.items()
    }
    given.setdefault("time", 1e-3 * np.arange(len(next(iter(given.values())))))
    found, _ = rig.native.recorder("a table", given, {}, lambda signal, row: f"row {row} of {signal}")
    return [text for text, *_ in found]


def left_out(reason: str) -> NoReturn:
    """Leave a test out, of which a line at the end tells; where everything has to be there, as on CI, fail it."""
    if os.environ.get("CI", "false") not in ("", "false"):
        pytest.fail(f"{reason}, and with CI set nothing is left out", pytrace=False)
    pytest.skip(reason)


def run(client: Client, stop: float, step: float, first: float = 0.0) -> Iterator[float]:
    """Steps from `first` to `stop`, with the input set at each communication point; yields after each step."""
    for index in range(round(first / step), round(stop / step)):
        client.set({"valveVoltage": sine(index * step)})
        client.advance((index + 1) * step)
        yield client.time

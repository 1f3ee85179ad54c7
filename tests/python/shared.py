"""What the tests share: the friction laws, and runs with the input of the default experiment."""

import math
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from client import Client

DESCRIPTION = Path(__file__).parents[2] / "modelDescription" / "PneumaticServoCylinder.xml"

LAWS = [item.get("name", "") for item in ElementTree.parse(DESCRIPTION).iterfind(".//*[@name='FrictionLaw']//Item")]
"""Every friction law, by the committed description."""



def sine(time: float) -> float:
    """Valve voltage in V: 1 Hz, 5 +- 2 V."""
    return 5.0 + 2.0 * math.sin(2.0 * math.pi * time)


def run(client: Client, stop: float, step: float, first: float = 0.0) -> Iterator[float]:
    """Steps from `first` to `stop`, with the input set at each communication point; yields after each step."""
    for index in range(round(first / step), round(stop / step)):
        client.set({"valveVoltage": sine(index * step)})
        client.advance((index + 1) * step)
        yield client.time

"""Goes on from a serialized state in a process of its own; prints the outputs after each step as JSON."""

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "packaging" / "python"))

from client import Client
from shared import run


def main(fmu: str, saved: str, first: str, stop: str, step: str, *outputs: str) -> None:
    with Client(Path(fmu)) as client:
        client.start()
        state = client.slave.deSerializeFMUstate(Path(saved).read_bytes())
        client.slave.setFMUstate(state)
        client.slave.freeFMUstate(state)
        client.time = float(first)
        rows = [client.get(outputs) for _ in run(client, float(stop), float(step), float(first))]
    json.dump(rows, sys.stdout)


if __name__ == "__main__":
    main(*sys.argv[1:])

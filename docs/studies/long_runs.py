"""An hour of the cylinder under ten laws, in communication steps of 1 ms with fresh voltages, or as long as you like.

Every law runs in two processes, whose outputs must have the same bits each second. The accounts of mass
and energy must close, and no process may grow. Ends with an error where one of this does not hold.

Usage: python docs/studies/long_runs.py [--seconds 604800] [--laws Stribeck LuGre ...]
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import math
import subprocess
import sys
import time
from pathlib import Path

import pneumatic_servo as ps
from tqdm import tqdm

ROOT = Path(__file__).resolve().parents[2]
LAWS = ["Stribeck", "Karnopp", "Polito", "Dahl", "Bristle", "LuGre", "Leuven", "GMS", "MaxwellSlip", "ElastoPlastic"]
STEP = 1e-3
PER_SECOND = round(1.0 / STEP)
SETTLED = 60
"""Seconds of a run after which its process has all the memory that it needs."""
MOST_GROWTH = 256
"""In kB: what Python's own bookkeeping takes."""
HELD = {"balance.massResidual": 3e-4, "balance.energyResidual": 50.0}
"""Roughly what both chambers hold, in kg and J."""
MOST_LOST = 0.01
"""Share of it that an account may be off after an hour, by errors of millions of steps: three times what is found."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=int, default=3600, help="simulated time of each run (default: an hour)")
    parser.add_argument("--laws", nargs="+", metavar="LAW", default=LAWS, help="friction laws (default: ten)")
    parser.add_argument("--output", type=Path, default=ROOT / "target" / "studies", help="folder of the table")
    parser.add_argument("--run", metavar="LAW", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.run:
        json.dump(run(options.run, options.seconds), sys.stdout)
        return 0
    options.output.mkdir(parents=True, exist_ok=True)
    file = options.output / "long_runs.csv"
    wrong: list[str] = []
    with file.open("w", newline="", encoding="utf-8") as table:
        for law in tqdm(options.laws, unit="law"):
            first, second = pair(law, options.seconds)
            writer = csv.DictWriter(table, list(first))
            if law == options.laws[0]:
                writer.writeheader()
            writer.writerow(first)
            table.flush()
            wrong += [f"{law}: {what}" for what in findings(first, second, options.seconds)]
    print(file, *wrong, sep="\n")
    return 1 if wrong else 0


def pair(law: str, seconds: int) -> list[dict[str, float | str]]:
    """The same run in two processes at once."""
    command = [sys.executable, __file__, "--run", law, "--seconds", str(seconds)]
    processes = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    outputs = [process.communicate()[0] for process in processes]
    failed = [process.returncode for process in processes if process.returncode]
    if failed:
        raise RuntimeError(f"{law}: a run ended with the code {failed[0]}")
    return [json.loads(output) for output in outputs]


def run(law: str, seconds: int) -> dict[str, float | str]:
    """One run: the digest of its outputs, the largest residuals, growth, and cost."""
    model = ps.Model()
    outputs = [name for name, variable in model.variables.items() if variable.role == "output"]
    plant = model.start({"friction.law": law, "balance.enabled": True})
    digest, worst, settled = hashlib.sha256(), dict.fromkeys(HELD, 0.0), 0
    begin = time.process_time()
    for second in range(seconds):
        for index in range(PER_SECOND):
            # The frequency moves, so that no second is like another.
            phase = (second + index * STEP) * (1.0 + 0.1 * math.sin(1e-2 * second))
            plant.set_one("valveVoltage", 5.0 + 2.0 * math.sin(2.0 * math.pi * phase))
            plant.step(STEP)
        digest.update(plant.get(outputs).tobytes())
        for name in worst:
            worst[name] = max(worst[name], abs(plant.get_one(name)))
        if second == min(SETTLED, seconds - 1):
            settled = resident()
    return {
        "law": law,
        "seconds": seconds,
        "digest": digest.hexdigest()[:16],
        **worst,
        "growth (kB)": resident() - settled,
        "solver steps": plant.get_one("solver.steps"),
        "processor time (s)": round(time.process_time() - begin, 1),
    }


def resident() -> int:
    """Memory of this process in kB."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS:"))


def findings(first: dict[str, float | str], second: dict[str, float | str], seconds: int) -> list[str]:
    """Differences of two runs that should be the same."""
    found = []
    if first["digest"] != second["digest"]:
        found.append(f"two processes differ, {first['digest']} and {second['digest']}")
    found += [f"grows by {one['growth (kB)']} kB" for one in (first, second) if not one["growth (kB)"] <= MOST_GROWTH]
    for name, held in HELD.items():
        most = MOST_LOST * held * max(1.0, seconds / 3600.0)
        if not first[name] <= most:
            found.append(f"{name} is {first[name]}, beyond {most:.1g}")
    return found


if __name__ == "__main__":
    sys.exit(main())

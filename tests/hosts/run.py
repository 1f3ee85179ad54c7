"""Runs the cylinder in the importers that a package index has, each in an environment of its own.

It prints a table of the results, of the released FMU and of one that is configured with the law and few ports; with
--write it renews that table in docs/tools/README.md. By hand before a release, after `cargo xtask package`, with a
Python that has the package:

    python tests/hosts/run.py [--write] [tool ...]

Without names of tools it runs all. `--environments` keeps the environments in a folder for the next time.
"""

from __future__ import annotations

import argparse
import datetime
import json
import subprocess
import sys
import tempfile
import venv
from pathlib import Path
from typing import Any

import pneumatic_servo as ps

HERE = Path(__file__).resolve().parent
PAGE = HERE.parents[1] / "docs" / "tools" / "README.md"
BEGIN, END = "<!-- hosts: written by `python tests/hosts/run.py --write` -->", "<!-- end -->"

TOOLS: dict[str, tuple[str, list[str], str]] = {
    "fmpy": ("FMPy", ["fmpy==0.3.32", "numpy==2.3.5"], "`simulate_fmu`, law by number"),
    "libcosim": ("libcosim", ["libcosimpy==0.0.6"], "initial values by value reference"),
    "ecos": ("Ecos", ["ecospy==0.7.2"], "a set of parameters"),
    "fmucontainer": (
        "FMU Manipulation Toolbox",
        ["fmu_manipulation_toolbox==2.0", "fmpy==0.3.32", "numpy==2.3.5"],
        "a container of the cylinder alone, run by FMPy",
    ),
    "pathsim": (
        "PathSim-FMI",
        ["pathsim-fmi==0.1.1", "pathsim==0.27.1", "fmpy==0.3.32", "fmu_manipulation_toolbox==2.0"],
        "without Boolean inputs and outputs; the sample of one step before",
    ),
    "sofirpy": ("sofirpy", ["sofirpy==1.0.2", "fmpy==0.3.32"], "law by number"),
    "syssimx": ("syssimx", ["syssimx==0.4.3", "fmpy==0.3.32"], "law by number; `supplyPressure` set at each step"),
    "fmuloader": ("fmuloader", ["fmuloader==0.1.2rc0"], "law by number"),
    "fmugym": ("fmugym", ["fmugym==0.2.0", "fmpy==0.3.32"], "default law, steps of 1/1024 s; observes 32-bit floats"),
    "gemseo_fmu": ("gemseo-fmu", ["gemseo-fmu==3.1.1", "fmpy==0.3.19"], "default law"),
    "estim8": ("estim8", ["estim8==0.1.6", "fmpy==0.3.32"], "not read"),
}


def environment(folder: Path, pins: list[str]) -> Path:
    """Python of an environment with these packages."""
    python = folder / "bin" / "python"
    if not python.exists():
        venv.create(folder, with_pip=True)
        install = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *pins]
        subprocess.run(install, check=True)
    return python


def answer(python: Path, arguments: list[str]) -> Any:
    """The last line that a program prints, as JSON."""
    with tempfile.TemporaryDirectory() as folder:
        run = [str(python), "-W", "ignore", str(HERE / "programs.py"), *arguments]
        printed = subprocess.run(run, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout
    return json.loads(printed.strip().splitlines()[-1])


def deviation(found: Any, client: Path, fmus: str) -> str:
    """How far a position is from that of the released FMU, set by hand and run by FMPy."""
    if isinstance(found, str):
        return f"refused: `{found}`"
    far = abs(found["position"] - answer(client, ["reference", fmus, json.dumps(found)]))
    return "none" if far == 0 else f"{far:.0e} m"


def main() -> None:
    arguments = argparse.ArgumentParser()
    arguments.add_argument("tools", nargs="*", metavar="tool", help=", ".join(TOOLS))
    arguments.add_argument("--fmus", type=Path, default=HERE.parents[1] / "target" / "fmu")
    arguments.add_argument("--environments", type=Path)
    arguments.add_argument("--write", action="store_true")
    given = arguments.parse_args()
    if unknown := set(given.tools) - set(TOOLS):
        sys.exit(f"no such tools: {', '.join(sorted(unknown))}; there are {', '.join(TOOLS)}")
    if given.write and given.tools:
        sys.exit("--write needs all tools")
    with tempfile.TemporaryDirectory() as kept:
        folder = (given.environments or Path(kept)).resolve()
        fmus = str(given.fmus.resolve())
        client = environment(folder / "fmpy", TOOLS["fmpy"][1])
        own = folder / "fmus"
        own.mkdir(exist_ok=True)
        source = given.fmus / "PneumaticServoCylinder.fmu"
        ps.export_fmu(own / "LuGre.fmu", {"friction.law": "LuGre"}, preset="minimal", source=source)
        lines = [
            "| tool | release | run on | how | deviation of the position | the same of a configured FMU |",
            "|---|---|---|---|---|---|",
        ]
        today = datetime.datetime.now(datetime.UTC).date()
        for tool in given.tools or TOOLS:
            name, pins, how = TOOLS[tool]
            python = environment(folder / tool, pins)
            runs = [answer(python, [tool, fmus]), answer(python, [tool, str(own), "--configured"])]
            deviations = [deviation(found, client, fmus) for found in runs]
            release = pins[0].split("==")[1]
            lines.append(f"| {' | '.join([name, release, str(today), how, *deviations])} |")
            print(lines[-1], flush=True)
    if given.write:
        before, rest = PAGE.read_text().split(BEGIN)
        _, after = rest.split(END, 1)
        PAGE.write_text(f"{before}{BEGIN}\n{chr(10).join(lines)}\n{END}{after}")


if __name__ == "__main__":
    main()

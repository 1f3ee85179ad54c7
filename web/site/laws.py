"""A page for each friction law: what it is, its equations, parameters, curves and source, and a way to try it.

Everything comes from the one list of laws: the tables of the package, the page inside the FMU, and runs of the bench.
"""

from __future__ import annotations

import html
import re
import sys
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "docs/studies"))

import matplotlib as mpl
import numpy as np
import pneumatic_servo as ps
import portraits
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from pneumatic_servo.figures import BLUE, GREY, STYLE, VERMILION
from portraits import BENCH, LAW, SOFT

CYLINDER = "PneumaticServoCylinder"

COURSE = [(1.3, 10.0), (1.0, 0.0), *[(0.25, 2.0), (0.25, -2.0)] * 4, (5.0, -4.0)]
"""Velocities in mm/s of the drive, with durations in s: it pulls, rests under load, turns often, goes back slowly."""

COMPARED = "Stribeck"
"""The law with which the others are compared."""

SETTINGS = STYLE | {"font.size": 10, "svg.hashsalt": "laws", "svg.fonttype": "none"}


@dataclass(frozen=True)
class Told:
    """Text on a law in the page inside the FMU."""

    equations: str
    source: str


@dataclass(frozen=True)
class Law:
    """A law of the list, and how it moves on the course of the comparison."""

    number: int
    name: str
    description: str
    time: NDArray[np.float64]
    position: NDArray[np.float64]


def laws() -> list[Law]:
    """All laws, in the order of their numbers."""
    items = ps.Model(BENCH).variables[LAW].items
    assert items is not None
    found = []
    for number, (name, description) in enumerate(items.items(), start=1):
        run = course(name)
        found.append(Law(number, name, description, run.time, run["position"]))
    return found


def course(law: str) -> ps.Run:
    """A mass on a spring, whose other end moves along the course."""
    times, speeds = [], []
    begin = 0.0
    for duration, speed in COURSE:
        times += [begin, begin + duration - 1e-9]
        speeds += [speed * 1e-3] * 2
        begin += duration
    inputs = {"driveVelocity": (np.array(times), np.array(speeds))}
    return ps.Model(BENCH).simulate({LAW: law, **SOFT}, inputs=inputs, stop=begin, step=5e-3)


def write_laws(out: Path, fmu: Path, table: str) -> list[Law]:
    """Write the pages; `table` is the text of the page that helps to choose, whose table of properties they repeat."""
    told = told_by(fmu)
    known = properties(table)
    every = laws()
    reference = next(law for law in every if law.name == COMPARED)
    # Figures lie where Sphinx takes files as they are: the pages show them in HTML.
    folder, figures = out / "laws", out / "extra" / "laws"
    for one in (folder, figures):
        one.mkdir(parents=True)
    for law in every:
        draw_all(law, reference, figures)
        (folder / f"{law.name}.md").write_text(page(law, told[law.name], known[law.name]), encoding="utf-8")
    return every


def difference(law: Law, every: list[Law]) -> float:
    """The largest distance in m from the law that all are compared with."""
    reference = next(other for other in every if other.name == COMPARED)
    return float(np.max(np.abs(law.position - reference.position)))


def told_by(fmu: Path) -> dict[str, Told]:
    """Equations and sources of the laws, from the page inside an FMU."""
    with zipfile.ZipFile(fmu) as archive:
        text = archive.read("documentation/index.html").decode("utf-8")
    section = re.search(r'<section id="friction">(.*?)</section>', text, re.DOTALL)
    assert section is not None, f"{fmu} tells no friction laws"
    sources = [re.sub(r"\s+", " ", item) for item in re.findall(r"<li>(.*?)</li>", section[1], re.DOTALL)]
    rows = re.findall(
        r"<tr><td>\d+</td><td><code>(\w+)</code></td><td>(.*?)</td><td>(.*?)</td></tr>", section[1], re.DOTALL
    )
    return {name: Told(equations, cited(source, sources)) for name, equations, source in rows}


def cited(short: str, sources: list[str]) -> str:
    """The full references of short ones such as `Dahl 1968; Iwan 1966`."""
    found = []
    for one in re.split(r"[;,] (?=[A-Z])", short):
        author, year = re.match(r"[^\W\d]+(?:[- ][^\W\d]+)*?(?= et al\.| \d|$)|", one)[0], re.search(r"\d{4}", one)  # type: ignore[index]
        full = [
            source
            for source in sources
            if author and source.startswith(author) and (year is None or f"({year[0]})" in source)
        ]
        found.append(full[0] if full else one)
    return "; ".join(dict.fromkeys(found))


def properties(text: str) -> dict[str, dict[str, str]]:
    """The rows of the first table of a page, by the name of the law."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    heads = [cell.strip() for cell in lines[0].strip("|").split("|")]
    found = {}
    for line in lines[2:]:
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) != len(heads):
            break
        found[cells[1]] = dict(zip(heads[2:], cells[2:], strict=True))
    return found


def page(law: Law, told: Told, known: dict[str, str]) -> str:
    has = "; ".join(f"{name}: {value}" for name, value in known.items() if value)
    tries = [
        ("Feel it stick and slip", f"view=stick-slip&{CYLINDER}.{LAW}={law.number}"),
        ("Beside Stribeck", f"view=two-laws&{CYLINDER}.{LAW}=7&second={law.number}"),
        ("Presliding loops", f"view=presliding&{BENCH}.{LAW}={law.number}"),
        ("In a position loop", f"view=closed-loop&{CYLINDER}.{LAW}={law.number}"),
    ]
    links = "\n".join(f'<a href="../playground.html#{html.escape(fragment)}">{text}</a>' for text, fragment in tries)
    plots = "\n".join(
        f'<figure><img src="{law.name}-{name}.svg" alt="{alternative} under {law.name}" loading="lazy">'
        f"<figcaption>{caption}</figcaption></figure>"
        for name, alternative, caption in PLOTS
    )
    return "\n".join(
        [
            f"# {law.name}\n",
            f"Law {law.number}. {law.description}.\n",
            f'``````{{raw}} html\n<p class="tries"><strong>Try it:</strong>\n{links}</p>\n``````\n',
            f"{has[0].upper() + has[1:]}.\n",
            "## Equations\n",
            f'``````{{raw}} html\n<p class="equations">{told.equations}</p>\n``````\n',
            "[Symbols and the Stribeck curve](../models/FrictionBench.md#friction-laws) are those that all laws share; "
            "[which law to take](../docs/friction-laws.md).\n",
            "## Curves\n",
            f'``````{{raw}} html\n<div class="law-plots">{plots}</div>\n``````\n',
            "## Parameters\n",
            parameters(law),
            "## Source\n",
            f"``````{{raw}} html\n<p>{told.source or 'None is needed.'}</p>\n``````\n",
        ]
    )


def parameters(law: Law) -> str:
    """The parameters that count for a law alone; an array has one row."""
    model = ps.Model(BENCH)
    group = next((name.rpartition(".")[0] for name in model.variables if counts_for(model, name, law.name)), None)
    if group is None:
        return "It has none.\n"
    rows = ["| parameter | default | range | what it is |", "|---|---|---|---|"]
    for name in model.variables:
        variable = model.variables[name]
        if not name.startswith(f"{group}.") or re.search(r"\[(?!1\])", name):
            continue
        text = re.sub(r" \(element 1\)$", ", one for each element", variable.text)
        unit = "" if variable.unit in ("", "1") else variable.unit
        low, high = (None if bound is None else short(bound) for bound in (variable.minimum, variable.maximum))
        bounds = f"{low} to {high}" if low and high else f"at least {low}" if low else ""
        rows.append(f"| `{name.replace('[1]', '[...]')}` | {short(variable.default)} {unit} | {bounds} | {text} |")
    return "\n".join(rows) + "\n"


def short(value: ps.Value | None) -> str:
    """A value without needless digits: 1e6 and not 1e+06."""
    if not isinstance(value, (int, float)):
        return str(value)
    return re.sub(r"e([+-])0*(\d)", lambda found: f"e{found[1].strip('+')}{found[2]}", f"{value:g}")


def counts_for(model: ps.Model, name: str, law: str) -> bool:
    return model.variables[name].counts_for == (LAW, law)


PLOTS = [
    ("steady", "Friction over velocity", "Friction at constant speed"),
    ("presliding", "Load over displacement", "Displacement under a load below break-away, with an inner loop"),
    ("stick-slip", "Position over time", "A mass drawn by a soft spring at 10 mm/s"),
    (
        "course",
        "Position over time",
        f"Pull, rest under load, small reversals, slow return: the mass, and its distance from that under {COMPARED}",
    ),
]


def draw_all(law: Law, reference: Law, folder: Path) -> None:
    drawn: dict[str, Callable[[Figure], None]] = {
        "steady": lambda figure: portraits.draw_steady(figure.subplots(), portraits.steady_curve(law.name)),
        "presliding": lambda figure: portraits.draw_presliding(figure.subplots(), portraits.presliding(law.name)),
        "stick-slip": lambda figure: draw_stick_slip(figure.subplots(), law.name),
        "course": lambda figure: draw_course(figure, law, reference),
    }
    for name, draw in drawn.items():
        with mpl.rc_context(SETTINGS):
            figure = Figure(figsize=(4.4, 3.2), layout="constrained")
            draw(figure)
            figure.savefig(folder / f"{law.name}-{name}.svg", metadata={"Date": None, "Creator": None})


def draw_stick_slip(axis: Axes, law: str) -> None:
    portraits.draw_stick_slip(axis, portraits.stick_slip(law))
    axis.legend()


def draw_course(figure: Figure, law: Law, reference: Law) -> None:
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    above.plot(reference.time, 1e3 * reference.position, "--", color=GREY, label=COMPARED)
    above.plot(law.time, 1e3 * law.position, color=BLUE, label=law.name)
    above.set_ylabel("Position in mm")
    above.legend(fontsize=8, loc="lower center", ncols=2)
    below.plot(law.time, 1e3 * (law.position - reference.position), color=VERMILION)
    below.set(xlabel="Time in s", ylabel="Difference\nin mm")

"""Layout of the pages of the site for Sphinx: of the repository, and made of its products.

The pages of the models are those inside the FMUs, the gallery shows the figures of `docs/studies/gallery.py`, and the
command line tells its own help. Nothing is written twice.
"""

from __future__ import annotations

import argparse
import html
import importlib
import inspect
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

import tomllib
from laws import COMPARED, Law, difference, properties, write_laws
from PIL import Image

PAGES = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "RELEASING.md", "SECURITY.md", "CODE_OF_CONDUCT.md"]
"""Pages at the root of the repository."""

MORE_PAGES = [
    "findings/README.md",
    "packaging/wasm-as-c/README.md",
    "python/README.md",
    "web/site/README.md",
    "tests/reference/README.md",
]
"""Pages in folders that are not taken as a whole; `docs` is."""

MOVED = {"site/README": "web/site/README"}
"""Addresses that pages once had, and their addresses now."""

LINK = re.compile(r"\]\(([^)\s#:]+)[^)\s]*\)")
"""A link to a file, without its anchor."""

GALLERY = {"PneumaticServoCylinder": "The default experiment", "FrictionBench": "On the bench"}
"""Models whose figures are shown, and under which heading."""

USUAL = ["Stribeck", "LuGre", "ElastoPlastic", "Coulomb", "SmoothCoulomb"]
"""Laws that most people look for: they come first in the gallery, the others by their ids."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmus", type=Path, required=True, help="the FMUs, whose pages are shown")
    parser.add_argument("--gallery", type=Path, help="the figures of every law; without it their page has no figures")
    parser.add_argument("--playground", type=Path, required=True, help="the page in which the plant runs")
    parser.add_argument("--rustdoc", type=Path, required=True, help="the documentation of the crate, as made by Cargo")
    parser.add_argument("--out", type=Path, required=True, help="where the pages are laid out")
    arguments = parser.parse_args()
    root = Path(__file__).parents[2]
    out: Path = arguments.out
    if out.exists():
        shutil.rmtree(out)
    extra = out / "extra"
    extra.mkdir(parents=True)
    copy_repository(root, out)
    shutil.copyfile(arguments.playground, extra / "playground.html")
    copy_rustdoc(arguments.rustdoc, extra / "rust")
    for fmu in sorted(arguments.fmus.glob("*.fmu")):
        write(out / "models" / f"{fmu.stem}.md", model_page(fmu))
    chooser = (root / "docs" / "friction-laws.md").read_text(encoding="utf-8")
    laws = write_laws(out, arguments.fmus / "FrictionBench.fmu", chooser)
    write(out / "laws" / "index.md", laws_page(laws, properties(chooser)))
    write(out / "gallery.md", gallery_page(laws, arguments.gallery, out / "gallery"))
    write_python(out / "reference")
    write(out / "reference" / "command-line.md", command_line_page())
    write(out / "reference" / "rust.md", rust_page(extra / "rust"))
    contents = (root / "web/site" / "contents.toml").read_text(encoding="utf-8")
    landing = (root / "web/site" / "index.md").read_text(encoding="utf-8")
    landing = landing.replace("DOWNLOADS", downloads(arguments.fmus, extra)).replace("PICTURE", picture(root, extra))
    run_program(landing, extra)
    write(out / "index.md", landing + "\n" + toctrees(tomllib.loads(contents)["part"], out))
    return 0


def write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")


def copy_repository(root: Path, out: Path) -> None:
    ignore = shutil.ignore_patterns("__pycache__")
    shutil.copytree(root / "docs", out / "docs", ignore=ignore)
    for name in [*PAGES, *MORE_PAGES]:
        copy(root, out, name)
    for name in pages(out):
        page = out / f"{name}.md"
        if page.is_file():
            copy_linked(root, out, page)
    shutil.copytree(root / "web/site" / "static", out / "static")
    copy_search(root / "web/site", out)
    shutil.copyfile(root / "web/site" / "conf.py", out / "conf.py")
    write(out / "repository.txt", package_of(root).get("repository", ""))
    for old, new in MOVED.items():
        address = f"{'../' * old.count('/')}{new}.html"
        head = f'<meta charset="utf-8"><title>Moved</title><meta http-equiv="refresh" content="0; url={address}">'
        write(
            out / "extra" / f"{old}.html",
            f'<!doctype html><html lang="en">{head}<a href="{address}">Moved</a></html>\n',
        )


def package_of(root: Path) -> dict[str, str]:
    """Package data in the manifest of the workspace."""
    package: dict[str, str] = tomllib.loads((root / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]
    return package


def downloads(fmus: Path, extra: Path) -> str:
    """Copy what can be used at once, and list it with its size; an FMU says for which systems it is."""
    folder = extra / "downloads"
    folder.mkdir()
    fmu = folder / "PneumaticServoCylinder.fmu"
    shutil.copyfile(fmus / fmu.name, fmu)
    with zipfile.ZipFile(fmu) as archive:
        systems = sorted(
            {name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/") and name.count("/") > 1}
        )
    rows = [
        (f"downloads/{fmu.name}", fmu, f"the plant for FMI 2.0, for {' and '.join(systems)}"),
        ("playground.html", extra / "playground.html", "the plant in one page, which needs no network"),
    ]
    items = [
        f'<li><a href="{address}" download>{file.name}</a>: {text} ({file.stat().st_size / 1e6:.1f} MB)</li>'
        for address, file, text in rows
    ]
    return '<ul class="downloads">\n' + "\n".join(items) + "\n</ul>"


def run_program(landing: str, folder: Path) -> None:
    """Run the program of the landing page, which leaves the picture that is shown below it."""
    found = re.search(r"```python\n(.*?)```", landing, re.DOTALL)
    assert found is not None, "the landing page has no program"
    subprocess.run([sys.executable, "-c", found[1]], cwd=folder, check=True, env={**os.environ, "MPLBACKEND": "Agg"})
    # The landing page is to be light.
    drawn = folder / "run.png"
    Image.open(drawn).convert("RGB").quantize(64).save(drawn, optimize=True)


def picture(root: Path, extra: Path) -> str:
    """Copy the picture of shared links, and return its address: absolute where the manifest has the site's."""
    shutil.copyfile(root / "docs" / "images" / "playground.png", extra / "shared.png")
    return f"{package_of(root).get('homepage', '').rstrip('/')}/shared.png".lstrip("/")


def copy_search(site: Path, out: Path) -> None:
    """Copy the page of the search, and the package that ranks, with its licence."""
    shutil.copytree(site / "templates", out / "templates")
    package = site / "node_modules" / "minisearch"
    program = (package / "dist" / "umd" / "index.js").read_text(encoding="utf-8")
    licence = (package / "LICENSE.txt").read_text(encoding="utf-8")
    write(out / "static" / "minisearch.js", f"/*!\n{licence}*/\n{re.sub(r'//# sourceMappingURL=.*', '', program)}")


def copy(root: Path, out: Path, name: str) -> None:
    (out / name).parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(root / name, out / name)


def copy_linked(root: Path, out: Path, page: Path) -> None:
    """Copy the files that a page links to; Sphinx complains of links to anything else that is not there."""
    for target in LINK.findall(page.read_text(encoding="utf-8")):
        name = (page.parent / target).resolve().relative_to(out.resolve()).as_posix()
        if (root / name).is_file() and not (out / name).exists() and not name.endswith(".md"):
            copy(root, out, name)


def copy_rustdoc(source: Path, target: Path) -> None:
    """Copy what Cargo made, without its marks."""
    shutil.copytree(source, target, ignore=shutil.ignore_patterns(".lock", ".*"))


def pages(out: Path) -> Iterator[str]:
    """Every page that was laid out, by its path without an ending."""
    for file in sorted(out.rglob("*")):
        name = file.relative_to(out)
        if file.suffix in (".md", ".ipynb") and name.parts[0] != "extra":
            yield name.with_suffix("").as_posix()


def toctrees(parts: list[dict[str, list[str]]], out: Path) -> str:
    """The parts of the side bar, with every page in one of them."""
    # The pages of laws and of the package are in the table of contents of the page that lists them.
    inner = ("laws/", "reference/python/")
    every = [page for page in pages(out) if page != "index" and (page == "laws/index" or not page.startswith(inner))]
    named = {path_of(entry) for part in parts for entry in part["pages"]}
    text = []
    placed: set[str] = set()
    for part in parts:
        entries: list[str] = []
        for entry in part["pages"]:
            found = matching(path_of(entry), every, named)
            placed.update(found)
            entries += [entry] if entry != path_of(entry) else found
        text.append(f"```{{toctree}}\n:hidden:\n:caption: {part['title']}\n\n" + "\n".join(entries) + "\n```\n")
    left = set(every) - placed
    if left:
        raise SystemExit(f"web/site/contents.toml has no place for {', '.join(sorted(left))}")
    return "\n".join(text)


def path_of(entry: str) -> str:
    """The path of an entry that may have a name, too: `Name <path>`."""
    return entry.partition("<")[2].removesuffix(">") or entry


def matching(entry: str, every: list[str], named: set[str]) -> list[str]:
    """The pages that an entry stands for."""
    if "*" not in entry:
        if entry not in every:
            raise SystemExit(f"web/site/contents.toml: there is no page {entry}")
        return [entry]
    if entry == "*":
        folders = {name.removesuffix("/*") for name in named if name.endswith("/*")}
        of_docs = [page for page in every if page.startswith("docs/")]
        return [page for page in of_docs if page not in named and str(PurePosixPath(page).parent) not in folders]
    found = [page for page in every if PurePosixPath(page).match(entry) and page not in named]
    # The page that a forge shows of a folder comes first.
    return sorted(found, key=lambda page: (not page.endswith("/README"), page))


def model_page(fmu: Path) -> str:
    """The page inside an FMU, with its headings as headings of the site."""
    with zipfile.ZipFile(fmu) as archive:
        page = archive.read("documentation/index.html").decode("utf-8")
    header = re.search(r"<header>\n<h1>.*?</h1>\n(.*?)</header>", page, re.DOTALL)
    sections = re.findall(r'<section id="([^"]+)">\n<h2>(.*?)</h2>\n(.*?)</section>', page, re.DOTALL)
    if header is None or len(sections) < 5:
        raise SystemExit(f"{fmu}: its page is not made as it was, of a header and sections")
    text = [f"# {fmu.stem}\n", raw(header[1])]
    for name, heading, body in sections:
        plain = html.unescape(re.sub(r"<[^>]+>", "", heading))
        anchor = f'<span id="{name}"></span>\n' if name != slug(plain) else ""
        text += [f"## {plain}\n", raw(anchor + body)]
    return "\n".join(text)


def slug(heading: str) -> str:
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def raw(text: str) -> str:
    """A block of HTML with a fence longer than any inside; the search takes cells without a space for one word."""
    text = re.sub(r"(</(?:td|th|li|p|h3|figcaption|text)>)(?=\S)", r"\1\n", text)
    return f"``````{{raw}} html\n{text}\n``````\n"


WANTED = {
    "sticks exactly": ("stiction", r"exact"),
    "peak at break-away (Stribeck)": ("Stribeck", r"yes|jump"),
    "presliding": ("presliding", r"."),
    "nested loops close": ("non-local memory", r"."),
    "break-away depends on the rate": ("rate-dependent break-away", r"."),
    "no drift": ("drift", r"none"),
}
"""Properties of laws, by the column of the table of properties and the beginning of a cell that has them."""


def laws_page(laws: list[Law], known: dict[str, dict[str, str]]) -> str:
    """All laws, the one first that differs most from the one that they are compared with, and a choice among them."""
    by_difference = sorted(laws, key=lambda law: -difference(law, laws))
    boxes = "\n".join(
        f'<label><input type="checkbox" value="{number}"> {text}</label>' for number, text in enumerate(WANTED)
    )
    rows = []
    for law in by_difference:
        has = [
            str(number)
            for number, (column, begin) in enumerate(WANTED.values())
            if re.match(begin, known[law.name][column])
        ]
        rows.append(
            f'<tr data-has="{" ".join(has)}"><td><a href="{law.name}.html">{law.name}</a></td>'
            f"<td>{law.description}</td><td>{1e3 * difference(law, laws):.3g} mm</td></tr>"
        )
    table = (
        '<fieldset id="chooser" hidden><legend>It must have</legend>\n' + boxes + "\n<output></output></fieldset>\n"
        '<div class="scroll"><table id="laws">\n'
        "<thead><tr><th>law</th><th>what it is</th><th>difference at most</th></tr></thead>\n<tbody>\n"
        + "\n".join(rows)
        + '\n</tbody></table></div>\n<script src="../_static/chooser.js"></script>'
    )
    text = [
        "# The laws one by one\n",
        f"How far the mass on the bench is at most from where it would be under {COMPARED}, on one course: it is "
        "pulled by a spring at 10 mm/s until it breaks away, rests under the load, is turned every quarter of a second "
        "by 2 mm/s, and is drawn back at 4 mm/s. The law that differs most stands first. "
        "[Which friction law?](../docs/friction-laws.md) tells what the words mean and helps to choose.\n",
        raw(table),
    ]
    figures = "\n".join(
        f'<figure><a href="{law.name}.html"><img src="{law.name}-course.svg" loading="lazy" '
        f'alt="Position over time under {law.name}, and its difference from {COMPARED}"></a>'
        f"<figcaption>{law.name}</figcaption></figure>"
        for law in by_difference
        if law.name != COMPARED
    )
    contents = "\n".join(law.name for law in laws)
    text += ["", raw(f'<div class="law-plots">{figures}</div>'), f"```{{toctree}}\n:hidden:\n\n{contents}\n```\n"]
    return "\n".join(text)


def gallery_page(laws: list[Law], gallery: Path | None, target: Path) -> str:
    """The figures of every law, one model after the other, the usual laws first; an overview of all begins."""
    text = [
        "# Gallery of the friction laws\n",
        "One experiment under every law, each with its defaults: first the usual laws, then the others. The strokes "
        "are long and fast: many laws look alike. [The laws one by one](laws/index.md) shows where they differ.\n",
    ]
    usual = [law for name in USUAL for law in laws if law.name == name]
    if len(usual) < len(USUAL):
        raise SystemExit(f"USUAL names a law that does not exist: there are {', '.join(law.name for law in laws)}")
    in_order = usual + [law for law in laws if law.name not in USUAL]
    for model, heading in GALLERY.items():
        text.append(f"## {heading}\n")
        text.append(f"The default experiment of [{model}](models/{model}.md) over time, and friction over velocity.\n")
        alternative = f"{model} under every law: friction over velocity"
        text += gallery_picture(gallery, model, "laws", target, alternative)
        for law in in_order:
            text.append(f"### {law.name}: {model}\n")
            alternative = f"{model} under {law.name}: curves over time on the left, friction over velocity on the right"
            text += gallery_picture(gallery, model, law.name, target, alternative)
    return "\n".join(text)


def gallery_picture(gallery: Path | None, model: str, name: str, target: Path, alternative: str) -> list[str]:
    """Copy a picture of the gallery, if it was drawn, and return the text that shows it."""
    if gallery is None:
        return []
    (target / model).mkdir(parents=True, exist_ok=True)
    shutil.copyfile(gallery / model / f"{name}.png", target / model / f"{name}.png")
    return [f"```{{image}} gallery/{model}/{name}.png\n:alt: {alternative}\n:loading: lazy\n```\n"]


FOREIGN = ["BaseException", "Env", "ImportError", "Mapping", "Sequence", "VectorEnv"]
"""Base classes whose members are not repeated in the reference."""

TASKS = {
    "models": ("Models and runs", "Model models Simulation SavedState Run Runs SolverLog SolverEvent Comparison play"),
    "values": (
        "Variables, values and parameter sets",
        "Variables Variable Unit Value parameter_sets read_ssv fmus export_fmu export_drive DataSheet "
        "friction_table gas",
    ),
    "derivatives": (
        "Linear models and derivatives",
        "Linearisation linearise Observer Consistency Sensitivities Gradient Crossing Transition transitions",
    ),
    "identification": (
        "Identification",
        "fit Fit Options fit_series Series compare_fits Ranking plan Plan Posterior Band "
        "identification.CrossValidation identification.Estimate "
        "identification.Evidence identification.Telling identification.experiments.EXPERIMENTS",
    ),
    "environments": (
        "Learning environments",
        "envs.Positioning envs.VectorPositioning envs.Task envs.Arm envs.PositionControllers envs.task.RANDOM "
        "envs.register",
    ),
    "errors": (
        "Errors and warnings",
        "Refused PlantWarning SimulationError Interrupted NotConverged NoDerivative TrimError MissingPackage",
    ),
}
"""The pages of the reference of the package by task: their names, headings, and what they tell."""


def write_python(folder: Path) -> None:
    """Write the reference of the package, from its docstrings; every public name is on one page."""
    modules = {name: importlib.import_module(f"pneumatic_servo{name}") for name in ("", ".envs", ".identification")}
    told = {name.rpartition(".")[2] for _, names in TASKS.values() for name in names.split()}
    if left := {name for module in modules.values() for name in module.__all__} ^ told:
        raise SystemExit(
            f"web/site/gather.py: TASKS must have each public name once, and has not: {', '.join(sorted(left))}"
        )
    introduction = inspect.getdoc(modules[""]) or ""
    text = ["# Python reference\n", f"``````{{eval-rst}}\n{introduction}\n``````\n"]
    for page, (heading, names) in TASKS.items():
        text.append(f"## {heading}\n")
        text += ["| name | what it is |", "|---|---|"]
        for name in names.split():
            text.append(f"| [`{name}`](python/{page}.md#{slug(name)}) | {first_line(name)} |")
        text.append("")
        write(
            folder / "python" / f"{page}.md", f"# {heading}\n\n" + "\n".join(described(name) for name in names.split())
        )
    contents = "\n".join(f"python/{page}" for page in TASKS)
    text.append(f"```{{toctree}}\n:hidden:\n\n{contents}\n```\n")
    write(folder / "python.md", "\n".join(text))


def item(name: str) -> object:
    """A public object of the package by its dotted name."""
    module, _, own = name.rpartition(".")
    return getattr(importlib.import_module(f"pneumatic_servo.{module}".rstrip(".")), own)


def first_line(name: str) -> str:
    """The first sentence of a docstring, as text of a table."""
    of = item(name)
    has_text = inspect.isclass(of) or inspect.isroutine(of)
    text = (inspect.getdoc(of) or "").split("\n\n")[0] if has_text else ""
    return " ".join(text.split()).replace("``", "`").replace("|", "\\|")


def described(name: str) -> str:
    """Sphinx's data of an object."""
    of = item(name)
    if inspect.isclass(of):
        options = "   :special-members: __getitem__, __setitem__\n"
        options += f"   :inherited-members: {', '.join(FOREIGN)}\n"
        return f"## {name}\n\n```{{eval-rst}}\n.. autoclass:: pneumatic_servo.{name}\n{options}```\n"
    kind = "autofunction" if inspect.isroutine(of) else "autodata"
    return f"## {name}\n\n```{{eval-rst}}\n.. {kind}:: pneumatic_servo.{name}\n```\n"


def command_line_page() -> str:
    """Help of each command."""
    from pneumatic_servo.cli import COMMANDS

    text = ["# Command line\n", "`pneumatic-servo` comes with the Python package.\n"]
    for command in ["", *(command.NAME for command in COMMANDS)]:
        words = [sys.executable, "-m", "pneumatic_servo", *([command] if command else []), "--help"]
        answer = subprocess.run(words, capture_output=True, text=True, check=True, env={"COLUMNS": "100"}).stdout
        text.append(f"## {f'pneumatic-servo {command}'.strip()}\n")
        text.append(f"```text\n{answer.rstrip()}\n```\n")
    return "\n".join(text)


def rust_page(rustdoc: Path) -> str:
    """A list of the crate's items, so that the search finds them; the pages are rustdoc's."""
    everything = (rustdoc / "pneumatic_servo" / "all.html").read_text(encoding="utf-8")
    text = [
        "# Rust reference\n",
        raw('<p><a href="../rust/pneumatic_servo/index.html">Its pages</a> have a search of their own.</p>'),
    ]
    groups = re.findall(r'<h3 id="[^"]*">(.*?)</h3><ul class="all-items">(.*?)</ul>', everything, re.DOTALL)
    if not groups:
        raise SystemExit("rustdoc lists its items in another way than before")
    for heading, items in groups:
        text.append(f"## {heading}\n")
        links = re.sub(r'href="', 'href="../rust/pneumatic_servo/', items)
        text.append(raw(f'<ul class="items">{links}</ul>'))
    return "\n".join(text)


if __name__ == "__main__":
    sys.exit(main())

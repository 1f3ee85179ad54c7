"""Lays out the pages of the site as Sphinx reads them: those of the repository, and those made of its products.

The pages of the models are those inside the FMUs, the gallery shows the figures of `studies/gallery.py`, and the
command line tells its own help. Nothing is written twice.
"""

from __future__ import annotations

import argparse
import html
import importlib
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

import pneumatic_servo as ps
import tomllib

PAGES = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "RELEASING.md", "SECURITY.md", "CODE_OF_CONDUCT.md"]
"""Pages at the root of the repository."""

MORE_PAGES = ["python/README.md", "tests/reference/README.md"]
"""Pages in folders that are not taken as a whole; `docs` is."""

LINK = re.compile(r"\]\(([^)\s#:]+)[^)\s]*\)")
"""A link to a file, without its anchor."""

GALLERY = {"PneumaticServoCylinder": "The default experiment", "FrictionBench": "On the bench"}
"""Models whose figures are shown, and under which heading."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmus", type=Path, required=True, help="the FMUs, whose pages are shown")
    parser.add_argument("--gallery", type=Path, help="the figures of every law; without it their page has no figures")
    parser.add_argument("--playground", type=Path, required=True, help="the page in which the plant runs")
    parser.add_argument("--rustdoc", type=Path, required=True, help="the documentation of the crate, as made by Cargo")
    parser.add_argument("--out", type=Path, required=True, help="where the pages are laid out")
    arguments = parser.parse_args()
    root = Path(__file__).parents[1]
    out: Path = arguments.out
    if out.exists():
        shutil.rmtree(out)
    copy_repository(root, out)
    extra = out / "extra"
    extra.mkdir()
    shutil.copyfile(arguments.playground, extra / "playground.html")
    copy_rustdoc(arguments.rustdoc, extra / "rust")
    for fmu in sorted(arguments.fmus.glob("*.fmu")):
        write(out / "models" / f"{fmu.stem}.md", model_page(fmu))
    write(out / "gallery.md", gallery_page(arguments.gallery, out / "gallery"))
    write(out / "reference" / "python.md", python_page())
    write(out / "reference" / "command-line.md", command_line_page())
    write(out / "reference" / "rust.md", rust_page(extra / "rust"))
    contents = (root / "site" / "contents.toml").read_text(encoding="utf-8")
    landing = (root / "site" / "index.md").read_text(encoding="utf-8")
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
    shutil.copytree(root / "site" / "static", out / "static")
    copy_search(root / "site", out)
    shutil.copyfile(root / "site" / "conf.py", out / "conf.py")


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
    every = [page for page in pages(out) if page != "index"]
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
        raise SystemExit(f"site/contents.toml has no place for {', '.join(sorted(left))}")
    return "\n".join(text)


def path_of(entry: str) -> str:
    """The path of an entry that may have a name, too: `Name <path>`."""
    return entry.partition("<")[2].removesuffix(">") or entry


def matching(entry: str, every: list[str], named: set[str]) -> list[str]:
    """The pages that an entry stands for."""
    if "*" not in entry:
        if entry not in every:
            raise SystemExit(f"site/contents.toml: there is no page {entry}")
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


def gallery_page(gallery: Path | None, target: Path) -> str:
    """The figures of every law, one model after the other."""
    plant = ps.Model("PneumaticServoCylinder")
    laws = plant.variables["friction.law"].items
    assert laws is not None
    text = [
        "# Gallery of the friction laws\n",
        "One experiment under every law, each with its defaults. [Which friction law?](docs/friction-laws.md) tells "
        "the laws apart and helps to choose.\n",
    ]
    for model, heading in GALLERY.items():
        text.append(f"## {heading}\n")
        text.append(f"The default experiment of [{model}](models/{model}.md) over time, and friction over velocity.\n")
        for law in laws:
            text.append(f"### {law}: {model}\n")
            if gallery is None:
                continue
            picture = gallery / model / f"{law}.png"
            (target / model).mkdir(parents=True, exist_ok=True)
            shutil.copyfile(picture, target / model / picture.name)
            alternative = f"{model} under {law}: curves over time on the left, friction over velocity on the right"
            text.append(f"```{{image}} gallery/{model}/{law}.png\n:alt: {alternative}\n:loading: lazy\n```\n")
    return "\n".join(text)


FOREIGN = ["BaseException", "Env", "ImportError", "Mapping", "Sequence", "VectorEnv"]
"""What classes of the package have from these is not told again."""


def python_page() -> str:
    """The reference of the package, from its docstrings."""
    text = ["# Python reference\n"]
    told: set[str] = set()
    for module in ["pneumatic_servo", "pneumatic_servo.envs", "pneumatic_servo.identification"]:
        extra = "   :imported-members:\n   :special-members: __getitem__, __setitem__\n"
        extra += f"   :inherited-members: {', '.join(FOREIGN)}\n"
        names = set(importlib.import_module(module).__all__)
        if again := sorted(names & told):
            extra += f"   :exclude-members: {', '.join(again)}\n"
        told |= names
        text.append(f"## {module}\n")
        text.append(f"```{{eval-rst}}\n.. automodule:: {module}\n{extra}```\n")
    return "\n".join(text)


def command_line_page() -> str:
    """What each command says of itself."""
    from pneumatic_servo.cli import COMMANDS

    text = ["# Command line\n", "`pneumatic-servo` comes with the Python package.\n"]
    for command in ["", *(command.NAME for command in COMMANDS)]:
        words = [sys.executable, "-m", "pneumatic_servo", *([command] if command else []), "--help"]
        answer = subprocess.run(words, capture_output=True, text=True, check=True, env={"COLUMNS": "100"}).stdout
        text.append(f"## {f'pneumatic-servo {command}'.strip()}\n")
        text.append(f"```text\n{answer.rstrip()}\n```\n")
    return "\n".join(text)


def rust_page(rustdoc: Path) -> str:
    """A list of the crate's items, so that the search finds them; the pages are those of rustdoc."""
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

"""Makes the index of the search from the site as it was built: `_static/search-index.js`, the text of every section.

A script and no file of data, because a browser refuses to fetch one where pages are opened from a folder. Sphinx's own
index goes.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path

from bs4 import BeautifulSoup, NavigableString, Tag

HEADINGS = "h1, h2, h3, h4, dt.sig[id]"
"""Beginnings of sections: a heading, or an item of the reference of Python."""

LEFT_OUT = ["script", "style", "svg", "a.headerlink", "button", "nav", "figure.live"]
"""Elements of a page that are not text."""

OTHER_PAGES = {"genindex.html", "search.html", "py-modindex.html", "playground.html"}


def main() -> int:
    site = Path(sys.argv[1]).resolve()
    sections = []
    for file in sorted(site.rglob("*.html")):
        name = file.relative_to(site).as_posix()
        # `site/` has what leads on from an old address.
        if name not in OTHER_PAGES and not name.startswith(("rust/", "_static/", "site/")):
            sections += list(sections_of(file, name))
    script = f"globalThis.SECTIONS = {json.dumps(sections, ensure_ascii=False, separators=(',', ':'))};\n"
    (site / "_static" / "search-index.js").write_text(script, encoding="utf-8")
    (site / "searchindex.js").unlink(missing_ok=True)
    print(f"{len(sections)} sections, {len(script.encode()) // 1024} kB")
    return 0 if sections else 1


def sections_of(file: Path, name: str) -> Iterator[dict[str, str]]:
    """Page, heading, address and text of each section, and names in the first column of its tables."""
    article = BeautifulSoup(file.read_text(encoding="utf-8"), "html.parser").find("article")
    if not isinstance(article, Tag):
        raise SystemExit(f"{name} has no article")
    for unwanted in article.select(", ".join(LEFT_OUT)):
        unwanted.decompose()
    headings = article.select(HEADINGS)
    of = {id(text): heading for heading in headings for text in heading.find_all(string=True)}
    title = article.find("h1")
    page = words(title) if isinstance(title, Tag) else name
    texts: dict[int, list[str]] = {id(heading): [] for heading in headings}
    names: dict[int, list[str]] = {id(heading): [] for heading in headings}
    present = None
    for element in article.find_all(string=True):
        heading = of.get(id(element))
        if heading is not None:
            present = heading
        if present is not None and (heading is None or heading.name == "dt"):
            texts[id(present)].append(str(element))
            if element.find_parent("code") is not None and is_defined(element):
                names[id(present)].append(str(element))
    for heading in headings:
        owner = heading if heading.name == "dt" else heading.find_parent("section")
        address = name if heading.name == "h1" or owner is None else f"{name}#{owner.get('id', '')}"
        label = str(heading["id"]) if heading.name == "dt" else words(heading)
        text = spaced(" ".join(texts[id(heading)]))
        yield {"page": page, "heading": label, "address": address, "text": text, "names": " ".join(names[id(heading)])}


def is_defined(text: NavigableString) -> bool:
    """Whether a table is told about it: it stands in the first column."""
    cell = text.find_parent("td")
    return cell is not None and cell.find_previous_sibling("td") is None


def words(element: Tag) -> str:
    return spaced(element.get_text(" "))


def spaced(text: str) -> str:
    return re.sub(r"\s+", " ", text).strip()


if __name__ == "__main__":
    sys.exit(main())

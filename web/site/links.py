"""Checks the site as it was made: links lead somewhere, pictures have a text, and nothing is asked of a network.

The pages of rustdoc are looked into only for what others link to; Cargo checks their own links.
"""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {"script": "src", "img": "src", "iframe": "src", "link": "href", "source": "src", "object": "data"}
"""Elements that a browser loads by itself, and the attribute with the address."""


class Page(HTMLParser):
    """Links of a page, its anchors, and its errors."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.anchors: set[str] = set()
        self.problems: list[str] = []
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attributes}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag in LOADED:
            self.loaded += [given[name] for name in (LOADED[tag], "data-src") if name in given]
        text = given.get("alt", "").strip()
        if tag == "img" and (not text or text.endswith((".png", ".svg"))):
            self.problems.append(f"the picture {given.get('src', '')} has no text")
        if tag == "svg" and given.get("role") == "img" and not given.get("aria-label", "").strip():
            self.problems.append("a drawing has no text")


def main() -> int:
    site = Path(sys.argv[1]).resolve()
    files = sorted(file for file in site.rglob("*.html") if file.relative_to(site).parts[0] != "rust")
    seen = {file: Page(file) for file in files if file.name != "playground.html"}
    problems: list[str] = []
    for file, page in seen.items():
        problems += [f"{file.relative_to(site)}: {text}" for text in check(file, page, seen, site)]
    links = sum(len(page.links) for page in seen.values())
    print("\n".join(problems) or f"{len(seen)} pages, {links} links: all lead somewhere")
    return 1 if problems or not seen else 0


def check(file: Path, page: Page, seen: dict[Path, Page], site: Path) -> list[str]:
    """Errors of a page."""
    problems = list(page.problems)
    for link in page.loaded:
        parts = urlsplit(link)
        if parts.scheme not in ("", "data") or parts.netloc:
            problems.append(f"{link} is asked of a network")
    for link in [*page.links, *page.loaded]:
        parts = urlsplit(link)
        if parts.scheme or parts.netloc:
            continue
        if parts.path.startswith("/"):
            problems.append(f"{link} works at the root of a server only")
            continue
        target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
        if not target.is_file():
            problems.append(f"{link} leads nowhere")
        elif site not in target.parents:
            problems.append(f"{link} leads out of the site")
        elif parts.fragment and target.suffix == ".html" and target.name != "playground.html":
            there = seen.get(target) or Page(target)
            if unquote(parts.fragment) not in there.anchors:
                problems.append(f"{link}: there is no such anchor")
    return problems


if __name__ == "__main__":
    sys.exit(main())

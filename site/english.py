"""Looks for sentences that are hard to read: in README, docs, pages of the models, comments and docstrings.

The rules are few, so that each finding is worth a look:

- a sentence has at most 30 words, code and links counting as one each;
- no word comes twice in a row;
- no long word where a short one says the same (`WORDY`), no private word where the field has one (`PRIVATE`);
- a sentence, a comment or a docstring opens with a noun or a verb, not with a pronoun (`OPENINGS`);
- no pronoun stands for the noun of a genitive (`STANDING_FOR`), also not in messages.

Tables, code, formulas and headings are no sentences. A comment `plain: reason` in a line of code exempts it, and
`<!-- plain: reason -->` the next paragraph of a text. Usage: python site/english.py [FILE ...]
"""

from __future__ import annotations

import itertools
import json
import re
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TEXTS = [
    "README.md", "RELEASING.md", "SECURITY.md", "CONTRIBUTING.md", "CODE_OF_CONDUCT.md", "python/README.md",
    "packaging/wasm-as-c/README.md", "site/README.md", "site/index.md", "docs/**/*.md", "docs/**/*.ipynb",
    "modelDescription/*.html",
]  # fmt: skip
LONGEST = 30
WORDY = {
    "utilize": "use", "utilise": "use", "in order to": "to", "due to the fact that": "because", "prior to": "before",
    "subsequent to": "after", "in the event that": "if", "is able to": "can", "facilitate": "help",
    "leverage": "use", "commence": "begin", "terminate the process": "end", "whilst": "while", "aforementioned": "",
    "herein": "here", "thereof": "of it", "notwithstanding": "despite", "and/or": "or", "basically": "", "simply": "",
    "obviously": "", "of course": "", "very unique": "unique", "please note that": "", "it should be noted that": "",
}  # fmt: skip
PRIVATE = {
    "foretold": "predicted", "held out": "validation data", "told apart": "distinguished", "tell apart": "distinguish",
    "hang together": "are autocorrelated", "solver inside": "co-simulation", "solver outside": "solver of the importer",
    "fresh input": "new input sample", "instroke": "retracted", "outstroke": "extended", "to and fro": "back and forth",
    "so many": "a number of", "whatever": "any", "play of the valve": "hysteresis of the valve", "gentle": "non-stiff",
    "hasty": "fast", "takes home": "exports",
}  # fmt: skip
"""Words of this library's past, and what the field says (docs/glossary.md)."""
MODULES = ["*/src/**/*.rs", "src/**/*.rs", "*/*/src/**/*.rs", "**/tests/**/*.rs", "python/**/*.py", "tests/python/*.py",
           "site/*.py", "studies/*.py", "examples/*.py"]  # fmt: skip
COMMENTS = ["src/**/*.rs", "fit/**/*.rs", "fmu/**/*.rs", "packaging/**/*.rs", "xtask/**/*.rs", "sources/**/*.rs",
            "tests/*.rs", "playground/src/*.rs", "playground/page/**/*.ts", "benches/**/*.rs",
            "python/pneumatic_servo/**/*.py", "site/*.py", "studies/*.py", "examples/*.py",
            "tests/python/*.py"]  # fmt: skip
"""Files whose comments all keep the rules, not only their first lines."""
OPENINGS = r"(What|How|Who|Whose|Whatever|Whoever|Those|That of)\b"  # plain: the rule
STANDING_FOR = re.compile(r"\b(those|that) of\b", re.IGNORECASE)
MODULE = re.compile(r'(?://! |"""|// )(What|How|Who|Whose|Whether|Where|When|Why|Those|That|These)\b')
COMMENT = re.compile(r'\s*(//[/!]? |/\*\* |# |""")(.*)')
ABBREVIATIONS = re.compile(r"\b(e\.g|i\.e|etc|vs|al|Fig|Eq|No|approx|Trans|J|Proc|Soc|Math)\.")
ALLOWED_TWICE = {"that", "had", "CODE", "FORMULA"}


class Prose(HTMLParser):
    """The paragraphs and items of a page, without tables, code and formulas."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[int, str]] = []
        self.silent = 0
        self.paragraph: list[str] | None = None
        self.line = 1
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag in ("table", "math", "svg", "style", "script", "pre"):
            self.silent += 1
            self._put(" FORMULA ")
        elif tag in ("p", "li", "dd"):
            self.handle_endtag("p")
            self.paragraph, self.line = [], self.getpos()[0]

    def handle_endtag(self, tag: str) -> None:
        if tag in ("table", "math", "svg", "style", "script", "pre"):
            self.silent -= 1
        elif tag in ("p", "li", "dd") and self.paragraph is not None:
            self.found.append((self.line, "".join(self.paragraph)))
            self.paragraph = None

    def handle_data(self, data: str) -> None:
        if not self.silent:
            self._put(data)

    def _put(self, text: str) -> None:
        if self.paragraph is not None:
            self.paragraph.append(text)


def of_markdown(text: str) -> Iterator[tuple[int, str]]:
    """Yield the paragraphs and list items of a Markdown text, with the lines that they begin in."""
    paragraph: list[str] = []
    first, fence, is_exempt = 1, False, False
    for number, line in enumerate([*text.splitlines(), ""], start=1):
        stripped = line.strip()
        if stripped.startswith(("```", "~~~")):
            fence = not fence
            stripped = ""
        item = re.match(r"([-*+]|\d+\.)\s+", stripped)
        ends = fence or not stripped or item or stripped.startswith(("#", "|", "<!--", "![", ":::", "$$"))
        if ends and paragraph:
            if not is_exempt:
                yield first, " ".join(paragraph)
            paragraph, is_exempt = [], False
        is_exempt |= stripped.startswith("<!-- plain: ")
        if fence or not stripped or (ends and not item):
            continue
        if not paragraph:
            first = number
        paragraph.append(stripped[item.end() :] if item else stripped)


def of_notebook(text: str) -> Iterator[tuple[int, str]]:
    """Yield the paragraphs of the Markdown cells of a notebook, with the numbers of the cells."""
    for number, cell in enumerate(json.loads(text)["cells"], start=1):
        if cell["cell_type"] == "markdown":
            for _, paragraph in of_markdown("".join(cell["source"])):
                yield number, paragraph


def sentences(paragraph: str) -> list[str]:
    """Split a paragraph at the ends of its sentences."""
    plain = re.sub(r"`[^`]*`|\$[^$]*\$|\\\(.*?\\\)", "CODE", paragraph, flags=re.DOTALL)
    plain = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", plain)
    plain = ABBREVIATIONS.sub(r"\1", re.sub(r"[*_]{1,2}", "", plain))
    return re.split(r"(?<=[.!?:;])[)\"']*\s+", plain)


def problems(paragraph: str) -> Iterator[str]:
    """Name what is hard to read in a paragraph."""
    for sentence in sentences(paragraph):
        words = re.findall(r"[A-Za-zÀ-ÿ][\w'-]*", sentence)
        yield from private(sentence)
        if pronoun := STANDING_FOR.search(sentence):
            yield f"{pronoun[0]!r} stands for a noun: name it"
        if re.match(OPENINGS, sentence) and not sentence.endswith("?"):
            yield f"opens with a pronoun: {' '.join(sentence.split())[:70]}..."
        if len(words) > LONGEST:
            yield f"a sentence of {len(words)} words: {' '.join(sentence.split())[:70]}..."
        for one, other in itertools.pairwise(words):
            is_twice = one.lower() == other.lower() and one.isalpha() and f"{one} {other}" in sentence
            if is_twice and one not in ALLOWED_TWICE:
                yield f"{one} comes twice"
        low = f" {' '.join(sentence.lower().split())} "
        for wordy, short in WORDY.items():
            if re.search(rf"[^\w]{re.escape(wordy)}[^\w]", low):
                yield f"{wordy!r} can be {short!r}" if short else f"{wordy!r} can be left out"


def private(text: str) -> Iterator[str]:
    """Name the words for which the field has others."""
    low = f" {' '.join(text.lower().split())} "
    for word, field in PRIVATE.items():
        if re.search(rf"[^\w]{word}[^\w]", low):
            yield f"{word!r} is {field!r} in the field"


def comments() -> Iterator[str]:
    """Name the modules, comments and docstrings that open with a pronoun, or have words to avoid."""
    whole = {file for text in COMMENTS for file in ROOT.glob(text)}
    for file in sorted({file for text in MODULES for file in ROOT.glob(text)} | whole):
        name = file.relative_to(ROOT)
        if not {"target", "node_modules"}.isdisjoint(name.parts):
            continue
        lines = file.read_text(encoding="utf-8").splitlines()
        if lines and MODULE.match(lines[0]):
            yield f"{name}:1: opens with a pronoun or an adverb, not with a noun"
        begins = True
        for number, line in enumerate(lines if file in whole else [], start=1):
            comment = COMMENT.match(line)
            text = comment[2] if comment else ""
            if begins and "plain:" not in line:
                if re.match(OPENINGS, text):
                    yield f"{name}:{number}: opens with a pronoun: {text[:70]}"
                for problem in private(text):
                    yield f"{name}:{number}: {problem}"
            if "plain:" not in line and (pronoun := STANDING_FOR.search(line)):
                yield f"{name}:{number}: {pronoun[0]!r} stands for a noun: name it"
            begins = not text or text.rstrip().endswith((".", ":"))


def main(given: list[str]) -> int:
    files = [Path(name) for name in given] or sorted(file for text in TEXTS for file in ROOT.glob(text))
    found = count = 0
    for file in files:
        text = file.read_text(encoding="utf-8")
        kinds = {".html": lambda text: Prose(text).found, ".ipynb": of_notebook}
        for line, paragraph in kinds.get(file.suffix, of_markdown)(text):
            count += len(sentences(paragraph))
            for problem in problems(paragraph):
                found += 1
                print(f"{file.relative_to(ROOT) if file.is_relative_to(ROOT) else file}:{line}: {problem}")
    for problem in [] if given else comments():
        found += 1
        print(problem)
    print(f"{len(files)} texts, {count} sentences, {found} to be looked at")
    return 1 if found or not count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

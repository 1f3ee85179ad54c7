"""Puts many mistakes into the Rust source at once, each behind a switch, and counts those that the tests notice.

The mistakes are those of cargo-mutants, drawn at random. All are compiled together, once; the environment says which
one is made, so that a mistake costs the tests that reach it, and no build. Tests run one by one, the quickest first;
those that compare with recorded runs are not asked, since a record says what was, not what is right.

Usage: python tests/mutants/switched.py PART ... [--sample 200] [--seed 1] [--hours 1.0]

It needs cargo-mutants, and `pip install scipy tree-sitter tree-sitter-rust`. It works on a clone in target/switched,
with what is committed, and goes on where it was interrupted; outcomes are there, in a file for each commit.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import subprocess
import sys
import time
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

import tree_sitter
import tree_sitter_rust
from scipy.stats import binomtest

ROOT = Path(__file__).parents[2]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "switched"
SWITCH = Path(__file__).with_name("switch.rs")


@dataclass(frozen=True)
class Part:
    """What is changed, and what is to notice."""

    mutants: list[str]
    """What tells cargo-mutants."""
    files: str
    """A pattern of the files that are changed."""
    tested: list[str]
    """Packages whose tests are to notice."""


PLANT = ["pneumatic-servo", "pneumatic-servo-fmu"]
TOOLS = ["pneumatic-servo-packaging", "pneumatic-servo-playground", "pneumatic-servo-ssp"]
PARTS = {
    "plant": Part(["--config", ".cargo/mutants.toml"], r"src/", PLANT),
    "faces": Part(["--no-config"], r"fmu/src/(face|fmi2|fmi3|instance)/", PLANT),
    "tools": Part(["--config", ".cargo/mutants-tools.toml"], r"(packaging|playground|ssp)/src/", TOOLS),
}
RECORDED = "recorded_runs"
MOST = int(re.findall(r"AtomicBool; (\d+)\]", SWITCH.read_text(encoding="utf-8"))[0])
"""As many switches as there is room for."""
CONSTANT = "E0015"
"""What the compiler says of a switch in a constant."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "parts", nargs="+", metavar="PART", help=", ".join(PARTS) + "; together those with the same tests"
    )
    parser.add_argument("--sample", type=int, default=200, help="how many mistakes of each are drawn (default: 200)")
    parser.add_argument("--seed", type=int, default=1, help="of the draw (default: 1)")
    parser.add_argument("--hours", type=float, default=1.0, help="after which no mistake is begun (default: 1)")
    options = parser.parse_args()
    if any(name not in PARTS for name in options.parts):
        parser.error(f"there are {', '.join(PARTS)}")
    tested = PARTS[options.parts[0]].tested
    if any(PARTS[name].tested != tested for name in options.parts):
        parser.error(f"{', '.join(options.parts)} have different tests")
    samples = [draw(name, options.sample, options.seed) for name in options.parts]
    # In turn, so that each part has its share of what is tried in time.
    drawn = [one for turn in zip_longest(*samples) for one in turn if one]
    if len(drawn) > MOST:
        parser.error(f"--sample {options.sample} draws {len(drawn)} mistakes; there is room for {MOST} switches")
    folder = TARGET / "-".join(options.parts)
    source, commit = clone(folder)
    binaries, refused = build(tested, source, drawn)
    (folder / "refused.json").write_text(json.dumps(refused, indent=1))
    tests = known_tests(folder, binaries)
    outcomes = run(folder / f"outcomes-{commit}.jsonl", drawn, refused, tests, options.hours)
    for name, sample in zip(options.parts, samples, strict=True):
        report(name, sample, refused, outcomes)
    return 0


def draw(name: str, size: int, seed: int) -> list[dict]:
    """Mistakes drawn at random from all of a part."""
    part = PARTS[name]
    packages = [word for package in part.tested for word in ("--package", package)]
    command = ["cargo", "mutants", "--list", "--json", *part.mutants, *packages]
    listed = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout)
    every = sorted((one for one in listed if re.match(part.files, one["file"])), key=lambda one: one["name"])
    print(f"{name}: {min(size, len(every))} of {len(every)} mistakes are drawn", flush=True)
    return random.Random(seed).sample(every, min(size, len(every)))


def clone(folder: Path) -> tuple[Path, str]:
    """A clone of what is committed, to be changed, and the commit."""
    source = folder / "source"
    if not source.exists():
        subprocess.run(["git", "clone", "--quiet", "--shared", ROOT, source], check=True)
    asked = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, check=True, capture_output=True, text=True)
    commit = asked.stdout.strip()
    subprocess.run(["git", "fetch", "--quiet"], cwd=source, check=True)
    subprocess.run(["git", "reset", "--quiet", "--hard", commit], cwd=source, check=True)
    return source, commit


class Switches:
    """A file with some of its mistakes behind switches."""

    def __init__(self, file: Path, mistakes: dict[int, dict]) -> None:
        self.text = file.read_bytes()
        self.lines = [0, *(found.end() for found in re.finditer(rb"\n", self.text))]
        tree = tree_sitter.Parser(tree_sitter.Language(tree_sitter_rust.language())).parse(self.text)
        self.inserted: list[tuple[int, bytes]] = []
        self.chosen: dict[tuple[int, int], list[tuple[int, int, int, bytes]]] = {}
        self.strange = [number for number, one in mistakes.items() if not self.put(tree.root_node, number, one)]

    def at(self, place: dict) -> int:
        """The byte of a line and a column, both counted from 1."""
        line = self.lines[place["line"] - 1]
        end = self.text.find(b"\n", line)
        return line + len(self.text[line:end].decode()[: place["column"] - 1].encode())

    def put(self, root: tree_sitter.Node, number: int, mistake: dict) -> bool:
        """Put in a mistake, if its place is of a known kind."""
        start, end = self.at(mistake["span"]["start"]), self.at(mistake["span"]["end"])
        text = mistake["replacement"].encode()
        node = root.descendant_for_byte_range(start, end)
        switch = f"crate::mutated({number})".encode()
        genre = mistake["genre"]
        if genre == "FnValue":
            while node is not None and node.type not in ("function_item", "impl_item", "trait_item"):
                node = node.parent
            if node is None or node.type != "function_item":
                return False
            self.inserted.append(
                (node.child_by_field_name("body").start_byte + 1, b" if %s { return %s; }" % (switch, text))
            )
            return True
        if genre == "MatchArm":
            while node is not None and node.type != "match_arm":
                node = node.parent
            if node is None:
                return False
            pattern = node.child_by_field_name("pattern")
            guard = pattern.child_by_field_name("condition")
            if guard is None:
                self.inserted.append((pattern.end_byte, b" if !%s" % switch))
            else:
                self.inserted += [(guard.start_byte, b"!%s && (" % switch), (guard.end_byte, b")")]
            return True
        kinds = {
            "BinaryOperator": ("binary_expression", "compound_assignment_expr"),
            "UnaryOperator": ("unary_expression",),
            "StructField": ("struct_expression",),
            "MatchArmGuard": (),
        }
        if genre not in kinds:
            return False
        while kinds[genre] and node is not None and node.type not in kinds[genre]:
            node = node.parent
        if node is None:
            return False
        if genre == "StructField":
            end += self.text[end : end + 1] == b","
        if genre == "MatchArmGuard":
            self.chosen.setdefault((start, end), []).append((number, start, end, text))
        else:
            self.chosen.setdefault((node.start_byte, node.end_byte), []).append((number, start, end, text))
        return True

    def switched(self) -> bytes:
        """The text with all switches."""
        return self.between(0, len(self.text), frozenset())

    def between(self, start: int, end: int, done: frozenset[tuple[int, int]]) -> bytes:
        """What is between two bytes, with the switches within."""
        pieces, at = [], start
        inside = [spot for spot in self.chosen if start <= spot[0] and spot[1] <= end and spot not in done]
        while at < end:
            following = [spot for spot in inside if spot[0] >= at]
            # The first that begins, and the longest of those: what is within is written with it.
            spot = min(following, key=lambda spot: (spot[0], -spot[1]), default=None)
            until = spot[0] if spot else end
            pieces.append(self.plain(at, until))
            if spot:
                pieces.append(self.choice(spot, done | {spot}))
            at = spot[1] if spot else end
        return b"".join(pieces)

    def choice(self, spot: tuple[int, int], done: frozenset[tuple[int, int]]) -> bytes:
        """An expression, or what mistakes make of it."""
        pieces = []
        for number, start, end, text in self.chosen[spot]:
            wrong = self.between(spot[0], start, done) + text + self.between(end, spot[1], done)
            pieces.append(b"if crate::mutated(%d) { %s } else " % (number, wrong))
        return b"(%s{ %s })" % (b"".join(pieces), self.between(*spot, done))

    def plain(self, start: int, end: int) -> bytes:
        """What is between two bytes, with what is inserted."""
        pieces, at = [], start
        for place, text in sorted(self.inserted):
            if start <= place < end:
                pieces += [self.text[at:place], text]
                at = place
        return b"".join([*pieces, self.text[at:end]])


def build(tested: list[str], source: Path, drawn: list[dict]) -> tuple[list[dict], dict[str, str]]:
    """The tests, compiled with all mistakes that compile; those that do not, and why."""
    refused: dict[str, str] = {}
    crates = {one["file"].split("src/")[0] for one in drawn}
    for crate in crates:
        main = source / crate / "src/lib.rs"
        with main.open("a") as file:
            file.write(SWITCH.read_text())
    original = {one["file"]: (source / one["file"]).read_bytes() for one in drawn}
    while True:
        for name, text in original.items():
            file = source / name
            file.write_bytes(text)
            here = {n: one for n, one in enumerate(drawn) if one["file"] == name and one["name"] not in refused}
            switches = Switches(file, here)
            refused |= {drawn[number]["name"]: "a place of an unknown kind" for number in switches.strange}
            file.write_bytes(switches.switched())
        # What only tests compile is seen in the second.
        for what in (["check", "--lib"], ["test", "--no-run", "--lib", "--tests"]):
            binaries, wrong = compiled(tested, source, drawn, what)
            if wrong:
                break
        else:
            return binaries, refused
        print(*(f"does not compile: {name}: {why}" for name, why in wrong.items()), sep="\n", flush=True)
        refused |= wrong


def compiled(tested: list[str], source: Path, drawn: list[dict], what: list[str]) -> tuple[list[dict], dict[str, str]]:
    """What the compiler makes, and the mistakes in which it finds errors."""
    packages = [word for package in tested for word in ("--package", package)]
    command = ["cargo", *what, "--profile", "mutants", *packages]
    environment = os.environ | {"CARGO_TARGET_DIR": str(TARGET / "build"), "RUSTFLAGS": "--cap-lints allow"}
    done = subprocess.run(
        [*command, "--message-format", "json"], cwd=source, env=environment, stdout=subprocess.PIPE, text=True
    )
    messages = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    wrong: dict[str, str] = {}
    for one in messages:
        if one["reason"] != "compiler-message" or one["message"]["level"] != "error":
            continue
        for span in one["message"]["spans"]:
            if span["is_primary"] and (source / span["file_name"]).is_file():
                before = (source / span["file_name"]).read_bytes()[: span["byte_end"]]
                numbers = re.findall(rb"crate::mutated\((\d+)\)", before)
                if numbers:
                    code = (one["message"]["code"] or {}).get("code", "")
                    wrong[drawn[int(numbers[-1])]["name"]] = f"{code} {one['message']['message']}"
    if done.returncode and not wrong:
        raise SystemExit("the source does not compile, and no mistake is to blame")
    return [one for one in messages if one["reason"] == "compiler-artifact" and one.get("executable")], wrong


@dataclass
class Test:
    """A test, by its binary and its name there."""

    binary: str
    name: str
    folder: str
    seconds: float = 0.0
    reached: frozenset[int] | None = None
    """The mistakes that it reaches, or nothing where that could not be recorded: then it may reach all."""
    noticed: int = 0

    def run(self, limit: float, **environment: str) -> bool | None:
        """Whether it passes; nothing where it has not ended after a time in s."""
        command = [self.binary, "--exact", self.name, "--test-threads", "1"]
        surroundings = os.environ | {"CARGO_MANIFEST_DIR": self.folder, "RUST_BACKTRACE": "0"} | environment
        try:
            done = subprocess.run(
                command,
                cwd=self.folder,
                env=surroundings,
                timeout=limit,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        except subprocess.TimeoutExpired:
            return None
        return done.returncode == 0

    def cost(self) -> float:
        """What comes first: what is quick and has noticed much."""
        return self.seconds / (1 + self.noticed)


def known_tests(folder: Path, binaries: list[dict]) -> list[Test]:
    """All tests that pass as things are and say what is right, with what they reach."""
    tests = []
    for one in (one for one in binaries if RECORDED not in Path(one["executable"]).name):
        listed = subprocess.run([one["executable"], "--list", "--format", "terse"], capture_output=True, text=True)
        ignored = subprocess.run(
            [one["executable"], "--list", "--format", "terse", "--ignored"], capture_output=True, text=True
        ).stdout.splitlines()
        names = [line.removesuffix(": test") for line in listed.stdout.splitlines() if line not in ignored]
        home = str(Path(one["manifest_path"]).parent)
        tests += [Test(one["executable"], name, home) for name in names if name]
    record, passing = folder / "reached.txt", []
    for test in tests:
        record.write_text("")
        begin = time.monotonic()
        if test.run(1200.0, MUTATED_RECORD=str(record)):
            test.reached = frozenset(map(int, record.read_text().split()))
        elif not test.run(1200.0):
            print(f"fails without any mistake: {Path(test.binary).name} {test.name}", flush=True)
            continue
        test.seconds = time.monotonic() - begin
        passing.append(test)
    print(f"{len(passing)} tests, {sum(test.seconds for test in passing):.0f} s", flush=True)
    return passing


def run(file: Path, drawn: list[dict], refused: dict[str, str], tests: list[Test], hours: float) -> dict[str, str]:
    """What became of the mistakes, also in the file: the test that notices each, or an empty text."""
    begin = time.monotonic()
    outcomes = dict(json.loads(line) for line in file.read_text().splitlines()) if file.exists() else {}
    for number, mistake in enumerate(drawn):
        name = mistake["name"]
        if name in refused or name in outcomes:
            continue
        if time.monotonic() - begin > 3600.0 * hours:
            break
        outcomes[name] = noticing(number, tests)
        with file.open("a") as lines:
            print(json.dumps([name, outcomes[name]]), file=lines)
        print(f"{name}: {outcomes[name] or 'NOT NOTICED'}", flush=True)
    return outcomes


def noticing(number: int, tests: list[Test]) -> str:
    """The first test that notices a mistake, if one does."""
    for test in sorted(tests, key=Test.cost):
        if test.reached is not None and number not in test.reached:
            continue
        limit = 30.0 + 10.0 * test.seconds
        passes = test.run(limit, MUTATED=str(number))
        # What is late without the mistake, too, tells of a busy machine.
        if passes is False or (passes is None and test.run(limit)):
            test.noticed += 1
            return f"{Path(test.binary).name.rsplit('-', 1)[0]} {test.name}"
    return ""


def report(part: str, drawn: list[dict], refused: dict[str, str], outcomes: dict[str, str]) -> None:
    """Print what became of the mistakes of a part."""
    names = [one["name"] for one in drawn]
    tried = [name for name in names if name in outcomes and name not in refused]
    left = [name for name in tried if not outcomes[name]]
    print("", f"Not noticed in {part}:", *left, "", sep="\n")
    noticed, size = len(tried) - len(left), len(tried)
    least, most = binomtest(noticed, size).proportion_ci(method="exact")
    alone = [name for name in names if refused.get(name, "").startswith(CONSTANT)]
    print(f"In constants, without room for a switch, to be tried alone in {part}:", *alone, "", sep="\n")
    unviable = sum(name in refused for name in names) - len(alone)
    print(
        f"{part}: {noticed} of {size} noticed, {100 * least:.1f} to {100 * most:.1f} % of all with 95 % confidence; "
        f"{unviable} of {len(names)} drawn do not compile"
    )


if __name__ == "__main__":
    sys.exit(main())

"""What commands take and print: each option as `commands.txt` beside this has it, results as Python shows them."""

from __future__ import annotations

import argparse
import inspect
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import pneumatic_servo as ps
import pytest
from pneumatic_servo.cli import main, parser
from pneumatic_servo.cli.common import settings_of
from test_identification import COLUMNS, bench, write

DESCRIBED = Path(__file__).with_name("commands.txt")


def told(action: argparse.Action) -> str:
    """An option as users see it: its names, what it takes, whether it must be given, its default, and its help."""
    names = [", ".join(action.option_strings) or action.dest]
    if action.choices:
        names.append("|".join(map(str, action.choices)))
    elif action.nargs != 0:
        names.append(str(action.metavar or getattr(action.type, "__name__", "TEXT")))
    if action.nargs not in (None, 0):
        names.append(str(action.nargs))
    if type(action).__name__ == "_AppendAction":
        names.append("(again and again)")
    if action.required and action.option_strings:
        names.append("(required)")
    return f"  {' '.join(names)} = {action.default}: {action.help}"


def commands() -> Iterator[str]:
    top = parser()
    yield f"{top.prog}: {top.description}"
    (found,) = (action for action in top._actions if isinstance(action, argparse._SubParsersAction))
    for name, command in found.choices.items():
        yield f"{command.prog}: {next(one.help for one in found._choices_actions if one.dest == name)}"
        yield from (told(action) for action in command._actions if action.dest != "help")


def test_every_option_is_as_described() -> None:
    """Where this is meant to change, the file is to be changed with it."""
    assert list(commands()) == DESCRIBED.read_text(encoding="utf-8").splitlines()


@pytest.mark.parametrize(
    "options", [["simulate", "a.csv", "--outpu", "position"], ["--versio"], ["fit", "--experimen"]]
)
def test_options_are_written_out(options: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """What is short today may mean two options tomorrow."""
    with pytest.raises(SystemExit) as caught:
        main(options)
    assert caught.value.code == 2 and "error: " in capsys.readouterr().err


def test_help_keeps_its_lines(capsys: pytest.CaptureFixture[str]) -> None:
    for options in ([], ["fit"], ["plan"]):
        with pytest.raises(SystemExit):
            main([*options, "--help"])
        shown = capsys.readouterr().out
        text = parser().epilog if not options else parser()._actions[-1].choices[options[0]].description  # type: ignore[index,call-overload]
        assert str(text) in shown


def test_simulate_tells_ranges_and_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my.csv").write_text("time,valveVoltage\n0,6.5\n0.1,6.5\n", encoding="utf-8")
    assert main(["simulate", "my.csv", "--outputs", "position,velocity"]) == 0
    run = ps.Model().simulate(inputs={"valveVoltage": 6.5}, stop=0.1, step=1e-3, outputs=["position", "velocity"])
    lines = [
        f"{name:24} {min(run[name]):14.6g} to {max(run[name]):14.6g} {unit}"
        for name, unit in (("position", "m"), ("velocity", "m/s"))
    ]
    assert capsys.readouterr().out.splitlines() == [*lines, "101 rows to 0.1 s"]


def test_fits_are_printed_as_python_shows_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write(Path("a.csv"), bench())
    given = ["a.csv", "--experiment", "motion", "--columns", COLUMNS, "--starts", "0", "--play", "0"]
    options = {"experiment": "motion", "columns": COLUMNS, "starts": 0, "play": 0.0, "progress": False}
    assert main(["fit", *given, "--law", "Coulomb"]) == 0
    alone = ps.fit("a.csv", law="Coulomb", **options)  # type: ignore[arg-type]
    assert capsys.readouterr().out == f"{alone}\nverdict: {alone.verdict}\n"
    assert main(["fit", *given, "--law", "Coulomb,Stribeck"]) == 0
    ranking = ps.compare_fits("a.csv", ["Coulomb", "Stribeck"], **options)  # type: ignore[arg-type]
    assert capsys.readouterr().out == f"{ranking}\n{ranking.best}\nverdict: {ranking.best.verdict}\n"


def test_settings_of_a_file_go_on_with_others(tmp_path: Path) -> None:
    file, model = tmp_path / "my.ssv", ps.Model()
    ps.DataSheet(bore=32, stroke=200, mass=5, qn=700).to_ssv(file)
    alone = settings_of(model, [str(file)])
    assert len(alone) > 3 and "incline" not in alone
    assert settings_of(model, ["incline=0.4", str(file), "friction.law=Dahl"]) == {
        "incline": 0.4, **alone, "friction.law": "Dahl",
    }  # fmt: skip


class Found(SimpleNamespace):
    """A fit that has found something of everything, and has not converged."""

    law = "Dahl"
    beside = ("offset.frictionForce", "area")
    undetermined: ClassVar[dict[str, str]] = {"friction.dahl.sigma0": "it is hidden"}
    problem = SimpleNamespace(experiment=SimpleNamespace(table=SimpleNamespace(name="FrictionBench")))
    cross_validation = "folds"
    verdict = "red"
    converged = False
    message = "out of steps"

    def __init__(self) -> None:
        files: list[str] = []
        super().__init__(
            files=files, to_ssv=files.append, to_json=files.append, to_report=files.append,
            posterior=Draws(files),
        )  # fmt: skip

    def __str__(self) -> str:
        return "values"


class Draws:
    """Its draws."""

    def __init__(self, files: list[str]) -> None:
        self.to_csv = files.append

    def __str__(self) -> str:
        return "draws"


WRITTEN = ["--out", "a.ssv", "--json", "a.json", "--report", "a.html", "--posterior", "a.csv"]
SAID = (
    "note: a.ssv is without offset.frictionForce, area, which FrictionBench does not have\n"
    "warning: friction.dahl.sigma0 is not determined: it is hidden\n"
    "error: the fit has not converged: out of steps\n"
)


def test_fit_says_and_writes_all_that_was_found(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    usual = {name: one.default for name, one in inspect.signature(ps.fit).parameters.items()}
    found, called = Found(), dict[str, object]()

    def fit(data: object, **given: object) -> Found:
        called.update(given, data=data)
        return found

    monkeypatch.setattr("pneumatic_servo.identification.fit", fit)
    command = ["fit", "bench.csv", "--experiment", "motion", "--law", "Dahl", *WRITTEN, "--cross-validate", "record"]
    assert main([*command, "--set", "friction.dahl.Fc=5,delay.position=3 ms"]) == 1
    told = capsys.readouterr()
    assert told.out == "draws\nfolds\nvalues\nverdict: red\n" and told.err == SAID
    assert [str(file) for file in found.files] == ["a.ssv", "a.json", "a.html", "a.csv"]
    # What nobody asked for is as it is in Python.
    assert called == {name: usual[name] for name in called if name != "data"} | {
        "data": [Path("bench.csv")], "fit": "", "experiment": "motion", "law": "Dahl", "posterior": True,
        "progress": True, "cross_validate": "record", "settings": {"friction.dahl.Fc": 5.0, "delay.position": 0.003},
    }  # fmt: skip


def test_several_fits_are_ranked_and_the_best_is_written(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    best, seeds = Found(), list[int]()

    class Ranking:
        def __init__(self, data: object, laws: Sequence[str], **given: object) -> None:
            self.best, self.laws, self.given = best, laws, given

        def evidence(self, seed: int) -> str:
            seeds.append(seed)
            return f"evidence of {', '.join(self.laws)}"

        def __str__(self) -> str:
            return "ranking"

    monkeypatch.setattr("pneumatic_servo.identification.compare_fits", Ranking)
    command = ["fit", "bench.csv", "--experiment", "motion", *WRITTEN, "--evidence", "--seed", "3"]
    assert main([*command, "--law", "Dahl,LuGre"]) == 1
    told = capsys.readouterr()
    assert told.out == "ranking\nevidence of Dahl, LuGre\ndraws\nfolds\nvalues\nverdict: red\n" and told.err == SAID
    assert seeds == [3] and [str(file) for file in best.files] == ["a.ssv", "a.json", "a.html", "a.csv"]
    assert main([*command, "--law", "Dahl"]) == 2
    assert capsys.readouterr().err == "error: --evidence compares laws: name several by --law\n"

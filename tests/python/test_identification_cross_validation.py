"""What is said of conditions that were left out: as a text, a table, a file, and in a figure."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.figures import BLUE
from pneumatic_servo.identification.conditions import Condition
from pneumatic_servo.identification.cross_validation import Case, CrossValidation, _of_others, _of_windows
from pneumatic_servo.identification.foretold import Foretold
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.signals import Units
from shared import is_styled

Array = NDArray[np.float64]

FORCE = Foretold(10.0, 8.0, 12.0, 11.0, 10.5, 11.5, 0.1)


def case(name: str, friction: Foretold | None, **ratios: float) -> Case:
    condition: Any = SimpleNamespace(name=name)
    fitted = dict.fromkeys(ratios, 0.01)
    return Case(condition, 200, {signal: 0.01 * ratio for signal, ratio in ratios.items()}, fitted, friction, ())


TOLD = CrossValidation(
    (case("1 bar", FORCE, force=1.5), case("3 bar", replace(FORCE, high=np.inf, measured=7.0), force=4.0))
)
UNTOLD = CrossValidation(
    (case("fast", None, position=3.0, velocity=1.0), case("slow", None, position=3.01, velocity=1.0))
)


def test_text_says_where_the_law_holds() -> None:
    assert repr(TOLD) == (
        "each condition left out in turn: the law holds in 1 of 2\n"
        "  1 bar: predicted 10 N [8, 12], measured 11 N [10.5, 11.5]\n"
        "  3 bar: predicted 10 N [8, inf], measured 7 N [10.5, 11.5]: the law does not hold there"
    )
    # Without friction it holds where up to three times as much is left as of a fit.
    assert repr(UNTOLD) == (
        "each condition left out in turn: the law holds in 1 of 2\n"
        "  fast: position is predicted to 0.03 m rms, and fitted to 0.01, velocity is predicted to 0.01 m/s rms, and "
        "fitted to 0.01\n"
        "  slow: position is predicted to 0.0301 m rms, and fitted to 0.01, velocity is predicted to 0.01 m/s rms, and "
        "fitted to 0.01: the law does not hold there"
    )
    turning = replace(TOLD, units=Units(is_rotating=True))
    assert "predicted 10 N.m [8, 12]" in repr(turning)
    assert [name for name in turning.columns if "(" in name] == ["friction predicted (N.m)", "measured (N.m)"]


def test_table_has_a_row_for_each_signal(tmp_path: Path) -> None:
    TOLD.to_csv(tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines() == [
        "left out,samples,signal,rms predicted,rms fitted along,unit,friction predicted (N),low,high,measured (N),"
        "measured low,measured high,holds",
        "1 bar,200,force,0.015,0.01,N,10.0,8.0,12.0,11.0,10.5,11.5,yes",
        "3 bar,200,force,0.04,0.01,N,10.0,8.0,inf,7.0,10.5,11.5,no",
    ]
    assert UNTOLD.rows()[1:3] == [
        ["fast", 200, "velocity", 0.01, 0.01, "m/s", *[None] * 6, "yes"],
        ["slow", 200, "position", pytest.approx(0.0301), 0.01, "m", *[None] * 6, "no"],
    ]
    assert UNTOLD.texts()[2] == ["slow", "200", "position", "0.0301", "0.01", "m", *[""] * 6, "no"]
    # An end that nothing tells is null.
    assert TOLD.as_list()[1] | {"left out": "", "signal": ""} == {
        "left out": "", "samples": 200, "signal": "", "rms predicted": 0.04, "rms fitted along": 0.01, "unit": "N",
        "friction predicted (N)": 10.0, "low": 8.0, "high": None, "measured (N)": 7.0, "measured low": 10.5,
        "measured high": 11.5, "holds": "no",
    }  # fmt: skip
    assert TOLD._repr_html_().count("<tr>") == 3 and "<td>3 bar</td>" in TOLD._repr_html_()


def test_figure_has_what_is_left_where_no_friction_is_told() -> None:
    figure = UNTOLD.plot()
    [axis] = figure.axes
    assert is_styled(figure) and {line.get_color() for line in axis.get_lines()} == {BLUE}
    for place, (line, ratio) in enumerate(zip(axis.get_lines(), (3.0, 3.01), strict=True)):
        assert_close(line.get_xdata(), np.array([ratio, 1.0]), rel=1e-14, what="ratios")
        assert line.get_ydata().tolist() == [place, place]
    assert axis.get_xlabel() == "rms if left out, over that if fitted along"
    assert [text.get_text() for text in axis.get_yticklabels()] == ["fast", "slow"] and axis.get_legend() is None


def test_windows_take_their_beginnings_with_them() -> None:
    """Two parameters, and windows that leave 2, 0 and 3 numbers of their beginnings free."""
    windows = tuple(SimpleNamespace(begin=SimpleNamespace(loose=("a", "b", "c")[:count])) for count in (2, 0, 3))
    problem = Problem(None, windows, (None, None), {})  # type: ignore[arg-type]
    x = np.arange(7.0)
    for places, expected in (([0, 1], [0, 1, 2, 3]), ([1, 2], [0, 1, 4, 5, 6]), ([2, 0], [0, 1, 4, 5, 6, 2, 3])):
        own, vector = _of_windows(problem, x, places)
        assert vector.tolist() == expected and own.windows == tuple(windows[place] for place in places)


def test_other_conditions_are_those_of_the_same_quantity() -> None:
    def group(quantity: str, *windows: int) -> Condition:
        return Condition(quantity, 0.0, "", windows)

    groups = [group("record", 0), group("pressure", 0, 1), group("pressure", 2, 4), group("pressure", 3)]
    # Of the windows 0, 1 and 3, which are fitted, the first two and the third are conditions of their own.
    assert _of_others([0, 1, 3], groups, groups[2]) == [[0, 1], [2]]

"""Forms of inputs and parameters: what means the same gives the same run, what could mean two things is refused."""

from __future__ import annotations

import datetime
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas
import pneumatic_servo as ps
import pytest

TIMES = np.arange(0, 0.2, 1e-3)
VOLTAGES = 5.0 + 3.0 * np.sin(30.0 * TIMES)
SPANS = pandas.to_timedelta(TIMES, unit="s")
DATES = pandas.Timestamp("2026-11-27") + SPANS
GIVEN: dict[str, Any] = {"stop": 0.2, "step": 1e-3, "outputs": ["position"]}
MANY: dict[str, Any] = {**GIVEN, "progress": False}


def simulate(inputs: object) -> ps.Run:
    return ps.Model().simulate(inputs=inputs if isinstance(inputs, pandas.DataFrame) else {"valveVoltage": inputs},
                               **GIVEN)  # fmt: skip


SAME: dict[str, object] = {
    "durations": (SPANS, VOLTAGES),
    "Series over durations": pandas.Series(VOLTAGES, index=SPANS),
    "dates": (DATES, VOLTAGES),
    "dates of NumPy": (DATES.to_numpy(), VOLTAGES),
    "Series over dates": pandas.Series(VOLTAGES, index=DATES),
    "Series over dates of a zone": pandas.Series(VOLTAGES, index=DATES.tz_localize("Europe/Berlin")),
    "durations of Python": ([datetime.timedelta(seconds=time) for time in TIMES.tolist()], VOLTAGES),
    "dates of Python": (DATES.to_pydatetime().tolist(), VOLTAGES),
    "times of the clock": ([f"{date:%H:%M:%S.%f}" for date in DATES], VOLTAGES),
    "Series that may have gaps": pandas.Series(pandas.array(VOLTAGES, dtype="Float64"), index=TIMES),
    "objects": (TIMES, VOLTAGES.astype(object)),
    "masked array without a mask": (TIMES, np.ma.masked_greater(VOLTAGES, 10.0)),
    "table over dates": pandas.DataFrame({"valveVoltage": VOLTAGES}, index=DATES),
    "table over durations with a name": pandas.DataFrame({"valveVoltage": VOLTAGES}, index=SPANS.rename("time")),
    "table over seconds": pandas.DataFrame({"valveVoltage": VOLTAGES, "Zustand": "on"}, index=TIMES)[["valveVoltage"]],
}


@pytest.mark.parametrize("form", SAME)
def test_input_is_the_same_in_each_form(form: str) -> None:
    expected = simulate((TIMES, VOLTAGES))["position"]
    assert np.ptp(expected) > 1e-3
    # Durations of pandas are whole nanoseconds.
    assert np.allclose(simulate(SAME[form])["position"], expected, rtol=0.0, atol=1e-12)


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "masked values": (lambda: simulate((TIMES, np.ma.masked_greater(VOLTAGES, 7.0))), "value .* is masked"),
    "masked times": (lambda: simulate((np.ma.masked_greater(TIMES, 0.1), VOLTAGES)), "value 101 is masked"),
    "logical values": (lambda: simulate((TIMES, VOLTAGES > 6.0)), "valveVoltage .* the values are true and false"),
    "logical Series": (lambda: simulate(pandas.Series(VOLTAGES > 6, index=TIMES)), "the values are true and false"),
    "logical column": (
        lambda: simulate(pandas.DataFrame({"time": TIMES, "valveVoltage": VOLTAGES > 6})), "are true and false"),
    "Series without times": (lambda: simulate(pandas.Series(VOLTAGES)), "valveVoltage: a Series must have times"),
    "rows that are only counted": (
        lambda: simulate(pandas.DataFrame({"valveVoltage": VOLTAGES})), "there is no column `time`"),
    "Series of many runs": (
        lambda: ps.Model().simulate_many(inputs={"valveVoltage": pandas.Series([6.0, 7.0])}, **MANY), "must have"),
    "pair that is no points": (
        lambda: ps.Model().simulate_many(inputs={"valveVoltage": (6, 7)}, **MANY), "is a list or an array"),
    "points of each run": (
        lambda: ps.Model().simulate_many(inputs={"valveVoltage": [(TIMES, VOLTAGES), (TIMES, VOLTAGES)]}, **MANY),
        "points of several runs are"),
    "masked parameters": (
        lambda: ps.Model().simulate_many({"supplyPressure": np.ma.masked_less([5e5, 6e5], 5.5e5)}, **MANY),
        "run 0 of 2: supplyPressure is refused: the value is masked"),
    "logical parameters": (
        lambda: ps.Model().simulate_many({"supplyPressure": np.array([True, False])}, **MANY),
        "run 0 of 2: supplyPressure = True is refused"),
}  # fmt: skip


@pytest.mark.parametrize("form", REFUSED)
def test_form_that_could_mean_something_else_is_refused(form: str) -> None:
    call, words = REFUSED[form]
    with pytest.raises(ValueError, match=words):
        call()


def test_table_of_parameters_has_a_row_for_each_run() -> None:
    values = {"supplyPressure": [5e5, 6e5], "friction.law": ["LuGre", "Dahl"], "mass.moving": [0.9, 1.1]}
    many = ps.Model().simulate_many
    expected = many(values, inputs={"valveVoltage": 7.0}, **MANY)["position"].tobytes()
    frame = pandas.DataFrame(values)
    for given in (frame, frame.to_dict("records"), {name: tuple(column) for name, column in values.items()}):
        assert many(given, inputs={"valveVoltage": 7.0}, **MANY)["position"].tobytes() == expected

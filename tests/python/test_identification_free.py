"""What a word says is free: where it begins, how far it may go, and whether the solver sees its logarithm."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pneumatic_servo as ps
import pytest
from pneumatic_servo.identification.parameters import Free, group_of, named_by, parse
from pneumatic_servo.identification.signals import Units

INF = math.inf
BENCH = ps.Model("FrictionBench")
FS = "friction.stribeck.Fs"
# What is positive and may be large goes three decades either way, and no further than the model takes.
LEVEL = Free(FS, "N", 11.0, 0.011, 11e3, 0.0, legal=(0.0, 1e6))
KAPPA = Free("friction.kappaA", "1/Pa", 0.0, -1e-3, 1e-3, 1e-6, legal=(-1e-3, 1e-3))


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        (FS, LEVEL),
        (f" {FS} = 5 ", replace(LEVEL, start=5.0, low=0.011, high=5e3, is_given=True)),
        (f"{FS}=1e4", replace(LEVEL, start=1e4, low=10.0, is_given=True)),
        # A start beyond the usual has its own three decades.
        (f"{FS}=12 kN", replace(LEVEL, start=12e3, low=12.0, high=1e6, is_given=True)),
        # Nothing has no logarithm; nor has a range that begins with it.
        (f"{FS}=0", replace(LEVEL, start=0.0, low=0.0, scale=11e3, is_given=True)),
        (f"{FS}:0:20", replace(LEVEL, low=0.0, high=20.0, scale=20.0, is_bounded=True, legal=(0.0, 20.0))),
        (f"{FS}=0:0:5", Free(FS, "N", 0.0, 0.0, 5.0, 5.0, is_given=True, is_bounded=True, legal=(0.0, 5.0))),
        # Bounds hold for whatever start is found later, and move one that nobody gave.
        (f"{FS}:1 N:2 kN", replace(LEVEL, low=1.0, high=2e3, is_bounded=True, legal=(1.0, 2e3))),
        (f"{FS}:40:50", replace(LEVEL, start=40.0, low=40.0, high=50.0, is_bounded=True, legal=(40.0, 50.0))),
        (f"{FS}:2:5", replace(LEVEL, start=5.0, low=2.0, high=5.0, is_bounded=True, legal=(2.0, 5.0))),
        # The ends of the range may be the start.
        (f"{FS}=2:2:5", Free(FS, "N", 2.0, 2.0, 5.0, 0.0, is_given=True, is_bounded=True, legal=(2.0, 5.0))),
        (f"{FS}=5:2:5", Free(FS, "N", 5.0, 2.0, 5.0, 0.0, is_given=True, is_bounded=True, legal=(2.0, 5.0))),
        # It may well be zero.
        ("friction.stribeck.sigma2", Free("friction.stribeck.sigma2", "N.s/m", 30.0, 0.0, 1e7, 30.0, legal=(0.0, 1e7))),
        # What is 0 by default changes by its nominal value, or by 1.
        ("friction.stribeck.FsInf", Free("friction.stribeck.FsInf", "N", 0.0, 0.0, 1e6, 15.0, legal=(0.0, 1e6))),
        ("position0", Free("position0", "m", 0.0, -1e3, 1e3, 1.0, legal=(-1e3, 1e3))),
        ("friction.dnlrx.c[2]", Free("friction.dnlrx.c[2]", "N/m", -3e4, -1e12, 1e12, 3e4, legal=(-1e12, 1e12))),
        # A share is none of decades.
        ("friction.bristle.deltaS", Free("friction.bristle.deltaS", "m", 1e-5, 1e-9, 1.0, 1e-5, legal=(1e-9, 1.0))),
        # A bench has it as well, which has no such parameter.
        ("friction.kappaA", KAPPA),
    ],
)  # fmt: skip
def test_word_says_what_is_free(word: str, expected: Free) -> None:
    found = parse(word, BENCH, ["frictionForce"])
    assert replace(found, low=expected.low, high=expected.high) == expected
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), rel=1e-14)
    assert named_by(word) == expected.name
    assert found.outer(found.inner(expected.high)) == pytest.approx(expected.high, rel=1e-14)


def test_area_is_told_by_the_data_alone() -> None:
    expected = Free("area", "m2", math.nan, -INF, INF, 1e-4)
    assert parse("area", BENCH, ["force"]) == replace(expected, start=math.nan)


def test_rotating_machine_has_units_of_its_own() -> None:
    turning = Units(is_rotating=True)
    assert parse(FS, BENCH, ["force"], units=turning) == replace(LEVEL, unit="N.m")
    assert parse(f"{FS}=200 mN.m", BENCH, ["force"], units=turning).start == pytest.approx(0.2)
    # What sensors do has its units already.
    assert parse("offset.force", BENCH, ["force"], {"offset.force": "N"}, turning).unit == "N"


@pytest.mark.parametrize(
    ("word", "text"),
    [
        (f"{FS}=5:1", "it must be NAME[=start][:low:high]"),
        (" =3", "it must be NAME[=start][:low:high]"),
        (f"{FS}:3:3", "the lower bound 3 is not below the upper bound 3"),
        (f"{FS}:-1:20", "the bounds leave what is legal, 0 to 1000000 N"),
        (f"{FS}:1:2e6", "the bounds leave what is legal, 0 to 1000000 N"),
        ("friction.stribeck.delta:0:1", "the bounds leave what is legal, 0.1 to 10"),
        (f"{FS}=30:1:20", "the start 30 is not within 1 to 20 N"),
        (f"{FS}=1e9", "the start 1000000000 is not within 0 to 1000000 N"),
        (f"{FS}=-1e-12", "the start -1e-12 is not within 0 to 1000000 N"),
        ("friction.law", "friction.law is no real parameter, so that it cannot be fitted"),
        ("friction.gms.N", "friction.gms.N is no real parameter, so that it cannot be fitted"),
        ("position", "position is no real parameter, so that it cannot be fitted"),
        ("area", "area needs the columns force and pressure, in the experiment motion"),
        ("friction.stribeck.Fx", "there is no friction.stribeck.Fx here; did you mean friction.stribeck.Fs or "
                                 "friction.stribeck.Fc or friction.stribeck.vs?"),
    ],
)  # fmt: skip
def test_word_that_says_nothing_is_refused(word: str, text: str) -> None:
    with pytest.raises(ValueError, match="^" + re.escape(f"fit={word!r}: {text}") + "$"):
        parse(word, BENCH, ["frictionForce"])


def test_start_that_is_found_moves_what_nobody_gave() -> None:
    """Bounds of a logarithm widen to three decades about it, as far as the model takes; others hold it."""
    found = LEVEL.at(100.0)
    assert (found.start, found.low, found.high) == (100.0, 0.011, pytest.approx(1e5))
    found = LEVEL.at(1e4)
    assert (found.start, found.high) == (1e4, 1e6)
    found = replace(LEVEL, legal=(1e-4, 1e6)).at(1e-2)
    assert (found.start, found.low, found.high) == (1e-2, 1e-4, 11e3)
    bounded = parse(f"{FS}:2:20", BENCH, ["frictionForce"])
    assert [bounded.at(start).start for start in (1.0, 7.0, 30.0)] == [2.0, 7.0, 20.0]
    assert bounded.at(30.0) == replace(bounded, start=20.0)
    assert [KAPPA.at(start).start for start in (-1.0, 1e-4, 1.0)] == [-1e-3, 1e-4, 1e-3]
    for free, start in (
        (LEVEL, math.nan),
        (LEVEL, INF),
        (LEVEL, 0.0),
        (LEVEL, -1.0),
        (replace(LEVEL, is_given=True), 5.0),
    ):
        assert free.at(start) == free


def test_group_of_a_law_is_that_of_its_parameters() -> None:
    assert [group_of(law, BENCH) for law in ("Stribeck", "BlimanSorine", "None")] == [
        "friction.stribeck", "friction.blimanSorine", ""
    ]  # fmt: skip
    with pytest.raises(
        ValueError, match=r"^law='Strbeck': there is no such law; did you mean Stribeck\?; there are None, "
    ):
        group_of("Strbeck", BENCH)

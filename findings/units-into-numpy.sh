#!/usr/bin/env bash
# Quantities of three packages meet NumPy. unyt 3.2.0 gives its numbers away without a word: mm and m in one list become [1, 2], and
# float(3 mm/m) is 3. Pint 0.25.3 warns when an array takes them and refuses a single element or float(); astropy 8.0.2 refuses single
# elements and float() but gives a whole array away. float(3 mm/m) is 0.003 in both, float(90 deg) is 1.57 in Pint, 90 in unyt, refused in astropy.
. "$(dirname "$0")/common.sh"
pinned pint==0.25.3 unyt==3.2.0 astropy==8.0.2 numpy==2.4.6
python - <<'PROGRAM'
import math
import warnings

import astropy.units as ap
import numpy as np
import pint
import unyt

pt = pint.UnitRegistry()


def outcome(call):
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        try:
            value = call()
        except Exception:
            return "refused"
    return (np.asarray(value).tolist(), any("UnitStripped" in str(w.category) for w in seen))


def filled(quantity, where):
    array = np.zeros(2)
    array[where] = quantity
    return array


expected = {  # (value, a warning was given), or refused
    "unyt": {"whole": ([1.0, 2.0], False), "element": ([3.0, 0.0], False), "mixed": ([1.0, 2.0], False), "float": (3.0, False),
             "ratio": (3.0, False), "angle": (90.0, False)},
    "astropy": {"whole": ([1.0, 2.0], False), "element": "refused", "mixed": "refused", "float": "refused", "ratio": (0.003, False),
                "angle": "refused"},
    "pint": {"whole": ([1.0, 2.0], True), "element": "refused", "mixed": "refused", "float": "refused", "ratio": (0.003, False),
             "angle": (math.pi / 2, False)},
}
for name, mm, m, deg in (("unyt", unyt.mm, unyt.m, unyt.degree), ("astropy", ap.mm, ap.m, ap.deg), ("pint", pt.mm, pt.m, pt.degree)):
    found = {
        "whole": outcome(lambda: filled(np.array([1.0, 2.0]) * mm, slice(None))),
        "element": outcome(lambda: filled(3 * mm, 0)),
        "mixed": outcome(lambda: np.array([1 * mm, 2 * m], dtype=float)),
        "float": outcome(lambda: float(3 * mm)),
        "ratio": outcome(lambda: float(3 * mm / m)),
        "angle": outcome(lambda: float(90 * deg)),
    }
    print(name, found)
    assert found == expected[name], name
PROGRAM

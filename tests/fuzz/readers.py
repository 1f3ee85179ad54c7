"""Looks for files that the readers of the Python package neither read nor refuse.

``python tests/fuzz/readers.py FOLDERS OPTIONS`` with the options of libFuzzer; `cargo xtask fuzz readers` calls it.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["pneumatic_servo"]):
    from reading import check

with tempfile.TemporaryDirectory() as folder:
    atheris.Setup(sys.argv, lambda data: check(data, Path(folder)))
    atheris.Fuzz()

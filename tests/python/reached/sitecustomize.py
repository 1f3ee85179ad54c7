"""Notes which functions of a copy that mutmut made a program reaches that a test starts, for `reach.py` to read."""

import atexit
import os
from pathlib import Path

from mutmut.mutation import trampoline

reached: set[str] = set()

trampoline._mutant_under_test = "stats"
trampoline.record_trampoline_hit = lambda function, caller=None: reached.add(function)


@atexit.register
def note() -> None:
    Path(os.environ["REACHED"], str(os.getpid())).write_text("\n".join(reached), encoding="utf-8")

"""Where a search starts: at levels of friction that the record shows, whatever the law calls them."""

from __future__ import annotations

import pneumatic_servo as ps
import pytest
from pneumatic_servo.identification.guess import started
from test_identification import bench

BREAK_AWAY = {"Stribeck": "Fs", "LuGre": "Fs", "ElastoPlastic": "Fs", "Armstrong": "FsInf"}
"""What tells how much more it takes to break away; of Armstrong it is only what comes on top."""


@pytest.mark.parametrize("law", BREAK_AWAY)
def test_search_starts_at_the_levels_of_the_record(law: str) -> None:
    """The record slides at 7 N and 25 N.s/m, and has 4 N more at rest, of which slow samples show a part."""
    problem = ps.fit(bench(), experiment="motion", law=law, play=0.0, starts=0, progress=False).problem
    starts = {free.name.rpartition(".")[2]: free.start for free in started(problem).free}
    assert starts["Fc"] == pytest.approx(7.0, rel=0.05)
    assert starts["sigma2"] == pytest.approx(25.0, rel=0.2)
    excess = starts[BREAK_AWAY[law]] - (0.0 if law == "Armstrong" else starts["Fc"])
    assert 2.0 < excess < 4.0
    # The slow samples are those below a tenth of the fastest; the peak is 12 mm/s wide.
    assert 0.004 < starts["vs"] < 0.03
    if "sigma0" in starts:
        # Bristles bend by a fiftieth of the stroke of 47 mm; at full speed, 65 mm/s, their damping is a tenth of Fc.
        assert starts["Fc"] / starts["sigma0"] == pytest.approx(0.047 / 50.0, rel=0.05)
        assert starts["sigma1"] * 0.065 == pytest.approx(0.1 * starts["Fc"], rel=0.1)

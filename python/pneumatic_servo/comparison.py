"""One experiment under several friction laws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pneumatic_servo import checks
from pneumatic_servo.files import write_csv
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.run import COUNTS, Run, Runs, table

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

COLUMNS = ["law", "travel (m)", "largest speed (m/s)", "largest friction (N)", "time at rest (s)", "apart (m rms)"]
AIR = "air (kg)"
"""The last column, where the runs count their air."""
RECORDED = ["position", "velocity", "frictionForce", "sticking"]
"""Variables of the table."""
COUNTED = "supply.consumed"
"""Variable of its last column."""


@dataclass(frozen=True)
class Comparison:
    """Runs of one experiment under several friction laws.

    Attributes
    ----------
    laws : tuple of str
        The laws.
    runs : Runs
        A run for each.
    notes : tuple of str
        In which levels of friction the laws are unlike, so that they are not models of one contact: other values, or
        none, since a law has no such parameter.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> found = ps.Model().compare(["Stribeck", "LuGre"], inputs={"valveVoltage": 6}, stop=0.2, step=1e-3)
    >>> found["LuGre"]["position"].shape, len(found.rows())
    ((201,), 2)
    >>> found.plot("velocity").savefig("laws.png")
    """

    laws: tuple[str, ...]
    runs: Runs
    notes: tuple[str, ...] = ()

    @staticmethod
    def of_begun(laws: Sequence[str], runs: Runs, notes: Sequence[str] = ()) -> Comparison | None:
        """Return the comparison of those laws whose runs have begun, if there are any."""
        begun = [place for place, rows in enumerate(runs.rows) if rows > 0]
        return Comparison(tuple(laws[place] for place in begun), runs.of(begun), tuple(notes)) if begun else None

    def __getitem__(self, law: str) -> Run:
        """Return the run under a law."""
        if law not in self.laws:
            raise KeyError(
                f"{law} was not compared{did_you_mean(str(law), self.laws)}; there are {', '.join(self.laws)}"
            )
        return self.runs[self.laws.index(law)]

    def __iter__(self) -> Iterator[str]:
        return iter(self.laws)

    def __len__(self) -> int:
        return len(self.laws)

    @property
    def columns(self) -> list[str]:
        """The columns of the table: `COLUMNS`, and with ``consumption.enabled`` the air consumption."""
        counts = COUNTED in self.runs.variables and all(run.settings.get(COUNTS) for run in self.runs)
        return [*COLUMNS, AIR] if counts else COLUMNS

    def rows(self) -> list[tuple[Any, ...]]:
        """Return the table: travel and largest values, time at rest, and the position's rms distance from the first.

        The columns are `columns`. A law whose run fails is measured up to the failure.
        """
        return [(law, *self._facts(run)) for law, run in zip(self.laws, self.runs, strict=True)]

    def _facts(self, run: Run) -> tuple[float, ...]:
        position, first = run["position"], self.runs[0]["position"]
        common = min(len(position), len(first))
        apart = float(np.sqrt(np.mean((position[:common] - first[:common]) ** 2)))
        rest = float(np.sum(np.diff(run.time) * (run["velocity"][:-1] == 0.0)))
        largest = (float(np.max(np.abs(run[name]))) for name in ("velocity", "frictionForce"))
        air = (float(run[COUNTED][-1] - run[COUNTED][0]),) if AIR in self.columns else ()
        return float(np.ptp(position)), *largest, rest, apart, *air

    def to_pandas(self) -> pandas.DataFrame:
        """Return the table with the laws as its index."""
        from pneumatic_servo.errors import MissingPackage

        try:
            import pandas
        except ImportError as error:
            raise MissingPackage("pandas", "pandas") from error
        return pandas.DataFrame(self.rows(), columns=self.columns).set_index("law")

    def to_csv(self, file: str | Path) -> None:
        """Write the table; the file appears as a whole or not at all."""
        write_csv(Path(file), self.columns, self.rows())

    def plot(self, *names: str) -> Figure:
        """Draw variables under all laws over each other, by default position, velocity and friction force."""
        from pneumatic_servo.figures import draw_laws

        return draw_laws(dict(zip(self.laws, self.runs, strict=True)), names or RECORDED[:3])

    def _repr_html_(self) -> str:
        notes = "".join(f"<p>{escape(note)}</p>" for note in self._unlike())
        return table(self.columns, ([law, *(f"{fact:.6g}" for fact in facts)] for law, *facts in self.rows())) + notes

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.laws)

    def __repr__(self) -> str:
        width = max(len(law) for law in self.laws)
        head = f"{'law':{width}}" + "".join(f"{column:>22}" for column in self.columns[1:])
        body = (f"{law:{width}}" + "".join(f"{fact:22.6g}" for fact in facts) for law, *facts in self.rows())
        return "\n".join([head, *body, *self._unlike()])

    def _unlike(self) -> list[str]:
        return [f"unlike in {note}" for note in self.notes]


def check_laws(laws: Sequence[str]) -> tuple[str, ...]:
    """Refuse a text, an empty list and repetitions."""
    laws = checks.names("laws", laws)
    if not laws:
        raise ValueError("laws is empty: name at least one friction law")
    twice = next((law for law in laws if laws.count(law) > 1), None)
    if twice is not None:
        raise ValueError(f"laws has {twice} twice")
    return tuple(laws)

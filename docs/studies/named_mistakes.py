"""Named mistakes: each is made in the record of the synthetic rig, one at a time.

A mistake counts as named if what is said of the record before the fit, or by the verdict after it, has the words that
say what is wrong. The record as it is must not be doubted.

Usage: python docs/studies/named_mistakes.py [--output target/studies]
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
from numpy.typing import NDArray
from pneumatic_servo.files import write_csv
from pneumatic_servo.identification.smoothing import slope

Array = NDArray[np.float64]
Data = dict[str, Array]

ROOT = Path(__file__).resolve().parents[2]
COLUMNS = ["mistake", "named", "when", "what is said"]
FREE = [*(f"friction.stribeck.{name}" for name in ("Fs", "Fc", "vs", "sigma2")), "valve.deadZone", "valve.C"]
BEFORE, AFTER = "before the fit", "by the verdict"


@dataclass(frozen=True)
class Mistake:
    """A change of the record, and the words that name it."""

    change: Callable[[Data], Data]
    words: tuple[str, ...]
    when: str = BEFORE


def record() -> Data:
    """The record that ships as examples/rig.csv, in SI units."""
    table = np.genfromtxt(ROOT / "examples" / "rig.csv", delimiter=",", names=True)
    return {"time": table["t"], "valveVoltage": table["u"], "position": 1e-3 * table["x_mm"],
            "chamberA.pressure": 1e5 * table["pa_bar"], "chamberB.pressure": 1e5 * table["pb_bar"]}  # fmt: skip


def scaled(name: str, factor: float, offset: float = 0.0) -> Callable[[Data], Data]:
    return lambda data: {**data, name: factor * data[name] + offset}


def swapped(data: Data) -> Data:
    a, b = "chamberA.pressure", "chamberB.pressure"
    return {**data, a: data[b], b: data[a]}


def with_velocity(factor: float) -> Callable[[Data], Data]:
    return lambda data: {**data, "velocity": factor * slope(data["position"], 1e-3, 0.02)}


def spoilt(name: str, value: float) -> Callable[[Data], Data]:
    def change(data: Data) -> Data:
        course = data[name].copy()
        course[700] = value
        return {**data, name: course}

    return change


def clipped(name: str, share: float) -> Callable[[Data], Data]:
    """A converter whose range ends below the highest readings."""
    return lambda data: {**data, name: np.minimum(data[name], np.quantile(data[name], share))}


def dropped(first: int, count: int) -> Callable[[Data], Data]:
    """Samples that are lost in one go while the time counts on."""

    def change(data: Data) -> Data:
        kept = {name: np.delete(course, np.s_[first : first + count]) for name, course in data.items()}
        return {**kept, "time": data["time"][: len(kept["time"])]}

    return change


def repeated(every: int) -> Callable[[Data], Data]:
    """A recorder that now and then writes the row before once more."""

    def change(data: Data) -> Data:
        places = np.arange(len(data["time"]))
        places[every::every] -= 1
        return {name: course if name == "time" else course[places] for name, course in data.items()}

    return change


def filtered(names: tuple[str, ...], time: float) -> Callable[[Data], Data]:
    """A filter of first order with a time constant in s."""

    def low_pass(course: Array) -> Array:
        share, found, last = 1e-3 / (1e-3 + time), np.empty_like(course), course[0]
        for place, value in enumerate(course):
            last += share * (value - last)
            found[place] = last
        return found

    return lambda data: {**data, **{name: low_pass(data[name]) for name in names}}


def late(name: str, samples: int) -> Callable[[Data], Data]:
    return lambda data: {
        **data, name: np.concatenate([np.full(samples, data[name][0]), data[name][:-samples]])
    }  # fmt: skip


MISTAKES: dict[str, Mistake] = {
    "position in mm": Mistake(scaled("position", 1e3), ("position is from", "write position=...[mm]")),
    "position turned": Mistake(
        scaled("position", -1.0), ("position is from", "sign turned", "position=-column")
    ),
    "position from the other end": Mistake(
        scaled("position", -1.0, 0.5), ("does the position count from the other end?", "'gain.position': -1")
    ),
    "position from its middle": Mistake(
        scaled("position", 1.0, -0.25), ("position is from", "does it count from the middle")
    ),
    "pressure A in bar": Mistake(
        scaled("chamberA.pressure", 1e-5), ("chamberA.pressure is from", "are these bar?")
    ),
    "pressure B in kPa": Mistake(
        scaled("chamberB.pressure", 1e-3), ("chamberB.pressure is from", "are these kPa?")
    ),
    "pressure A from the atmosphere": Mistake(
        scaled("chamberA.pressure", 1.0, -101325.0), ("chamberA.pressure is from", "count from the atmosphere")
    ),
    "pressure B from the atmosphere, in bar": Mistake(
        scaled("chamberB.pressure", 1e-5, -1.01325), ("chamberB.pressure is from", "barg")
    ),
    "chambers swapped": Mistake(swapped, ("chambers swapped",)),
    "voltage in percent": Mistake(scaled("valveVoltage", 10.0), ("valveVoltage is from", "in percent?")),
    "voltage in mV": Mistake(scaled("valveVoltage", 1e3), ("valveVoltage is from", "are these mV?")),
    "voltage about 0": Mistake(
        scaled("valveVoltage", 1.0, -5.0), ("valveVoltage is from", "count from the middle?")
    ),
    "voltage turned": Mistake(
        scaled("valveVoltage", -1.0, 10.0), ("falls when valveVoltage is above 5 V", "turned")
    ),
    "voltage 10 ms late": Mistake(late("valveVoltage", 10), ("estimate delay.valveVoltage", "late"), AFTER),
    "time in ms": Mistake(scaled("time", 1e3), ("samples are 1 s apart", "[ms]")),
    "time in Ms": Mistake(scaled("time", 1e-6), ("samples are 1e-9 s apart",)),
    "a word that was lost": Mistake(
        spoilt("chamberA.pressure", 9.99e6), ("far off all samples around it", "9990000 Pa")
    ),
    "a sample that is missing": Mistake(spoilt("position", np.nan), ("position is NaN", "sample 700")),
    "samples dropped, time counted on": Mistake(dropped(300, 100), ("position leaps by", "samples dropped")),
    "each tenth row repeated": Mistake(repeated(10), ("rows repeat the one before", "lost samples")),
    "a sensor that is dead": Mistake(
        scaled("chamberB.pressure", 0.0, 2e5), ("chamberB.pressure = 200000 Pa all the time",)
    ),
    "pressure A clipped": Mistake(
        clipped("chamberA.pressure", 0.9), ("chamberA.pressure stays at", "clipped")
    ),
    "pressure A through a filter of 20 ms": Mistake(
        filtered(("chamberA.pressure",), 0.02), ("estimate lag.chamberA.pressure", "through a filter"), AFTER
    ),
    "velocity in mm/s": Mistake(
        with_velocity(1e3), ("times the slope of position", "velocity=...[mm/s]")
    ),
    "velocity turned": Mistake(with_velocity(-1.0), ("times the slope of position", "velocity=-column")),
}  # fmt: skip


def said_before(data: Data) -> str:
    """Messages about a record before a second vector is evaluated."""

    def stop(text: str) -> None:
        if text.startswith("cost"):
            raise KeyboardInterrupt

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            ps.fit(data, experiment="rig", law="Stribeck", settings={"supplyPressure": 6e5}, starts=0, progress=stop)
        except ps.Interrupted:
            pass
        except ValueError as error:
            return str(error)
    return " ".join(str(one.message) for one in caught)


def said_after(data: Data) -> str:
    """The light of the verdict on a fit, and what it says of sensors."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = ps.fit(data, experiment="rig", law="Stribeck", fit=FREE, settings={"supplyPressure": 6e5}, starts=0,
                       progress=False)  # fmt: skip
    return f"{found.verdict.light}: {found.doubt or 'no sensor is doubted'}"


def tried(name: str) -> tuple[str, str, str, str]:
    """A row of the table."""
    mistake = MISTAKES[name]
    text = (said_before if mistake.when == BEFORE else said_after)(mistake.change(record()))
    is_named = all(word in text for word in mistake.words)
    return name, "yes" if is_named else "no", mistake.when, text


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=ROOT / "target" / "studies", help="folder of the table")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    rows = [tried(name) for name in MISTAKES]
    write_csv(options.output / "mistakes.csv", COLUMNS, rows)
    for row in rows:
        print(" | ".join(row))
    print(f"{sum(row[1] == 'yes' for row in rows)} of {len(rows)} mistakes are named")
    return 0


if __name__ == "__main__":
    sys.exit(main())

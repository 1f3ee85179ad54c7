"""Trajectories of the slider, the vibro-impact system and the festoon, computed without the implementation.

    python systems.py              write the CSV of every case of systems.json
    python systems.py NAME ...     some of them

Needs NumPy and SciPy. Parameters that a case does not state have the defaults of the description in modelDescription.

Every system is a hybrid automaton: smooth within a mode, whose end is located as an event. Unknowns differ on purpose
from the implementation: the slider is integrated in the frame at rest, the two masses of the vibro-impact
system in their displacement, and the trolleys of the festoon through their mass matrix.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from scipy.integrate import solve_ivp

FOLDER = Path(__file__).resolve().parent
DESCRIPTIONS = FOLDER.parents[1] / "modelDescription"
TOLERANCE = 1e-12
COARSE_TOLERANCE = 1e-10
GRAVITY = 9.80665
MAX_EVENTS = 100_000

Vector = np.ndarray
Margin = Callable[[float, Vector], float]


class Friction:
    """A set-valued law: break-away force, and kinetic force as a function of speed."""

    def __init__(self, law: str, statics: float, coulomb: float, vs: float, delta: float, sigma2: float) -> None:
        self.statics, self._coulomb, self._vs, self._delta = statics, coulomb, vs, delta
        self._sigma2 = sigma2
        self._has_peak = law == "Stribeck"

    def kinetic(self, velocity: float, direction: int, level: float = 1.0) -> float:
        peak = math.exp(-((max(direction * velocity, 0.0) / self._vs) ** self._delta)) if self._has_peak else 0.0
        return level * direction * (self._coulomb + (self.statics - self._coulomb) * peak) + self._sigma2 * velocity

    def mode_at_rest(self, applied: float, level: float = 1.0) -> int:
        """0 where friction can hold, else the direction of sliding."""
        return 0 if abs(applied) <= level * self.statics else int(math.copysign(1, applied))


class System(ABC):
    """A hybrid automaton; each system defines its modes."""

    state: Vector
    mode: Any

    @abstractmethod
    def rates(self, t: float, y: Vector) -> Sequence[float]:
        """Derivatives of the states in the present mode."""

    @abstractmethod
    def margins(self) -> Sequence[Margin]:
        """Functions that are positive while the present mode lasts."""

    @abstractmethod
    def switch(self, which: int, t: float) -> None:
        """Changes mode and state when a margin has reached zero."""

    @abstractmethod
    def row(self, t: float) -> dict[str, float]:
        """The columns."""

    def set(self, name: str, value: float, t: float) -> None:
        """Takes a new value of an input."""
        setattr(self, name, value)
        self.settle(t)

    def settle(self, t: float) -> None:
        """Switches where a new input has made the mode invalid."""
        while True:
            broken = [i for i, margin in enumerate(self.margins()) if margin(t, self.state) < -1e-9]
            if not broken:
                return
            self.switch(broken[0], t)

    def advance(self, start: float, end: float, tolerance: float) -> None:
        time = start
        for _ in range(MAX_EVENTS):
            events = [_falling(margin) for margin in self.margins()]
            solution = solve_ivp(
                self.rates,
                (time, end),
                self.state,
                method="DOP853",
                events=events,
                rtol=tolerance,
                atol=tolerance * 1e-3,
                max_step=5e-3,
            )
            self.state = solution.y[:, -1]
            time = solution.t[-1]
            if solution.status == 0:
                return
            which = next(i for i, times in enumerate(solution.t_events) if len(times))
            self.switch(which, time)
        raise RuntimeError("no progress")


def _falling(margin: Margin) -> Margin:
    function = lambda t, y: margin(t, y)  # noqa: E731
    function.terminal, function.direction = True, -1.0
    return function


class Slider(System):
    """States: position and velocity in the frame at rest."""

    def __init__(self, p: Mapping[str, float], friction: Friction) -> None:
        self._m, self._friction = p["mass"], friction
        self._vd, self._w = p["tray.velocityAmplitude"], 2.0 * math.pi * p["tray.frequency"]
        self.externalForce = 0.0
        self.state = np.array([p["relativePosition0"], p["relativeVelocity0"] + self._vd])
        self._place = p["relativePosition0"]
        u = p["relativeVelocity0"]
        self.mode = int(math.copysign(1, u)) if u else self._friction.mode_at_rest(self._applied(0.0))

    def _tray(self, t: float) -> tuple[float, float]:
        return self._vd / self._w * math.sin(self._w * t), self._vd * math.cos(self._w * t)

    def _applied(self, t: float) -> float:
        """Friction force that takes the slider along."""
        return self.externalForce + self._m * self._vd * self._w * math.sin(self._w * t)

    def rates(self, t: float, y: Vector) -> Sequence[float]:
        if self.mode == 0:
            return [self._tray(t)[1], -self._vd * self._w * math.sin(self._w * t)]
        force = self._friction.kinetic(y[1] - self._tray(t)[1], self.mode)
        return [y[1], (self.externalForce - force) / self._m]

    def margins(self) -> Sequence[Margin]:
        if self.mode == 0:
            return [lambda t, y: self._friction.statics - abs(self._applied(t))]
        return [lambda t, y: self.mode * (y[1] - self._tray(t)[1])]

    def switch(self, which: int, t: float) -> None:
        x, v = self._tray(t)
        if self.mode == 0:
            self.state = np.array([x + self._place, v])
            self.mode = int(math.copysign(1, self._applied(t)))
        else:
            self.state[1] = v
            self._place = self.state[0] - x
            self.mode = self._friction.mode_at_rest(self._applied(t))

    def row(self, t: float) -> dict[str, float]:
        x, v = self._tray(t)
        position, velocity = (x + self._place, v) if self.mode == 0 else self.state
        return {
            "position": position,
            "velocity": velocity,
            "relativePosition": position - x,
            "relativeVelocity": velocity - v,
            "sticking": float(self.mode == 0),
        }


class VibroImpact(System):
    """States: displacement of the internal mass and its rate, position and velocity of the body."""

    def __init__(self, p: Mapping[str, float], friction: Friction) -> None:
        self._p, self._friction = p, friction
        self._w = 2.0 * math.pi * p["excitation.frequency"]
        self.state = np.zeros(4)
        self._touches, self._impacts = False, 0
        self.mode = 0

    def _internal(self, t: float, y: Vector) -> float:
        """Force on the internal mass."""
        p, (d, rate) = self._p, y[:2]
        force = p["excitation.amplitude"] * math.sin(self._w * t) - p["spring.k1"] * d - p["spring.k2"] * d**3
        force -= p["spring.damping"] * rate
        return force - (p["impact.stiffness"] * (d - p["impact.gap"]) if self._touches else 0.0)

    def rates(self, t: float, y: Vector) -> Sequence[float]:
        inner, p = self._internal(t, y), self._p
        body = 0.0 if self.mode == 0 else (-inner - self._friction.kinetic(y[3], self.mode)) / p["mass"]
        return [y[1], inner / p["internal.mass"] - body, 0.0 if self.mode == 0 else y[3], body]

    def margins(self) -> Sequence[Margin]:
        side = 1.0 if self._touches else -1.0
        impact: Margin = lambda t, y: side * (y[0] - self._p["impact.gap"])  # noqa: E731
        if self.mode == 0:
            return [impact, lambda t, y: self._friction.statics - abs(self._internal(t, y))]
        return [impact, lambda t, y: self.mode * y[3]]

    def switch(self, which: int, t: float) -> None:
        if which == 0:
            self._touches = not self._touches
            self._impacts += self._touches
            return
        inner = self._internal(t, self.state)
        if self.mode == 0:
            self.mode = int(math.copysign(1, -inner))
        else:
            self.state[1] += self.state[3]
            self.state[3] = 0.0
            self.mode = self._friction.mode_at_rest(-inner)

    def row(self, t: float) -> dict[str, float]:
        d, rate, x, v = self.state
        sticks = self.mode == 0
        return {
            "position": x,
            "velocity": 0.0 if sticks else v,
            "displacement": d,
            "displacementRate": rate,
            "sticking": float(sticks),
            "impacts": float(self._impacts),
        }


class Festoon(System):
    """States: position of the crane trolley; position, velocity, angle and angular velocity of each trolley."""

    def __init__(self, p: Mapping[str, float], friction: Friction) -> None:
        self._p, self._friction, self._n = p, friction, int(p["trolleys"])
        self.craneVelocity = self.pulseForce = 0.0
        start = [p["crane.position0"]]
        for i in range(self._n):
            start += [p["crane.position0"] - (i + 1) * p["spacing0"], 0.0, p["load.angle0"], 0.0]
        self.state = np.array(start)
        self.mode = [0] * self._n
        self._links = [self._link(self._gap(self.state, i)) for i in range(self._n)]

    def _gap(self, y: Vector, i: int) -> float:
        return (y[0] if i == 0 else y[4 * i - 3]) - y[4 * i + 1]

    def _link(self, gap: float) -> int:
        return int(gap > self._p["rope.length"]) - int(gap < self._p["buffer.length"])

    def _velocities(self, y: Vector) -> list[float]:
        return [y[4 * i + 2] if self.mode[i] else 0.0 for i in range(self._n)]

    def _pull(self, y: Vector, i: int) -> float:
        if i == self._n or self._links[i] == 0:
            return 0.0
        kind, side = ("rope", 1) if self._links[i] > 0 else ("buffer", -1)
        p, v = self._p, self._velocities(y)
        stretch = side * (self._gap(y, i) - p[f"{kind}.length"])
        rate = side * ((self.craneVelocity if i == 0 else v[i - 1]) - v[i])
        return side * max(0.0, p[f"{kind}.stiffness"] * stretch * (1.0 + p[f"{kind}.damping"] * rate))

    def _level(self, i: int) -> float:
        return self._p[f"friction.level[{i + 1}]"]

    def _swing(self, y: Vector, i: int) -> tuple[float, float, float]:
        """Coupling of the mass matrix, and the forces on trolley and load besides accelerations and friction."""
        p = self._p
        angle, spin = y[4 * i + 3 : 4 * i + 5]
        m, length = p["load.mass"], p["load.length"]
        force = self._pull(y, i) - self._pull(y, i + 1) + (self.pulseForce if i == 0 else 0.0)
        force += m * length * spin**2 * math.sin(angle)
        torque = -m * GRAVITY * length * math.sin(angle) - p["load.damping"] * spin
        return m * length * math.cos(angle), force, torque

    def _applied(self, y: Vector, i: int) -> float:
        """Friction force that balances a trolley at rest."""
        coupling, force, torque = self._swing(y, i)
        return force - coupling * torque / (self._p["load.mass"] * self._p["load.length"] ** 2)

    def rates(self, t: float, y: Vector) -> Sequence[float]:
        p = self._p
        inertia = p["load.mass"] * p["load.length"] ** 2
        rates = [self.craneVelocity]
        for i, velocity in enumerate(self._velocities(y)):
            coupling, force, torque = self._swing(y, i)
            if self.mode[i] == 0:
                acceleration, spin_rate = 0.0, torque / inertia
            else:
                force -= self._friction.kinetic(velocity, self.mode[i], self._level(i))
                matrix = np.array([[p["trolley.mass"] + p["load.mass"], coupling], [coupling, inertia]])
                acceleration, spin_rate = np.linalg.solve(matrix, [force, torque])
            rates += [velocity, acceleration, y[4 * i + 4], spin_rate]
        return rates

    def margins(self) -> Sequence[Margin]:
        return [self._link_margin(i) for i in range(self._n)] + [self._trolley_margin(i) for i in range(self._n)]

    def _link_margin(self, i: int) -> Margin:
        rope, buffer, link = self._p["rope.length"], self._p["buffer.length"], self._links[i]
        if link == 0:
            return lambda t, y: min(rope - self._gap(y, i), self._gap(y, i) - buffer)
        return lambda t, y: self._gap(y, i) - rope if link > 0 else buffer - self._gap(y, i)

    def _trolley_margin(self, i: int) -> Margin:
        if self.mode[i] == 0:
            return lambda t, y: self._level(i) * self._friction.statics - abs(self._applied(y, i))
        return lambda t, y: self.mode[i] * y[4 * i + 2]

    def switch(self, which: int, t: float) -> None:
        if which < self._n:
            slack = self._links[which] != 0
            middle = 0.5 * (self._p["rope.length"] + self._p["buffer.length"])
            self._links[which] = 0 if slack else (1 if self._gap(self.state, which) > middle else -1)
            return
        i = which - self._n
        if self.mode[i]:
            self.state[4 * i + 2] = 0.0
            self.mode[i] = 0
            self.mode[i] = self._friction.mode_at_rest(self._applied(self.state, i), self._level(i))
        else:
            self.mode[i] = int(math.copysign(1, self._applied(self.state, i)))

    def row(self, t: float) -> dict[str, float]:
        row = {"crane.position": self.state[0]}
        for i, velocity in enumerate(self._velocities(self.state)):
            row |= {
                f"trolley[{i + 1}].position": self.state[4 * i + 1],
                f"trolley[{i + 1}].velocity": velocity,
                f"trolley[{i + 1}].load.angle": self.state[4 * i + 3],
                f"trolley[{i + 1}].sticking": float(self.mode[i] == 0),
            }
        return row


def build(case: Mapping[str, Any]) -> System:
    p = defaults(case["model"]) | {k: v for k, v in case["parameters"].items() if not isinstance(v, str)}
    law = case["parameters"].get("friction.law", "Stribeck")
    group = f"friction.{law[0].lower()}{law[1:]}"
    curve = [p.get(f"{group}.{name}", 1.0) for name in ("vs", "delta", "sigma2")]
    match case["model"]:
        case "DrivenSlider":
            weight = p["mass"] * GRAVITY
            return Slider(p, Friction(law, p["muStatic"] * weight, p["muDynamic"] * weight, *curve))
        case "VibroImpact":
            return VibroImpact(p, Friction(law, p["friction.Fs"], p["friction.ratio"] * p["friction.Fs"], *curve))
        case _:
            return Festoon(p, Friction(law, p[f"{group}.Fs"], p[f"{group}.Fc"], *curve))


def defaults(model: str) -> dict[str, float]:
    """Start values of the real and integer parameters."""
    values = {}
    for variable in ElementTree.parse(DESCRIPTIONS / f"{model}.xml").iter("ScalarVariable"):
        for kind in ("Real", "Integer"):
            element = variable.find(kind)
            if element is not None and element.get("start") is not None:
                values[variable.get("name", "")] = float(element.get("start", ""))
    return values


def simulate(case: Mapping[str, Any], tolerance: float) -> list[list[float]]:
    """Rows of time and columns."""
    system = build(case)
    changes = sorted((time, name, value) for name, steps in case["inputs"].items() for time, value in steps)
    count = round(case["stopTime"] / case["outputStep"])
    times = [round(k * case["outputStep"], 9) for k in range(count + 1)]
    rows = []
    for start, end in zip(times, [*times[1:], None], strict=True):
        for time, name, value in changes:
            if time == start:
                system.set(name, value, start)
        system.settle(start)
        row = system.row(start)
        rows.append([start, *(row[name] for name in case["columns"])])
        if end is not None:
            system.advance(start, end, tolerance)
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", help="cases to run; all if none is given")
    names = parser.parse_args().names
    for case in json.loads((FOLDER / "systems.json").read_text()):
        if names and case["name"] not in names:
            continue
        rows = simulate(case, TOLERANCE)
        with (FOLDER / f"{case['name']}.csv").open("w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["time", *case["columns"]])
            writer.writerows([f"{value:.12g}" for value in row] for row in rows)
        apart = np.abs(np.array(rows) - np.array(simulate(case, COARSE_TOLERANCE))).max(axis=0)
        worst = dict(zip(case["columns"], (f"{value:.0e}" for value in apart[1:]), strict=True))
        print(f"{case['name']}: {len(rows)} rows; change from tolerance {COARSE_TOLERANCE:.0e}: {worst}", flush=True)


if __name__ == "__main__":
    main()

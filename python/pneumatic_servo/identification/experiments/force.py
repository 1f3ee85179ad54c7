"""An axis or a carriage that a measured force moves; no gas anywhere."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.argument_names import quoted
from pneumatic_servo.identification.experiments import position
from pneumatic_servo.identification.experiments.base import Beginning, Values, Window
from pneumatic_servo.identification.experiments.cylinder import GRAVITY, middle
from pneumatic_servo.identification.experiments.mechanical import WINDOW
from pneumatic_servo.identification.experiments.pushed import Pushed
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.smoothing import fastest, slope, smooth
from pneumatic_servo.model import Model
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]

FEWEST = 30
"""Fewest samples of a window, unless another length is given: its start values are estimated as well."""
COMPARED = ("position", "velocity")


class Force(Pushed):
    """A free mass on FrictionBench, pushed by the measured force; its position or its velocity, or both, are compared.

    ```text
    mass*dv/dt = gain.force*(force - offset.force) - mass*g*sin(incline) - spring*(position - springRest) - friction
    level = normalForce/rated, times friction.direction.factor outwards
    ```

    The spring takes the position that was measured, so that it needs one. Of a rotating machine mass is an inertia,
    force a torque, and position an angle.
    """

    name = "force"
    required = ("time", "force")

    def make_model(self) -> Model:
        """Return the bench."""
        return Model("FrictionBench")

    def use(self, signals: object) -> None:
        """Take the measured signals; refuse too few."""
        super().use(signals)  # type: ignore[arg-type]
        if not self.signals & set(COMPARED):
            raise ValueError(f"{quoted('experiment', 'force')} needs a column for position or velocity")
        if self.units.is_rotating and "incline" in self.settings:
            raise ValueError(f"{quoted('settings', 'incline')}: a rotating machine has none; its mass is an inertia")
        for name in ("spring", "springRest"):
            if name in self.settings and "position" not in self.signals:
                raise ValueError(f"{quoted('settings', name)}: a spring needs a column for position")

    @property
    def compared(self) -> tuple[str, ...]:
        """Measured signals of the motion."""
        return tuple(signal for signal in COMPARED if signal in self.signals)

    @property
    def driving(self) -> tuple[str, ...]:
        """The force, and the load."""
        return tuple(signal for signal in ("force", "normalForce") if signal in self.signals)

    @property
    def unknown(self) -> tuple[str, ...]:
        """The mass, as the bench's default says nothing of a machine, and the gain from current to force."""
        return ("mass",) if self.units.of_gain("force") == "1" else ("mass", "gain.force")

    @property
    def beside(self) -> Mapping[str, str]:
        """Incline and spring, which the bench does not have; rotating masses are balanced."""
        own = {} if self.units.is_rotating else {"incline": "rad"}
        if "position" in self.signals:
            own |= {"spring": self.units.of("N/m"), "springRest": self.units.of("m")}
        return {**super().beside, **own}

    def windows(self, record: Record) -> list[Record]:
        """Cut a record into short parts, since the noise of a force adds up in the position."""
        if self.options.window is None:
            other = copy(self)
            other.options = replace(self.options, window=max(WINDOW, FEWEST * record.step))
            return other.windows(record)
        return super().windows(record)

    def prepare(self, record: Record) -> tuple[Mapping[str, Array], NDArray[np.bool_]]:
        """Smooth the force, whose noise would break the mass away before its time; compare all samples."""
        driven = {signal: record.on_grid(signal) for signal in record.signals}
        driven["direction"] = self.direction(record)
        if self.options.smooths:
            driven["force"] = smooth(driven["force"], record.step, self.options.width)
            self.notes.append(f"{record.name}: the force is smoothed over {1e3 * self.options.width:.3g} ms")
        return driven, np.ones(len(record.time), dtype=bool)

    def begin(self, record: Record, driven: Mapping[str, Array]) -> Beginning:
        """Begin with the smoothed position and its slope, or with the smoothed velocity."""
        width = self.options.width
        if "position" not in record.signals:
            return Beginning({"position0": 0.0}).with_more({"velocity0": float(self._speed(record, width)[0])})
        return position.begin(record, width)

    def resting(self, record: Record) -> NDArray[np.bool_]:
        """Tell where the position stays within its noise."""
        if "position" not in record.signals:
            return super().resting(record)
        return position.resting(record, self.options.width)

    def level(self, window: Window, values: Values) -> Array:
        """Return the load level at the communication points."""
        level = np.ones(len(window.record.grid))
        if "normalForce" in window.driven:
            level = np.maximum(self.given(window, "normalForce", values) / self.options.rated, 0.0)
        return self.directed(level, window, values)

    def inertia(self, values: Values) -> float:
        """Return the mass."""
        return self.value("mass", values)

    def applied(self, window: Window, values: Values) -> Array:
        """Return the force on the mass at the communication points, its weight and its spring included."""
        incline = self.beside_value("incline", values, 0.0)
        weight = self.value("mass", values) * GRAVITY * math.sin(incline)
        applied = self.given(window, "force", values) - weight
        spring = self.beside_value("spring", values, 0.0)
        if spring == 0.0:
            return applied
        rest = self.beside_value("springRest", values, 0.0)
        return np.asarray(applied - spring * (self.true("position", window.driven["position"], values) - rest))

    def inputs(self, window: Window, values: Values) -> dict[str, Array]:
        """Return the force and the load level."""
        applied = self.applied(window, values)
        given = applied if self.options.inputs == "held" else middle(applied)
        return {"appliedForce": given, "friction.level": self.level(window, values)}

    def start(self, window: Window, values: Values) -> dict[str, Value]:
        """Return the fixed and fitted values."""
        return {**self.of_model(values), "friction.law": self.law, "bench.drive": "Free", "driveVelocity": 0.0}

    def forces(self, window: Window, values: Values) -> tuple[Array, Array, Array]:
        """Return velocity, force minus inertial force, and the load level."""
        speed, acceleration = self._motion(window.record)
        friction = self.applied(window, values) - self.value("mass", values) * acceleration
        return speed, friction, self.level(window, values)

    def guess(self, windows: Sequence[Window], values: Values) -> dict[str, float]:
        """Return mass or gain, spring and offset by least squares, beside friction that is dry and viscous."""
        rows, right = [], []
        for window in windows:
            speed, acceleration = self._motion(window.record)
            level, one = self.level(window, values), np.ones(len(speed))
            columns = [acceleration, level * np.sign(speed), speed, one]
            if "spring" in values:
                columns.append(self.true("position", window.driven["position"], values))
            rows.append(np.column_stack(columns))
            right.append(window.driven["force"])
        table, force = np.concatenate(rows), np.concatenate(right)
        fast = np.abs(table[:, 2]) > 0.1 * fastest(table[:, 2])
        if np.sum(fast) < 10:
            return {}
        mass, _, _, offset, *spring = np.linalg.lstsq(table[fast], force[fast], rcond=None)[0]
        gain = self.beside_value("gain.force", values, 1.0)
        if "gain.force" in values and "mass" not in values and mass > 0.0:
            gain = self.value("mass", values) / float(mass)
        found = {"offset.force": float(offset)} if "offset.force" in values else {}
        if spring and spring[0] > 0.0:
            found["spring"] = float(gain * spring[0])
        return {**found, "mass": float(gain * mass), "gain.force": gain} if gain * mass > 0.0 else found

    def _motion(self, record: Record) -> tuple[Array, Array]:
        """Return smoothed velocity and acceleration at the communication points."""
        width = 2.0 * self.options.width
        speed = self.pace * self._speed(record, width)
        return speed, slope(speed, record.step, width)

    def _speed(self, record: Record, width: float) -> Array:
        if "velocity" in record.signals:
            return smooth(record.on_grid("velocity"), record.step, width)
        return position.velocity(record, width)

"""An actuator: a valve, a regulator, a pair of switching valves."""

from __future__ import annotations

from abc import ABC, abstractmethod

from gas import Gas, Stream


class Actuator(ABC):
    """Actuator between supply and chambers; it has two states."""

    units: tuple[float, float]

    vents_to_surroundings = False
    """Whether what comes back from a chamber goes to the surroundings in place of the supply."""

    @abstractmethod
    def command(self, voltage: float, time: float) -> float:
        """Command of the actuator by a voltage sampled at a time."""

    def kinks(self, begin: float, end: float) -> list[float]:
        """Times between two where the flows have a kink."""
        return []

    def at(self, time: float, state: list[float]) -> list[float]:
        """Opening at a time: the states, unless they follow from the time."""
        return state

    @abstractmethod
    def start(self, command: float) -> tuple[float, float]:
        """The initial states."""

    @abstractmethod
    def rates(self, state: list[float], command: float) -> tuple[float, float]:
        """The derivatives of the states."""

    @abstractmethod
    def streams(self, state: list[float], a: Gas, b: Gas, supply_pressure: float) -> tuple[list[Stream], list[Stream]]:
        """The flows into chambers A and B."""

    @abstractmethod
    def spool(self, state: list[float]) -> float:
        """The position of the valve spool, -1 to 1."""

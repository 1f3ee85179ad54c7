"""What can go wrong, and what is left when it does."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pneumatic_servo.run import Run, Runs


class SimulationError(RuntimeError):
    """A run that cannot go on: the message says when and why.

    Attributes
    ----------
    finished : Run, Runs or None
        What was recorded until then.
    """

    finished: Run | Runs | None = None


class Interrupted(KeyboardInterrupt):
    """An interrupt from the keyboard (Ctrl-C) during a run.

    Attributes
    ----------
    finished : Run, Runs or None
        What was recorded until then.
    """

    finished: Run | Runs | None = None


class MissingPackage(ImportError):
    """An optional package that is not installed; the message says how to get it."""

    def __init__(self, package: str, extra: str) -> None:
        super().__init__(f"this needs {package}: pip install 'pneumatic-servo[{extra}]'")


class NotConverged(RuntimeError):
    """A fit whose solver did not come to an end."""

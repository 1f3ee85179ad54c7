"""Friction laws as hybrid automata.

A law is a set of regimes.  Within a regime the friction force and the rates of the internal states
are smooth functions, valid while the velocity keeps the regime's direction and every margin stays
positive.  The end of a regime is located as an event, and the regime names its successor.  So no
sign function, saturation or stick condition is ever integrated across.
"""

from .hybrid import Contact, Law, Regime
from .laws import LAWS

__all__ = ["LAWS", "Contact", "Law", "Regime"]

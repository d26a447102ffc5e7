"""Events of a motion: impulses, contacts, switched torques, shadows."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Event:
    """An impulse, a contact, another event of a motion, or its end.

    Attributes
    ----------
    seconds : s since the epoch
    kind : "impulse", "contact", "rest" (bounces accumulated: the ephemeris ends here), "torque on",
        "torque off", "shadow entry" (the last light goes), "shadow exit", "penumbra entry", "penumbra exit",
        "tolerance exceeded" (from here on, away from the epoch, the error is estimated above it)
    text : one line for people
    details : numbers by name, SI (of a contact: point, normal speed before, impulse ...)
    """

    seconds: float
    kind: str
    text: str
    details: dict[str, Any] = field(default_factory=dict)

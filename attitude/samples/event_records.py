"""What happened at instants, as plain data: units in the names, as everywhere in a file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .. import units
from .event import Event

# Of the details that events have; one without a unit here is a count, or says yes or no.
UNITS = {
    "normal_speed": "m_s",
    "impulse": "N_s",
    "angular_impulse": "N_m_s",
    "point": "m",
    "energy_lost": "J",
    "rate_before": "rad_s",
    "rate_after": "rad_s",
    "velocity_before": "m_s",
    "velocity_after": "m_s",
}
_WRITTEN = {name: f"{name}_{unit}" for name, unit in UNITS.items()}
_READ = {written: name for name, written in _WRITTEN.items()}


def to_plain(events: Sequence[Event]) -> list[dict[str, Any]]:
    """As JSON and YAML hold them: vectors are lists."""
    return [
        {
            "elapsed_s": float(event.seconds),
            "kind": event.kind,
            "text": event.text,
            "details": {_WRITTEN.get(name, name): _plain(value) for name, value in event.details.items()},
        }
        for event in events
    ]


def from_plain(found: Any) -> tuple[Event, ...]:
    """The events that `to_plain` wrote; raises TypeError, KeyError or InputError for anything else."""
    if not isinstance(found, list):
        raise TypeError("events that are no list")
    return tuple(_event(each) for each in found)


def _event(plain: dict[str, Any]) -> Event:
    seconds = float(units.finite_array(plain["elapsed_s"], "events"))
    if not isinstance(plain["kind"], str) or not isinstance(plain["text"], str):
        raise TypeError("an event whose kind or text is none")
    details = {_READ.get(name, name): _value(value) for name, value in plain["details"].items()}
    return Event(seconds, plain["kind"], plain["text"], details)


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value


def _value(value: Any) -> Any:
    """Yes or no, a count, a number, or a vector of finite numbers."""
    if isinstance(value, int) and abs(value) < 1 << 63:
        return value
    numbers = units.finite_array(value, "events")
    return numbers if numbers.ndim else float(numbers)

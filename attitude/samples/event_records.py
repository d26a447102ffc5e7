"""Events as plain data, with units in the names, as in all files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .. import units
from .event import Event

# Details of events with their units; those that are not listed are counts and flags.
RECORD_NAMES = {
    "normal_speed": "normal_speed_m_s",
    "impulse": "impulse_N_s",
    "angular_impulse": "angular_impulse_N_m_s",
    "point": "point_m",
    "energy_lost": "energy_lost_J",
    "rate_before": "rate_before_rad_s",
    "rate_after": "rate_after_rad_s",
    "velocity_before": "velocity_before_m_s",
    "velocity_after": "velocity_after_m_s",
}


def to_plain(events: Sequence[Event]) -> list[dict[str, Any]]:
    """The events as JSON and YAML hold them, vectors as lists."""
    return [
        {
            "elapsed_s": float(event.seconds),
            "kind": event.kind,
            "text": event.text,
            "details": {
                RECORD_NAMES.get(name, name): value.tolist()
                if isinstance(value, (np.ndarray, np.generic))
                else value
                for name, value in event.details.items()
            },
        }
        for event in events
    ]


def from_plain(records: Any) -> tuple[Event, ...]:
    """The events of the records of `to_plain`; raises TypeError, KeyError or InputError for anything else."""
    if not isinstance(records, list):
        raise TypeError("events are not a list")
    names = {record_name: name for name, record_name in RECORD_NAMES.items()}
    events = []
    for record in records:
        seconds = float(units.finite_array(record["elapsed_s"], "events"))
        if not isinstance(record["kind"], str) or not isinstance(record["text"], str):
            raise TypeError("kind or text of an event is not text")
        details = {names.get(name, name): _value(value) for name, value in record["details"].items()}
        events.append(Event(seconds, record["kind"], record["text"], details))
    return tuple(events)


def _value(value: Any) -> Any:
    """A flag, a count, a number, or a vector of finite numbers."""
    if isinstance(value, int) and abs(value) < 1 << 63:
        return value
    numbers = units.finite_array(value, "events")
    return numbers if numbers.ndim else float(numbers)

"""Instants of effects, checked against the span of the scene's times."""

from __future__ import annotations

from .. import stopping
from ..documents.quantities import Instant
from ..errors import InputError
from ..problem.initial_state import InitialState


def seconds(instant: Instant, initial_state: InitialState, field: str) -> float:
    """Seconds since the epoch; InputError with the field of the instant below `field`."""
    stopping.check()
    try:
        return instant.seconds(initial_state.epoch)
    except InputError as error:
        raise InputError(f"{field}.{error.field}", error.value, error.expected) from None


def check_in_span(instant: Instant, initial_state: InitialState, field: str) -> None:
    """Raise InputError for an instant outside the span."""
    elapsed = seconds(instant, initial_state, field)
    if not initial_state.start <= elapsed <= initial_state.stop:
        raise InputError(field, f"{elapsed!r} s", f"an instant in {span_text(initial_state)}")


def span_text(initial_state: InitialState) -> str:
    """Describe the span in an error message."""
    start, stop = initial_state.start, initial_state.stop
    return f"the span of the times with the epoch, {start!r} s to {stop!r} s since the epoch"

"""Instants of effects against the span of the scene's times."""

from __future__ import annotations

from ..documents.quantities import Instant
from ..errors import InputError
from ..problem.initial_state import Situation


def seconds(instant: Instant, situation: Situation, field: str) -> float:
    """s since the epoch; an error's field is that of the instant's own beside `field`."""
    try:
        return instant.seconds(situation.epoch)
    except InputError as error:
        raise InputError(f"{field}.{error.field}", error.value, error.expected) from None


def check_in_span(instant: Instant, situation: Situation, field: str) -> None:
    at = seconds(instant, situation, field)
    if not situation.start <= at <= situation.stop:
        raise InputError(field, f"{at!r} s", f"an instant in {span_text(situation)}")


def span_text(situation: Situation) -> str:
    return (
        f"the span of the times with the epoch, {situation.start!r} s to {situation.stop!r} s since the epoch"
    )

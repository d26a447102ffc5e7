"""Instants that a user asks an ephemeris for, in words: a list, or a step."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import units
from ..errors import InputError
from ..times.iso8601 import parse_times
from .ephemeris_data import EphemerisData

MAX_INSTANTS = 100_000_000


def requested(
    data: EphemerisData,
    times: str | None,
    step: str | None,
    prefix: str = "",
    max_instants: int = MAX_INSTANTS,
) -> Any:
    """The instants of a list, or of every step from the first instant to the last; None without either.

    prefix : of the names `times` and `step` in errors, such as "--"
    """
    if times is not None:
        words = [word.strip() for word in times.split(",")]
        try:
            return np.array([float(word) for word in words])
        except ValueError:
            if data.epoch is None:
                expected = "seconds: this ephemeris has no dates"
                raise InputError(f"{prefix}times", times, expected) from None
        try:
            return parse_times(words, data.instants.scale)
        except InputError as error:
            expected = "dates, or seconds since the epoch, separated by commas"
            raise InputError(f"{prefix}times", error.value, expected) from None
    if step is None:
        return None
    expected = 'a time above 0, such as "10 s" or "1 min" (without a unit: s)'
    seconds = units.positive_quantity(step, (units.SECOND, "s"), f"{prefix}step", expected)
    first, last = float(data.elapsed[0]), float(data.elapsed[-1])
    count = np.floor((last - first) / seconds * (1.0 + 1e-12)) + 1.0
    if not count <= max_instants:
        raise InputError(f"{prefix}step", step, f"a step that makes at most {max_instants} instants")
    return first + seconds * np.arange(int(count))

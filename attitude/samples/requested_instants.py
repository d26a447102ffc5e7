"""Instants that a user asks an ephemeris for, in words: a list, or a step."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from .. import units
from ..errors import InputError
from ..times.iso8601 import parse_times
from .ephemeris_data import EphemerisData

MAX_INSTANTS = 100_000_000
TIMES = "dates, or seconds since the epoch, separated by commas"
STEP = 'a time above 0, such as "10 s" or "1 min" (without a unit: s)'


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
        return _listed(times, data, f"{prefix}times")
    return None if step is None else _stepped(step, data, f"{prefix}step", max_instants)


def _listed(text: str, data: EphemerisData, field: str) -> Any:
    words = [word.strip() for word in text.split(",")]
    try:
        return np.array([float(word) for word in words])
    except ValueError:
        if data.epoch is None:
            raise InputError(field, text, "seconds: this ephemeris has no dates") from None
    try:
        return parse_times(words, data.instants.scale)
    except InputError as error:
        raise InputError(field, error.value, TIMES) from None


def _stepped(text: str, data: EphemerisData, field: str, max_instants: int) -> np.ndarray:
    match = re.fullmatch(r"\s*([-+.\deE]+)\s*([a-zA-Z]*)\s*", text)
    try:
        step = float(match[1]) * units.parse_unit(match[2] or "s", units.SECOND, field) if match else 0.0
    except ValueError:  # of InputError too: the unit is none
        step = 0.0
    if not 0.0 < step < np.inf:
        raise InputError(field, text, STEP)
    first, last = float(data.elapsed[0]), float(data.elapsed[-1])
    count = np.floor((last - first) / step * (1.0 + 1e-12)) + 1.0
    if not count <= max_instants:
        raise InputError(field, text, f"a step that makes at most {max_instants} instants")
    return first + step * np.arange(int(count))

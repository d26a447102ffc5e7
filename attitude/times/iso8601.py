"""ISO 8601 text to Time."""

from __future__ import annotations

import re
import warnings
from contextlib import suppress
from typing import Literal

from astropy.time import Time
from erfa import ErfaWarning

from ..errors import InputError

Scale = Literal["utc", "tai", "tt", "tdb", "tcb", "tcg", "ut1"]

ISO_DATE = re.compile(r"\d{4}-\d{2}-\d{2}([T ][\d:.]+)?")


def parse_time(text: str, scale: str | None, field: str) -> Time:
    """The Time of an ISO 8601 date; with a trailing Z only where the scale is UTC.

    Raises InputError for other text, and for dates that do not exist.
    """
    date = text.removesuffix("Z") if scale == "utc" else text
    if ISO_DATE.fullmatch(date):
        with suppress(ValueError):
            return _time(date, scale)
    raise InputError(field, text, "a date such as 2026-01-01T00:00:00 (ISO 8601)")


def _time(text: str | list[str], scale: str | None) -> Time:
    """A Time; ValueError for a second 60 without a leap second, for which astropy only warns."""
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message=".*after end of day")
        try:
            return Time(text, scale=scale)
        except ErfaWarning as warning:
            raise ValueError(str(warning)) from None


def parse_times(texts: list[str], scale: str | None) -> Time:
    """The Times of ISO 8601 dates: all at once, or one by one to report the one that is malformed."""
    if all(ISO_DATE.fullmatch(text) for text in texts):
        with suppress(ValueError):
            return _time(texts, scale)
    return Time([parse_time(text, scale, f"times.dates[{i}]") for i, text in enumerate(texts)])

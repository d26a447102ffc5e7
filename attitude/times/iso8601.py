"""ISO 8601 text to Time."""

from __future__ import annotations

import re
import warnings
from contextlib import suppress
from datetime import datetime, timedelta
from typing import Any, Literal

import numpy as np
from astropy.time import Time
from erfa import ErfaWarning

from ..errors import InputError

Scale = Literal["utc", "tai", "tt", "tdb", "tcb", "tcg", "ut1"]

MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
ISO_DATE = re.compile(r"\d{4}-\d{2}-\d{2}([T ][\d:.]+)?")
# Other forms: a day of the year, no separators, a local time with its offset from UTC.
OTHER_FORM = re.compile(
    r"(\d{4})(-\d\d-\d\d|-\d{3}|\d{4}|\d{3})"
    r"(?:[T ](\d\d):?(\d\d)(?::?(\d\d(?:\.\d{1,20})?))?(?:Z|([+-])([01]\d|2[0-3])(?::?([0-5]\d))?)?)?"
)


def parse_time(text: str, scale: str | None, field: str) -> Time:
    """The Time of an ISO 8601 date; with a trailing Z, or an offset such as +01:00, only in UTC.

    Raises InputError for other text, and for dates that do not exist.
    """
    with suppress(ValueError, OverflowError):
        return _time(_calendar_form(text, scale == "utc"), scale)
    raise InputError(field, text, "a date such as 2026-01-01T00:00:00 (ISO 8601)")


def _calendar_form(text: str, may_have_zone: bool) -> str:
    """Date as year, month, day and time of day, in UTC where the text has a zone; ValueError for no date."""
    plain = text.removesuffix("Z") if may_have_zone else text
    if ISO_DATE.fullmatch(plain):
        return plain
    match = OTHER_FORM.fullmatch(text)
    if match is None or ((match[6] or text.endswith("Z")) and not may_have_zone):
        raise ValueError(text)
    year, days, hour, minute, second, sign, *offset = match.groups()
    days = days.replace("-", "")
    day = datetime(int(year), 1, 1) + timedelta(int(days) - 1)
    if len(days) == 4:
        day = datetime(int(year), int(days[:2]), int(days[2:]))
    elif day.year != int(year):
        raise ValueError(text)
    ahead = timedelta(hours=int(offset[0] or 0), minutes=int(offset[1] or 0))
    local = day.replace(hour=int(hour or 0), minute=int(minute or 0))
    moved = local + ahead if sign == "-" else local - ahead
    return f"{moved.isoformat(timespec='minutes')}:{second or '00'}"


def _time(text: str | list[str], scale: str | None) -> Time:
    """A Time; ValueError for a second 60 without a leap second, for which astropy only warns."""
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message=".*after end of day")
        try:
            return Time(text, scale=scale)
        except ErfaWarning as warning:
            raise ValueError(str(warning)) from None


def dated(value: Any, scale: str, field: str) -> Time | None:
    """The Time of a date as users write it, or of a list or array of dates; None for what is no date.

    ISO 8601 text is in `scale`, or in UTC where it ends in Z; a datetime is in its own time zone, or in UTC.
    """
    try:
        array = np.asarray(value)
    except ValueError:  # lists of several lengths
        return None
    if array.dtype.kind == "M":
        return Time(array, scale="utc")
    members = array.reshape(-1).tolist() if array.dtype.kind in "OU" else []
    if members and all(isinstance(member, str) for member in members):
        is_zoned = all(re.search(r":.*(Z|[+-]\d\d(:?\d\d)?)$", member) for member in members)
        scale = "utc" if is_zoned else scale
        if array.ndim == 0:
            return parse_time(members[0], scale, field)
        return parse_times(members, scale, field).reshape(array.shape)
    if members and all(isinstance(member, datetime) for member in members):
        time = Time(members, scale="utc")
        return time[0] if array.ndim == 0 else time.reshape(array.shape)
    return None


def parse_times(texts: list[str], scale: str | None, field: str = "times.dates") -> Time:
    """The Times of ISO 8601 dates: all at once, or one by one to report the one that is malformed."""
    if all(ISO_DATE.fullmatch(text) for text in texts):
        with suppress(ValueError):
            return _time(texts, scale)
    return Time([parse_time(text, scale, f"{field}[{i}]") for i, text in enumerate(texts)])

"""Dates and times of STK's attitude files, by the names of STK's TimeFormat."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import date, timedelta

from astropy.time import Time, TimeDelta

from ..errors import FormatError
from ..times.iso8601 import MONTHS, parse_times
from .date_text import one_date

# Formats of times since the scenario's epoch: seconds in one of their units.
ELAPSED = {"epsec": 1.0, "epmin": 60.0, "ephr": 3600.0, "epday": 86400.0}
# Formats of dates: the time scale, and by how many seconds it is ahead of the format's.
DATES = {
    "utcg": ("utc", 0.0),
    "iso-ymd": ("utc", 0.0),
    "iso-yd": ("utc", 0.0),
    "utcjfour": ("utc", 0.0),
    "taig": ("tai", 0.0),
    "tdtg": ("tt", 0.0),
    "tdbg": ("tdb", 0.0),
    "gpsg": ("tai", 19.0),
}
CLOCK = r"(\d{1,2}):(\d{1,2})(?::(\d{1,2})(\.\d*)?)?"
FORMS = (
    re.compile(rf"(?P<day>\d{{1,2}}) (?P<month>[A-Za-z]{{3,9}})\.? (?P<year>\d{{4}}) {CLOCK}"),
    re.compile(rf"(?P<year>\d{{4}})-(?P<number>\d{{1,2}})-(?P<day>\d{{1,2}})[T ]{CLOCK}Z?"),
    re.compile(rf"(?P<year>\d{{4}})-(?P<of_year>\d{{3}})[T ]{CLOCK}Z?"),
    re.compile(rf"(?P<of_year>\d{{1,3}})/(?P<year>\d{{4}}) {CLOCK}"),
)


def iso_date(text: str) -> str:
    """ISO 8601 text of a date such as 1 Jul 2007 9:05:00.5, 2007-07-01T09:05:00.5 or 2007-182T09:05:00.5.

    Raises ValueError for any other text; that a day exists is left to who parses what is returned.
    """
    plain = " ".join(text.replace('"', " ").split())
    match = next(filter(None, (form.fullmatch(plain) for form in FORMS)), None)
    if match is None:
        raise ValueError(text)
    parts = match.groupdict()
    year, of_year = int(parts["year"]), parts.get("of_year")
    if of_year is not None:
        day = date(year, 1, 1) + timedelta(days=int(of_year) - 1)
        if day.year != year:
            raise ValueError(text)
        month, day_of_month = day.month, day.day
    else:
        name = parts.get("month")
        month = int(parts["number"]) if name is None else MONTHS.index(name[:3].capitalize()) + 1
        day_of_month = int(parts["day"])
    hour, minute, second, fraction = match.groups()[-4:]
    clock = f"{int(hour):02}:{int(minute):02}:{int(second or 0):02}{(fraction or '').rstrip('.')}"
    return f"{year:04}-{month:02}-{day_of_month:02}T{clock}"


def times(dates: Sequence[str], time_format: str) -> Time:
    """Times of dates as `iso_date` returns them; InputError for those that do not exist."""
    scale, offset = DATES[time_format]
    parsed = parse_times(list(dates), scale)
    return parsed + TimeDelta(offset, format="sec") if offset else parsed


def utcg(time: Time) -> str:
    """Date as STK writes it: day, month, year and time of day; FormatError for a year not of four digits."""
    text = one_date(time)
    parts = re.fullmatch(r"(\d{4})-(\d\d)-(\d\d)T(.+)", text)
    if parts is None:
        raise FormatError(f"STK has years of four digits, not {text}")
    year, month, day, clock = parts.groups()
    return f"{int(day)} {MONTHS[int(month) - 1]} {year} {clock}"

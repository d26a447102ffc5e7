"""Epochs of CCSDS messages: text to whole days, seconds and attoseconds, and those to instants.

Both forms of 504.0-B-2, 6.8.9 are read: 2016-12-31T23:59:60.5 and 2016-366T23:59:60.5, with a Z where the
time system is UTC.  Nothing is rounded on the way: text of up to 18 decimals is whole attoseconds.
"""

from __future__ import annotations

import re
from datetime import date
from typing import Any, NamedTuple

import erfa
import numpy as np
from astropy.time import Time

from ...times.instants import Instants, as_instants
from ...times.leap_seconds import MJD_ORDINAL
from ...times.leap_seconds import tai_minus_utc as tai_minus_utc
from ..text_rows import contents

SYSTEMS = {
    "UTC": "utc",
    "TAI": "tai",
    "TT": "tt",
    "TDB": "tdb",
    "TCB": "tcb",
    "TCG": "tcg",
    "UT1": "ut1",
    "GPS": "tai",  # and 19 s
}
BEHIND_TAI = {"GPS": 19}  # s
MOST_DECIMALS = 18
EPOCH = re.compile(rb"(\d{4})-(?:(\d\d)-(\d\d)|(\d{3}))T(\d\d):(\d\d):(\d\d)(?:\.(\d+))?(Z?)")
DAY = 86401  # seconds that a day may have, for a number that grows with the date and the time of day
MJD = 2400000.5
WHOLE_LEAP_SECONDS = 41317  # MJD of 1972-01-01


class EpochError(ValueError):
    """The epoch at `index` is none."""

    def __init__(self, index: int, reason: str):
        self.index = index
        self.reason = reason
        super().__init__(reason)


class Stamps(NamedTuple):
    """Dates as integers; `second` then `atto` put them in order.

    second : int64, `DAY` times the modified Julian day, and the second of that day
    atto : int64, 1e-18 s
    """

    second: np.ndarray
    atto: np.ndarray

    @property
    def first(self) -> tuple[int, int]:
        return int(self.second[0]), int(self.atto[0])

    @property
    def last(self) -> tuple[int, int]:
        return int(self.second[-1]), int(self.atto[-1])


def one(text: bytes, system: str) -> tuple[int, int]:
    """(second, atto) of an epoch on its own; EpochError where it is none."""
    return each([text], system).first


def each(texts: Any, system: str) -> Stamps:
    """Of epochs in whatever form each is, a list or an Arrow array of texts."""
    if not isinstance(texts, list):
        found = alike(_characters(texts), system)
        if found is not None:
            return found
        texts = texts.to_pylist()
    calendar = [_calendar(text, i, system) for i, text in enumerate(texts)]
    found = alike(np.frombuffer(b"".join(calendar), dtype=np.uint8).reshape(len(texts), -1), system)
    assert found is not None
    return found


def _characters(texts: Any) -> np.ndarray:
    """(n, width) of an Arrow array of texts; (n, 0) where they are not all of one width."""
    from pyarrow import compute

    widths = compute.binary_length(texts).to_numpy()
    width = int(widths[0]) if (widths == widths[0]).all() else 0
    characters = np.frombuffer(contents(texts), dtype=np.uint8)
    return characters[: width * len(widths)].reshape(len(widths), width)


def _calendar(text: bytes, index: int, system: str) -> bytes:
    """The epoch as day of a month and with 18 decimals."""
    match = EPOCH.fullmatch(text)
    if match is None:
        shown = text[:40].decode("ascii", errors="replace")
        raise EpochError(index, f"{shown!r} is no epoch such as 2026-01-01T00:00:00.000 or 2026-001T00:00:00")
    year, month, day, day_of_year, hour, minute, second, decimals, zulu = match.groups()
    if zulu and system != "UTC":
        raise EpochError(index, f"Z states UTC, where TIME_SYSTEM is {system}")
    decimals = decimals or b""
    if decimals[MOST_DECIMALS:].strip(b"0"):
        raise EpochError(index, f"more than {MOST_DECIMALS} decimals of a second")
    if day_of_year is not None:
        month, day = _month_and_day(int(year), int(day_of_year), index)
    clock = b"%s:%s:%s.%s" % (hour, minute, second, decimals[:MOST_DECIMALS].ljust(MOST_DECIMALS, b"0"))
    return b"%s-%s-%sT%s" % (year, month, day, clock)


def _month_and_day(year: int, day: int, index: int) -> tuple[bytes, bytes]:
    try:
        found = date.fromordinal(date(year, 1, 1).toordinal() + day - 1)
    except (ValueError, OverflowError):
        found = None
    if found is None or found.year != year:
        raise EpochError(index, f"no day {day} in year {year}")
    return b"%02d" % found.month, b"%02d" % found.day


def alike(characters: np.ndarray, system: str) -> Stamps | None:
    """Of (n, width) characters, all of the calendar's form with as many decimals; None where they are not.

    Raises EpochError for a date or time of day that does not exist.
    """
    width = characters.shape[1]
    zulu = width > 0 and bool((characters[:, -1] == ord("Z")).all())
    if zulu:
        if system != "UTC":
            raise EpochError(0, f"Z states UTC, where TIME_SYSTEM is {system}")
        width -= 1
    decimals = max(width - 20, 0)
    if width not in (19, 20 + decimals) or width == 20 or decimals > MOST_DECIMALS:
        return None
    rows = np.ascontiguousarray(characters[:, :width].T)
    form = (b"0000-00-00T00:00:00." + b"0" * decimals)[:width]
    digits = rows - np.uint8(ord("0"))  # others than digits wrap to more than 9
    for row, digit, letter in zip(rows, digits, form, strict=True):
        if not ((digit <= 9).all() if letter == ord("0") else (row == letter).all()):
            return None
    day = _days(_number(digits[0:4]) * 10000 + _number(digits[5:7]) * 100 + _number(digits[8:10]))
    hour, minute, second = (_number(digits[place : place + 2]) for place in (11, 14, 17))
    _check_clock(day, hour, minute, second, system)
    second += day * DAY + hour * 3600 + minute * 60
    return Stamps(second, _number(digits[20:]) * 10 ** (MOST_DECIMALS - decimals))


def _number(digits: np.ndarray) -> np.ndarray:
    """(n,) of (places, n) decimal digits."""
    value = np.zeros(digits.shape[1], dtype=np.int64)
    for place in digits:
        value *= 10
        value += place
    return value


def _days(dates: np.ndarray) -> np.ndarray:
    """Modified Julian days of dates written as yyyymmdd; each run of one date is looked up once."""
    starts = np.concatenate([[0], np.flatnonzero(dates[1:] != dates[:-1]) + 1])
    days = np.empty(len(starts), dtype=np.int64)
    for i, start in enumerate(starts.tolist()):
        year, rest = divmod(int(dates[start]), 10000)
        try:
            days[i] = date(year, *divmod(rest, 100)).toordinal() - MJD_ORDINAL
        except ValueError:
            raise EpochError(start, f"no date {year:04}-{rest // 100:02}-{rest % 100:02}") from None
    return np.repeat(days, np.diff(starts, append=len(dates)))


def _check_clock(
    day: np.ndarray, hour: np.ndarray, minute: np.ndarray, second: np.ndarray, system: str
) -> None:
    """Second 60 is one of the last minute of a UTC day at whose end there was a leap second."""
    bad = (hour > 23) | (minute > 59) | (second > 60)
    leap = second == 60
    if leap.any():
        was = (tai_minus_utc(day + 1) - tai_minus_utc(day) == 1) & (hour == 23) & (minute == 59)
        bad |= leap if system != "UTC" else leap & ~was
    if bad.any():
        i = int(np.argmax(bad))
        clock = f"{hour[i]:02}:{minute[i]:02}:{second[i]:02}"
        raise EpochError(i, f"no {clock} on that day in {system}")


# -- instants -----------------------------------------------------------------------------------


def to_instants(stamps: Stamps, system: str) -> Instants:
    """Seconds from the first of them, which is the epoch.

    In TAI, TT, GPS, and UTC since 1972, they are differences of integers, exact before they become two
    doubles; in other scales they are astropy's.
    """
    day, second = np.divmod(stamps.second, DAY)
    scale = SYSTEMS[system]
    epoch = _time(day[:1], second[:1], stamps.atto[:1], system)[0]
    if scale == "utc" and day.min() >= WHOLE_LEAP_SECONDS:
        second = second + tai_minus_utc(day)
    elif scale not in ("tai", "tt"):
        return as_instants(_time(day, second, stamps.atto, system), epoch, "EPOCH")
    second += day * 86400
    whole = (second - second[0]).astype(np.float64)
    fraction = (stamps.atto - stamps.atto[0]) / 1e18
    seconds = whole + fraction
    part = seconds - whole
    rest = (whole - (seconds - part)) + (fraction - part)  # of the sum, exactly (Knuth's two-sum)
    return Instants(seconds, rest if rest.any() else None, epoch, scale=scale)


def _time(day: np.ndarray, second: np.ndarray, atto: np.ndarray, system: str) -> Time:
    """As astropy has them; on a day with a leap second, UTC is counted in its own length of day."""
    clock = second + BEHIND_TAI.get(system, 0) + atto / 1e18
    if system == "UTC":
        year, month, of_month, _ = erfa.jd2cal(MJD, day.astype(np.float64))
        minute = np.minimum(second // 60, 1439)
        first, last = erfa.dtf2d(
            "UTC", year, month, of_month, minute // 60, minute % 60, (second - minute * 60) + atto / 1e18
        )
        return Time(first, last, format="jd", scale="utc")
    return Time(MJD + day, clock / 86400.0, format="jd", scale=SYSTEMS[system])

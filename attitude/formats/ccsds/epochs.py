"""Epochs of CCSDS messages: from text to integers (seconds and attoseconds), and from these to instants.

Both forms of 504.0-B-2, 6.8.9 are read: 2016-12-31T23:59:60.5 and 2016-366T23:59:60.5, with a Z where the
time system is UTC.  Text of up to 18 decimals is a whole number of attoseconds, so nothing is rounded.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from datetime import date
from typing import Any, NamedTuple

import erfa
import numpy as np
from astropy.time import Time

from ...times.instants import Instants, as_instants
from ...times.julian_dates import DAY, MJD
from ...times.leap_seconds import MJD_ORDINAL, tai_minus_utc
from ...times.two_part import two_sum
from ..text_rows import contents

TIME_SYSTEMS = {
    "UTC": "utc",
    "TAI": "tai",
    "TT": "tt",
    "TDB": "tdb",
    "TCB": "tcb",
    "TCG": "tcg",
    "UT1": "ut1",
    "GPS": "tai",  # 19 s behind it
}
MAX_DECIMALS = 18
EPOCH = re.compile(rb"(\d{4})-(?:(\d\d)-(\d\d)|(\d{3}))T(\d\d):(\d\d):(\d\d)(?:\.(\d+))?(Z?)")
SECONDS_PER_DAY_SLOT = 86401  # longest day, s: day * slot + second of day increases through leap seconds


class RowError(ValueError):
    """The row or epoch at `index` is invalid, for this reason."""

    def __init__(self, index: int, reason: str):
        self.index = index
        self.reason = reason
        super().__init__(reason)


class Timestamps(NamedTuple):
    """Epochs as integers, ordered by `second` and then `atto`.

    second : int64, `SECONDS_PER_DAY_SLOT` times the modified Julian day, and the second of that day
    atto : int64, 1e-18 s
    """

    second: np.ndarray
    atto: np.ndarray

    @property
    def first(self) -> tuple[int, int]:
        """(second, atto) of the first epoch."""
        return int(self.second[0]), int(self.atto[0])

    @property
    def last(self) -> tuple[int, int]:
        """(second, atto) of the last epoch."""
        return int(self.second[-1]), int(self.atto[-1])

    @property
    def unit(self) -> int:
        """Greatest power of ten, attoseconds, up to a second, that divides all: that of their last digit."""
        unit = 10**MAX_DECIMALS
        while unit > 1 and (self.atto % unit).any():
            unit //= 10
        return unit

    @property
    def is_ascending(self) -> np.ndarray:
        """(n - 1,) bool: which epochs but the first are after the one before them."""
        second, atto = self
        return (second[1:] > second[:-1]) | ((second[1:] == second[:-1]) & (atto[1:] > atto[:-1]))

    @classmethod
    def joined(cls, parts: Iterable[Timestamps]) -> Timestamps:
        """One series of several."""
        return cls(*map(np.concatenate, zip(*parts, strict=True)))

    def check_ascending(self) -> None:
        """RowError for the first epoch that is not after the one before it."""
        later = self.is_ascending
        if not later.all():
            raise RowError(int(np.argmin(later)) + 1, "an epoch that is not after the one before")

    def at(self, index: int) -> tuple[int, int]:
        """(second, atto) of one epoch."""
        return int(self.second[index]), int(self.atto[index])

    def is_after(self, time: tuple[int, int]) -> np.ndarray:
        """(n,) bool: which are later than a time."""
        return (self.second > time[0]) | ((self.second == time[0]) & (self.atto > time[1]))

    def is_before(self, time: tuple[int, int]) -> np.ndarray:
        """(n,) bool: which are earlier than a time."""
        return (self.second < time[0]) | ((self.second == time[0]) & (self.atto < time[1]))


def parse_epoch(text: bytes, system: str) -> tuple[int, int]:
    """(second, atto) of an epoch; RowError if it is invalid."""
    return parse_epochs([text], system).first


def unit_of(text: str) -> int:
    """The unit of an epoch's last digit, in attoseconds."""
    decimals = len(text.rstrip("Z").partition(".")[2])
    return int(10 ** (MAX_DECIMALS - min(decimals, MAX_DECIMALS)))


def moved(time: tuple[int, int], atto: int) -> tuple[int, int]:
    """A time moved by attoseconds, later or earlier."""
    second = time[0] + (time[1] + atto) // 10**MAX_DECIMALS
    if second % SECONDS_PER_DAY_SLOT == SECONDS_PER_DAY_SLOT - 1 and atto < 0:
        second -= 1  # most days have no such second
    return second, (time[1] + atto) % 10**MAX_DECIMALS


def parse_epochs(texts: Any, system: str) -> Timestamps:
    """Timestamps of epochs in any mix of forms, given as a list or an Arrow array of texts.

    Raises RowError for the first that is invalid.
    """
    if not isinstance(texts, list):
        from pyarrow import compute

        widths = compute.binary_length(texts).to_numpy()
        width = int(widths[0]) if (widths == widths[0]).all() else 0
        characters = np.frombuffer(contents(texts), np.uint8)[: width * len(widths)]
        stamps = parse_calendar_epochs(characters.reshape(len(widths), width), system)
        if stamps is not None:
            return stamps
        texts = texts.to_pylist()
    uniform = [_calendar_form(text, i, system) for i, text in enumerate(texts)]
    characters = np.frombuffer(b"".join(uniform), dtype=np.uint8).reshape(len(texts), -1)
    stamps = parse_calendar_epochs(characters, system)
    assert stamps is not None
    return stamps


def _calendar_form(text: bytes, index: int, system: str) -> bytes:
    """Epoch with day of month and 18 decimals."""
    match = EPOCH.fullmatch(text)
    if match is None:
        shown = text[:40].decode("ascii", errors="replace")
        raise RowError(index, f"{shown!r} is no epoch such as 2026-01-01T00:00:00.000 or 2026-001T00:00:00")
    year, month, day, day_of_year, hour, minute, second, decimals, zulu = match.groups()
    if zulu and system != "UTC":
        raise RowError(index, f"Z states UTC, where TIME_SYSTEM is {system}")
    decimals = decimals or b""
    if decimals[MAX_DECIMALS:].strip(b"0"):
        raise RowError(index, f"more than {MAX_DECIMALS} decimals of a second")
    if day_of_year is not None:
        try:
            calendar = date.fromordinal(date(int(year), 1, 1).toordinal() + int(day_of_year) - 1)
        except (ValueError, OverflowError):
            calendar = None
        if calendar is None or calendar.year != int(year):
            raise RowError(index, f"no day {int(day_of_year)} in year {int(year)}")
        month, day = b"%02d" % calendar.month, b"%02d" % calendar.day
    clock = b"%s:%s:%s.%s" % (hour, minute, second, decimals[:MAX_DECIMALS].ljust(MAX_DECIMALS, b"0"))
    return b"%s-%s-%sT%s" % (year, month, day, clock)


def parse_calendar_epochs(characters: np.ndarray, system: str) -> Timestamps | None:
    """Timestamps of (n, width) characters in calendar form, equally many decimals each; None for any other.

    Raises RowError for a date or time of day that does not exist.
    """
    width = characters.shape[1]
    zulu = width > 0 and bool((characters[:, -1] == ord("Z")).all())
    if zulu:
        if system != "UTC":
            raise RowError(0, f"Z states UTC, where TIME_SYSTEM is {system}")
        width -= 1
    decimals = max(width - 20, 0)
    if width not in (19, 20 + decimals) or width == 20 or decimals > MAX_DECIMALS:
        return None
    rows = np.ascontiguousarray(characters[:, :width].T)
    form = (b"0000-00-00T00:00:00." + b"0" * decimals)[:width]
    digits = rows - np.uint8(ord("0"))  # others than digits wrap to more than 9
    for row, digit, letter in zip(rows, digits, form, strict=True):
        if not ((digit <= 9).all() if letter == ord("0") else (row == letter).all()):
            return None
    day = _days(_number(digits[0:4]) * 10000 + _number(digits[5:7]) * 100 + _number(digits[8:10]))
    hour, minute, second = (_number(digits[offset : offset + 2]) for offset in (11, 14, 17))
    _check_clock(day, hour, minute, second, system)
    second += day * SECONDS_PER_DAY_SLOT + hour * 3600 + minute * 60
    return Timestamps(second, _number(digits[20:]) * 10 ** (MAX_DECIMALS - decimals))


def _number(digits: np.ndarray) -> np.ndarray:
    """(n,) numbers of (width, n) decimal digits."""
    value = np.zeros(digits.shape[1], dtype=np.int64)
    for digit in digits:
        value *= 10
        value += digit
    return value


def _days(dates: np.ndarray) -> np.ndarray:
    """Return modified Julian days of dates written as yyyymmdd; each run of one date is looked up once."""
    starts = np.concatenate([[0], np.flatnonzero(dates[1:] != dates[:-1]) + 1])
    days = np.empty(len(starts), dtype=np.int64)
    for i, start in enumerate(starts.tolist()):
        year, rest = divmod(int(dates[start]), 10000)
        try:
            days[i] = date(year, *divmod(rest, 100)).toordinal() - MJD_ORDINAL
        except ValueError:
            raise RowError(start, f"no date {year:04}-{rest // 100:02}-{rest % 100:02}") from None
    return np.repeat(days, np.diff(starts, append=len(dates)))


def _check_clock(
    day: np.ndarray, hour: np.ndarray, minute: np.ndarray, second: np.ndarray, system: str
) -> None:
    """Refuse times of day that do not exist; second 60 does before a leap second, in UTC."""
    bad = (hour > 23) | (minute > 59) | (second > 60)
    leap = second == 60
    if leap.any():
        exists = (tai_minus_utc(day + 1) - tai_minus_utc(day) == 1) & (hour == 23) & (minute == 59)
        bad |= leap if system != "UTC" else leap & ~exists
    if bad.any():
        i = int(np.argmax(bad))
        clock = f"{hour[i]:02}:{minute[i]:02}:{second[i]:02}"
        raise RowError(i, f"no {clock} on that day in {system}")


# -- instants -----------------------------------------------------------------------------------


def to_instants(stamps: Timestamps, system: str) -> Instants:
    """Instants in seconds since the first timestamp, which becomes the epoch.

    In TAI, TT, GPS, and UTC since 1972, they are exact differences of integers, rounded to two doubles; in
    other scales astropy computes them.
    """
    day, second = np.divmod(stamps.second, SECONDS_PER_DAY_SLOT)
    scale = TIME_SYSTEMS[system]
    epoch = _time(day[:1], second[:1], stamps.atto[:1], system)[0]
    if scale == "utc" and day.min() >= 41317:  # MJD of 1972-01-01
        second = second + tai_minus_utc(day)
    elif scale not in ("tai", "tt"):
        return as_instants(_time(day, second, stamps.atto, system), epoch, "EPOCH")
    second += day * 86400
    whole = (second - second[0]).astype(np.float64)
    fraction = (stamps.atto - stamps.atto[0]) / 1e18
    seconds, rest = two_sum(whole, fraction)
    return Instants(seconds, rest if rest.any() else None, epoch, scale=scale)


def seconds_at(time: tuple[int, int], stamps: Timestamps, system: str) -> float:
    """Seconds from the first of the timestamps to a time."""
    both = (np.array(pair) for pair in zip(stamps.first, time, strict=True))
    return float(to_instants(Timestamps(*both), system).seconds[1])


def _time(day: np.ndarray, second: np.ndarray, atto: np.ndarray, system: str) -> Time:
    """Return an astropy Time; on a day with a leap second, UTC uses the length of that day."""
    clock = second + (19 if system == "GPS" else 0) + atto / 1e18
    if system == "UTC":
        year, month, of_month, _ = erfa.jd2cal(MJD, day.astype(np.float64))
        minute = np.minimum(second // 60, 1439)
        first, last = erfa.dtf2d(
            "UTC", year, month, of_month, minute // 60, minute % 60, (second - minute * 60) + atto / 1e18
        )
        return Time(first, last, format="jd", scale="utc")
    return Time(MJD + day, clock / DAY, format="jd", scale=TIME_SYSTEMS[system])

"""Dates as text: ISO 8601 to the nanosecond, leap seconds as second 60."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import Any

import erfa
import numpy as np
from astropy.time import Time

from ..times import leap_seconds
from ..times.instants import Instants
from ..times.time_scales import with_ut1
from .text_rows import array, contents

ISO_BYTES = 29  # of a date with nanoseconds
SECOND_NS = 10**9
DAY = 86_400  # s, a whole number


def dates(instants: Instants) -> np.ndarray:
    """ISO 8601 text as `iso_text`, of dated instants: their two-part seconds are rounded once.

    Of dates in TAI, TT, and UTC since 1972 no Time is built, which takes ten times as long.
    """
    epoch, scale = instants.epoch, instants.scale
    if epoch is None or scale not in ("tai", "tt", "utc"):
        return iso_text(instants.time)
    seconds = np.asarray(instants.seconds, dtype=np.float64)
    if not instants.max_abs_seconds < 1e12:  # ten thousand years are less
        return iso_text(instants.time)
    second, nanosecond = _whole_seconds(seconds, instants.seconds_low, epoch, scale)
    leap = np.zeros(second.shape, dtype=bool)
    if scale == "utc":
        begins, offsets = leap_seconds.steps()
        row = np.searchsorted(begins * DAY + offsets, second, side="right") - 1
        second -= offsets[row]
        leap = second >= np.append(begins[1:], 2**40)[row] * DAY  # no end of the last offset is known
        second -= leap
        if np.min(row, initial=0) < 0:
            return iso_text(instants.time)
    if not ((second >= -678941 * DAY) & (second < 2973484 * DAY)).all():  # years 0 to 9999
        return iso_text(instants.time)
    return _texts(second, nanosecond, leap)


def _whole_seconds(
    seconds: np.ndarray, seconds_low: np.ndarray | None, epoch: Time, scale: str
) -> tuple[np.ndarray, np.ndarray]:
    """Seconds from modified Julian day 0 of TT or TAI, rounded to nanoseconds, and the nanoseconds."""
    day, nanosecond, below = _since_mjd(float(epoch.jd1), float(epoch.jd2), epoch.scale, scale)
    whole = np.floor(seconds)
    low = 0.0 if seconds_low is None else seconds_low * 1e9
    fraction = np.rint((seconds - whole) * 1e9 + (low + below)).astype(np.int64)
    carry, nanoseconds = np.divmod(fraction + nanosecond, SECOND_NS)
    return whole.astype(np.int64) + carry + day * DAY, nanoseconds


def _texts(second: np.ndarray, nanosecond: np.ndarray, leap: np.ndarray) -> np.ndarray:
    """Text of seconds from modified Julian day 0, of days without leap seconds; second 60 where `leap`."""
    import pyarrow as pa

    text = np.empty((second.size, ISO_BYTES), dtype=np.uint8)
    unix = array((second - 40587 * DAY).ravel(), pa.timestamp("s"))
    text[:, :19] = np.frombuffer(contents(unix.cast(pa.string())), np.uint8).reshape(-1, 19)
    decimals = array((nanosecond + SECOND_NS).ravel(), pa.int64())
    text[:, 19:] = np.frombuffer(contents(decimals.cast(pa.string())), np.uint8).reshape(-1, 10)
    text[:, [10, 19]] = ord("T"), ord(".")
    text[leap.ravel(), 17:19] = ord("6"), ord("0")
    return text.view(f"S{ISO_BYTES}").reshape(second.shape)


@lru_cache(maxsize=256)
def _since_mjd(jd1: float, jd2: float, scale: str, to: str) -> tuple[int, int, float]:
    """(days, nanoseconds, fraction of one) from modified Julian day 0 of TT or TAI to an epoch."""
    epoch = with_ut1(Time(jd1, jd2, format="jd", scale=scale))
    start = epoch.tt if to == "tt" else epoch.tai
    days = Fraction(float(start.jd1)) - Fraction(4800001, 2) + Fraction(float(start.jd2))
    nanoseconds = days * DAY * SECOND_NS
    day, nanosecond = divmod(nanoseconds.__floor__(), DAY * SECOND_NS)
    return day, nanosecond, float(nanoseconds - nanoseconds.__floor__())


def iso_text(time: Time) -> np.ndarray:
    """ISO 8601 text to the nanosecond, leap seconds as second 60; bytes of shape time.shape.

    astropy's own formatting takes 6 us per instant, more than everything else in a file of text.
    """
    return _iso_text(time.jd1, time.jd2, time.scale)


def one_date(time: Time) -> str:
    """The text of one date."""
    return _one_date(float(time.jd1), float(time.jd2), time.scale)


@lru_cache(maxsize=256)
def _one_date(jd1: float, jd2: float, scale: str) -> str:
    text: bytes = _iso_text(np.float64(jd1), np.float64(jd2), scale).item()
    return text.decode()


def _iso_text(jd1: Any, jd2: Any, scale: str) -> np.ndarray:
    year, month, day, clock = erfa.d2dtf(scale.upper(), 9, jd1, jd2)
    if np.min(year, initial=0) < 0 or np.max(year, initial=0) > 9999:
        isot = Time(jd1, jd2, format="jd", scale=scale).copy(format="isot")
        isot.precision = 9
        return np.asarray(isot.value).astype("S")
    fields = (year, month, day, *(clock[name] for name in "hmsf"))
    if np.size(year) <= 64:  # fewer calls than for digits of whole columns
        rows = zip(*(np.reshape(field, -1).tolist() for field in fields), strict=True)
        texts = [b"%04d-%02d-%02dT%02d:%02d:%02d.%09d" % row for row in rows]
        return np.array(texts, dtype=f"S{ISO_BYTES}").reshape(np.shape(year))
    text = np.empty((*np.shape(year), ISO_BYTES), dtype=np.uint8)
    text[..., :] = np.frombuffer(b"0000-00-00T00:00:00.000000000", dtype=np.uint8)
    layout = ((0, 4), (5, 2), (8, 2), (11, 2), (14, 2), (17, 2), (20, 9))  # offset and width of each field
    for value, (offset, width) in zip(fields, layout, strict=True):
        for i in range(width):
            text[..., offset + i] += (value // 10 ** (width - 1 - i) % 10).astype(np.uint8)
    return text.view(f"S{ISO_BYTES}")[..., 0]

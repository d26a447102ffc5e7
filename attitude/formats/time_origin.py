"""Instants as seconds since a whole second, for formats that count time from a date of their own."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import erfa
import numpy as np
from astropy.time import Time

from ..errors import FormatError
from ..samples.ephemeris_data import EphemerisData
from ..times.instants import Instants
from ..times.two_part import two_part, two_sum
from .interpolation_nodes import Nodes

J2000_DAY = 2451545  # TT


class TimeOrigin(NamedTuple):
    """The date from which a file counts time.

    time : a whole second of its scale
    tt : s past J2000 in TT
    epoch_offset, epoch_offset_low : s, in two parts, from it to the ephemeris's epoch
    """

    time: Time
    tt: Fraction
    epoch_offset: float
    epoch_offset_low: float

    def seconds(self, instants: Instants) -> tuple[np.ndarray, np.ndarray]:
        """(n,) twice: SI seconds since the origin rounded to one double, and the rounding error."""
        total, low = two_sum(self.epoch_offset, instants.seconds)
        return two_sum(total, low + (self.epoch_offset_low + instants.low))


def checked_head(nodes: Nodes, format_name: str) -> EphemerisData:
    """Return the ephemeris at the first instant; FormatError without an epoch, or of many bodies."""
    head = nodes.segments[0].first
    if head.epoch is None:
        raise FormatError(f"{format_name} holds dates, and an ephemeris without an epoch has none")
    if not nodes.segments[0].is_list:
        raise FormatError(f"{format_name} holds one body at a list of instants, not shape {head.shape}")
    return head


def tt_origin(head: EphemerisData) -> TimeOrigin:
    """Return the last whole second of TT that is not after the first instant."""
    first = head.instants.flattened()
    tt = tt_seconds(head.epoch) + Fraction(float(first.seconds[0])) + Fraction(float(first.low[0]))
    whole = tt.__floor__()
    return TimeOrigin(tt_time(whole), Fraction(whole), *two_part(tt_seconds(head.epoch) - whole))


def utc_origin(head: EphemerisData) -> TimeOrigin:
    """Return the whole second of UTC of the first instant, never second 60, which few readers know."""
    utc = head.time.utc.ravel()[0]
    year, month, day, clock = erfa.d2dtf("UTC", 9, utc.jd1, utc.jd2)
    second = min(int(clock["s"]), 59)
    days = erfa.dtf2d("UTC", year, month, day, clock["h"], clock["m"], second)
    time = Time(*days, format="jd", scale="utc")
    tt = tt_seconds(time)
    return TimeOrigin(time, tt, *two_part(tt_seconds(head.epoch) - tt))


def tt_seconds(time: Time) -> Fraction:
    """Return exact seconds past J2000 in TT, of both Julian dates."""
    tt = time.tt
    return (Fraction(float(tt.jd1)) - J2000_DAY + Fraction(float(tt.jd2))) * 86400


def tt_time(seconds: int) -> Time:
    """Return the date of whole seconds past J2000 in TT."""
    days, second_of_day = divmod(seconds, 86400)
    return Time(float(J2000_DAY + days), second_of_day / 86400, format="jd", scale="tt")


def refuse_unordered(times: np.ndarray, last: float | None, format_name: str, unit: str) -> None:
    """Refuse times (n,) that do not increase; `last` is the time before them.  Readers search by date."""
    earlier = times[:-1] if last is None else np.concatenate([[last], times[:-1]])
    later = times[len(times) - len(earlier) :]
    wrong = np.flatnonzero(~(later > earlier))
    if wrong.size:
        i = int(wrong[0])
        raise FormatError(
            f"{format_name} holds instants in increasing order; {float(later[i])!r} does not "
            f"come after {float(earlier[i])!r} {unit}"
        )

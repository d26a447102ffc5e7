"""Instants as seconds since a whole second, for formats that count from a date of their own."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import erfa
import numpy as np
from astropy.time import Time

from ..errors import FormatError
from ..samples.ephemeris_data import EphemerisData
from ..times.instants import Instants
from .interpolation_nodes import Nodes

J2000 = 2451545  # the day, in TT
DAY = 86400


class Origin(NamedTuple):
    """Where a file counts from.

    time : Time, a whole second of its scale
    tt : s past J2000 in TT
    ahead, ahead_rest : s, in two parts: from it to the ephemeris's epoch
    """

    time: Time
    tt: Fraction
    ahead: float
    ahead_rest: float

    def seconds(self, instants: Instants) -> tuple[np.ndarray, np.ndarray]:
        """(n,) twice: SI seconds since the origin rounded to one double, and what that left."""
        rest = 0.0 if instants.seconds_low is None else instants.seconds_low
        first, left = _two_sum(self.ahead, instants.seconds)
        return _two_sum(first, left + (self.ahead_rest + rest))


def _two_sum(a: float | np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """a + b and its rounding error, exactly (Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def first_head(nodes: Nodes, format: str) -> EphemerisData:
    """At the first instant; refuses an ephemeris without an epoch, or of many bodies."""
    head = nodes.segments[0].first
    if head.epoch is None:
        raise FormatError(f"{format} holds dates, and an ephemeris without an epoch has none")
    if not nodes.segments[0].is_list:
        raise FormatError(f"{format} holds one body at a list of instants, not shape {head.shape}")
    return head


def whole_tt_second(head: EphemerisData) -> Origin:
    """The last whole second of TT that is not after the first instant."""
    return _origin(tt_time(first_tt(head).__floor__()), head)


def whole_utc_second(head: EphemerisData) -> Origin:
    """The whole second of UTC that the first instant is in; never second 60, which few readers know."""
    year, month, day, clock = erfa.d2dtf("UTC", 9, *_days(head.time.utc))
    second = min(int(clock["s"]), 59)
    days = erfa.dtf2d("UTC", year, month, day, clock["h"], clock["m"], second)
    return _origin(Time(*days, format="jd", scale="utc"), head)


def _days(time: Time) -> tuple[float, float]:
    return float(np.ravel(time.jd1)[0]), float(np.ravel(time.jd2)[0])


def _origin(time: Time, head: EphemerisData) -> Origin:
    ahead = tt_of(head.epoch) - tt_of(time)
    rounded = float(ahead)
    return Origin(time, tt_of(time), rounded, float(ahead - Fraction(rounded)))


def first_tt(head: EphemerisData) -> Fraction:
    """s past J2000 in TT of the first instant."""
    first = head.instants
    rest = 0.0 if first.seconds_low is None else float(first.seconds_low.reshape(-1)[0])
    return tt_of(head.epoch) + Fraction(float(first.seconds.reshape(-1)[0])) + Fraction(rest)


def tt_of(time: Time | None) -> Fraction:
    """s past J2000 in TT, of both Julian dates exactly."""
    days = _days(time.tt)  # type: ignore[union-attr]
    return (Fraction(days[0]) - J2000 + Fraction(days[1])) * DAY


def tt_time(seconds: int) -> Time:
    """Of whole seconds past J2000 in TT."""
    days, rest = divmod(seconds, DAY)
    return Time(float(J2000 + days), rest / DAY, format="jd", scale="tt")


def refuse_unordered(times: np.ndarray, before: float | None, format: str, unit: str) -> None:
    """Readers search by date: each instant (n,) must be after the one before it."""
    earlier = times[:-1] if before is None else np.concatenate([[before], times[:-1]])
    later = times[len(times) - len(earlier) :]
    wrong = np.flatnonzero(~(later > earlier))
    if wrong.size:
        i = int(wrong[0])
        raise FormatError(
            f"{format} holds instants in increasing order; {float(later[i])!r} does not "
            f"come after {float(earlier[i])!r} {unit}"
        )

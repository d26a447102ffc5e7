"""Instants: astropy Time, and the two-part SI seconds since the epoch that the kernels take.

The motion runs in SI seconds of TAI (the same as TT).  A Time in any scale is brought to TAI and
differenced from the epoch as a two-part number, so a UTC span counts its leap seconds and a span
of centuries keeps its picoseconds.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from functools import cached_property, partial
from typing import Any

import erfa
import numpy as np
from astropy import units as u
from astropy.time import Time, TimeDelta

from .. import units
from ..errors import InputError, whole_number
from ..runtime import compiled
from ..runtime.threads import ranges, run
from .iso8601 import dated
from .time_scales import tai_days, to_tai, with_ut1
from .two_part import two_sum


class Instants:
    """An array of instants: two-part seconds since the epoch, and the Time they were constructed from.

    Attributes
    ----------
    seconds : ndarray, s
        Elapsed SI seconds, rounded to one double.
    seconds_low : ndarray or None, s
        The rounding error of `seconds`: seconds + seconds_low is good to 32 digits.  None for zero.
    shape : tuple, dimensions of the instants
    epoch : Time or None
    scale : str or None
        The time scale of `time`: that of the Time they were constructed from, else the epoch's.
    """

    def __init__(
        self,
        seconds: np.ndarray,
        seconds_low: np.ndarray | None,
        epoch: Time | None,
        time: Time | None = None,
        scale: str | None = None,
    ):
        self.seconds = np.asarray(seconds)
        self.seconds_low = None if seconds_low is None else np.asarray(seconds_low)
        self.shape = self.seconds.shape
        self.epoch = epoch
        self._time = time
        dated = epoch if time is None else time
        self.scale = dated.scale if scale is None and dated is not None else scale

    @classmethod
    def from_time(cls, time: Time, epoch: Time, field: str) -> Instants:
        """The instants of a Time since the epoch; InputError where one is masked or not finite."""
        _refuse_missing(time, field)
        tai, start = to_tai(time, field), to_tai(epoch, "epoch")
        parts = _seconds_since(tai.jd1, tai.jd2, float(start.jd1), float(start.jd2))
        return cls(*parts, epoch, with_ut1(time).copy()).finite(field)

    @classmethod
    def from_delta(cls, delta: TimeDelta, epoch: Time | None, field: str) -> Instants:
        """The instants of a TimeDelta since the epoch, which one in TDB, TCB, TCG or UT1 needs."""
        _refuse_missing(delta, field)
        if delta.scale in ("tdb", "tcb", "tcg", "ut1") and epoch is not None:
            return cls.from_time(getattr(with_ut1(epoch, delta.scale), delta.scale) + delta, epoch, field)
        if delta.scale not in (None, "tai", "tt"):
            expected = "one in TAI or TT, or an epoch to count it from"
            raise InputError(field, f"a TimeDelta in {delta.scale}", expected)
        return cls(*_seconds_since(delta.jd1, delta.jd2, 0.0, 0.0), epoch).finite(field)

    @property
    def low(self) -> np.ndarray:
        """`seconds_low`, or zeros, s."""
        return np.zeros(self.shape) if self.seconds_low is None else self.seconds_low

    def flattened(self) -> Instants:
        """The same instants along one dimension, in contiguous doubles, as kernels take them."""
        low = None if self.seconds_low is None else _kernel_array(self.seconds_low).reshape(-1)
        return Instants(_kernel_array(self.seconds).reshape(-1), low, self.epoch, scale=self.scale)

    @cached_property
    def max_abs_seconds(self) -> float:
        """s; the greatest abs(seconds), not finite where one of them is not."""
        return _max_abs(_kernel_array(self.seconds).reshape(-1), 0, self.seconds.size)

    @property
    def rest(self) -> np.ndarray | None:
        """Deprecated name of `seconds_low`."""
        warnings.warn("Instants.rest is now Instants.seconds_low", DeprecationWarning, stacklevel=2)
        return self.seconds_low

    @property
    def farthest(self) -> float:
        """Deprecated name of `max_abs_seconds`."""
        warnings.warn("Instants.farthest is now Instants.max_abs_seconds", DeprecationWarning, stacklevel=2)
        return self.max_abs_seconds

    def since(self, origin: float) -> np.ndarray:
        """Seconds after an instant, s since the epoch: near it they lose no digits."""
        seconds = self.seconds - origin
        return seconds if self.seconds_low is None else seconds + self.seconds_low

    def counted_from(self, epoch: Instants) -> Instants:
        """The same instants, by the seconds since the epoch of one, at which their own epoch is."""
        seconds, low = two_sum(self.seconds, epoch.seconds)
        return Instants(seconds, low + self.low + epoch.low, epoch.epoch, scale=self.scale)

    def finite(self, field: str, expected: str = "instants whose seconds are finite doubles") -> Instants:
        """These instants; InputError naming the first that is not finite."""
        if not math.isfinite(self.max_abs_seconds):
            units.refuse_where(~np.isfinite(self.seconds), self.seconds, field, expected)
        return self

    @property
    def time(self) -> Time | None:
        """The instants as a Time in `scale`, made when first asked for; None without an epoch."""
        if self._time is None and self.epoch is not None:
            self._time = self._build_time(self.epoch)
        return self._time

    @property
    def tai(self) -> tuple[np.ndarray, np.ndarray]:
        """(n,), (n,): Julian dates of TAI in two parts, of all instants flattened.

        Raises InputError without an epoch.
        """
        if self.epoch is None:
            raise InputError("epoch", None, "a Time, for instants to be dated")
        start, below = tai_days(float(self.epoch.jd1), float(self.epoch.jd2), self.epoch.scale)
        days, days_low = self._days()
        whole = np.round(days)
        return start + whole, (days - whole) + (days_low + below)

    def _days(self) -> tuple[np.ndarray, np.ndarray]:
        """(n,), (n,): days since the epoch in two parts, of all instants flattened."""
        flat = self.flattened()
        days, days_low = np.empty_like(flat.seconds), np.empty_like(flat.seconds)
        compiled.days_from_seconds(flat.seconds, flat.low, days, days_low)
        return days, days_low

    def _build_time(self, epoch: Time) -> Time:
        days, days_low = self._days()
        offset = TimeDelta(days.reshape(self.shape), days_low.reshape(self.shape), format="jd", scale="tai")
        scale = self.scale or epoch.scale
        try:
            time = getattr(with_ut1(with_ut1(epoch).tai + offset, scale), scale)
        except (erfa.ErfaError, ValueError) as error:
            raise InputError(
                "time", f"scale {self.scale!r}", f"instants that a calendar has ({error})"
            ) from None
        to_tai(time, "time")
        time.format, time.precision = epoch.format, epoch.precision
        return time

    def __getitem__(self, key: Any) -> Instants:
        low = None if self.seconds_low is None else self.seconds_low[key]
        time = None if self._time is None else self._time[key]
        return Instants(self.seconds[key], low, self.epoch, time, self.scale)


def check_epoch(epoch: Any, field: str = "epoch") -> Time | None:
    """A copy of the epoch, a scalar Time that can be converted to any scale; None for None.

    Raises InputError for anything else, and for a Time that cannot be converted to TAI.
    """
    time = None if epoch is None else _date(epoch, field)
    if time is None and epoch is not None:
        raise InputError(field, epoch, "an astropy Time, a datetime, ISO 8601 text (UTC), or None")
    return time


def _date(value: Any, field: str) -> Time | None:
    """`check_epoch` of a date as users write it; None for what is no date."""
    time = value if isinstance(value, Time) else dated(value, "utc", field)
    if time is None:
        return None
    if not time.isscalar:
        raise InputError(field, f"shape {time.shape}", "one Time for all bodies")
    _refuse_missing(time, field)
    tai_days(float(time.jd1), float(time.jd2), time.scale, field)
    return with_ut1(time).copy()


def as_instants(t: Any, epoch: Time | None, field: str = "t", threads: int = 1) -> Instants:
    """Instants from times in any of the accepted forms, as two-part seconds since the epoch.

    Parameters
    ----------
    t : float array (s), Quantity, TimeDelta; or dates, which need an epoch: Time, datetime, or ISO 8601 text
        in the epoch's time scale; any shape, either sign; or a Grid

    Raises
    ------
    InputError : not one of these, not finite, masked, or a Time without an epoch.
    """
    if isinstance(t, Grid):
        return t.part(0, t.count, epoch)
    if type(t) is not np.ndarray or t.dtype != np.float64:
        date = None if isinstance(t, (Time, TimeDelta)) else dated(t, epoch.scale if epoch else "utc", field)
        t = t if date is None else date
    if isinstance(t, Time):
        if epoch is None:
            raise InputError(field, "a Time", "elapsed time, or an epoch for the motion to count from")
        return Instants.from_time(t, epoch, field)
    if isinstance(t, TimeDelta):
        return Instants.from_delta(t, epoch, field)
    if isinstance(t, u.Quantity):
        if t.unit != u.s:
            units.si_array(t, units.SECOND, field)  # refuses other dimensions
            return in_unit(units.finite_array(t.value, field), t.unit.to_string(), field, epoch)
        t = t.value
    try:
        return _from_seconds(t, epoch, field, threads).finite(field, "finite numbers")
    except InputError as error:
        expected = error.expected
        if expected == "numbers":
            expected = "seconds as floats, a Quantity, a TimeDelta, a Grid or (with an epoch) a Time"
        raise InputError(error.field, error.value, expected) from None


def _from_seconds(t: Any, epoch: Time | None, field: str, threads: int) -> Instants:
    """Instants from a copy of bare seconds; with threads, each copies and checks a range of a long array."""
    if type(t) is not np.ndarray or t.dtype != np.float64:
        return Instants(units.float_array(t, field), None, epoch)
    source, seconds = np.ascontiguousarray(t).reshape(-1), np.empty((t.size,))
    maxima: list[float] = []

    def copy(limits: tuple[int, int]) -> None:
        first, last = limits
        seconds[first:last] = source[first:last]
        maxima.append(_max_abs(seconds, first, last))

    run(copy, ranges(t.size, threads if t.size >= 500_000 else 1))  # fewer are copied before a thread starts
    instants = Instants(seconds.reshape(t.shape), None, epoch)
    instants.max_abs_seconds = float(np.max(maxima, initial=0.0))  # NaN where any is
    return instants


def _max_abs(seconds: np.ndarray, first: int, last: int) -> float:
    greatest = np.zeros(1)
    compiled.max_abs_seconds(seconds, first, last, greatest)
    return float(greatest[0])


def lazy_instants(t: Any, epoch: Time | None) -> tuple[Callable[[int, int], Instants], int]:
    """A function of (first, last) that returns Instants, and their number, of a `Grid` or what users give.

    Only the requested range is converted.  Raises InputError unless there is one dimension.
    """
    if isinstance(t, Grid):
        return partial(t.part, epoch=epoch), t.count
    if not isinstance(t, (Time, TimeDelta, Instants)):
        t = t if isinstance(t, u.Quantity) else np.asarray(t)
    if len(t.shape) != 1:
        raise InputError("times", f"shape {t.shape}", "instants along one dimension")
    if isinstance(t, Instants):
        return lambda first, last: t[first:last], t.shape[0]
    return lambda first, last: as_instants(t[first:last], epoch), t.shape[0]


def _refuse_missing(time: Time | TimeDelta, field: str) -> None:
    if time.masked:
        missing = np.asarray(time.mask)
        units.refuse_where(missing, np.where(missing, "nothing", ""), field, "a time for every instant")


def _seconds_since(day: Any, fraction: Any, day0: float, fraction0: float) -> tuple[np.ndarray, np.ndarray]:
    """Two-part seconds from one two-part day to others."""
    day, fraction = _kernel_array(day), _kernel_array(fraction)
    seconds, seconds_low = np.empty(day.shape), np.empty(day.shape)
    flat = [array.reshape(-1) for array in (day, fraction, seconds, seconds_low)]
    compiled.seconds_from_days(flat[0], flat[1], day0, fraction0, flat[2], flat[3])
    return seconds, seconds_low


def _kernel_array(array: Any) -> np.ndarray:
    """Doubles in C order, as kernels require."""
    return np.ascontiguousarray(array, dtype=np.float64).reshape(np.shape(array))


class Grid:
    """Evenly spaced instants; `TorqueFreeMotion.chunks` computes them range by range.

    Parameters
    ----------
    start, stop : float, in `unit` since the epoch; or both dates: Time, datetime, or ISO 8601 text (UTC)
    count : int, how many instants from start to stop, both included; or
    step : float, in `unit`; the last instant is the last one not beyond stop
    unit : str, a unit of time

    Raises
    ------
    InputError : a value that is not finite, none or both of count and step, or a date beside a number.
    """

    def __init__(
        self, start: Any, stop: Any, count: int | None = None, step: float | None = None, unit: str = "s"
    ):
        if (count is None) == (step is None):
            raise InputError("times", {"count": count, "step": step}, "one of count and step")
        self._ratio = _ratio(unit, "times.unit")
        self._first_date = _date(start, "times.start")
        last_date = _date(stop, "times.stop")
        if (self._first_date is None) != (last_date is None):
            raise InputError(
                "times.start", start, "a date where stop is a date, a number where it is a number"
            )
        if self._first_date is not None:
            elapsed = float(as_instants(last_date, self._first_date, "times.stop").seconds)
            start, stop = 0.0, elapsed * self._ratio[1] / self._ratio[0]
        self.unit = unit
        self.start, self.stop = _number(start, "times.start"), _number(stop, "times.stop")
        self.step = 0.0 if step is None else _number(step, "times.step")
        if count is None:
            if self.step <= 0.0:
                raise InputError("times.step", self.step, "a number greater than 0")
            intervals = (self.stop - self.start) / self.step
            if not intervals < 2**53:
                raise InputError("times.step", self.step, "a step that makes fewer than 2**53 instants")
            count = math.floor(intervals * (1.0 + 4e-16) + 1e-9) + 1
        self.count = whole_number(count, "times.count")

    def __len__(self) -> int:
        return self.count

    def part(self, first: int, last: int, epoch: Time | None = None) -> Instants:
        """Instants `first` to `last`, exclusive; their bits do not depend on the ranges requested."""
        count = last - first
        try:
            seconds, seconds_low = np.empty((count,)), np.empty((count,))
        except (MemoryError, ValueError):
            raise InputError("times", f"{count} samples", "as many samples as memory can hold") from None
        spacing = np.array([self.start, self.stop, self.count - 1, self.step, *self._ratio], dtype=float)
        compiled.grid(spacing, float(first), seconds, seconds_low)
        if self.step == 0.0 and first < last == self.count > 1:  # stop itself, without the rounding of a sum
            compiled.scaled(np.array([self.stop]), *self._ratio, seconds[-1:], seconds_low[-1:])
        if self._first_date is not None:
            origin = as_instants(self._first_date, epoch, "times.start")
            seconds, rounding = two_sum(float(origin.seconds), seconds)
            seconds, seconds_low = two_sum(seconds, rounding + (seconds_low + float(origin.low)))
        return Instants(seconds, seconds_low if seconds_low.any() else None, epoch).finite("times")


def _number(value: Any, field: str) -> float:
    """A float; InputError for what is not one finite number, as a Quantity, which has a unit of its own."""
    number = np.nan if isinstance(value, u.Quantity) else units.float_array(value, field)
    if np.ndim(number) or not np.isfinite(number):
        raise InputError(field, value, "a finite number")
    return float(number)


def in_unit(values: np.ndarray, unit: str, field: str, epoch: Time | None) -> Instants:
    """Instants from values in `unit`, as two-part seconds good to 32 digits."""
    seconds, seconds_low = np.empty(values.shape), np.empty(values.shape)
    ratio = _ratio(unit, field)
    compiled.scaled(values.reshape(-1), *ratio, seconds.reshape(-1), seconds_low.reshape(-1))
    return Instants(seconds, seconds_low if seconds_low.any() else None, epoch).finite(field)


def _ratio(unit: str, field: str) -> tuple[float, float]:
    """Seconds in a unit as a ratio of doubles: a millisecond is 1/1000, which no double is."""
    factor = units.parse_unit(unit, units.SECOND, field)
    inverse = 1.0 / factor
    if factor < 1.0 and abs(inverse - round(inverse)) < 1e-9 * inverse:
        return 1.0, float(round(inverse))
    return factor, 1.0

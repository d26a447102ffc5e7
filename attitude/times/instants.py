"""Instants: astropy Time, and the two-part SI seconds since the epoch that the kernels take.

The motion runs in SI seconds of TAI (the same as TT).  A Time in any scale is brought to TAI and
differenced from the epoch as a two-part number, so a UTC span counts its leap seconds and a span
of centuries keeps its picoseconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np
from astropy import units as u
from astropy.time import ScaleValueError, Time, TimeDelta
from erfa import ErfaError

from .. import units
from ..errors import InputError
from ..runtime import compiled
from ..runtime.threads import cut, run

WORTH_SHARING = 500_000  # instants; fewer are copied before a thread has begun
BEYOND = "instants that a double can hold in seconds"
KINDS = "seconds as floats, a Quantity, a TimeDelta or (with an epoch) a Time"


class Instants:
    """An array of instants: two-part seconds since the epoch, and the Time they were given as.

    Attributes
    ----------
    seconds : ndarray, s
        Elapsed SI seconds, rounded to one double.
    rest : ndarray or None, s
        What that rounding left, so that seconds + rest is good to 32 digits; None for zero.
    epoch : Time or None
    scale : str or None
        The time scale in which they are dated: that of the Time they were given as, else the epoch's.
    """

    def __init__(
        self,
        seconds: np.ndarray,
        rest: np.ndarray | None,
        epoch: Time | None,
        time: Time | None = None,
        scale: str | None = None,
    ):
        self.seconds = np.asarray(seconds)
        self.rest = None if rest is None else np.asarray(rest)
        self.epoch = epoch
        self._time = time
        dated = epoch if time is None else time
        self.scale = dated.scale if scale is None and dated is not None else scale

    @property
    def shape(self) -> tuple[int, ...]:
        return self.seconds.shape

    @cached_property
    def farthest(self) -> float:
        """s; the greatest abs(seconds), not finite where one of them is not."""
        return _farthest(_for_kernel(self.seconds).reshape(-1), 0, self.seconds.size)

    def finite(self, field: str, expected: str = BEYOND) -> Instants:
        """These instants; InputError naming the first that is not finite."""
        if not math.isfinite(self.farthest):
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
        """(n,), (n,): Julian dates of TAI in two parts, of all instants in a row.

        Raises InputError without an epoch.
        """
        if self.epoch is None:
            raise InputError("epoch", None, "a Time, for instants to be dated")
        start, below = _tai_days(float(self.epoch.jd1), float(self.epoch.jd2), self.epoch.scale)
        days, days_low = self._days()
        whole = np.round(days)
        return start + whole, (days - whole) + (days_low + below)

    def _days(self) -> tuple[np.ndarray, np.ndarray]:
        """Since the epoch, in two parts, of all instants in a row."""
        seconds = _for_kernel(self.seconds).reshape(-1)
        rest = np.zeros_like(seconds) if self.rest is None else _for_kernel(self.rest).reshape(-1)
        days, days_low = np.empty_like(seconds), np.empty_like(seconds)
        compiled.days_from_seconds(seconds, rest, days, days_low)
        return days, days_low

    def _build_time(self, epoch: Time) -> Time:
        days, days_low = self._days()
        offset = TimeDelta(days.reshape(self.shape), days_low.reshape(self.shape), format="jd", scale="tai")
        try:
            time = getattr(_offline(epoch).tai + offset, self.scale or epoch.scale)
        except (ErfaError, ValueError) as error:
            raise InputError(
                "time", f"scale {self.scale!r}", f"instants that a calendar has ({error})"
            ) from None
        _tai(time, "time")
        time.format, time.precision = epoch.format, epoch.precision
        return time

    def __getitem__(self, key: Any) -> Instants:
        rest = None if self.rest is None else self.rest[key]
        time = None if self._time is None else self._time[key]
        return Instants(self.seconds[key], rest, self.epoch, time, self.scale)


def check_epoch(epoch: Any, field: str = "epoch") -> Time | None:
    if epoch is None:
        return None
    if not isinstance(epoch, Time):
        raise InputError(field, epoch, "an astropy Time, or None")
    if not epoch.isscalar:
        raise InputError(field, f"shape {epoch.shape}", "one Time for all bodies")
    _refuse_missing(epoch, field)
    _tai_days(float(epoch.jd1), float(epoch.jd2), epoch.scale, field)
    return epoch.copy()


def as_instants(t: Any, epoch: Time | None, field: str = "t", threads: int = 1) -> Instants:
    """What users give as times, checked, as two-part seconds since the epoch.

    Parameters
    ----------
    t : float array (s), Quantity, TimeDelta, or Time (needs an epoch); any shape, either sign

    Raises
    ------
    InputError : not one of these, not finite, masked, or a Time without an epoch.
    """
    if isinstance(t, Time):
        if epoch is None:
            raise InputError(field, "a Time", "elapsed time, or an epoch for the motion to count from")
        return _from_time(t, epoch, field)
    if isinstance(t, TimeDelta):
        return _from_delta(t, epoch, field)
    if isinstance(t, u.Quantity) and t.unit != u.s:
        units.si_array(t, units.SECOND, field)  # refuses other dimensions
        return in_unit(units.finite_array(t.value, field), t.unit.to_string(), field, epoch)
    if isinstance(t, u.Quantity):
        t = t.value
    try:
        return _taken(t, epoch, field, threads).finite(field, "finite numbers")
    except InputError as error:
        expected = KINDS if error.expected == "numbers" else error.expected
        raise InputError(error.field, error.value, expected) from None


def _taken(t: Any, epoch: Time | None, field: str, threads: int) -> Instants:
    """A copy of bare seconds: with threads, each copies its part of a long array, and looks it through."""
    if type(t) is not np.ndarray or t.dtype != np.float64:
        return Instants(units.float_array(t, field), None, epoch)
    parts = threads if t.size >= WORTH_SHARING else 1
    given, seconds, found = np.ascontiguousarray(t).reshape(-1), np.empty((t.size,)), []

    def copy(part: tuple[int, int]) -> None:
        first, last = part
        seconds[first:last] = given[first:last]
        found.append(_farthest(seconds, first, last))

    run(copy, cut(t.size, parts))
    taken = Instants(seconds.reshape(t.shape), None, epoch)
    taken.farthest = float(np.max(found, initial=0.0))  # NaN where any is
    return taken


def _farthest(seconds: np.ndarray, first: int, last: int) -> float:
    greatest = np.zeros(1)
    compiled.farthest(seconds, first, last, greatest)
    return float(greatest[0])


def parts(t: Any, epoch: Time | None) -> tuple[Callable[[int, int], Instants], int]:
    """(the instants from first to last as a function, how many there are) of a `Grid` or what users give.

    Only the part that is asked for is converted.  Raises InputError unless there is one dimension.
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


@lru_cache(maxsize=256)
def _tai_days(jd1: float, jd2: float, scale: str, field: str = "epoch") -> tuple[float, float]:
    """The Julian date of TAI in two parts; remembered, for scenes share their epochs."""
    tai = _tai(Time(jd1, jd2, format="jd", scale=scale), field)
    return float(tai.jd1), float(tai.jd2)


def _tai(time: Time, field: str) -> Time:
    """In TAI; what astropy cannot convert offline (UT1 outside its tables) is refused."""
    try:
        return _offline(time).tai
    except (ValueError, ScaleValueError, ErfaError) as error:
        expected = f"a time that can be brought to TAI ({error})"
        raise InputError(field, f"scale {time.scale!r}", expected) from None


def _offline(time: Time, to: str | None = None) -> Time:
    """The same Time, and no network: where UT1 comes in (from it or `to` it) astropy's own tables do."""
    if "ut1" in (time.scale, to):
        from astropy.utils import iers

        iers.conf.auto_download = False
        _, status = iers.earth_orientation_table.get().ut1_utc(time.jd1, time.jd2, return_status=True)
        if np.any((status == iers.TIME_BEFORE_IERS_RANGE) | (status == iers.TIME_BEYOND_IERS_RANGE)):
            raise ValueError("UT1 - UTC is not in the tables for it")  # astropy would take the nearest
    return time


def _from_time(time: Time, epoch: Time, field: str) -> Instants:
    _refuse_missing(time, field)
    tai, start = _tai(time, field), _tai(epoch, "epoch")
    seconds, rest = _seconds(tai.jd1, tai.jd2, float(start.jd1), float(start.jd2))
    return Instants(seconds, rest, epoch, time.copy()).finite(field)


def _from_delta(delta: TimeDelta, epoch: Time | None, field: str) -> Instants:
    _refuse_missing(delta, field)
    if delta.scale in ("tdb", "tcb", "tcg", "ut1") and epoch is not None:
        return _from_time(getattr(_offline(epoch, delta.scale), delta.scale) + delta, epoch, field)
    if delta.scale not in (None, "tai", "tt"):
        raise InputError(
            field, f"a TimeDelta in {delta.scale}", "one in TAI or TT, or an epoch to count it from"
        )
    seconds, rest = _seconds(delta.jd1, delta.jd2, 0.0, 0.0)
    return Instants(seconds, rest, epoch).finite(field)


def _refuse_missing(time: Time | TimeDelta, field: str) -> None:
    if time.masked:
        missing = np.asarray(time.mask)
        units.refuse_where(missing, np.where(missing, "nothing", ""), field, "a time for every instant")


def _seconds(day: Any, fraction: Any, day0: float, fraction0: float) -> tuple[np.ndarray, np.ndarray]:
    day, fraction = _for_kernel(day), _for_kernel(fraction)
    seconds, rest = np.empty(day.shape), np.empty(day.shape)
    flat = [array.reshape(-1) for array in (day, fraction, seconds, rest)]
    compiled.seconds_from_days(flat[0], flat[1], day0, fraction0, flat[2], flat[3])
    return seconds, rest


def _for_kernel(array: Any) -> np.ndarray:
    """Doubles in C order, what kernels take."""
    return np.ascontiguousarray(array, dtype=np.float64).reshape(np.shape(array))


class Grid:
    """Even instants, made only when and as far as they are wanted: for `TorqueFreeMotion.chunks`.

    Parameters
    ----------
    start, stop : float, in `unit`
    count : int, how many instants from start to stop, both included; or
    step : float, in `unit`; the last instant is the last one not beyond stop
    unit : str, a unit of time

    Raises
    ------
    InputError : a value that is not finite, or none or both of count and step.
    """

    def __init__(
        self,
        start: float,
        stop: float,
        count: int | None = None,
        step: float | None = None,
        unit: str = "s",
    ):
        if (count is None) == (step is None):
            raise InputError("times", {"count": count, "step": step}, "one of count and step")
        self.start, self.stop, self.unit = float(start), float(stop), unit
        self._ratio = _ratio(unit, "times.unit")
        self.step = 0.0 if step is None else float(step)
        for name in ("start", "stop", "step"):
            if not np.isfinite(getattr(self, name)):
                raise InputError(f"times.{name}", getattr(self, name), "a finite number")
        self.count = self._stepped_count() if count is None else count
        if isinstance(self.count, bool) or not isinstance(self.count, int) or self.count < 1:
            raise InputError("times.count", self.count, "a whole number, at least 1")

    def _stepped_count(self) -> int:
        if self.step <= 0.0:
            raise InputError("times.step", self.step, "a number greater than 0")
        intervals = (self.stop - self.start) / self.step
        if not intervals < 2**53:
            raise InputError("times.step", self.step, "a step that makes fewer than 2**53 instants")
        return math.floor(intervals * (1.0 + 4e-16) + 1e-9) + 1

    def __len__(self) -> int:
        return self.count

    def part(self, first: int, last: int, epoch: Time | None = None) -> Instants:
        """The instants from first to last, the last one excluded; the bits do not depend on the parts."""
        seconds, rest = _room_for(last - first)
        spacing = np.array([self.start, self.stop, self.count - 1, self.step, *self._ratio], dtype=float)
        compiled.grid(spacing, float(first), seconds, rest)
        return Instants(seconds, rest if rest.any() else None, epoch).finite("times")


def in_unit(values: np.ndarray, unit: str, field: str, epoch: Time | None) -> Instants:
    """Values in `unit` as two-part seconds, good to 32 digits."""
    seconds, rest = np.empty(values.shape), np.empty(values.shape)
    compiled.scaled(values.reshape(-1), *_ratio(unit, field), seconds.reshape(-1), rest.reshape(-1))
    return Instants(seconds, rest if rest.any() else None, epoch).finite(field)


def _ratio(unit: str, field: str) -> tuple[float, float]:
    """Seconds in a unit as a ratio of doubles: a millisecond is 1/1000, which no double is."""
    factor = units.parse_unit(unit, units.SECOND, field)
    inverse = 1.0 / factor
    return (
        (1.0, float(round(inverse)))
        if factor < 1.0 and abs(inverse - round(inverse)) < 1e-9 * inverse
        else (factor, 1.0)
    )


def _room_for(count: int) -> tuple[np.ndarray, np.ndarray]:
    try:
        return np.empty((count,)), np.empty((count,))
    except (MemoryError, ValueError):
        raise InputError("times", f"{count} samples", "as many samples as memory can hold") from None

"""Spacecraft clocks of SPICE's SCLK kernels: from ticks to TT (NAIF, SCLK and time required reading)."""

from __future__ import annotations

import math
import re
from datetime import date
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from ...errors import FormatError
from ...times.iso8601 import MONTHS
from ...times.two_part import two_sum
from .text_kernels import variables

CLOCK_VARIABLES = (
    "SCLK_DATA_TYPE",
    "SCLK01_TIME_SYSTEM",
    "SCLK01_MODULI",
    "SCLK01_COEFFICIENTS",
    "SCLK_PARTITION_START",
    "SCLK_PARTITION_END",
)


class Clock(NamedTuple):
    """Spacecraft clock, linear between the instants of its calibration.

    ticks : in a count of its most significant field
    is_tt : whether `coefficients` are in TT; else in TDB
    coefficients : (n, 3): ticks since the clock's start, s past J2000, s a count
    end : the last tick of its last partition
    """

    ticks: float
    is_tt: bool
    coefficients: np.ndarray
    end: float

    def tt(self, ticks: np.ndarray, source: str) -> tuple[int, np.ndarray, np.ndarray]:
        """Whole seconds past J2000 in TT, and from there s in two parts, of (n,) increasing ticks."""
        first, last = float(ticks[0]), float(ticks[-1])
        if first < self.coefficients[0, 0]:
            raise FormatError("begins before the first calibration of its clock", source)
        if not (first >= 0.0 and last <= self.end):
            raise FormatError(f"ticks {first!r} to {last!r}, of a clock from 0 to {self.end!r}", source)
        start, since, rate = self.coefficients[self._rows(ticks)].T
        run = (ticks - start) / self.ticks * rate
        if not (np.abs(since) + np.abs(run) < 2.5e11).all():  # 7900 years
            raise FormatError("instants beyond any calendar", source)
        late = np.zeros_like(run) if self.is_tt else tdb_minus_tt(since + run)
        anchor = math.floor(since[0] + run[0] - late[0])
        whole = since - anchor
        seconds, error = two_sum(whole, run)
        rest = error - late
        total = seconds + rest
        return anchor, total, (seconds - total) + rest

    def _rows(self, ticks: np.ndarray) -> np.ndarray:
        """(n,) the row that dates each tick: by bisection as in SPICE, which decides where rows step back."""
        counts = self.coefficients[:, 0]
        low, high = np.zeros(len(ticks), dtype=np.int64), np.full(len(ticks), len(counts) - 1)
        low = np.where(ticks >= counts[-1], high, low)
        while (low < high - 1).any():
            middle = (low + high + 2) // 2 - 1
            is_before = counts[middle] <= ticks
            low, high = np.where(is_before, middle, low), np.where(is_before, high, middle)
        return low


def tdb_minus_tt(tdb: np.ndarray) -> np.ndarray:
    """TDB - TT, s, as in SPICE: one term, good to 30 us.  tdb : s past J2000."""
    mean = 6.239996 + 1.99096871e-7 * tdb  # the numbers are the same in every leap-second kernel
    return 1.657e-3 * np.sin(mean + 1.671e-2 * np.sin(mean))


def clock_from(text: str, source: str, structure: int, ck: str, clock_id: int | None = None) -> Clock:
    """Clock `clock_id` of a kernel; by default the clock of the spacecraft that carries the CK's structure.

    SPICE's rule: a structure's number is a thousand times that of its spacecraft, and less than a thousand
    more; a variable of a clock ends in the negative of the spacecraft's number.  That the kernel has not the
    clock of a structure is an error of the CK: either of the two may be the wrong one.
    """
    kernel = variables(text, source)
    endings = [name.removeprefix("SCLK_DATA_TYPE_") for name in kernel if name.startswith("SCLK_DATA_TYPE_")]
    spacecraft = int(structure / 1000) if clock_id is None else clock_id
    ending = str(-spacecraft)
    if ending not in endings:
        missing = (
            f"no SCLK_DATA_TYPE_{-spacecraft}, the clock of structure {structure} on spacecraft {spacecraft}"
        )
        if clock_id is not None:
            missing = f"no SCLK_DATA_TYPE_{-clock_id}, which clock_id={clock_id} names"
        elif spacecraft == 0:
            missing = f"the number of structure {structure} does not tell its spacecraft"
        numbers = [-int(each) for each in endings if re.fullmatch(r"-?\d{1,10}", each)]
        clocks = ", ".join(f"clock {-number} of spacecraft {number}" for number in numbers[:10]) or "no clock"
        cure = f"; clock_id={numbers[0]} takes that clock" if numbers else ""
        raise FormatError(f"{missing}; {source} has {clocks}{cure}", ck)
    values = {name: kernel.get(f"{name}_{ending}") for name in CLOCK_VARIABLES}
    try:
        return _clock(values)
    except (TypeError, ValueError, IndexError, OverflowError) as error:
        reason = f": {error.args[0]}" if error.args and str(error.args[0]) in CLOCK_VARIABLES else ""
        raise FormatError(f"clock {ending} is not of type 1, in TT or TDB{reason}", source) from None


def _clock(values: dict[str, list[Any] | None]) -> Clock:
    """Clock of the values of `CLOCK_VARIABLES`; ValueError with the name of one that describes none."""
    kind, system, moduli, coefficients, starts, ends = values.values()
    if kind != [1.0]:
        raise ValueError("SCLK_DATA_TYPE")
    if system not in (None, [1.0], [2.0]):
        raise ValueError("SCLK01_TIME_SYSTEM")
    ticks = float(np.prod(np.array(moduli, dtype=float)[1:]))
    numbers = [seconds(value) if isinstance(value, str) else value for value in coefficients or ()]
    table = np.array(numbers, dtype=float).reshape(-1, 3)
    if not (0 < ticks < np.inf and len(table) and np.isfinite(table).all() and (table[:, 2] > 0).all()):
        raise ValueError("SCLK01_COEFFICIENTS")
    lengths = np.rint(np.subtract(ends, starts, dtype=float)) if starts and ends else np.array([np.inf])
    if not (lengths > 0.0).all():
        raise ValueError("SCLK_PARTITION_END")
    return Clock(ticks, system == [2.0], table, float(lengths.sum()))


def seconds(text: str) -> float:
    """Seconds past J2000, in the scale of the text, of a kernel's date: @2024-JAN-01-12:01:09.184, for one.

    Its date is a year, a month by number or name and a day, or a day, the name of a month and a year; hours,
    minutes and seconds may be missing.  ValueError for any other text.
    """
    match = re.fullmatch(r"@(\w+)[-/.](\w+)[-/.](\w+)(?:[-/T:]+(\d+)(?::(\d+)(?::(\d+(?:\.\d*)?))?)?)?", text)
    if match is None:
        raise ValueError(text)
    first, second, third, *clock = match.groups()
    if not second.isdigit():
        year, month, day = (third, second, first) if len(third) == 4 else (first, second, third)
    elif not first.isdigit():
        month, day, year = first, second, third
    else:
        year, month, day = first, second, third
    number = int(month) if month.isdigit() else MONTHS.index(month[:3].capitalize()) + 1
    days = date(int(year), number, int(day)).toordinal() - date(2000, 1, 1).toordinal()
    hour, minute = int(clock[0] or 0), int(clock[1] or 0)
    return float(Fraction(days * 86400 - 43200 + hour * 3600 + minute * 60) + Fraction(clock[2] or 0))

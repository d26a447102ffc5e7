"""Spacecraft clocks of SPICE's SCLK kernels: from ticks to TT (NAIF, SCLK and time required reading)."""

from __future__ import annotations

import math
import re
from typing import Any, NamedTuple

import numpy as np

from ...errors import FormatError
from ...times.two_part import two_sum
from .text_kernels import variables

# Constants of TDB - TT, the same in every leap-second kernel.
K, EB, M0, M1 = 1.657e-3, 1.671e-2, 6.239996, 1.99096871e-7
MAX_SECONDS = 2.5e11  # past J2000, 7900 years: dates beyond have no calendar here
CLOCK_VARIABLES = ("SCLK_DATA_TYPE", "SCLK01_TIME_SYSTEM", "SCLK01_MODULI", "SCLK01_COEFFICIENTS")


class Clock(NamedTuple):
    """Spacecraft clock, linear between the instants of its calibration.

    ticks : in a count of its most significant field
    is_tt : whether `coefficients` are in TT; else in TDB
    coefficients : (n, 3): ticks since the clock's start, s past J2000, s a count
    """

    ticks: float
    is_tt: bool
    coefficients: np.ndarray

    def tt(self, ticks: np.ndarray, source: str) -> tuple[int, np.ndarray, np.ndarray]:
        """Whole seconds past J2000 in TT, and from there s in two parts, of (n,) increasing ticks."""
        row = np.searchsorted(self.coefficients[:, 0], ticks, side="right") - 1
        if row[0] < 0:
            raise FormatError("begins before the first calibration of its clock", source)
        start, since, rate = self.coefficients[row].T
        run = (ticks - start) / self.ticks * rate
        if not (np.abs(since) + np.abs(run) < MAX_SECONDS).all():
            raise FormatError("instants beyond any calendar", source)
        late = np.zeros_like(run) if self.is_tt else tdb_minus_tt(since + run)
        anchor = math.floor(since[0] + run[0] - late[0])
        whole = since - anchor
        seconds, error = two_sum(whole, run)
        rest = error - late
        total = seconds + rest
        return anchor, total, (seconds - total) + rest


def tdb_minus_tt(tdb: np.ndarray) -> np.ndarray:
    """TDB - TT, s, as in SPICE: one term, good to 30 us.  tdb : s past J2000."""
    mean = M0 + M1 * tdb
    return K * np.sin(mean + EB * np.sin(mean))


def clock_from(text: str, structure: int, source: str, clock_id: int | None = None) -> Clock:
    """Clock `clock_id` of a kernel; by default the clock of the spacecraft that carries the structure.

    SPICE's rule: a structure's number is a thousand times that of its spacecraft, and less than a thousand
    more; a variable of a clock ends in the negative of the spacecraft's number.
    """
    kernel = variables(text, source)
    endings = [name.removeprefix("SCLK_DATA_TYPE_") for name in kernel if name.startswith("SCLK_DATA_TYPE_")]
    spacecraft = int(structure / 1000) if clock_id is None else clock_id
    ending = str(-spacecraft)
    if ending not in endings:
        raise FormatError(_missing_clock(endings, structure, spacecraft, clock_id), source)
    try:
        return _clock(*(kernel.get(f"{name}_{ending}") for name in CLOCK_VARIABLES))
    except (TypeError, ValueError, IndexError, OverflowError):
        raise FormatError(f"clock {ending} is not of type 1, in TT or TDB", source) from None


def _missing_clock(endings: list[str], structure: int, spacecraft: int, clock_id: int | None) -> str:
    """Error message for a kernel whose clocks have these endings; it names a clock_id that is there."""
    numbers = [-int(ending) for ending in endings if re.fullmatch(r"-?\d{1,10}", ending)]
    clocks = ", ".join(f"clock {-number} of spacecraft {number}" for number in numbers[:10]) or "no clock"
    if clock_id is not None:
        missing = f"no SCLK_DATA_TYPE_{-clock_id}, which clock_id={clock_id} names"
    elif spacecraft == 0:
        missing = f"the number of structure {structure} does not tell its spacecraft"
    else:
        missing = (
            f"no SCLK_DATA_TYPE_{-spacecraft}, the clock of structure {structure} on spacecraft {spacecraft}"
        )
    cure = f"; clock_id={numbers[0]} takes that clock" if numbers else ""
    return f"{missing}; this kernel has {clocks}{cure}"


def _clock(
    kind: list[Any] | None, system: list[Any] | None, moduli: list[Any] | None, coefficients: list[Any] | None
) -> Clock:
    """Clock of the values of `CLOCK_VARIABLES`; ValueError if they describe none."""
    system = [1.0] if system is None else system
    if kind != [1.0] or system not in ([1.0], [2.0]):
        raise ValueError(kind, system)
    ticks = float(np.prod(np.array(moduli, dtype=float)[1:]))
    table = np.array(coefficients, dtype=float).reshape(-1, 3)
    if not (0 < ticks < np.inf and len(table) and np.isfinite(table).all() and (table[:, 2] > 0).all()):
        raise ValueError(coefficients)
    if not (np.diff(table[:, 0]) > 0).all():
        raise ValueError(coefficients)
    return Clock(ticks, system == [2.0], table)

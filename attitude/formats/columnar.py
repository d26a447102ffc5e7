"""Columns of numbers alone: dates as nanoseconds of TAI, which has no leap seconds.

A datetime64, or an Arrow timestamp, cannot be at a leap second; UTC would be wrong by it, or ambiguous.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from astropy.time import Time

from ..errors import FormatError
from ..pointing import vector_columns
from ..runtime import compiled
from ..samples.chunks import Samples
from ..samples.ephemeris_data import EphemerisData
from ..times.instants import Instants
from . import schema

TIME_TAI = "time_tai"
MEANING = "TAI, nanoseconds since 1970-01-01T00:00:00 TAI"
LEFT_OUT = "left out: dates beyond those that 64-bit nanoseconds hold, 1678 to 2261"

HALF_DAY_NS = 43_200 * 10**9
MAX_DATE_NS = 9_200_000_000 * 10**9  # the greatest of 64 bits is 0.25 % more
TIME_COLUMNS = (TIME_TAI, schema.ELAPSED, schema.REST)
VECTOR_COLUMNS = (
    *(*vector_columns.QUATERNION, *vector_columns.RATE, *vector_columns.MOMENTUM),
    *(*vector_columns.POSITION, *vector_columns.VELOCITY, *vector_columns.NOT_READ),
)


def names(samples: Samples) -> list[str]:
    """Names of the columns, the same for every chunk; dates, if 64 bits can hold them, first."""
    numbers = [name for name in schema.names(samples) if name != schema.TIME]
    epoch = samples.first.epoch
    span = samples.extremes.least, samples.extremes.greatest
    return [TIME_TAI, *numbers] if epoch is not None and can_hold(epoch, *span) else numbers


def dtype(name: str) -> np.dtype[Any]:
    """The type of a column's numbers."""
    return np.dtype("<M8[ns]" if name == TIME_TAI else "<f8")


def check_names(names: Sequence[str], source: str, what: str = "column") -> None:
    """Raises FormatError for a name that is not a column's, and for one that is there twice."""
    for i, name in enumerate(names):
        if name not in (*TIME_COLUMNS, *VECTOR_COLUMNS) or name in names[:i]:
            raise FormatError(f"{what} {name!r:.40}, unknown or repeated", source)


def can_hold(epoch: Time, least: float, greatest: float) -> bool:
    """Whether 64-bit nanoseconds can hold dates from the least to the greatest, s since the epoch."""
    start = sum(_since_1970(epoch))
    return start + least * 1e9 > -MAX_DATE_NS and start + greatest * 1e9 < MAX_DATE_NS


def columns(ephemeris: EphemerisData, names: Collection[str]) -> dict[str, np.ndarray]:
    """The columns of these names, each of the ephemeris's shape (those of time: of the instants')."""
    table = schema.columns(ephemeris, names)
    if TIME_TAI in names and ephemeris.epoch is not None:
        table[TIME_TAI] = nanoseconds(ephemeris.instants, ephemeris.epoch)
    return table


def nanoseconds(instants: Instants, epoch: Time) -> np.ndarray:
    """datetime64[ns] of the instants' shape: TAI, to the nearest nanosecond."""
    start, below = _since_1970(epoch)
    flat = instants.flattened()
    counts = np.empty(flat.shape)
    compiled.nanoseconds(flat.seconds, flat.low, start, below, counts)
    return counts.view("M8[ns]").reshape(instants.shape)


def _since_1970(epoch: Time) -> tuple[int, float]:
    """ns of TAI in two parts: jd1 is a multiple of half a day, jd2 less than a day."""
    tai = epoch.tai
    days = float(tai.jd1) - 2440587.5
    halves = round(2.0 * days)
    below = (days - 0.5 * halves + float(tai.jd2)) * 2.0 * HALF_DAY_NS
    return halves * HALF_DAY_NS + round(below), below - round(below)

"""Columns of numbers alone: dates as nanoseconds of TAI, which has no leap seconds to leave out.

A datetime64, or an Arrow timestamp, cannot be at a leap second; UTC would be wrong by it, or ambiguous.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np
from astropy.time import Time

from .. import memory
from ..runtime import compiled
from ..samples.chunks import Samples
from ..times.instants import Instants
from . import schema

if TYPE_CHECKING:
    from ..samples.ephemeris_data import EphemerisData

TIME_TAI = "time_tai"
MEANING = "TAI, nanoseconds since 1970-01-01T00:00:00 TAI"
LEFT_OUT = "left out: dates beyond those that 64-bit nanoseconds hold, 1678 to 2261"

JD_1970 = 2440587.5
HALF_DAY = 43_200 * 10**9  # ns
BEYOND = 9_200_000_000 * 10**9  # ns; the greatest of 64 bits is 0.25 % further


def names(samples: Samples) -> list[str]:
    """Of the columns: the same for every piece; the dates first, if they can be held."""
    plain = [name for name in schema.names(samples) if name != schema.TIME]
    return [TIME_TAI, *plain] if has_dates(samples) else plain


def has_dates(samples: Samples) -> bool:
    epoch = samples.first.epoch
    return epoch is not None and can_hold(epoch, *samples.span)


def can_hold(epoch: Time, least: float, greatest: float) -> bool:
    """Whether 64-bit nanoseconds reach from the first of these (s since the epoch) to the last."""
    start = sum(_since_1970(epoch))
    return start + least * 1e9 > -BEYOND and start + greatest * 1e9 < BEYOND


def columns(ephemeris: EphemerisData, wanted: Collection[str]) -> dict[str, np.ndarray]:
    """Those asked for by name, each of the ephemeris's shape (those of time: of the instants')."""
    table = schema.columns(ephemeris, wanted)
    if TIME_TAI in wanted and ephemeris.epoch is not None:
        table[TIME_TAI] = nanoseconds(ephemeris.instants, ephemeris.epoch)
    return table


def nanoseconds(instants: Instants, epoch: Time) -> np.ndarray:
    """datetime64[ns] of the instants' shape: TAI, to the nearest nanosecond."""
    start, below = _since_1970(epoch)
    seconds = np.ascontiguousarray(instants.seconds).reshape(-1)
    rest = (
        np.zeros_like(seconds) if instants.seconds_low is None else np.ascontiguousarray(instants.seconds_low)
    )
    counts = memory.empty(seconds.shape)
    compiled.nanoseconds(seconds, rest.reshape(-1), start, below, counts)
    return counts.view("M8[ns]").reshape(instants.shape)


def _since_1970(epoch: Time) -> tuple[int, float]:
    """ns, in two parts: jd1 is a multiple of half a day, jd2 less than a day."""
    tai = epoch.tai
    halves = round(2.0 * (float(tai.jd1) - JD_1970))
    below = (float(tai.jd1) - JD_1970 - 0.5 * halves + float(tai.jd2)) * 2.0 * HALF_DAY
    return halves * HALF_DAY + round(below), below - round(below)

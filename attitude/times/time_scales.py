"""Conversion of Times to TAI, and from and to UT1 by the tables that come with astropy."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any

import erfa
import numpy as np
from astropy.time import ScaleValueError, Time

from ..errors import InputError


@lru_cache(maxsize=256)
def tai_days(jd1: float, jd2: float, scale: str, field: str = "epoch") -> tuple[float, float]:
    """The Julian date of TAI in two parts; cached, because scenes share their epochs."""
    tai = to_tai(Time(jd1, jd2, format="jd", scale=scale), field)
    return float(tai.jd1), float(tai.jd2)


def to_tai(time: Time, field: str) -> Time:
    """The Time in TAI; what astropy cannot convert (UT1 outside its bundled tables) is refused."""
    try:
        return with_ut1(time).tai
    except (ValueError, ScaleValueError, erfa.ErfaError) as error:
        expected = f"a time that can be brought to TAI ({error})"
        raise InputError(field, f"scale {time.scale!r}", expected) from None


def with_ut1(time: Time, scale: str | None = None) -> Time:
    """The same Time, prepared for conversion from UT1, or to it where `scale` is "ut1".

    UT1 - UTC is interpolated in the tables that come with astropy (or in a table that the user has set as
    `astropy.utils.iers.earth_orientation_table`) and stored in the Time.  So astropy looks nothing up
    itself: there is no download, and its configuration is neither read nor changed, in whatever thread.

    Raises ValueError for a time outside the table; astropy would extrapolate.
    """
    if "ut1" not in (time.scale, scale):
        return time
    from astropy.utils import iers

    table = iers.earth_orientation_table.get()
    if isinstance(table, iers.IERS_Auto):  # not the user's own
        table = _bundled_ut1_table()
    if time.scale != "ut1":
        delta = _delta_ut1(table, time.utc.jd1, time.utc.jd2)
    else:
        delta = _delta_ut1(table, time.jd1, time.jd2)
        if hasattr(time, "_delta_ut1_utc"):  # set by the user, or by an earlier conversion
            return time
        # looked up by UT1 it may be a second off beside a leap second: once more, by UTC, as astropy does
        delta = _delta_ut1(table, *erfa.ut1utc(time.jd1, time.jd2, delta))
    time = time.copy()
    time.delta_ut1_utc = delta
    return time


def _delta_ut1(table: Any, jd1: Any, jd2: Any) -> Any:
    """UT1 - UTC, s, at two-part Julian dates."""
    from astropy.utils import iers

    delta, status = table.ut1_utc(jd1, jd2, return_status=True)
    if np.any((status == iers.TIME_BEFORE_IERS_RANGE) | (status == iers.TIME_BEYOND_IERS_RANGE)):
        raise ValueError("UT1 - UTC is not in the tables for it")
    return delta.to_value("s")


@cache
def _bundled_ut1_table() -> Any:
    """The Earth orientation table that comes with astropy, of a class that never downloads."""
    from astropy.utils import iers

    return iers.IERS_A(iers.IERS_Auto.read(iers.IERS_A_FILE))

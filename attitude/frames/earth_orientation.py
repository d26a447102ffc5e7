"""What the Earth's rotation is observed to be: UT1 and the pole, from tables that come with astropy.

No network: the series of the IERS (EOP C04, its Bulletin B) as far as it goes, from 1962 on, and after it the
rapid service's (finals2000A, Bulletin A) with its predictions, as astropy joins them.  Interpolated linearly
between the days, as astropy does, without tides of less than two days (some 1e-9 rad).
"""

from __future__ import annotations

import warnings
from functools import cache
from typing import Any, NamedTuple

import erfa
import numpy as np
from erfa import ErfaWarning

ARCSECOND = np.pi / 648000.0
DAY = 86400.0
MJD, J2000 = 2400000.5, 2451545.0


class Observed(NamedTuple):
    """Of (n,) instants, with the rate of change of each, per second.

    ut1_tai : s; x_pole, y_pole : rad
    """

    ut1_tai: np.ndarray
    x_pole: np.ndarray
    y_pole: np.ndarray
    rates: np.ndarray  # (3, n)


class Table(NamedTuple):
    """Rows at 0 h UTC of each day: MJD in UTC, days of TAI since J2000.0, and (3, n) what `Observed` has."""

    mjd: np.ndarray
    tai: np.ndarray
    values: np.ndarray

    @property
    def span(self) -> str:
        """The first date and the last."""
        from astropy.time import Time

        first, last = Time(self.mjd[[0, -1]], format="mjd").strftime("%Y-%m-%d")
        return f"{first} to {last}"


def covering(tai: np.ndarray) -> Table | None:
    """The table for instants (n,), days of TAI since J2000.0; None where neither covers them."""
    least, greatest = tai.min(initial=np.inf), tai.max(initial=-np.inf)
    for table in (_final, _with_rapid):
        if table().tai[0] <= least and greatest <= table().tai[-1]:
            return table()
    return None


def longest() -> Table:
    return _with_rapid()


def observed(table: Table, tai: np.ndarray) -> Observed:
    """At instants (n,), days of TAI since J2000.0, that the table covers."""
    row = np.clip(np.searchsorted(table.tai, tai, side="right") - 1, 0, len(table.tai) - 2)
    length = table.tai[row + 1] - table.tai[row]
    slope = (table.values[:, row + 1] - table.values[:, row]) / length
    values = table.values[:, row] + slope * (tai - table.tai[row])
    return Observed(values[0], values[1], values[2], slope / DAY)


@cache
def _final() -> Table:
    from astropy.utils import iers

    return _table(iers.IERS_B.open(iers.IERS_B_FILE))


@cache
def _with_rapid() -> Table:
    """The final table, and after it the rapid service's rows."""
    from astropy.utils import iers

    final, rapid = _final(), _table(iers.IERS_A.open(iers.IERS_A_FILE))
    after = rapid.mjd > final.mjd[-1]
    return Table(
        np.concatenate([final.mjd, rapid.mjd[after]]),
        np.concatenate([final.tai, rapid.tai[after]]),
        np.concatenate([final.values, rapid.values[:, after]], axis=1),
    )


def _table(rows: Any) -> Table:
    mjd = np.asarray(rows["MJD"].value, dtype=float)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ErfaWarning)  # leap seconds of years to come
        day, fraction = erfa.utctai(MJD + mjd, 0.0)
    offset = ((day - (MJD + mjd)) + fraction) * DAY  # TAI - UTC
    ut1_tai = np.asarray(rows["UT1_UTC"].to_value("s"), dtype=float) - offset
    pole = [np.asarray(rows[name].to_value("arcsec"), dtype=float) * ARCSECOND for name in ("PM_x", "PM_y")]
    return Table(mjd, (mjd - (J2000 - MJD)) + offset / DAY, np.array([ut1_tai, *pole]))

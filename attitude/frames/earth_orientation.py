"""Earth orientation parameters: UT1 and polar motion, from the IERS tables that come with astropy.

Offline: the final series (EOP C04, Bulletin B) from 1962 to its end, then that of the rapid service
(finals2000A, Bulletin A) with its predictions, as astropy joins them.  The bundled files are read by name, so
that astropy's configuration does not matter.  Interpolation is linear between days, as astropy's, without
tides of less than two days (some 1e-9 rad).
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import erfa
import numpy as np

from ..times.julian_dates import DAY, J2000, MJD
from ..times.leap_seconds import dubious_years

ARCSECOND = np.pi / 648000.0


class EarthOrientation(NamedTuple):
    """Earth orientation parameters at (n,) instants, with the rate of change of each, per second.

    ut1_tai : s; x_pole, y_pole : rad
    """

    ut1_tai: np.ndarray
    x_pole: np.ndarray
    y_pole: np.ndarray
    rates: np.ndarray  # (3, n)


class EarthOrientationTable(NamedTuple):
    """Daily rows at 0 h UTC: MJD in UTC, days of TAI since J2000.0, (3, n) UT1 - TAI, s, and pole, rad."""

    mjd: np.ndarray
    tai: np.ndarray
    values: np.ndarray

    @property
    def span(self) -> str:
        """The first date and the last, as text."""
        from astropy.time import Time

        first, last = Time(self.mjd[[0, -1]], format="mjd").strftime("%Y-%m-%d")
        return f"{first} to {last}"


def covering(tai: np.ndarray) -> EarthOrientationTable | None:
    """The table that covers instants (n,), days of TAI since J2000.0: the final one if it does; or None."""
    least, greatest = tai.min(initial=np.inf), tai.max(initial=-np.inf)
    for table in (final, longest):
        if table().tai[0] <= least and greatest <= table().tai[-1]:
            return table()
    return None


def interpolated(table: EarthOrientationTable, tai: np.ndarray) -> EarthOrientation:
    """The parameters at instants (n,), days of TAI since J2000.0, that the table covers."""
    row = np.clip(np.searchsorted(table.tai, tai, side="right") - 1, 0, len(table.tai) - 2)
    length = table.tai[row + 1] - table.tai[row]
    slope = (table.values[:, row + 1] - table.values[:, row]) / length
    values = table.values[:, row] + slope * (tai - table.tai[row])
    return EarthOrientation(values[0], values[1], values[2], slope / DAY)


def of_utc(tai: np.ndarray) -> EarthOrientation:
    """UTC taken for UT1, and no polar motion, at instants (n,), days of TAI since J2000.0.

    Off by up to 0.9 s of UT1, 13.5 arcseconds, and 0.6 arcseconds of the pole; a leap second is a step.
    """
    with dubious_years():
        day, fraction = erfa.taiutc(J2000, tai)
    zero = np.zeros_like(tai)
    return EarthOrientation(((day - J2000) + (fraction - tai)) * DAY, zero, zero, np.zeros((3, tai.size)))


@cache
def final() -> EarthOrientationTable:
    """The final table."""
    from astropy.utils import iers

    return _table(iers.IERS_B.open(iers.IERS_B_FILE))


@cache
def longest() -> EarthOrientationTable:
    """The final table, continued by the rapid service's."""
    from astropy.utils import iers

    past, rapid = final(), _table(iers.IERS_A.open(iers.IERS_A_FILE))
    after = rapid.mjd > past.mjd[-1]
    return EarthOrientationTable(
        np.concatenate([past.mjd, rapid.mjd[after]]),
        np.concatenate([past.tai, rapid.tai[after]]),
        np.concatenate([past.values, rapid.values[:, after]], axis=1),
    )


def _table(rows: Any) -> EarthOrientationTable:
    mjd = np.asarray(rows["MJD"].value, dtype=float)
    with dubious_years():
        day, fraction = erfa.utctai(MJD + mjd, 0.0)
    offset = ((day - (MJD + mjd)) + fraction) * DAY  # TAI - UTC
    ut1_tai = np.asarray(rows["UT1_UTC"].to_value("s"), dtype=float) - offset
    pole = [np.asarray(rows[name].to_value("arcsec"), dtype=float) * ARCSECOND for name in ("PM_x", "PM_y")]
    return EarthOrientationTable(mjd, (mjd - (J2000 - MJD)) + offset / DAY, np.array([ut1_tai, *pole]))

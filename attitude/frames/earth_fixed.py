"""Frames that the Earth carries along: the true equator and mean equinox of date, and the Earth-fixed frame.

    GCRF --S--> pole of date --about z--> TEME
                             --about z by the Earth rotation angle, then to the pole of the crust--> ITRF

S takes the pole of IAU 2006/2000A, X and Y, onto z the shortest way; what is left of the celestial
intermediate origin's place is the locator s (IERS Conventions 2010, section 5.4.4).  Every sign is that of a
function of time alone: quaternions are continuous over any span, and do not depend on which instants are
asked for together.
"""

from __future__ import annotations

import math
import warnings
from decimal import Decimal
from typing import NamedTuple

import erfa
import numpy as np
from erfa import ErfaWarning

from ..errors import InputError
from ..times import turn_rates
from ..times.instants import Instants
from . import earth_orientation
from .inertial import FrameRotation

DAY = 86400.0
TT_TAI = 32.184 / DAY  # days
TAU = 2.0 * math.pi
J2000 = 2451545.0
CENTURY = 36525.0
# Days; precession and nutation are given for some centuries about J2000.0.
REACH = 10.0 * CENTURY
# The Earth rotation angle (IERS Conventions 2010, eq. 5.15): turns at J2000.0, and those a day beyond one.
ANGLE_AT_J2000 = 0.7790572732640
BEYOND_ONE = Decimal("0.00273781191135448")
# That angle less the sidereal time of 1982 (Aoki et al. 1982), turns in powers of UT1 centuries.
LESS_SIDEREAL = (
    ANGLE_AT_J2000 - 67310.54841 / DAY,
    float(BEYOND_ONE * 36525) - 8640184.812866 / DAY,
    -0.093104 / DAY,
    6.2e-6 / DAY,
)
# The pole is computed at so many instants a day, and a polynomial laid through the nearest six: what errs
# most, 0.03 arcseconds in 9 days, then does by 1e-15 rad.
A_DAY, NEAREST = 8, 6
# Of the locator in the Earth's crust, rad a day (IERS Conventions 2010, eq. 5.13).
CRUST = -47e-6 * earth_orientation.ARCSECOND / CENTURY


class Days(NamedTuple):
    """Days of TAI since J2000.0: whole ones, and the rest, from 0 to 1."""

    whole: np.ndarray
    rest: np.ndarray

    def later(self, days: np.ndarray | float) -> Days:
        rest = self.rest + days
        whole = np.floor(rest)
        return Days(self.whole + whole, rest - whole)

    @property
    def sum(self) -> np.ndarray:
        return self.whole + self.rest


def since_j2000(instants: Instants) -> Days:
    """Of (n,) dated instants; refuses what is beyond precession and nutation."""
    whole, rest = instants.tai
    days = Days(whole - J2000, rest).later(0.0)
    off = ~(np.abs(days.sum) < REACH)
    if off.any():
        found = f"{float(days.sum[np.argmax(off)]) / 365.25:.6g} years from J2000.0"
        raise InputError("t", found, "instants within 1000 years of J2000.0, for which nutation is known")
    return days


# -- the two frames -----------------------------------------------------------------------------


def teme(instants: Instants) -> FrameRotation:
    """GCRF to TEME at (n,) instants.

    The sidereal time of 1982 carries TEME to the Earth-fixed frame, so their difference from the Earth
    rotation angle is all that counts, in which a second of UT1 is 7e-12 rad: UTC does for it.
    """
    tai = since_j2000(instants)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ErfaWarning)  # a year for which UTC is not defined
        day, fraction = erfa.taiutc(tai.whole + J2000, tai.rest)
    centuries = ((day - J2000) + fraction) / CENTURY
    to_pole, locator, locator_rate = _pole(tai)
    angle = TAU * np.polynomial.polynomial.polyval(centuries, LESS_SIDEREAL)
    slope = np.polynomial.polynomial.polyval(centuries, [k * c for k, c in enumerate(LESS_SIDEREAL) if k])
    rate = TAU / (CENTURY * DAY) * slope
    return to_pole.then(_about_z(0.5 * (angle - locator), rate - locator_rate))


def itrf(instants: Instants) -> FrameRotation:
    """GCRF to ITRF at (n,) instants.

    IAU 2006/2000A without the observed offsets of the pole (1e-9 rad); UT1 and the pole of the crust from
    astropy's tables.

    Raises
    ------
    InputError : instants before or after them; no network is asked for newer ones.
    """
    tai = since_j2000(instants)
    table = earth_orientation.covering(tai.sum)
    if table is None:
        raise _beyond_tables(instants, tai.sum)
    found = earth_orientation.observed(table, tai.sum)
    to_pole, locator, locator_rate = _pole(tai)
    ut1_rate, x_rate, y_rate = found.rates
    turns = _half_turns(tai.later(found.ut1_tai / DAY))
    half = TAU * turns + 0.5 * (CRUST * tai.sum - locator)
    a_second = TAU * float(1 + BEYOND_ONE) / DAY
    rate = a_second * (1.0 + ut1_rate) + CRUST / DAY - locator_rate
    crust = _about("y", -found.x_pole, -x_rate).then(_about("x", -found.y_pole, -y_rate))
    return to_pole.then(_about_z(half, rate)).then(crust)


def _beyond_tables(instants: Instants, tai: np.ndarray) -> InputError:
    table = earth_orientation.longest()
    off = (tai < table.tai[0]) | (tai > table.tai[-1])
    when = instants[int(np.argmax(off))].time
    found = "an instant" if when is None else f"{when.isot} {when.scale}"
    return InputError("t", found, f"instants from {table.span}, which astropy's tables of UT1 cover")


def _half_turns(ut1: Days) -> np.ndarray:
    """(n,): half the Earth rotation angle in turns, less whole ones: continuous where the angle is not."""
    high, low = turn_rates.split(BEYOND_ONE / 2)
    of_days = turn_rates.fraction_of_turn(ut1.whole, high, low) + 0.5 * np.mod(ut1.whole, 2.0)
    return of_days + 0.5 * (ANGLE_AT_J2000 + float(1 + BEYOND_ONE) * ut1.rest)


# -- the pole -----------------------------------------------------------------------------------


def _pole(tai: Days) -> tuple[FrameRotation, np.ndarray, np.ndarray]:
    """S as a turn, and the locator s of the celestial intermediate origin, rad, with its rate a second."""
    values, rates = _followed(tai.later(TT_TAI))
    (X, Y, s), (dX, dY, ds) = values, rates
    Z = np.sqrt(1.0 - X * X - Y * Y)
    dZ = -(X * dX + Y * dY) / Z
    quaternion = np.stack([1.0 + Z, Y, -X, np.zeros_like(X)], axis=-1)
    quaternion /= np.sqrt(2.0 * (1.0 + Z))[:, None]
    over = 1.0 / (1.0 + Z)
    rate = np.stack([dZ * Y * over - dY, dX - dZ * X * over, (dX * Y - dY * X) * over], axis=-1)
    return FrameRotation(quaternion, rate), s, ds


def _followed(tt: Days) -> tuple[np.ndarray, np.ndarray]:
    """X, Y and s, (3, n), rad, and their rates a second, by the polynomial through the nearest instants."""
    place = A_DAY * tt.rest
    interval = np.minimum(np.floor(place), A_DAY - 1)
    intervals, where = np.unique((A_DAY * tt.whole + interval).astype(np.int64), return_inverse=True)
    x = place - interval
    values, slopes = np.zeros((3, x.size)), np.zeros((3, x.size))
    for coefficient in _polynomials(intervals)[::-1, :, where]:
        slopes = slopes * x + values
        values = values * x + coefficient
    return values, slopes * (A_DAY / DAY)


def _polynomials(intervals: np.ndarray) -> np.ndarray:
    """(NEAREST, 3, n): X, Y and s in powers of the place, from 0 to 1, in each of n intervals."""
    needed = intervals[:, None] + (np.arange(NEAREST) - (NEAREST // 2 - 1))
    instants, where = np.unique(needed, return_inverse=True)
    given = _computed(instants)[:, where.reshape(needed.shape)]
    return np.array([(given * weights).sum(axis=-1) for weights in _LAGRANGE])


def _computed(instants: np.ndarray) -> np.ndarray:
    """(3, n): X, Y and s; `instants` counts eighths of a day of TT since J2000.0."""
    tt = instants / A_DAY
    X, Y = erfa.bpn2xy(erfa.pnm06a(J2000, tt))
    return np.array([X, Y, erfa.s06(J2000, tt, X, Y)])


def _lagrange() -> np.ndarray:
    """(NEAREST, NEAREST): row k has what each node's value counts for in the coefficient of the k-th power.

    The nodes are the whole numbers from -2 to 3; the polynomial is asked between 0 and 1.
    """
    nodes = np.arange(NEAREST) - (NEAREST // 2 - 1)
    columns = []
    for i, node in enumerate(nodes):
        others = np.delete(nodes, i)
        columns.append(np.polynomial.polynomial.polyfromroots(others) / np.prod(node - others))
    return np.array(columns).T


_LAGRANGE = _lagrange()


# -- turns about an axis ------------------------------------------------------------------------


def _about_z(half: np.ndarray, rate: np.ndarray) -> FrameRotation:
    """The axes turned about z by twice the angle `half`, at the rate."""
    zero = np.zeros_like(half)
    quaternion = np.stack([np.cos(half), zero, zero, -np.sin(half)], axis=-1)
    return FrameRotation(quaternion, np.stack([zero, zero, rate], axis=-1))


def _about(axis: str, angle: np.ndarray, rate: np.ndarray) -> FrameRotation:
    """The axes turned about one of them by a small angle."""
    i = "xyz".index(axis)
    quaternion, turning = np.zeros((angle.size, 4)), np.zeros((angle.size, 3))
    quaternion[:, 0], quaternion[:, 1 + i] = np.cos(0.5 * angle), -np.sin(0.5 * angle)
    turning[:, i] = rate
    return FrameRotation(quaternion, turning)

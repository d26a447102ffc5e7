"""Rotating frames of the Earth: TEME (true equator, mean equinox of date) and ITRF (Earth-fixed).

    GCRF --S--> pole of date --about z--> TEME
                             --about z by the Earth rotation angle, then to the pole of the crust--> ITRF

S is the shortest rotation of the pole of IAU 2006/2000A, X and Y, onto z; the celestial intermediate origin
is then located by the locator s (IERS Conventions 2010, section 5.4.4).  Every sign is a function of time
alone: quaternions are continuous over any span, and do not depend on the other instants of a call.
"""

from __future__ import annotations

import math
from decimal import Decimal
from typing import TYPE_CHECKING

import erfa
import numpy as np

from ..errors import InputError
from ..times import turn_rates
from ..times.instants import Instants
from ..times.julian_dates import DAY, J2000
from ..times.leap_seconds import dubious_years
from . import earth_orientation
from .daily_nodes import Days, interpolated
from .inertial import STILL, FrameRotation, from_gcrf
from .rotations import TEME_AT_EPOCH, rotate

if TYPE_CHECKING:
    from astropy.time import Time

CENTURY = 36525.0  # days
WGS84 = 1  # number of this ellipsoid in erfa
# The Earth rotation angle (IERS Conventions 2010, eq. 5.15): turns at J2000.0, and turns per day less one.
ANGLE_AT_J2000 = 0.7790572732640
EXCESS_TURNS = Decimal("0.00273781191135448")
# That angle less the sidereal time of 1982 (Aoki et al. 1982), turns in powers of UT1 centuries.
ANGLE_LESS_GMST = (
    ANGLE_AT_J2000 - 67310.54841 / DAY,
    float(EXCESS_TURNS * 36525) - 8640184.812866 / DAY,
    -0.093104 / DAY,
    6.2e-6 / DAY,
)
# Rate of the terrestrial locator s', rad/day (IERS Conventions 2010, eq. 5.13).
TERRESTRIAL_LOCATOR_RATE = -47e-6 * earth_orientation.ARCSECOND / CENTURY


def since_j2000(instants: Instants) -> Days:
    """Days of TAI of (n,) dated instants.

    Raises InputError beyond 1000 years from J2000.0, where precession and nutation are not known.
    """
    days = Days.of_tai(instants)
    off = ~(np.abs(days.sum) < 10.0 * CENTURY)  # precession and nutation are valid for some centuries
    if off.any():
        distance = f"{float(days.sum[np.argmax(off)]) / 365.25:.6g} years from J2000.0"
        raise InputError("t", distance, "instants within 1000 years of J2000.0, for which nutation is known")
    return days


# -- the two frames -----------------------------------------------------------------------------


def teme(instants: Instants) -> FrameRotation:
    """GCRF to TEME at (n,) instants.

    The sidereal time of 1982 rotates TEME to the Earth-fixed frame, so that only its difference from the
    Earth rotation angle matters, in which a second of UT1 is 7e-12 rad: UTC is used for UT1.
    """
    tai = since_j2000(instants)
    with dubious_years():
        day, fraction = erfa.taiutc(tai.whole + J2000, tai.fraction)
    centuries = ((day - J2000) + fraction) / CENTURY
    to_pole, locator, locator_rate = celestial_pole(tai)
    angle = math.tau * np.polynomial.polynomial.polyval(centuries, ANGLE_LESS_GMST)
    slope = np.polynomial.polynomial.polyval(centuries, [k * c for k, c in enumerate(ANGLE_LESS_GMST) if k])
    rate = math.tau / (CENTURY * DAY) * slope
    return to_pole.then(FrameRotation.about("z", angle - locator, rate - locator_rate))


def teme_at_epoch(epoch: Time | None) -> FrameRotation:
    """GCRF to the inertial axes that TEME has at an epoch; InputError without one."""
    if epoch is None:
        raise InputError("epoch", None, "an epoch; the axes of TEME are those of a date")
    return FrameRotation(teme(Instants(np.zeros(1), None, epoch)).quaternion[0], STILL)


def scene_axes(frame: str, epoch: Time | None, purpose: str) -> np.ndarray:
    """(3, 3) matrix from components in GCRF to those in the inertial frame of a scene; see `from_gcrf`."""
    if frame == TEME_AT_EPOCH:
        return rotate(teme_at_epoch(epoch).quaternion, np.eye(3)).T
    return from_gcrf(frame, purpose)


def itrf(instants: Instants, ut1: str = "tables") -> FrameRotation:
    """GCRF to ITRF at (n,) instants: that to GTOD, and polar motion.

    IAU 2006/2000A without the observed offsets of the pole (1e-9 rad); UT1 and polar motion from the tables
    that come with astropy.  With ut1="utc", for missions beyond these tables, UTC is taken for UT1 (within
    0.9 s, 13.5 arcseconds) and there is no polar motion.

    Raises
    ------
    InputError : instants outside these tables; newer ones are not downloaded.
    """
    to_gtod, orientation = _to_gtod(instants, ut1)
    _, x_rate, y_rate = orientation.rates
    about = FrameRotation.about
    polar_motion = about("y", -orientation.x_pole, -x_rate).then(about("x", -orientation.y_pole, -y_rate))
    return to_gtod.then(polar_motion)


def gtod(instants: Instants, ut1: str = "tables") -> FrameRotation:
    """GCRF to GTOD at (n,) instants: fixed to the Earth but for polar motion (TIRS of the IERS conventions).

    Raises InputError as `itrf`.
    """
    return _to_gtod(instants, ut1)[0]


def _to_gtod(instants: Instants, ut1: str) -> tuple[FrameRotation, earth_orientation.EarthOrientation]:
    tai = since_j2000(instants)
    if ut1 == "utc":
        orientation = earth_orientation.of_utc(tai.sum)
    else:
        orientation = earth_orientation.interpolated(_covering_table(instants, tai.sum), tai.sum)
    to_pole, locator, locator_rate = celestial_pole(tai)
    ut1_rate, _, _ = orientation.rates
    turns = half_rotation_angle(tai.plus(orientation.ut1_tai / DAY))
    half = math.tau * turns + 0.5 * (TERRESTRIAL_LOCATOR_RATE * tai.sum - locator)
    angle_rate = math.tau * float(1 + EXCESS_TURNS) / DAY
    rate = angle_rate * (1.0 + ut1_rate) + TERRESTRIAL_LOCATOR_RATE / DAY - locator_rate
    return to_pole.then(FrameRotation.about("z", 2.0 * half, rate)), orientation


def _covering_table(instants: Instants, tai: np.ndarray) -> earth_orientation.EarthOrientationTable:
    """The table that covers instants, days of TAI since J2000.0; InputError where none does."""
    table = earth_orientation.covering(tai)
    if table is not None:
        return table
    table = earth_orientation.longest()
    off = (tai < table.tai[0]) | (tai > table.tai[-1])
    time = instants[int(np.argmax(off))].time
    value = "an instant" if time is None else f"{time.isot} {time.scale}"
    cure = 'ut1="utc" takes UTC for UT1 beyond them'
    expected = f"instants from {table.span}, which astropy's tables of UT1 cover; {cure}"
    raise InputError("t", value, expected)


def half_rotation_angle(ut1: Days) -> np.ndarray:
    """(n,): half the Earth rotation angle in turns, less whole ones; continuous where the angle wraps."""
    high, low = turn_rates.split(EXCESS_TURNS / 2)
    of_days = turn_rates.fraction_of_turn(ut1.whole, high, low) + 0.5 * np.mod(ut1.whole, 2.0)
    return of_days + 0.5 * (ANGLE_AT_J2000 + float(1 + EXCESS_TURNS) * ut1.fraction)


# -- the pole -----------------------------------------------------------------------------------


def celestial_pole(tai: Days) -> tuple[FrameRotation, np.ndarray, np.ndarray]:
    """S, and the locator s of the celestial intermediate origin, rad, with its rate, rad/s."""
    (X, Y, s), (dX, dY, ds) = interpolated(_pole_and_locator, tai.plus(32.184 / DAY))
    Z = np.sqrt(1.0 - X * X - Y * Y)
    dZ = -(X * dX + Y * dY) / Z
    quaternion = np.stack([1.0 + Z, Y, -X, np.zeros_like(X)], axis=-1)
    quaternion /= np.sqrt(2.0 * (1.0 + Z))[:, None]
    over = 1.0 / (1.0 + Z)
    rate = np.stack([dZ * Y * over - dY, dX - dZ * X * over, (dX * Y - dY * X) * over], axis=-1)
    return FrameRotation(quaternion, rate), s, ds


def _pole_and_locator(tt: np.ndarray) -> np.ndarray:
    """(3, n): X, Y and s, rad, at days of TT since J2000.0."""
    X, Y = erfa.bpn2xy(erfa.pnm06a(J2000, tt))
    return np.array([X, Y, erfa.s06(J2000, tt, X, Y)])

"""Directions that depend on the date alone: the Sun, and the Earth's magnetic dipole."""

from __future__ import annotations

import warnings

import erfa
import numpy as np

from ..times.instants import Instants

# The Earth's dipole for 2025.0: g10, g11, h11 in T and their reference radius in m (IGRF-14, IAGA 2024).
G10, G11, H11 = -29350.0e-9, -1410.3e-9, 4545.5e-9
REFERENCE_RADIUS = 6371.2e3
DAY = 86400.0  # s


def au() -> float:
    """Return the astronomical unit, m."""
    from astropy.constants import au

    return float(au.value)


def sun_from_earth(tdb: tuple[float, float], seconds: np.ndarray) -> np.ndarray:
    """(n, 3) m, from the Earth to the Sun along the axes of GCRF, at seconds (n,) since a Julian date of TDB.

    The geometric position, not the apparent one (20 arcseconds apart), by the series that astropy's built-in
    ephemeris uses (erfa.epv00; 1900 to 2100, extrapolated beyond).
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", erfa.ErfaWarning)  # a year outside 1900 to 2100
        earth = erfa.epv00(tdb[0], tdb[1] + seconds / DAY)[0]
    return np.asarray(-au() * earth["p"])


def sun_at(instants: Instants) -> np.ndarray:
    """(n, 3) m, from the Earth to the Sun along the axes of GCRF; InputError without an epoch."""
    jd1, jd2 = instants.tai
    # TT for TDB: they differ by at most 2 ms, in which the Sun moves by 4e-10 rad
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", erfa.ErfaWarning)
        earth = erfa.epv00(jd1, jd2 + 32.184 / DAY)[0]
    return np.asarray(-au() * earth["p"])


def dipole_field(position: np.ndarray) -> np.ndarray:
    """(..., 3) T, the field of the Earth's dipole at positions (..., 3), m, both along axes of ITRF.

    B = (R/r)^3 (3 (g.u) u - g), with g = (g11, h11, g10) and u the unit vector of the position.
    """
    gauss = np.array([G11, H11, G10])
    distance = np.sqrt((position**2).sum(axis=-1, keepdims=True))
    unit = position / distance
    along = 3.0 * (unit @ gauss)[..., None] * unit - gauss
    return np.asarray((REFERENCE_RADIUS / distance) ** 3 * along)

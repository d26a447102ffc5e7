"""Directions that depend on the date alone: the Sun, and the Earth's magnetic dipole."""

from __future__ import annotations

import warnings

import erfa
import numpy as np

from ..times.instants import Instants
from ..times.julian_dates import DAY, J2000
from .daily_nodes import Days, interpolated

# The Earth's dipole for 2025.0: g10, g11, h11 in T and their reference radius in m (IGRF-14, IAGA 2024).
G10, G11, H11 = -29350.0e-9, -1410.3e-9, 4545.5e-9
REFERENCE_RADIUS = 6371.2e3
SUN_RADIUS = 6.957e8  # m (IAU 2015 resolution B3, nominal)


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
    """(n, 3) m, from the Earth to the Sun along the axes of GCRF, within 1e-12 of `sun_from_earth`.

    Raises InputError without an epoch.
    """
    # TT for TDB: they differ by at most 2 ms, in which the Sun moves by 4e-10 rad
    days = Days.of_tai(instants).plus(32.184 / DAY)
    return interpolated(lambda node: sun_from_earth((J2000, 0.0), node * DAY).T, days)[0].T


def dipole_field(position: np.ndarray) -> np.ndarray:
    """(..., 3) T, the field of the Earth's dipole at positions (..., 3), m, both along axes of ITRF.

    B = (R/r)^3 (3 (g.u) u - g), with g = (g11, h11, g10) and u the unit vector of the position.
    """
    gauss = np.array([G11, H11, G10])
    distance = np.linalg.norm(position, axis=-1, keepdims=True)
    unit = position / distance
    along = 3.0 * (unit @ gauss)[..., None] * unit - gauss
    return np.asarray((REFERENCE_RADIUS / distance) ** 3 * along)


def shadow_heights(
    position: np.ndarray, sun: np.ndarray, radius: float, side: float
) -> tuple[np.ndarray, np.ndarray]:
    """Distances (n,), m, from a surface of the shadow of a central body of a radius, m, negative within.

    The surface is the cylinder behind the central body (side 0), or the cone that touches both it and the
    Sun, crossing between them (side 1: the penumbra) or beyond (side -1: the umbra, and behind its tip the
    part from which the Sun is a ring).  Sunward of where that touches the central body, the distance from the
    latter.

    position, sun : (n, 3) m, from the central body

    Returns also the radius of the surface there (n,), m, which is negative behind the tip of the umbra.
    """
    distance2, sun_distance = (position**2).sum(axis=1), np.linalg.norm(sun, axis=1)
    sunward = (position * sun).sum(axis=1) / sun_distance
    sine = side * (SUN_RADIUS + side * radius) / sun_distance
    across = np.sqrt(np.maximum(distance2 - sunward**2, 0.0))
    edge = radius - sunward * sine
    cone = across * np.sqrt(1.0 - sine**2) - np.abs(edge)
    return np.where(sunward < radius * sine, cone, np.sqrt(distance2) - radius), edge

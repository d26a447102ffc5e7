"""Where the axes of the inertial frames lie: what the sky needs, and bodies on their own do not."""

from __future__ import annotations

import erfa
import numpy as np

from .errors import InputError

# The obliquity that ECLIPJ2000 is defined by, in arcseconds (IAU 1976; NAIF, frames required reading).
OBLIQUITY_J2000 = 84381.448


def from_gcrf(frame: str, purpose: str) -> np.ndarray:
    """(3, 3): components in GCRF to components in `frame`.

    Raises InputError for a frame whose axes nobody knows but its user; `purpose` says what needs them.

    Notes
    -----
    GCRF and ICRF have the same axes.  EME2000 is the mean equator and equinox of J2000.0, off them by
    the frame bias (IAU 2006, 23 mas); ECLIPJ2000 is EME2000 turned by the obliquity about its x axis.
    """
    if frame in ("ICRF", "GCRF"):
        return np.eye(3)
    if frame == "EME2000":
        return _bias()
    if frame == "ECLIPJ2000":
        return _about_x(np.deg2rad(OBLIQUITY_J2000 / 3600.0)) @ _bias()
    raise InputError("frame", frame, f"ICRF, GCRF, EME2000 or ECLIPJ2000, for {purpose}")


def _bias() -> np.ndarray:
    return np.asarray(erfa.bp06(2451545.0, 0.0)[0])


def _about_x(angle: float) -> np.ndarray:
    """Components after the axes are turned about x by the angle."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])

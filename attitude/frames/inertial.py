"""Axes of the inertial frames, and rotations between frames."""

from __future__ import annotations

from typing import NamedTuple

import erfa
import numpy as np

from ..errors import InputError
from ..times.julian_dates import J2000
from .rotations import conjugate, from_matrix, product, rotate

# The obliquity that ECLIPJ2000 is defined by, in arcseconds (IAU 1976; NAIF, frames required reading).
OBLIQUITY_J2000 = 84381.448
STILL = np.zeros(3)


class FrameRotation(NamedTuple):
    """The rotation from one frame to another, at one instant or many.

    Attributes
    ----------
    quaternion : (..., 4) wxyz: components along the axes of the second are q v conj(q)
    rate : (..., 3), rad/s: of the second relative to the first, components along the axes of the second
    """

    quaternion: np.ndarray
    rate: np.ndarray

    @classmethod
    def about(cls, axis: str, angle: np.ndarray, rate: np.ndarray) -> FrameRotation:
        """Rotation of the axes about one of them by an angle (n,), rad, at a rate (n,), rad/s."""
        i = "xyz".index(axis)
        quaternion, angular_velocity = np.zeros((angle.size, 4)), np.zeros((angle.size, 3))
        quaternion[:, 0], quaternion[:, 1 + i] = np.cos(0.5 * angle), -np.sin(0.5 * angle)
        angular_velocity[:, i] = rate
        return cls(quaternion, angular_velocity)

    def then(self, other: FrameRotation) -> FrameRotation:
        """The product: the rotation followed by the other."""
        quaternion = product(other.quaternion, self.quaternion)
        return FrameRotation(quaternion, rotate(other.quaternion, self.rate) + other.rate)

    def back(self) -> FrameRotation:
        """The inverse rotation."""
        quaternion = conjugate(self.quaternion)
        return FrameRotation(quaternion, -rotate(quaternion, self.rate))


def from_gcrf(frame: str, purpose: str) -> np.ndarray:
    """(3, 3) matrix from components in GCRF to components in `frame`.

    Raises InputError for INERTIAL, whose axes are the user's own; `purpose` is part of the message.

    Notes
    -----
    GCRF and ICRF have the same axes.  EME2000 is the mean equator and equinox of J2000.0, rotated by
    the frame bias (IAU 2006, 23 mas).  ECLIPJ2000 is the ICRF rotated by the obliquity about its x axis,
    without that bias, as SPICE, JPL Horizons and astropy's HeliocentricEclipticIAU76 have it.
    """
    if frame in ("ICRF", "GCRF"):
        return np.eye(3)
    if frame == "EME2000":
        return np.asarray(erfa.bp06(J2000, 0.0)[0])
    if frame == "ECLIPJ2000":
        obliquity = np.deg2rad(OBLIQUITY_J2000 / 3600.0)
        c, s = np.cos(obliquity), np.sin(obliquity)
        return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
    raise InputError("frame", frame, f"ICRF, GCRF, EME2000 or ECLIPJ2000, for {purpose}")


def rotation_from_gcrf(frame: str, purpose: str) -> FrameRotation:
    """`from_gcrf` as a FrameRotation."""
    return FrameRotation(from_matrix(from_gcrf(frame, purpose)), STILL)

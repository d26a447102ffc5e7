"""The spin of a body as operators state it: momentum direction, nutation, phases and rates.

The spin axis is a body axis s, the body's z if no other is named.  With the angular momentum along the
direction l, and the angles of q = q_z(ra + 90 deg) q_x(90 deg - dec) q_z(precession) q_x(nutation) q_z(phase)
in axes of which s is the third:

    nutation     angle between s and l
    precession   angle of the plane of l and s about l, from the line of nodes of l
    phase        angle about s, from that plane
    rate         component of the angular velocity along s
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..frames import rotations
from ..samples.ephemeris_data import EphemerisData
from .targets import body_axis, unit_vectors


class SpinState(NamedTuple):
    """The spin at each instant, (...,) each: rad, and rad/s for `rate`.

    ra, dec : right ascension and declination of the angular momentum in the ephemeris's frame
    nutation, precession, phase : the angles defined in this module
    rate : component of the body rate along the spin axis
    """

    ra: np.ndarray
    dec: np.ndarray
    nutation: np.ndarray
    precession: np.ndarray
    phase: np.ndarray
    rate: np.ndarray


def spin_state(data: EphemerisData, axis: Any = "z") -> SpinState:
    """The spin about a body axis.

    Raises RegimeError without inertia or rates, at rest, and in a frame that turns.
    """
    third = body_axis(axis)
    momentum = unit_vectors(np.asarray(data.angular_momentum), "the spin, of the angular momentum,")
    ra = np.arctan2(momentum[..., 1], momentum[..., 0]) % (2.0 * np.pi)
    dec = np.arctan2(momentum[..., 2], np.hypot(momentum[..., 0], momentum[..., 1]))
    to_momentum = rotations.from_euler("ZX", np.stack([ra + 0.5 * np.pi, 0.5 * np.pi - dec], axis=-1))
    q = rotations.product(rotations.conjugate(to_momentum), data.quaternion("wxyz"))
    q = rotations.product(q, _to_third(third))
    precession, nutation, phase = np.moveaxis(rotations.euler_angles(q, "ZXZ"), -1, 0)
    rate = data.angular_velocity @ third
    return SpinState(ra, dec, nutation, precession % (2.0 * np.pi), phase % (2.0 * np.pi), rate)


def spinning(ra: float, dec: float, phase: float, axis: Any = "z") -> np.ndarray:
    """(4,) wxyz of a body whose axis points to a right ascension and declination; nutation 0 above."""
    return _attitude(ra, dec, (0.0, 0.0, phase), body_axis(axis))


def nutating(
    tensor: np.ndarray, spin: SpinState, axis: Any = "z", field: str = "rate"
) -> tuple[np.ndarray, np.ndarray]:
    """(4,) wxyz and (3,) rad/s of a spin: what `spin_state` takes apart, for any tensor (3, 3), kg m2.

    The magnitude of the angular momentum follows from the rate along the axis.

    Raises InputError where momentum of this direction has no rate along the axis (a nutation of 90 degrees of
    a principal axis), or one of the other sign.
    """
    third = body_axis(axis)
    angles = float(spin.precession), float(spin.nutation), float(spin.phase)
    q = _attitude(float(spin.ra), float(spin.dec), angles, third)
    momentum = rotations.unit_direction(spin.ra, spin.dec)
    omega = np.linalg.solve(tensor, rotations.rotate(rotations.conjugate(q), momentum))
    along = float(omega @ third)
    if abs(along) <= 1e-9 * np.sqrt(omega @ omega):
        expected = "a nutation other than 90 deg, at which momentum makes no rate along the axis"
        raise InputError(field, float(spin.rate), expected)
    if float(spin.rate) * along < 0.0:
        expected = f"a rate {'above' if along > 0.0 else 'below'} 0, as momentum of this direction has"
        raise InputError(field, float(spin.rate), f"{expected} at this nutation")
    return q, omega * (float(spin.rate) / along)


def _attitude(ra: float, dec: float, angles: tuple[float, float, float], third: np.ndarray) -> np.ndarray:
    q = rotations.from_euler("ZXZ", np.array([ra + 0.5 * np.pi, 0.5 * np.pi - dec, 0.0]))
    q = rotations.product(q, rotations.from_euler("ZXZ", np.array(angles)))
    return rotations.product(q, rotations.conjugate(_to_third(third)))


def _to_third(axis: np.ndarray) -> np.ndarray:
    """(4,) wxyz of the shortest rotation from z to a body axis: axes of which that one is the third."""
    across = axis[0] ** 2 + axis[1] ** 2
    if axis[2] < 0.0 and not across:
        return np.array([0.0, 1.0, 0.0, 0.0])
    w = 1.0 + axis[2] if axis[2] > -0.5 else across / (1.0 - axis[2])  # which near -z does not cancel
    q = np.array([w, -axis[1], axis[0], 0.0])
    return q / np.sqrt(q @ q)

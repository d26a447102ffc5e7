"""Attitudes of spinners as AEM rows have them: spin axis, phase and nutation (504.0-B-2, 3.2).

The spin axis is the body's z.  Its right ascension and declination are alpha and delta, and the spin angle
turns the body about it:

    q = q_z(alpha + 90 deg) q_x(90 deg - delta) q_z(angle)

The body rate is that of the spin about z, and of the precession about the angular momentum's direction l:

    omega = d(angle)/dt z + Omega l

SPIN has no precession.  SPIN/NUTATION has Omega = 2 pi / NUTATION_PER and, along the body's axes,
l = (sin(nu) cos(phase), -sin(nu) sin(phase), cos(nu)) with the angle nu and the phase of the nutation;
SPIN/NUTATION_MOM has Omega = NUTATION_VEL, and the direction of the momentum in the external frame.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...errors import FormatError
from ...frames import rotations
from ...samples.ephemeris_data import EphemerisData
from .epochs import RowError
from .keywords import Keywords


def attitude_and_rate(columns: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions (4, n) wxyz, body to external frame, and body rates (3, n), rad/s; columns in deg and s."""
    alpha, delta, angle, speed = (np.deg2rad(columns[name]) for name in Keywords.SPIN)
    angles = np.stack([alpha + 0.5 * np.pi, 0.5 * np.pi - delta, angle], axis=1)
    q = rotations.from_euler("ZXZ", angles)
    rate = np.zeros((len(q), 3))
    if "NUTATION" in columns:
        nutation, phase = np.deg2rad(columns["NUTATION"]), np.deg2rad(columns["NUTATION_PHASE"])
        period = columns["NUTATION_PER"]
        good = (period > 0.0) | ((period == 0.0) & (nutation == 0.0))  # writers leave all zero for none
        if not good.all():
            raise RowError(int(np.argmin(good)), "NUTATION_PER: a period greater than 0 belongs here")
        momentum = rotations.unit_direction(-phase, 0.5 * np.pi - nutation)
        rate = (
            np.where(period > 0.0, 2.0 * np.pi / np.where(period > 0.0, period, 1.0), 0.0)[:, None] * momentum
        )
    elif "NUTATION_VEL" in columns:
        momentum = rotations.unit_direction(
            np.deg2rad(columns["MOMENTUM_ALPHA"]), np.deg2rad(columns["MOMENTUM_DELTA"])
        )
        momentum = rotations.rotate(rotations.conjugate(q), momentum)
        rate = np.deg2rad(columns["NUTATION_VEL"])[:, None] * momentum
    rate[:, 2] += speed
    return np.ascontiguousarray(q.T), np.ascontiguousarray(rate.T)


def numbers(piece: EphemerisData, kind: tuple[str, ...]) -> np.ndarray:
    """(4 or 7, n) numbers of rows SPIN, or with the columns NUTATION or MOMENTUM, in deg, deg/s and s.

    Raises FormatError where the body's rate is not the spin that such rows state.
    """
    q, rate = piece.quaternion("wxyz"), piece.angular_velocity
    first, second, angle = rotations.euler_angles(q, "ZXZ").T
    columns = [first - 0.5 * np.pi, 0.5 * np.pi - second, angle]
    if not kind:
        _refuse_other_rates(rate, np.abs(rate[:, :2]).max(axis=1), "SPIN, which is about z")
        return np.rad2deg(np.stack([*columns, rate[:, 2]]))
    momentum = piece.angular_momentum
    momentum = momentum / np.linalg.norm(momentum, axis=1, keepdims=True)
    x, y, z = rotations.rotate(rotations.conjugate(q), momentum).T
    across = x * x + y * y
    precession = (x * rate[:, 0] + y * rate[:, 1]) / np.where(across > 0.0, across, 1.0)
    off = np.hypot(rate[:, 0] - precession * x, rate[:, 1] - precession * y)
    _refuse_other_rates(rate, off, "SPIN/NUTATION, which is of bodies symmetric about z")
    columns.append(rate[:, 2] - precession * z)
    if kind is Keywords.NUTATION:
        period = 2.0 * np.pi / np.where(precession > 0.0, precession, np.inf)  # 0 without nutation
        nutation, phase = np.arctan2(np.sqrt(across), z), np.arctan2(-y, x)
        nutation = np.where(precession > 0.0, nutation, 0.0)
        return np.concatenate([np.rad2deg([*columns, nutation]), [period], np.rad2deg([phase])])
    longitude, latitude = (
        np.arctan2(momentum[:, 1], momentum[:, 0]),
        np.arcsin(np.clip(momentum[:, 2], -1.0, 1.0)),
    )
    return np.rad2deg(np.stack([*columns, longitude, latitude, precession]))


def _refuse_other_rates(rate: np.ndarray, off: np.ndarray, kind: str) -> None:
    """Refuse rates of which rows of a spin leave out more than 1e-9."""
    size = np.linalg.norm(rate, axis=1)
    if (off > 1e-9 * size).any():
        share = float((off / np.where(size > 0.0, size, 1.0)).max())
        kinds = f"is not that of {kind}; QUATERNION/ANGVEL holds any rate"
        raise FormatError(f"attitude_type: {share:.1e} of the body's rate {kinds}")

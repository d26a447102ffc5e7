"""Orbital frames: QSW as a rotation from the inertial frame of the orbit."""

from __future__ import annotations

import math

import numpy as np

from ..errors import RegimeError
from ..frames.inertial import FrameRotation
from ..frames.rotations import conjugate, from_matrix, product
from ..kernels.layout import Ellipse
from ..problem.initial_state import OrbitPath
from ..times import turn_rates
from .path_states import eccentric_anomaly, ellipse_axes, position, velocity

# The sign of the quaternion is carried from knot to knot; the body moves by a few degrees between them.
KNOTS_PER_INTERVAL = 8


def qsw(path: OrbitPath, t: np.ndarray, rest: np.ndarray | None = None) -> FrameRotation:
    """Rotation to QSW: x radial outward, z along the orbital momentum; t + rest (n,) s since the epoch.

    The sign of the quaternion is continuous over any span: that of half the true anomaly, or carried along
    the knots of a table.
    """
    if path.is_keplerian:
        return qsw_of_ellipse(path, t, np.zeros_like(t) if rest is None else rest)
    return qsw_of_table(path, t)


def qsw_of_ellipse(path: OrbitPath, t: np.ndarray, rest: np.ndarray) -> FrameRotation:
    """Perifocal axes, rotated about the normal by the true anomaly."""
    e, start, high, low, mean_motion = path.numbers[Ellipse.ECCENTRICITY : Ellipse.P]
    P, Q = ellipse_axes(path)
    perifocal = from_matrix(np.stack([P, Q, np.cross(P, Q)], axis=-1))
    half_turns = 0.5 * start + turn_rates.fraction_of_turn(t, 0.5 * high, 0.5 * low) + 0.5 * high * rest
    whole = np.round(2.0 * half_turns)
    E = eccentric_anomaly(math.tau * (2.0 * half_turns - whole), e)
    half = np.arctan2(np.sqrt(1.0 + e) * np.sin(0.5 * E), np.sqrt(1.0 - e) * np.cos(0.5 * E)) + np.pi * whole
    zero = np.zeros_like(half)
    axes = product(perifocal, np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1))
    rate = mean_motion * np.sqrt((1.0 - e) * (1.0 + e)) / (1.0 - e * np.cos(E)) ** 2
    return FrameRotation(conjugate(axes), np.stack([zero, zero, rate], axis=-1))


def qsw_of_table(path: OrbitPath, t: np.ndarray) -> FrameRotation:
    """Axes of the plane of position and velocity.

    Along a TLE the velocity is SGP4's own, which is not the derivative of its positions: the rate is that of
    the axes, by the derivatives r' and v', with h = r x v:
    omega = (-h'.y / |h|, -r'.z / |r|, r'.y / |r|).
    """
    polynomial, own = path.polynomial, path.velocity_polynomial
    r, v = position(path, t), velocity(path, t)
    r_slope = polynomial(t, 1)
    v_slope = polynomial(t, 2) if own is None else own(t, 1)
    axes, distance, momentum = qsw_axes(r, v)
    quaternion = from_matrix(axes)
    knots, x = _knots(path), KNOTS_PER_INTERVAL * (t - polynomial.start) / polynomial.length
    nearest = knots[np.clip(np.round(x), 0, len(knots) - 1).astype(np.int64)]
    quaternion *= np.where((nearest * quaternion).sum(axis=-1) < 0.0, -1.0, 1.0)[:, None]
    _, y, z = np.moveaxis(axes, -1, 0)
    change = np.cross(r_slope, v) + np.cross(r, v_slope)
    along = -(change * y).sum(axis=-1) / momentum
    rate = np.stack([along, *((r_slope * axis).sum(axis=-1) / distance for axis in (-z, y))], axis=-1)
    return FrameRotation(conjugate(quaternion), rate)


def _knots(path: OrbitPath) -> np.ndarray:
    """(m, 4): quaternions of the axes without sign changes; that nearest the epoch as by `from_matrix`."""
    knots, polynomial = np.arange(KNOTS_PER_INTERVAL * len(path.coefficients) + 1), path.polynomial
    t = polynomial.start + polynomial.length / KNOTS_PER_INTERVAL * knots
    q = from_matrix(qsw_axes(position(path, t), velocity(path, t))[0])
    changes = np.where((q[1:] * q[:-1]).sum(axis=-1) < 0.0, -1.0, 1.0)
    signs = np.concatenate([[1.0], np.cumprod(changes)])
    return q * (signs * signs[np.argmin(np.abs(t))])[:, None]


def qsw_axes(r: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(n, 3, 3) whose columns are the axes; (n,) distance, m, and specific angular momentum, m2/s."""
    distance, speed = (np.linalg.norm(vector, axis=-1) for vector in (r, v))
    normal = np.cross(r, v)
    momentum = np.linalg.norm(normal, axis=-1)
    if not (momentum > 1e-9 * distance * speed).all():  # the least sine of the angle between them
        raise RegimeError("orbit: where the body moves along the radius its orbit has no plane")
    x, z = r / distance[:, None], normal / momentum[:, None]
    return np.stack([x, np.cross(z, x), z], axis=-1), distance, momentum

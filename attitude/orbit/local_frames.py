"""Axes along an orbit: QSW as a turn from the inertial frame of its course."""

from __future__ import annotations

import numpy as np

from ..errors import RegimeError
from ..frames.inertial import FrameRotation
from ..frames.rotations import conjugate, from_matrix, product
from ..kernels import layout
from ..problem.initial_state import OrbitPath, PiecewisePolynomial
from ..times import turn_rates
from .path_states import TAU, as_pieces, eccentric_anomaly, evaluate

# Of pieces: the sign is carried from one of these to the next, so many in a piece; the body goes a few
# degrees round between them.
IN_A_PIECE = 8
# Position and velocity along one line have no plane: the sine of the angle between them.
LEAST_SINE = 1e-9


def qsw(course: OrbitPath, t: np.ndarray, rest: np.ndarray | None = None) -> FrameRotation:
    """x radial outward, z along the orbital momentum; t (n,) s since the epoch, and what their rounding left.

    The sign is continuous over any span: it is that of half the true anomaly, or is carried along the pieces.
    """
    if course.numbers[0] == layout.KEPLER:
        return _of_ellipse(course, t, np.zeros_like(t) if rest is None else rest)
    return _of_pieces(as_pieces(course), t)


def _of_ellipse(course: OrbitPath, t: np.ndarray, rest: np.ndarray) -> FrameRotation:
    """The perifocal axes, turned about the normal by the true anomaly."""
    e, start, high, low, mean_motion = course.numbers[2:7]
    P, Q = course.numbers[7:10], course.numbers[10:13]
    perifocal = from_matrix(np.stack([P, Q, np.cross(P, Q)], axis=-1))
    half_turns = 0.5 * start + turn_rates.fraction_of_turn(t, 0.5 * high, 0.5 * low) + 0.5 * high * rest
    whole = np.round(2.0 * half_turns)
    E = eccentric_anomaly(TAU * (2.0 * half_turns - whole), e)
    half = np.arctan2(np.sqrt(1.0 + e) * np.sin(0.5 * E), np.sqrt(1.0 - e) * np.cos(0.5 * E)) + np.pi * whole
    zero = np.zeros_like(half)
    along = product(perifocal, np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1))
    rate = mean_motion * np.sqrt((1.0 - e) * (1.0 + e)) / (1.0 - e * np.cos(E)) ** 2
    return FrameRotation(conjugate(along), np.stack([zero, zero, rate], axis=-1))


def _of_pieces(pieces: PiecewisePolynomial, t: np.ndarray) -> FrameRotation:
    """Axes of the osculating plane; it turns about the radius by what of the acceleration is across it."""
    r, v, a = (evaluate(pieces, t, derivative) for derivative in (0, 1, 2))
    axes, distance, momentum = _axes(r, v)
    quaternion = from_matrix(axes)
    knots, at = _knots(pieces), IN_A_PIECE * (t - pieces.start) / pieces.length
    beside = knots[np.clip(np.round(at), 0, len(knots) - 1).astype(np.int64)]
    quaternion *= np.where((beside * quaternion).sum(axis=-1) < 0.0, -1.0, 1.0)[:, None]
    across = (a * axes[..., 2]).sum(axis=-1)
    rate = np.stack([distance * across / momentum, np.zeros_like(across), momentum / distance**2], axis=-1)
    return FrameRotation(conjugate(quaternion), rate)


def _knots(pieces: PiecewisePolynomial) -> np.ndarray:
    """(m, 4): attitudes of the axes along the pieces without a flip; at the epoch as `from_matrix` has it."""
    t = pieces.start + pieces.length / IN_A_PIECE * np.arange(IN_A_PIECE * len(pieces.coefficients) + 1)
    q = from_matrix(_axes(evaluate(pieces, t), evaluate(pieces, t, 1))[0])
    flips = np.where((q[1:] * q[:-1]).sum(axis=-1) < 0.0, -1.0, 1.0)
    signs = np.concatenate([[1.0], np.cumprod(flips)])
    return q * (signs * signs[np.argmin(np.abs(t))])[:, None]


def _axes(r: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(n, 3, 3) whose columns are the axes; (n,) distance, m, and orbital momentum for each kg, m2/s."""
    distance, speed = (np.sqrt((vector**2).sum(axis=-1)) for vector in (r, v))
    normal = np.cross(r, v)
    momentum = np.sqrt((normal**2).sum(axis=-1))
    if not (momentum > LEAST_SINE * distance * speed).all():
        raise RegimeError("orbit: where the body moves along the radius its orbit has no plane")
    x, z = r / distance[:, None], normal / momentum[:, None]
    return np.stack([x, np.cross(z, x), z], axis=-1), distance, momentum

"""Positions and velocities along a course, in numpy: for plans, shadows, frames and tests."""

from __future__ import annotations

import math

import numpy as np

from ..kernels import layout
from ..problem.initial_state import OrbitPath, PiecewisePolynomial
from ..times import turn_rates

TAU = 2.0 * np.pi
# Newton's method from above converges at once but for eccentricities beside 1, and there from below 60 steps.
MOST_STEPS = 100


def position(course: OrbitPath, t: np.ndarray) -> np.ndarray:
    """(n, 3) m, inertial, from the central body; t (n,) s since the epoch."""
    return _state(course, np.asarray(t, dtype=float), 0)


def velocity(course: OrbitPath, t: np.ndarray) -> np.ndarray:
    """(n, 3) m/s, inertial."""
    return _state(course, np.asarray(t, dtype=float), 1)


def evaluate(pieces: PiecewisePolynomial, t: np.ndarray, derivative: int = 0) -> np.ndarray:
    """(n, 3): the vector, or a derivative by time, s; before and after, the outermost pieces hold."""
    count, degree = pieces.coefficients.shape[0], pieces.coefficients.shape[2] - 1
    place = (t - pieces.start) / pieces.length
    piece = np.clip(np.floor(place), 0, count - 1).astype(np.int64)
    x, coefficients = place - piece, pieces.coefficients[piece]
    value = np.zeros((t.size, 3))
    for k in range(degree, derivative - 1, -1):
        factor = math.perm(k, derivative)
        value = value * x[:, None] + factor * coefficients[:, :, k]
    return value / pieces.length**derivative


def eccentric_anomaly(mean: np.ndarray, e: float) -> np.ndarray:
    """E with E - e sin E = mean; mean (n,) rad, from -pi to pi.

    Newton's method on abs(mean), where the function is convex: started on the right of its zero it
    comes down to it and cannot leave.  Each stops on its own: the bits do not depend on the others.
    """
    size = np.abs(mean)
    E, going = np.minimum(size + e, np.pi), np.ones(size.shape, dtype=bool)
    for _ in range(MOST_STEPS):
        step = (E - e * np.sin(E) - size) / (1.0 - e * np.cos(E))
        E = np.where(going, E - step, E)
        going &= np.abs(step) > 1e-9  # its square is below rounding
        if not going.any():
            break
    return np.copysign(E, mean)


def least_distance(course: OrbitPath) -> float:
    """m: the nearest that the course comes to the central body; of pieces, at nine instants of each."""
    if course.numbers[0] == layout.KEPLER:
        return float(course.numbers[1] * (1.0 - course.numbers[2]))
    return float(np.sqrt((position(course, samples(course)) ** 2).sum(axis=1).min()))


def normals(course: OrbitPath) -> np.ndarray:
    """(n, 3): unit normals of the plane of the orbit, along it where it turns."""
    if course.numbers[0] == layout.KEPLER:
        return np.cross(course.numbers[7:10], course.numbers[10:13])[None]
    pieces = as_pieces(course)
    t = pieces.start + pieces.length * np.arange(len(pieces.coefficients) + 1)
    normal = np.cross(position(course, t), velocity(course, t))
    size = np.sqrt((normal**2).sum(axis=1))
    return normal[size > 0.0] / size[size > 0.0, None]  # a body falling straight down has none


def samples(course: OrbitPath) -> np.ndarray:
    """(n,) s: close together, for what is greatest on the course: 720 of a revolution, 9 of a piece."""
    if course.numbers[0] == layout.KEPLER:
        E = TAU * np.arange(-360, 360) / 720.0  # even in E: dense near the pericentre, and one there
        mean = (E - course.numbers[2] * np.sin(E)) / TAU
        return (mean - course.numbers[3]) * course.period
    pieces = as_pieces(course)
    return pieces.start + pieces.length * np.arange(8 * len(pieces.coefficients) + 1) / 8.0


def as_pieces(course: OrbitPath) -> PiecewisePolynomial:
    return PiecewisePolynomial(float(course.numbers[1]), float(course.numbers[2]), course.pieces)


def _state(course: OrbitPath, t: np.ndarray, derivative: int) -> np.ndarray:
    if course.numbers[0] == layout.TABLE:
        return evaluate(as_pieces(course), t, derivative)
    a, e, start, high, low, rate = course.numbers[1:7]
    P, Q = course.numbers[7:10], course.numbers[10:13]
    turn = start + turn_rates.fraction_of_turn(t, high, low)
    E = eccentric_anomaly(TAU * (turn - np.round(turn)), e)
    minor = np.sqrt((1.0 - e) * (1.0 + e))
    if derivative == 0:
        x, y = a * (np.cos(E) - e), a * minor * np.sin(E)
    else:
        speed = a * rate / (1.0 - e * np.cos(E))
        x, y = -speed * np.sin(E), speed * minor * np.cos(E)
    return x[:, None] * P + y[:, None] * Q

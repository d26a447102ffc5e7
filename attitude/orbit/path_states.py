"""Positions and velocities on an orbit, in numpy: for plans, shadows, frames and tests."""

from __future__ import annotations

import math

import numpy as np

from ..kernels.layout import Ellipse
from ..problem.initial_state import OrbitPath
from ..samples.ephemeris_data import OrbitLimits
from ..times import turn_rates


def position(path: OrbitPath, t: np.ndarray) -> np.ndarray:
    """(n, 3) m, inertial, from the central body; t (n,) s since the epoch."""
    return state(path, np.asarray(t, dtype=float), 0)


def velocity(path: OrbitPath, t: np.ndarray) -> np.ndarray:
    """(n, 3) m/s, inertial; t (n,) s since the epoch."""
    t = np.asarray(t, dtype=float)
    own = path.velocity_polynomial
    return state(path, t, 1) if own is None else own(t)


def eccentric_anomaly(mean: np.ndarray, e: float) -> np.ndarray:
    """E with E - e sin E = mean; mean (n,) rad, from -pi to pi.

    Newton's method on abs(mean), where the function is convex: started on the right of its root it
    approaches it from there.  Each element stops on its own: its bits do not depend on the others.

    `kernels.solvers.orbit_path` solves the same equation inside compiled loops, with fused operations that
    numpy does not have; its last bits differ, and a plan needs no compiler with this one.
    """
    size = np.abs(mean)
    E, active = np.minimum(size + e, np.pi), np.ones(size.shape, dtype=bool)
    for _ in range(100):  # it converges at once but for eccentricities beside 1, and there in below 60 steps
        step = (E - e * np.sin(E) - size) / (1.0 - e * np.cos(E))
        E = np.where(active, E - step, E)
        active &= np.abs(step) > 1e-9  # its square is below rounding
        if not active.any():
            break
    return np.copysign(E, mean)


def hyperbolic_anomaly(mean: np.ndarray, e: float) -> np.ndarray:
    """H with e sinh H - H = mean; mean (n,), e > 1.

    Newton's method on abs(mean), where the function is convex, from the right of its root: e sinh H - H is
    more than (e - 1) sinh H and than e H^3 / 6.
    """
    size = np.abs(mean)
    H, active = np.minimum(np.arcsinh(size / (e - 1.0)), np.cbrt(6.0 * size / e)), size > 0.0
    for _ in range(100):
        step = (e * np.sinh(H) - H - size) / np.where(active, e * np.cosh(H) - 1.0, 1.0)
        H = np.where(active, H - step, H)
        active &= np.abs(step) > 1e-9 * np.maximum(1.0, H)  # its square is below rounding
        if not active.any():
            break
    return np.copysign(H, mean)


def least_distance(path: OrbitPath) -> float:
    """Least distance from the central body, m; of a table at nine instants of each interval."""
    if path.is_keplerian:
        return float(path.numbers[Ellipse.SEMI_MAJOR_AXIS] * (1.0 - path.numbers[Ellipse.ECCENTRICITY]))
    return float(np.sqrt((position(path, samples(path)) ** 2).sum(axis=1).min()))


def limits(path: OrbitPath) -> OrbitLimits:
    """Bounds on the motion along a path: of an ellipse at its apsides, of a table by its coefficients.

    On an interval of polynomials of x from -1 to 1 a derivative is at most the sum of its coefficients'
    lengths, some tens of percent above the greatest where intervals are short parts of a revolution.
    """
    if path.is_keplerian:
        a, e = path.numbers[Ellipse.SEMI_MAJOR_AXIS], path.numbers[Ellipse.ECCENTRICITY]
        rate = path.numbers[Ellipse.MEAN_MOTION]
        speed = a * rate * math.sqrt((1.0 + e) / (1.0 - e))
        return OrbitLimits(float(speed), float(a * rate**2 / (1.0 - e) ** 2), float(a * (1.0 - e)), 0.0)
    polynomial = path.polynomial
    size = np.linalg.norm(polynomial.coefficients, axis=1)
    k = np.arange(size.shape[1])
    speed = float((size @ k).max() / (0.5 * polynomial.length))
    acceleration = float((size @ (k * (k - 1))).max() / (0.5 * polynomial.length) ** 2)
    distance = np.sqrt((position(path, samples(path)) ** 2).sum(axis=1))
    reach = speed * polynomial.length / 16.0  # to the nearest of the samples
    greatest = float(distance.max()) + reach
    return OrbitLimits(speed, acceleration, float(distance.min()) - reach, greatest * acceleration)


def ellipse_axes(path: OrbitPath) -> tuple[np.ndarray, np.ndarray]:
    """(3,) each: unit vectors of an ellipse to the pericentre and along the motion there, inertial."""
    return path.numbers[Ellipse.P : Ellipse.P + 3], path.numbers[Ellipse.Q : Ellipse.Q + 3]


def normals(path: OrbitPath) -> np.ndarray:
    """(n, 3): unit normals of the orbital plane; of a table at the ends of its intervals."""
    if path.is_keplerian:
        return np.cross(*ellipse_axes(path))[None]
    polynomial = path.polynomial
    t = polynomial.start + polynomial.length * np.arange(len(polynomial.coefficients) + 1)
    normal = np.cross(position(path, t), velocity(path, t))
    size = np.linalg.norm(normal, axis=1)
    return normal[size > 0.0] / size[size > 0.0, None]  # a body falling straight down has none


def samples(path: OrbitPath) -> np.ndarray:
    """(n,) s: instants dense enough to find maxima along the orbit: 720 a revolution, 9 an interval."""
    if path.is_keplerian:
        E = math.tau * np.arange(-360, 360) / 720.0  # even in E: dense near the pericentre, and one there
        mean = (E - path.numbers[Ellipse.ECCENTRICITY] * np.sin(E)) / math.tau
        return (mean - path.numbers[Ellipse.MEAN_ANOMALY]) * path.period
    polynomial = path.polynomial
    return polynomial.start + polynomial.length * np.arange(8 * len(polynomial.coefficients) + 1) / 8.0


def state(path: OrbitPath, t: np.ndarray, derivative: int) -> np.ndarray:
    """(n, 3): position, m, or its first derivative, m/s, inertial; t (n,) s since the epoch."""
    if not path.is_keplerian:
        return path.polynomial(t, derivative)
    a, e, start, high, low, rate = path.numbers[Ellipse.SEMI_MAJOR_AXIS : Ellipse.P]
    P, Q = ellipse_axes(path)
    turn = start + turn_rates.fraction_of_turn(t, high, low)
    E = eccentric_anomaly(math.tau * (turn - np.round(turn)), e)
    minor = np.sqrt((1.0 - e) * (1.0 + e))
    if derivative == 0:
        x, y = a * (np.cos(E) - e), a * minor * np.sin(E)
    else:
        speed = a * rate / (1.0 - e * np.cos(E))
        x, y = -speed * np.sin(E), speed * minor * np.cos(E)
    return x[:, None] * P + y[:, None] * Q

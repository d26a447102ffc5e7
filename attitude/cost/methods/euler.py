"""Euler's equations of free motion, compiled, as the integrators take them.

Principal axes, and time in a unit that makes the body rate of order one: y = (q, w), and

    q' = q w / 2,     w1' = (I2 - I3) / I1  w2 w3   (and cyclic).

Both are quadratic in y, so that a second derivative costs two more products.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ..initial_value_problem import InitialValueProblem
from ..method import AbsentError
from .principal_frame import exponent, principal_axes

try:
    from numba import njit
except ModuleNotFoundError:  # as in the container image, whose other kernels are built ahead
    njit = None


def routine(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that kernels call."""
    return function if njit is None else njit(error_model="numpy")(function)


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that Python calls; cached on disk where numba can write."""
    if njit is None:
        return _absent
    try:
        return njit(cache=True, error_model="numpy", nogil=True)(function)
    except RuntimeError:  # no writable cache directory
        return njit(error_model="numpy", nogil=True)(function)


def _absent(*_: Any) -> None:
    """Raise, rather than measure interpreted Python in place of the method."""
    raise AbsentError("numba, which compiles the equations of motion, is not installed: pip install numba")


@dataclass(frozen=True)
class FreeEquations:
    """Euler's equations of one body, and its initial state.

    Attributes
    ----------
    k : (3,); (I2 - I3) / I1 and cyclic
    start : (7,), wxyz and rate, rad a unit of time
    second : units of time in a second; a power of two, so that instants keep their bits
    axes : of the principal frame in the body frame; None where the frames coincide
    """

    k: np.ndarray
    start: np.ndarray
    second: float
    axes: Rotation | None

    @classmethod
    def of(cls, problem: InitialValueProblem) -> FreeEquations:
        """Equations of a free body."""
        (I1, I2, I3), columns = principal_axes(problem)
        attitude, rate, axes = problem.attitude, problem.angular_velocity, None
        if problem.moments is None:
            axes = Rotation.from_matrix(columns)
            attitude = (Rotation.from_quat(attitude, scalar_first=True) * axes).as_quat(scalar_first=True)
            rate = rate @ columns
        second = 2.0 ** exponent(rate)
        k = np.array([(I2 - I3) / I1, (I3 - I1) / I2, (I1 - I2) / I3])
        return cls(k, np.concatenate([attitude, rate / second]), second, axes)

    def to_body(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n, 7) states as unit quaternions (n, 4) and rates (n, 3), rad/s, in the body frame."""
        attitudes, rates = np.empty((len(y), 4)), np.empty((len(y), 3))
        normalise(y, self.second, attitudes, rates)
        if self.axes is None:
            return attitudes, rates
        q = Rotation.from_quat(attitudes, scalar_first=True) * self.axes.inv()
        return q.as_quat(scalar_first=True), self.axes.apply(rates)


@kernel
def normalise(y, second, attitudes, rates):
    """Write states (n, 7) as unit quaternions (n, 4) and rates (n, 3), rad/s."""
    for j in range(len(y)):
        norm = 1.0 / np.sqrt(y[j, 0] ** 2 + y[j, 1] ** 2 + y[j, 2] ** 2 + y[j, 3] ** 2)
        for i in range(4):
            attitudes[j, i] = y[j, i] * norm
        for i in range(3):
            rates[j, i] = y[j, 4 + i] * second


@routine
def product(u, v, k):
    """The bilinear form of which y' = product(y, y)."""
    return (
        -0.5 * (u[1] * v[4] + u[2] * v[5] + u[3] * v[6]),
        0.5 * (u[0] * v[4] + u[2] * v[6] - u[3] * v[5]),
        0.5 * (u[0] * v[5] + u[3] * v[4] - u[1] * v[6]),
        0.5 * (u[0] * v[6] + u[1] * v[5] - u[2] * v[4]),
        k[0] * u[5] * v[6],
        k[1] * u[6] * v[4],
        k[2] * u[4] * v[5],
    )


@kernel
def derivative(y, k):
    """y', (7,)."""
    return np.array(product(y, y, k))


@routine
def add_scaled(y, h, f):
    """y + h f."""
    return (
        y[0] + h * f[0],
        y[1] + h * f[1],
        y[2] + h * f[2],
        y[3] + h * f[3],
        y[4] + h * f[4],
        y[5] + h * f[5],
        y[6] + h * f[6],
    )


@routine
def step(y, h, k):
    """One step of the classical fourth-order method, the quaternion normalised."""
    f1 = product(y, y, k)
    y2 = add_scaled(y, 0.5 * h, f1)
    f2 = product(y2, y2, k)
    y3 = add_scaled(y, 0.5 * h, f2)
    f3 = product(y3, y3, k)
    y4 = add_scaled(y, h, f3)
    f4 = product(y4, y4, k)
    z = add_scaled(add_scaled(add_scaled(add_scaled(y, h / 6.0, f1), h / 3.0, f2), h / 3.0, f3), h / 6.0, f4)
    norm = 1.0 / np.sqrt(z[0] * z[0] + z[1] * z[1] + z[2] * z[2] + z[3] * z[3])
    return z[0] * norm, z[1] * norm, z[2] * norm, z[3] * norm, z[4], z[5], z[6]


@routine
def hermite(y0, y1, h, k, c):
    """Write to c (6, 7) the coefficients of the quintic through both ends of a step and two derivatives."""
    f0, f1 = product(y0, y0, k), product(y1, y1, k)
    g0 = add_scaled(product(y0, f0, k), 1.0, product(f0, y0, k))
    g1 = add_scaled(product(y1, f1, k), 1.0, product(f1, y1, k))
    for i in range(7):
        c1, c2 = h * f0[i], 0.5 * h * h * g0[i]
        D, E, F = y1[i] - y0[i] - c1 - c2, h * f1[i] - c1 - 2.0 * c2, h * h * g1[i] - 2.0 * c2
        c[0, i], c[1, i], c[2, i] = y0[i], c1, c2
        c[3, i], c[4, i], c[5, i] = (
            10.0 * D - 4.0 * E + 0.5 * F,
            7.0 * E - 15.0 * D - F,
            6.0 * D - 3.0 * E + 0.5 * F,
        )


@kernel
def runge_kutta(start, k, h, t, out, halted):
    """Write states (n, 7) at ascending instants t, by steps of h from 0; halted : as in `kernels.solvers`.

    Between steps a quintic interpolates: its error is far below that of the steps at any h, and it is cheaper
    than shortened steps where samples are dense.
    """
    steps, has_quintic, c = 0, False, np.empty((6, 7))
    y0 = (start[0], start[1], start[2], start[3], start[4], start[5], start[6])
    y1 = step(y0, h, k)
    for j in range(t.size):
        while t[j] > (steps + 1) * h and halted[0] == 0.0:
            steps, y0, y1, has_quintic = steps + 1, y1, step(y1, h, k), False
        if not has_quintic:
            hermite(y0, y1, h, k, c)
            has_quintic = True
        s = (t[j] - steps * h) / h
        for i in range(7):
            out[j, i] = c[0, i] + s * (c[1, i] + s * (c[2, i] + s * (c[3, i] + s * (c[4, i] + s * c[5, i]))))

"""Paths on piecewise polynomials that interpolate a function of time and are checked against it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from .. import stopping
from ..errors import InputError
from ..kernels.layout import ORBIT_WIDTH, OrbitCode
from ..problem.initial_state import CentralBody, OrbitPath, PiecewisePolynomial

PIECES_PER_REVOLUTION = 12  # the longest
# Degree 9 over a twelfth of a revolution leaves 1e-15 of a circle, and rounding in powers of -1 to 1 3e-13;
# an ellipse takes more intervals.
DEGREE = 9
MAX_INTERVALS = 200_000
BLOCK_INSTANTS = 1 << 14  # at which a function is evaluated at once
# Parts of an interval: beside the end, where intervals meet, and halfway between Chebyshev points.
BETWEEN = np.concatenate([[1e-3], 0.5 - 0.5 * np.cos(np.pi * np.arange(1, DEGREE + 1) / (DEGREE + 1))])

VectorFunction = Callable[[np.ndarray], np.ndarray]


def function_path(
    function: VectorFunction,
    span: tuple[float, float],
    period: float,
    central: CentralBody,
    tolerance: float,
    field: str,
) -> OrbitPath:
    """Return the path of a function of time: interpolated to a tolerance, relative to the distance.

    `refined` goes through it in intervals half as long, so that what interpolation leaves is in the bound.

    Parameters
    ----------
    function : (n,) s -> (n, 3) m, or (n, 6) m and m/s
    span : s, from where to where it is interpolated
    period : s, of one revolution, or in which the path bends as much
    field : named in the error where it takes too many polynomials
    """
    start, stop = span
    polynomial = interpolated(function, start, stop, period / PIECES_PER_REVOLUTION, tolerance, field)
    refined = interpolated_evenly(function, start, stop, 2 * len(polynomial.coefficients))
    return tabulated_path(polynomial, period, central, refined)


def tabulated_path(
    polynomial: PiecewisePolynomial,
    period: float,
    central: CentralBody,
    refined: PiecewisePolynomial | None = None,
) -> OrbitPath:
    """Return the path on piecewise polynomials of positions, or of positions and velocities; period in s."""
    numbers = np.zeros(ORBIT_WIDTH)
    numbers[:3] = OrbitCode.TABLE, polynomial.start, polynomial.length
    both = polynomial.coefficients
    positions, velocities = np.ascontiguousarray(both[:, :3]), both[:, 3:] if both.shape[1] > 3 else None
    better = None if refined is None else tabulated_path(refined, period, central)
    return OrbitPath(numbers, positions, period, central, better, velocities)


def interpolated(
    function: VectorFunction,
    start: float,
    stop: float,
    step: float,
    tolerance: float,
    field: str,
    least_step: float = 0.0,
) -> PiecewisePolynomial:
    """Polynomials through the function's values at the Chebyshev points of equal intervals.

    Parameters
    ----------
    function : (n,) s -> (n, 3) m, or with another vector (n, 6); evaluated within start to stop only
    step : s, the longest interval; halved until the error of the first vector is below tolerance times its
        length at ten points of every interval, halfway between those the polynomial goes through
    field : named in the error if that takes more than MAX_INTERVALS
    least_step : s, below which no interval is halved, whatever the error is

    Raises
    ------
    InputError : too many intervals; or the function has a zero, where no relative error is defined.
    """
    count = max(1, math.ceil((stop - start) / step))
    error = math.inf
    while count <= MAX_INTERVALS:
        polynomial = interpolated_evenly(function, start, stop, count)
        error = _relative_error(function, polynomial)
        if error <= tolerance or polynomial.length <= 2.0 * least_step:
            return polynomial
        count *= 2
    value = f"{stop - start:g} s" + (f", error {error:.1e}" if math.isfinite(error) else "")
    expected = f"positions that {MAX_INTERVALS} polynomials interpolate within {tolerance:g}"
    raise InputError(field, value, expected)


def interpolated_evenly(
    function: VectorFunction, start: float, stop: float, count: int
) -> PiecewisePolynomial:
    """Polynomials through the function's values at the Chebyshev points of so many equal intervals."""
    length = (stop - start) / count
    nodes, to_powers = _chebyshev()
    t = start + length * (np.arange(count)[:, None] + nodes)
    values = _in_blocks(function, t.reshape(-1)).reshape(count, DEGREE + 1, -1)
    coefficients = np.ascontiguousarray(np.einsum("kj,pji->pik", to_powers, values))
    return PiecewisePolynomial(start, length, coefficients)


def interpolated_between(
    function: VectorFunction, ends: np.ndarray, lengths: tuple[float, float], tolerance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Polynomials through a function's values between instants at which it is not smooth.

    Parameters
    ----------
    function : (n,) s -> (n,); evaluated within the ends only
    ends : (k,) s, ascending, at which pieces end
    lengths : s, of the shortest and the longest piece; one is halved until the error is below the
        tolerance at points between those the polynomial goes through, or the halves would be shorter

    Returns
    -------
    starts, lengths : (n,) s, ascending; coefficients : (n, DEGREE + 1), as of a PiecewisePolynomial
    """
    nodes, to_powers = _chebyshev()
    shortest, longest = lengths
    counts = np.maximum(1, np.ceil(np.diff(ends) / longest)).astype(int)
    length = np.repeat(np.diff(ends) / counts, counts)
    index = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    start = np.repeat(ends[:-1], counts) + length * index
    x = 2.0 * BETWEEN - 1.0
    pieces = []
    while start.size:
        at = start[:, None] + length[:, None] * np.concatenate([nodes, BETWEEN])
        values = _in_blocks(function, at.reshape(-1)).reshape(at.shape)
        coefficients = values[:, : DEGREE + 1] @ to_powers.T
        error = np.abs(np.polynomial.polynomial.polyval(x, coefficients.T) - values[:, DEGREE + 1 :])
        done = (error.max(axis=1) <= tolerance) | (length < 2.0 * shortest)
        pieces.append((start[done], length[done], coefficients[done]))
        start, length = np.repeat(start[~done], 2), np.repeat(0.5 * length[~done], 2)
        start[1::2] += length[1::2]
    start, length, coefficients = (np.concatenate(parts) for parts in zip(*pieces, strict=True))
    order = np.argsort(start)
    return start[order], length[order], coefficients[order]


def _in_blocks(function: VectorFunction, t: np.ndarray) -> np.ndarray:
    """The function's values at t, of which a million take seconds."""
    values = []
    for first in range(0, t.size, BLOCK_INSTANTS):
        stopping.check()
        values.append(function(t[first : first + BLOCK_INSTANTS]))
    return np.concatenate(values)


def _relative_error(function: VectorFunction, polynomial: PiecewisePolynomial) -> float:
    """Greatest distance from the function over its length, between the nodes."""
    intervals = np.arange(len(polynomial.coefficients))[:, None]
    t = (polynomial.start + polynomial.length * (intervals + BETWEEN)).reshape(-1)
    expected = _in_blocks(function, t)[:, :3]
    error = np.sqrt(((polynomial(t)[:, :3] - expected) ** 2).sum(axis=1))
    length = np.linalg.norm(expected, axis=1)
    return float((error / length).max()) if (length > 0.0).all() else math.inf


@cache
def _chebyshev() -> tuple[np.ndarray, np.ndarray]:
    """(nodes from 0 to 1, matrix from the values there to coefficients of powers).

    Through the coefficients of Chebyshev polynomials, which a sum over the nodes gives without
    cancellation; theirs in powers are whole numbers.
    """
    n = DEGREE + 1
    angle = np.pi * (np.arange(n) + 0.5) / n
    series = 2.0 / n * np.cos(np.arange(n)[:, None] * angle)
    series[0] *= 0.5
    powers = np.zeros((n, n))
    for k in range(n):
        powers[: k + 1, k] = np.polynomial.chebyshev.cheb2poly(np.eye(n)[k])
    return 0.5 + 0.5 * np.cos(angle), powers @ series

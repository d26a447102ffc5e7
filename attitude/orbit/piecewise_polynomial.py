"""A vector that some function gives, as polynomials in time that are checked against it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from ..errors import InputError
from ..problem.initial_state import PiecewisePolynomial
from .path_states import evaluate

# Degree 9 over a twelfth of a revolution leaves 1e-12 of a circle; an ellipse takes more pieces.
DEGREE = 9
MOST_PIECES = 200_000


def sampled(
    function: Callable[[np.ndarray], np.ndarray],
    start: float,
    stop: float,
    step: float,
    tolerance: float,
    field: str,
) -> PiecewisePolynomial:
    """Polynomials through the function's values at the Chebyshev points of equal pieces.

    Parameters
    ----------
    function : (n,) s -> (n, 3) m; asked for nothing outside start to stop
    step : s, the longest piece; halved until the error is below tolerance times the vector's length
        at ten points of every piece, halfway between those the polynomial goes through
    field : what to name if that takes more than MOST_PIECES

    Raises
    ------
    InputError : too many pieces; or the function has a zero, beside which no such tolerance is.
    """
    count = max(1, math.ceil((stop - start) / step))
    error = math.inf
    while count <= MOST_PIECES:
        pieces = _interpolated(function, start, (stop - start) / count, count)
        error = _error(function, pieces)
        if error <= tolerance:
            return pieces
        count *= 2
    found = f"{stop - start:g} s" + (f", error {error:.1e}" if math.isfinite(error) else "")
    raise InputError(field, found, f"a course that {MOST_PIECES} polynomials can follow within {tolerance:g}")


def _interpolated(
    function: Callable[[np.ndarray], np.ndarray], start: float, length: float, count: int
) -> PiecewisePolynomial:
    nodes, to_powers = _chebyshev()
    t = start + length * (np.arange(count)[:, None] + nodes)
    values = function(t.reshape(-1)).reshape(count, DEGREE + 1, 3)
    return PiecewisePolynomial(
        start, length, np.ascontiguousarray(np.einsum("kj,pji->pik", to_powers, values))
    )


def _error(function: Callable[[np.ndarray], np.ndarray], pieces: PiecewisePolynomial) -> float:
    """Greatest distance from the function, over its length."""
    k = np.arange(1, DEGREE + 1)
    between = 0.5 - 0.5 * np.cos(np.pi * k / (DEGREE + 1))
    places = np.concatenate([[1e-3], between])  # and beside the end, where pieces meet
    t = (pieces.start + pieces.length * (np.arange(len(pieces.coefficients))[:, None] + places)).reshape(-1)
    expected = function(t)
    off = np.sqrt(((evaluate(pieces, t) - expected) ** 2).sum(axis=1))
    length = np.sqrt((expected**2).sum(axis=1))
    return float((off / length).max()) if (length > 0.0).all() else math.inf


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
        basis = np.polynomial.chebyshev.cheb2poly(np.eye(n)[k])
        shifted = np.polynomial.Polynomial(basis)(np.polynomial.Polynomial([-1.0, 2.0]))
        powers[: k + 1, k] = shifted.coef
    return 0.5 + 0.5 * np.cos(angle), powers @ series

"""Paths on piecewise polynomials: of SGP4, of secular rates, of hyperbolas and of tables."""

from __future__ import annotations

import numpy as np

from ..kernels.layout import ORBIT_WIDTH, OrbitCode
from ..problem.initial_state import CentralBody, OrbitPath, PiecewisePolynomial
from .piecewise_polynomial import VectorFunction, interpolated, interpolated_evenly

PIECES_PER_REVOLUTION = 12


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

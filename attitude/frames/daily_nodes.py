"""Slow functions of the date, interpolated between nodes of every three hours: series that cost microseconds.

The polynomial goes through the nearest six nodes: the error of a term of amplitude a and angular rate w per
day is below 0.005 a (w / 8)^6.  For the fastest term of the pole, 0.03 arcseconds in 9 days, that is 1e-15
rad; for the Sun's direction, 6 arcseconds in 27 days, less.  Nodes do not depend on the instants of a call.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from ..stopping import check
from ..times.instants import Instants
from ..times.julian_dates import DAY, J2000

NODES_PER_DAY, NEAREST = 8, 6


class Days(NamedTuple):
    """Days since J2000.0: whole ones, and the fraction, from 0 to 1."""

    whole: np.ndarray
    fraction: np.ndarray

    @classmethod
    def of_tai(cls, instants: Instants) -> Days:
        """Days of TAI of (n,) dated instants; InputError without an epoch."""
        whole, fraction = instants.tai
        return cls(whole - J2000, fraction).plus(0.0)

    def plus(self, days: np.ndarray | float) -> Days:
        """The sum, normalized."""
        fraction = self.fraction + days
        whole = np.floor(fraction)
        return Days(self.whole + whole, fraction - whole)

    @property
    def sum(self) -> np.ndarray:
        """Both parts as one double."""
        return self.whole + self.fraction


def interpolated(function: Callable[[np.ndarray], np.ndarray], days: Days) -> tuple[np.ndarray, np.ndarray]:
    """Values (k, n) of a function at dates (n,), and their rates of change, per second.

    function : of days since J2000.0 (m,), of the nodes, returns (k, m)
    """
    position = NODES_PER_DAY * days.fraction
    interval = np.minimum(np.floor(position), NODES_PER_DAY - 1)
    intervals, inverse = _distinct((NODES_PER_DAY * days.whole + interval).astype(np.int64))
    coefficients = _polynomials(function, intervals)
    x = position - interval
    values, slopes = np.zeros((coefficients.shape[1], x.size)), np.zeros((coefficients.shape[1], x.size))
    for coefficient in coefficients[::-1, :, inverse]:
        slopes = slopes * x + values
        values = values * x + coefficient
    return values, slopes * (NODES_PER_DAY / DAY)


def _distinct(numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ascending whole numbers that include all of these, and the index of each of these among them."""
    if not numbers.size:
        return numbers.reshape(-1), numbers
    first, last = int(numbers.min()), int(numbers.max())
    if last - first <= numbers.size // 8:  # they are close to each other: none are sorted
        return np.arange(first, last + 1), numbers - first
    distinct, inverse = np.unique(numbers, return_inverse=True)
    return distinct, inverse.reshape(numbers.shape)


def _polynomials(function: Callable[[np.ndarray], np.ndarray], intervals: np.ndarray) -> np.ndarray:
    """(NEAREST, k, n): coefficients of the values in powers of the position, 0 to 1, in n intervals."""
    nodes = intervals[:, None] + (np.arange(NEAREST) - (NEAREST // 2 - 1))
    distinct, inverse = _distinct(nodes)
    days, pieces, size = distinct / NODES_PER_DAY, [], 4096  # nodes of the Sun take 0.1 s
    for first in range(0, max(1, days.size), size):
        check()
        pieces.append(function(days[first : first + size]))
    values = np.concatenate(pieces, axis=1)[:, inverse]
    return np.array([(values * weights).sum(axis=-1) for weights in _lagrange()])


@cache
def _lagrange() -> np.ndarray:
    """(NEAREST, NEAREST): row k has the weight of each node's value in the coefficient of the k-th power.

    The nodes are the integers from -2 to 3; the polynomial is evaluated between 0 and 1.
    """
    nodes = np.arange(NEAREST) - (NEAREST // 2 - 1)
    columns = []
    for i, node in enumerate(nodes):
        others = np.delete(nodes, i)
        columns.append(np.polynomial.polynomial.polyfromroots(others) / np.prod(node - others))
    return np.array(columns).T

"""Gauss's nodes and weights, and integrals of polynomials through the nodes, in the longest numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class GaussScheme(NamedTuple):
    """Gauss's scheme of n nodes on the interval from -1 to 1, in the processor's longest numbers.

    Attributes
    ----------
    nodes : (n,), increasing
    weights : (n,), of the interval from 0 to 1
    to_coefficients : (n, n), node by degree: values at the nodes to Legendre coefficients
    integrals : (n, n), degree by node: of each polynomial up to each node, over an interval of length 1
    """

    nodes: np.ndarray
    weights: np.ndarray
    to_coefficients: np.ndarray
    integrals: np.ndarray


def gauss_scheme(count: int) -> GaussScheme:
    """The scheme of so many nodes.

    Nodes and weights are Newton's from numpy's.  The weights of the integrals up to a node, and of the
    Legendre coefficients, are those of Legendre's polynomials P_k, each of which is integrated exactly:

        int_-1^y P_k = (P_{k+1} - P_{k-1}) / (2 k + 1),    c_k = (2 k + 1) / 2 sum w P_k f
    """
    y = np.polynomial.legendre.leggauss(count)[0].astype(np.longdouble)
    for _ in range(2):
        p = _legendre(y)
        y = y - p[count] * (y * y - 1.0) / (count * (y * p[count] - p[count - 1]))
    p, k = _legendre(y), np.arange(count)
    weights = (1.0 - y * y) / (count * p[count - 1]) ** 2
    to_coefficients = (2 * k + 1) * (weights * p[:count]).T
    integrals = np.concatenate([[y + 1.0], p[2:] - p[: count - 1]]) / (4 * k + 2)[:, None]
    return GaussScheme(y, weights, to_coefficients, integrals)


def _legendre(y: np.ndarray) -> np.ndarray:
    """(n + 1, n): Legendre's polynomials of degrees 0 to n at n places."""
    p = [np.ones_like(y), y]
    for n in range(1, y.size):
        p.append(((2 * n + 1) * y * p[n] - n * p[n - 1]) / (n + 1))
    return np.array(p)

"""How readers of other tools find attitudes between those of a file, and how far off that is.

slerp      constant rate from node to node, along the shorter arc
lagrange   of each component, the polynomial through the nearest nodes; brought to unit length
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .. import orientation
from ..errors import InputError
from ..runtime import compiled
from ..runtime.threads import cut, run
from .rows import WORTH_SHARING, cores

MOST_DEGREE = 15


class Interpolant(NamedTuple):
    """`kind` is "slerp" or "lagrange", then of polynomials of the `degree`."""

    kind: str
    degree: int = 1

    def __str__(self) -> str:
        return "slerp" if self.kind == "slerp" else f"Lagrange, degree {self.degree}"

    @property
    def order(self) -> int:
        """Power of the spacing that errors fall with."""
        return self.degree + 1

    def errors(self, t: np.ndarray, nodes: np.ndarray, true: np.ndarray, first: int = 0) -> np.ndarray:
        """(m,) rad: at the midpoints of the m intervals that begin with the node `first`.

        t : (n,) s, increasing; nodes : (n, 4) wxyz; true : (m, 4), the attitudes there
        """
        if self.kind == "slerp":
            found = _slerp_middle(nodes[first : first + len(true)], nodes[first + 1 : first + len(true) + 1])
            return np.asarray(orientation.angle_between(found, true))
        size = np.empty(len(true))
        parts, width = _by_component(nodes), min(self.degree, len(t) - 1)
        given = np.ascontiguousarray(t), parts, first, width
        wanted = _by_component(true)

        def interpolate(share: tuple[int, int]) -> None:
            compiled.interpolate(*given, *share, wanted, size)

        run(interpolate, cut(len(true), min(cores(), max(1, len(true) // WORTH_SHARING))))
        return 2.0 * np.arcsin(np.minimum(size, 1.0))


def lagrange(degree: int, field: str) -> Interpolant:
    """Of this degree; InputError, of the field that holds it, for one that nobody should interpolate with."""
    if isinstance(degree, bool) or not isinstance(degree, int) or not 1 <= degree <= MOST_DEGREE:
        raise InputError(field, degree, f"a whole number from 1 to {MOST_DEGREE}")
    return Interpolant("lagrange", degree)


def _by_component(q: np.ndarray) -> np.ndarray:
    """(4, n) of (n, 4)."""
    return np.ascontiguousarray(q.T)


def _slerp_middle(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Half-way along the shorter arc: the sum, brought to unit length."""
    return _unit(p + np.where((p * q).sum(axis=-1, keepdims=True) < 0.0, -q, q))


def _unit(q: np.ndarray) -> np.ndarray:
    """A sum of attitudes half a turn apart has no direction; one of them is as wrong as any."""
    length = np.sqrt((q * q).sum(axis=-1, keepdims=True))
    return np.where(length > 0.0, q / np.where(length > 0.0, length, 1.0), [1.0, 0.0, 0.0, 0.0])

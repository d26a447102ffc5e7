"""How readers of other tools find attitudes between those of a file, and how far off that is.

slerp      constant rate from node to node, along the shorter arc
lagrange   of each component, the polynomial through the nearest nodes; brought to unit length
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..frames import rotations
from ..runtime import compiled
from ..runtime.threads import processors, ranges, run

MOST_DEGREE = 15
MIN_INTERVALS_PER_THREAD = 4096
MAX_THREADS = 4


class Interpolant(NamedTuple):
    """`kind` is "slerp" or "lagrange", then of polynomials of the `degree`.

    crosses : whether its readers know no segments, and interpolate from the last node of one to the next
    """

    kind: str
    degree: int = 1
    crosses: bool = False

    def __str__(self) -> str:
        return "slerp" if self.kind == "slerp" else f"Lagrange, degree {self.degree}"

    @property
    def order(self) -> int:
        """Power of the spacing that errors fall with."""
        return self.degree + 1

    def errors(
        self, t: np.ndarray, nodes: np.ndarray, intervals: np.ndarray, places: np.ndarray, true: np.ndarray
    ) -> np.ndarray:
        """(m,) rad: of each interval the greatest error at these places of it.

        t : (n,) s, increasing; nodes : (n, 4) wxyz; intervals : (m,) int, the node that each begins with;
        places : (p,), fractions of an interval; true : (m * p, 4), the attitudes there
        """
        size = np.empty(len(intervals))
        width = 0 if self.kind == "slerp" else min(self.degree, len(t) - 1)
        signed = rotations.sign_continuous(nodes)  # as writers of polynomials have them
        given = (
            np.ascontiguousarray(t),
            _by_component(signed),
            np.ascontiguousarray(intervals, dtype=np.int64),
        )
        wanted = _by_component(true)

        def interpolate(share: tuple[int, int]) -> None:
            work, shared = np.empty((5, len(places))), np.empty((3, width + 1))
            compiled.interpolate(*given, *share, width, places, wanted, work, shared, size)

        threads = min(processors(), MAX_THREADS, max(1, size.size // MIN_INTERVALS_PER_THREAD))
        run(interpolate, ranges(size.size, threads))
        return 2.0 * np.arcsin(np.minimum(size, 1.0))


def lagrange(degree: int, field: str) -> Interpolant:
    """Of this degree; InputError, of the field that holds it, for one that nobody should interpolate with."""
    if isinstance(degree, bool) or not isinstance(degree, int) or not 1 <= degree <= MOST_DEGREE:
        raise InputError(field, degree, f"a whole number from 1 to {MOST_DEGREE}")
    return Interpolant("lagrange", degree)


def _by_component(q: np.ndarray) -> np.ndarray:
    """(4, n) of (n, 4)."""
    return np.ascontiguousarray(q.T)

"""Interpolation as readers of files do it, and its error.

slerp      constant rate from node to node, along the shorter arc
lagrange   polynomial through the nearest nodes, of each component; then normalised
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..frames import rotations
from ..runtime import compiled
from ..runtime.threads import processors, ranges, run

MAX_DEGREE = 15


class Interpolant(NamedTuple):
    """How readers interpolate.

    kind : "slerp" or "lagrange"
    degree : of the polynomials; 1 for slerp
    crosses : whether readers know no segments, and interpolate from the last node of one to the next
    """

    kind: str
    degree: int = 1
    crosses: bool = False

    def __str__(self) -> str:
        return "slerp" if self.kind == "slerp" else f"Lagrange, degree {self.degree}"

    @property
    def order(self) -> int:
        """Power of the spacing to which errors are proportional."""
        return self.degree + 1

    def errors(
        self, t: np.ndarray, nodes: np.ndarray, intervals: np.ndarray, fractions: np.ndarray, true: np.ndarray
    ) -> np.ndarray:
        """(m,) rad: greatest error in each interval, at fractions of it.

        t : (n,) s, increasing; nodes : (n, 4) wxyz; intervals : (m,) int, the node at which each begins;
        fractions : (p,), of an interval; true : (m * p, 4), the attitudes there
        """
        sines = np.empty(len(intervals))
        width = 0 if self.kind == "slerp" else min(self.degree, len(t) - 1)
        signed = rotations.sign_continuous(nodes)  # as polynomials need them, and writers provide them
        t, nodes = np.ascontiguousarray(t), np.ascontiguousarray(signed.T)
        intervals = np.ascontiguousarray(intervals, dtype=np.int64)
        true, count = np.ascontiguousarray(true), len(fractions)

        def interpolate(share: tuple[int, int]) -> None:
            first, last = share
            work = np.empty((8, max(count, width + 1)))
            part = true[first * count : last * count]
            compiled.interpolate(
                t, nodes, intervals[first:last], width, fractions, part, work, sines[first:last]
            )

        threads = min(processors(), 4, max(1, sines.size // 4096))
        run(interpolate, ranges(sines.size, threads))
        return 2.0 * np.arcsin(np.minimum(sines, 1.0))


def lagrange(degree: int, field: str) -> Interpolant:
    """Interpolant of this degree; InputError naming the field if it is out of range."""
    if isinstance(degree, bool) or not isinstance(degree, int) or not 1 <= degree <= MAX_DEGREE:
        raise InputError(field, degree, f"a whole number from 1 to {MAX_DEGREE}")
    return Interpolant("lagrange", degree)

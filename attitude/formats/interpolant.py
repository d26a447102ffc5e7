"""Interpolation as readers of files do it, and its error.

slerp      constant rate from node to node, along the shorter arc
lagrange   polynomial through the nearest nodes, of each component; then normalised
hermite    the same, with the derivatives at the nodes
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..frames import rotations
from ..runtime import compiled
from ..runtime.threads import processors, ranges, run
from ..samples.ephemeris_data import EphemerisData
from ..samples.interpolation import hermite_components

# Errors are evaluated at these fractions of every interval.  They are zero at its ends and, between, the
# nodal polynomial (squared, for Hermite's) times a smooth factor.  For factors linear in time, in every
# interval of the windows, the greatest error is at most 1.05 times the greatest at these fractions;
# tests/formats/test_nodes.py repeats this and compares with many motions.
FRACTIONS = np.array([0.175, 0.285, 0.422, 0.578, 0.715, 0.825])
HERMITE_FRACTIONS = (np.arange(12) + 0.5) / 12


class Interpolant(NamedTuple):
    """How readers interpolate.

    kind : "slerp", "lagrange" or "hermite"
    degree : of the polynomials; 1 for slerp
    crosses : whether readers know no segments, and interpolate from the last node of one to the next
    """

    kind: str
    degree: int = 1
    crosses: bool = False

    def __str__(self) -> str:
        return "slerp" if self.kind == "slerp" else f"{self.kind.capitalize()}, degree {self.degree}"

    @property
    def order(self) -> int:
        """Power of the spacing to which errors are proportional."""
        return self.degree + 1

    @property
    def width(self) -> int:
        """Intervals between the nodes of one polynomial."""
        return (self.degree - 1) // 2 if self.kind == "hermite" else self.degree

    @property
    def fractions(self) -> np.ndarray:
        """Fractions of every interval at which errors are evaluated (`FRACTIONS`)."""
        return HERMITE_FRACTIONS if self.kind == "hermite" else FRACTIONS

    def node_values(self, ephemeris: EphemerisData) -> np.ndarray:
        """What the polynomials need at nodes: (n, 4) attitudes, for Hermite's (n, 7) with the rates."""
        q = ephemeris.quaternion("wxyz")
        return np.concatenate([q, ephemeris.angular_velocity], axis=1) if self.kind == "hermite" else q

    def errors(
        self, t: np.ndarray, nodes: np.ndarray, intervals: np.ndarray, fractions: np.ndarray, true: np.ndarray
    ) -> np.ndarray:
        """(m,) rad: greatest error in each interval, at fractions of it.

        t : (n,) s, increasing; nodes : of `node_values`; intervals : (m,) int, the node at which each begins;
        fractions : (p,), of an interval; true : (m * p, 4), the attitudes there
        """
        if self.kind == "hermite":
            return self._hermite_errors(t, nodes, intervals, fractions, true.reshape(-1, len(fractions), 4))
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

    def _hermite_errors(
        self, t: np.ndarray, nodes: np.ndarray, intervals: np.ndarray, fractions: np.ndarray, true: np.ndarray
    ) -> np.ndarray:
        """Errors as by `errors`, of windows that shrink near the ends, as in SPICE; true : (m, p, 4)."""
        half, errors = (self.width + 1) // 2, np.empty(len(intervals))
        rounding = 2e-15  # rad, of a file's numbers and of a reader's arithmetic
        q = rotations.sign_continuous(nodes[:, :4])
        before = np.minimum(intervals, half - 1)
        after = np.minimum(len(t) - 1 - intervals, half)
        for left, right in sorted(set(zip(before.tolist(), after.tolist(), strict=True))):
            rows = np.flatnonzero((before == left) & (after == right))
            window = intervals[rows][:, None] + np.arange(-left, right + 1)
            since = t[window] - t[intervals[rows]][:, None]
            at = fractions * since[:, left + 1, None]
            repeated = np.repeat(np.arange(len(rows)), len(fractions))
            p, _ = hermite_components(
                since[repeated], at.reshape(-1), q[window][repeated], nodes[window, 4:][repeated]
            )
            length = np.sqrt((p * p).sum(axis=1, keepdims=True))
            p = np.where(length > 0.0, p / np.where(length > 0.0, length, 1.0), [1.0, 0.0, 0.0, 0.0])
            angles = rotations.angle_between(p.reshape(-1, len(fractions), 4), true[rows])
            errors[rows] = np.where(np.isfinite(angles), angles, np.pi).max(axis=1) + rounding
        return errors


def hermite(degree: int, field: str) -> Interpolant:
    """Interpolant of this degree, whose window has an even number of nodes; InputError names the field."""
    if isinstance(degree, bool) or degree not in (3, 7, 11, 15):
        raise InputError(field, degree, "3, 7, 11, 15 for Hermite's interpolation")
    return Interpolant("hermite", degree)


def higher_degrees(interpolant: Interpolant, option: str) -> dict[str, Interpolant]:
    """Lagrange's interpolation of some degrees above this one, by the option of a writer that sets it."""
    degrees = [degree for degree in (5, 7, 11, 15) if degree > interpolant.degree]
    return {f"{option}={degree}": interpolant._replace(kind="lagrange", degree=degree) for degree in degrees}


def lagrange(degree: int, field: str) -> Interpolant:
    """Interpolant of this degree; InputError naming the field if it is out of range."""
    if isinstance(degree, bool) or not isinstance(degree, int) or not 1 <= degree <= 15:
        raise InputError(field, degree, "a whole number from 1 to 15")
    return Interpolant("lagrange", degree)

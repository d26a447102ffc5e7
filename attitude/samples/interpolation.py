"""Attitudes between the nodes of a file, interpolated by the method that the file states."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .. import stopping
from ..errors import RegimeError
from ..frames import rotations
from ..times.instants import Instants

MAX_STATED_DEGREE = 31  # that a file may state (SPICE takes 27): memory and time grow with its square
DATE_ROUNDING = 1e-9  # s, of dates in files, and more than that of dates in doubles


class InterpolationMethod(NamedTuple):
    """A method of interpolation, as files state it.

    kind : "slerp", constant rate along the shorter arc from node to node; "lagrange", a polynomial of each
        component through degree + 1 nodes; "hermite", through (degree + 1) / 2 nodes and derivatives there
    degree : of the polynomial; 1 for slerp
    shrinks : whether near an end polynomials go through fewer nodes, as in SPICE, rather than through nodes
        farther inside
    """

    kind: str = "slerp"
    degree: int = 1
    shrinks: bool = False

    @property
    def node_count(self) -> int:
        """Nodes that a polynomial goes through; Hermite's also through the derivatives there."""
        return (self.degree + 2) // 2 if self.kind == "hermite" else self.degree + 1

    def __str__(self) -> str:
        return "slerp" if self.kind == "slerp" else f"{self.kind.capitalize()}, degree {self.degree}"


class InterpolationSegment(NamedTuple):
    """Nodes among which a file may be interpolated.

    start, stop : s, between which it may be, both included
    instants : (n,) of the nodes, increasing; they may reach beyond start and stop
    attitude : (..., n, 4) wxyz
    rate : (..., n, 3) rad/s, body components, or None
    """

    start: float
    stop: float
    instants: Instants
    attitude: np.ndarray
    rate: np.ndarray | None
    method: InterpolationMethod


@dataclass(frozen=True)
class Interpolation:
    """How attitudes between the instants of an ephemeris are found, where its motion is not known.

    segments : in the order of time
    is_stated : whether the file states the method and these are its instants, so that the method is written
        again with them
    sign_changes : how many attitudes of the file have a sign through which no polynomial may pass; they were
        read as -q
    """

    segments: tuple[InterpolationSegment, ...]
    is_stated: bool = False
    sign_changes: int = 0

    def owners(self, seconds: np.ndarray) -> np.ndarray:
        """(n,) the segment of each instant, the later of two that share it; -1 where there is none.

        An instant less than a nanosecond outside a segment, in which dates are rounded, belongs to it.
        """
        starts, stops = self.ends
        before = np.searchsorted(starts, seconds, side="right") - 1
        after = np.minimum(before + 1, len(starts) - 1)
        is_before = (before >= 0) & (seconds <= stops[before] + DATE_ROUNDING)
        is_after = np.abs(starts[after] - seconds) <= DATE_ROUNDING
        return np.where(is_before, before, np.where(is_after, after, -1))

    @cached_property
    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """First and last seconds of the segments."""
        return np.array([s.start for s in self.segments]), np.array([s.stop for s in self.segments])

    def method_at(self, seconds: float) -> InterpolationMethod | None:
        """The stated method of the segment with this instant; None where none is stated."""
        if not self.is_stated:
            return None
        return next(
            (s.method for s in reversed(self.segments) if s.start <= seconds), self.segments[0].method
        )

    def __str__(self) -> str:
        methods = sorted({str(segment.method) for segment in self.segments})
        source = "as the file states" if self.is_stated else "the file states no method"
        return f"interpolation between the attitudes of a file: {'; '.join(methods)} ({source})"


def interpolate(segment: InterpolationSegment, instants: Instants) -> tuple[np.ndarray, np.ndarray | None]:
    """Attitudes (..., m, 4) wxyz and, where the nodes have them, rates (..., m, 3) at instants of a segment.

    Polynomials are those of the components of quaternions, normalised afterwards; rates are interpolated like
    them, but linearly beside slerp, and with Hermite's they follow from the polynomial's derivative.
    """
    nodes = segment.instants
    origin = nodes.seconds[0]
    t, at = nodes.since(origin), instants.since(origin)
    if t.size == 1:
        q, rate = np.repeat(segment.attitude[..., :1, :], at.size, axis=-2), segment.rate
        return q, None if rate is None else np.repeat(rate[..., :1, :], at.size, axis=-2)
    kind, degree, _ = segment.method
    has_derivatives = kind == "hermite" and segment.rate is not None
    count = max(2, (degree + 1) // 2 if has_derivatives else degree + 1)  # of the nodes of one polynomial
    interval = np.clip(np.searchsorted(t, at, side="right") - 1, 0, t.size - 2)
    if segment.method.shrinks:
        return _in_shrinking_windows(segment, t, at, interval, count // 2)
    count = min(count, t.size)
    first = np.clip(interval - (count // 2 - 1), 0, t.size - count)
    return _interpolated(segment, t, at, first[:, None] + np.arange(count))


def _in_shrinking_windows(
    segment: InterpolationSegment, t: np.ndarray, at: np.ndarray, interval: np.ndarray, half: int
) -> tuple[np.ndarray, np.ndarray | None]:
    """Values as by `interpolate`, through up to `half` nodes on either side, those that exist."""
    batch = segment.attitude.shape[:-2]
    q = np.empty((*batch, at.size, 4))
    rate = None if segment.rate is None else np.empty((*batch, at.size, 3))
    before, after = np.minimum(interval, half - 1), np.minimum(t.size - 1 - interval, half)
    for left, right in set(zip(before.tolist(), after.tolist(), strict=True)):
        rows = np.flatnonzero((before == left) & (after == right))
        window = interval[rows][:, None] + np.arange(-left, right + 1)
        q[..., rows, :], omega = _interpolated(segment, t, at[rows], window)
        if rate is not None and omega is not None:
            rate[..., rows, :] = omega
    return q, rate


def _interpolated(
    segment: InterpolationSegment, t: np.ndarray, at: np.ndarray, window: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None]:
    """Attitudes and rates at instants (m,), each from the nodes of its window (m, w)."""
    attitude = segment.attitude[..., window, :]
    rate = None if segment.rate is None else segment.rate[..., window, :]
    if segment.method.kind == "hermite" and rate is not None:
        q, slope = hermite_components(t[window], at, attitude, rate)
        return _unit(q), rotations.body_rate(q, slope)
    weights, _ = lagrange_basis(t[window], at)
    if segment.method.kind == "slerp":
        return _slerp(attitude, weights[:, 1]), None if rate is None else weighted(weights, rate)
    return _unit(weighted(weights, attitude)), None if rate is None else weighted(weights, rate)


def lagrange_basis(t: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and derivatives of Lagrange's basis (m, w) through nodes t (m, w) at instants (m,)."""
    values, slopes = np.ones_like(t), np.zeros_like(t)
    for j in range(t.shape[1]):
        stopping.check()
        for k in range(t.shape[1]):
            if k != j:
                inverse = 1.0 / (t[:, j] - t[:, k])
                factor = (at - t[:, k]) * inverse
                slopes[:, j] = slopes[:, j] * factor + values[:, j] * inverse
                values[:, j] *= factor
    return values, slopes


def weighted(weights: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(..., m, c): sums of values (..., m, w, c) by weights (m, w)."""
    return np.einsum("mw,...mwc->...mc", weights, values)


def hermite_components(
    t: np.ndarray, at: np.ndarray, attitude: np.ndarray, rate: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Values and derivatives (..., m, 4) at instants (m,) of the polynomials through nodes t (m, w).

    At the nodes they have the attitudes (..., m, w, 4) and, from the rates, the derivatives q' = q omega / 2.
    """
    pure = np.concatenate([np.zeros_like(rate[..., :1]), rate], axis=-1)
    return hermite_vectors(t, at, attitude, 0.5 * rotations.product(attitude, pure))


def hermite_vectors(
    t: np.ndarray, at: np.ndarray, values: np.ndarray, derivatives: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Values and derivatives (..., m, c) at instants (m,) of the polynomials through nodes t (m, w).

    At the nodes they have these values and derivatives (..., m, w, c).
    """
    basis, slopes = lagrange_basis(t, at)
    apart = t[:, :, None] - t[:, None, :]
    own_slope = (1.0 / np.where(apart == 0.0, np.inf, apart)).sum(axis=2)  # of each basis at its own node
    ahead = at[:, None] - t
    square, square_slope = basis**2, 2.0 * basis * slopes
    linear = 1.0 - 2.0 * ahead * own_slope
    value = weighted(linear * square, values) + weighted(ahead * square, derivatives)
    slope = weighted(linear * square_slope - 2.0 * own_slope * square, values)
    return value, slope + weighted(square + ahead * square_slope, derivatives)


def _slerp(attitude: np.ndarray, fraction: np.ndarray) -> np.ndarray:
    """Attitudes at fractions (m,) of the shorter arc from the first of two nodes to the second."""
    p, q = attitude[..., 0, :], attitude[..., 1, :]
    turn = rotations.product(rotations.conjugate(p), q)
    sine = np.sqrt((turn[..., 1:] ** 2).sum(axis=-1))
    angle = np.arctan2(sine, np.abs(turn[..., 0]))
    safe = np.where(sine > 1e-150, sine, 1.0)
    before = np.where(sine > 1e-150, np.sin((1.0 - fraction) * angle) / safe, 1.0 - fraction)
    after = np.where(sine > 1e-150, np.sin(fraction * angle) / safe, fraction)
    after = np.where(turn[..., 0] < 0.0, -after, after)
    return _unit(before[..., None] * p + after[..., None] * q)


def _unit(q: np.ndarray) -> np.ndarray:
    """Quaternions divided by their lengths; RegimeError where a polynomial has hardly any."""
    length = np.sqrt((q * q).sum(axis=-1, keepdims=True))
    if not (length > 0.1).all():
        raise RegimeError(
            "resampled: attitudes of the file are too far apart for its polynomial, which passes near zero"
        )
    return q / length

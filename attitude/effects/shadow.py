"""Sunlit spans of an orbit: outside the cylinder of the central body's shadow."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .. import stopping
from ..orbit.path_states import evaluate, position, samples, velocity
from ..problem.initial_state import OrbitPath, PiecewisePolynomial

# The height over the shadow has one minimum in each sampling step, or few.
SAMPLES_PER_REVOLUTION = 360
SAMPLES_PER_BLOCK = 200_000
ROOT_TOLERANCE = 1e-10  # s
ROOT_RELATIVE_TOLERANCE = 4.5e-16  # of t: two of its last places, below which no interval can be halved


def sunlit(
    orbit_path: OrbitPath, sun: PiecewisePolynomial, radius: float, start: float, stop: float
) -> list[tuple[float, float]]:
    """Spans (s) from start to stop outside the shadow, ascending, disjoint.

    Every crossing between samples of opposite sides is found to ROOT_TOLERANCE (or the rounding of t); and
    where three samples on one side have an extremum between them that may lie on the other, the extremum is
    computed, so that no passage is missed but one shallower than the rounding of the position.
    """
    height = ShadowHeight(orbit_path, sun, radius)
    blocks = _blocks(orbit_path, start, stop)
    crossings = np.concatenate([np.zeros(0), *(_crossings(height, t) for t in blocks)])
    edges = np.concatenate([[start], np.unique(crossings), [stop]])
    lit = height(0.5 * (edges[1:] + edges[:-1])) > 0.0
    begins = edges[:-1][lit & ~np.concatenate([[False], lit[:-1]])]
    ends = edges[1:][lit & ~np.concatenate([lit[1:], [False]])]
    return [span for span in zip(begins.tolist(), ends.tolist(), strict=True) if span[0] < span[1]]


class ShadowHeight:
    """Distance of a body from the shadow, m, negative within; called with t, (...,), s.

    On the night side its distance from the cylinder's axis less the radius, on the day side that
    from the centre: one continuous function.
    """

    def __init__(self, orbit_path: OrbitPath, sun: PiecewisePolynomial, radius: float):
        self.orbit_path, self.sun, self.radius = orbit_path, sun, radius
        speed = np.sqrt((velocity(orbit_path, samples(orbit_path)) ** 2).sum(axis=1)).max()
        self.max_rate = 1.01 * float(speed)  # m/s

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """(...), m."""
        stopping.check()
        t = np.asarray(t, dtype=float)
        r, sun = position(self.orbit_path, t.reshape(-1)), evaluate(self.sun, t.reshape(-1))
        sun = sun / np.sqrt((sun**2).sum(axis=1))[:, None]
        sunward = (r * sun).sum(axis=1)
        out = np.where((sunward < 0.0)[:, None], r - sunward[:, None] * sun, r)
        return (np.sqrt((out**2).sum(axis=1)) - self.radius).reshape(t.shape)


def _blocks(orbit_path: OrbitPath, start: float, stop: float) -> Iterator[np.ndarray]:
    """Equidistant instants in blocks that overlap by two, so that no extremum falls between blocks."""
    step = orbit_path.period / SAMPLES_PER_REVOLUTION
    count = max(4, int(np.ceil((stop - start) / step)) + 1)
    for first in range(0, count - 2, SAMPLES_PER_BLOCK):
        k = np.arange(first, min(first + SAMPLES_PER_BLOCK + 2, count))
        yield start + (stop - start) * (k / (count - 1))


def _crossings(height: ShadowHeight, t: np.ndarray) -> np.ndarray:
    """Instants at which the body enters or leaves the shadow."""
    from scipy.optimize.elementwise import find_root

    values = height(t)
    nodes = np.concatenate([t, _extrema(height, t, values, 1.0), _extrema(height, t, values, -1.0)])
    nodes.sort()
    above = height(nodes) > 0.0
    changes = np.flatnonzero(above[1:] != above[:-1])
    if changes.size == 0:
        return np.zeros(0)
    tolerances = {"xatol": ROOT_TOLERANCE, "xrtol": ROOT_RELATIVE_TOLERANCE, "fatol": 0.0, "frtol": 0.0}
    return np.asarray(find_root(height, (nodes[changes], nodes[changes + 1]), tolerances=tolerances).x)


def _extrema(height: ShadowHeight, t: np.ndarray, values: np.ndarray, sign: float) -> np.ndarray:
    """Minima of sign * height that are not above 0, between samples that are."""
    from scipy.optimize.elementwise import find_minimum

    low, middle, high = sign * values[:-2], sign * values[1:-1], sign * values[2:]
    reach = height.max_rate * (t[1] - t[0])
    near = np.flatnonzero((middle <= low) & (middle <= high) & (middle > 0.0) & (middle < reach))
    near = near[(middle < np.maximum(low, high))[near]]
    if near.size == 0:
        return np.zeros(0)
    minima = find_minimum(lambda x: sign * height(x), (t[near], t[near + 1], t[near + 2]))
    return np.asarray(minima.x)[np.asarray(minima.f_x) <= 0.0]

"""Passages of an orbit through the central body's shadow: a cylinder, or umbra and penumbra as cones."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .. import stopping
from ..frames.celestial import shadow_heights
from ..kernels.solvers.plate_layout import Light, ShadowModel
from ..orbit.path_states import position, samples, velocity
from ..problem.initial_state import OrbitPath, Passages, PiecewisePolynomial
from ..windows.root_search import ROOT_RELATIVE_TOLERANCE

SAMPLES_PER_BLOCK = 200_000
ROOT_TOLERANCE = 1e-12  # s


def passages(
    orbit_path: OrbitPath,
    sun: PiecewisePolynomial,
    radius: float,
    span: tuple[float, float],
    shadow: int = ShadowModel.CONICAL,
) -> Passages:
    """Passages of a span, s, through a shadow, CONICAL or CYLINDRICAL, of a central body of a radius, m.

    Every crossing between samples of opposite sides is found to ROOT_TOLERANCE (or the rounding of t); and
    where three samples on one side have an extremum between them that may lie on the other, the extremum is
    computed, so that no passage is missed but one shallower than the rounding of the position.
    """
    sides = (0.0,) if shadow == ShadowModel.CYLINDRICAL else (1.0, -1.0)
    heights = [ShadowHeight(orbit_path, sun, radius, side) for side in sides]
    crossings = [_crossings(height, t) for t in _blocks(orbit_path, *span) for height in heights]
    edges = np.unique(np.concatenate(crossings))
    edges = edges[(edges > span[0]) & (edges < span[1])]
    ends = np.concatenate([span[:1], edges, span[1:]])
    middles = 0.5 * (ends[1:] + ends[:-1])
    kinds = np.full(middles.size, Light.FULL)
    kinds[heights[0](middles) < 0.0] = Light.PARTIAL
    kinds[(heights[-1](middles) < 0.0) & ~heights[-1].is_ring(middles)] = Light.DARK
    # Within a penumbra the light begins and ends like the power 3/2 of time: arcs end at its middle, and at
    # 1/4, 1/8, ... 1/64 of it from either end (the error of each level is in docs/torques.md, section 5).
    part = 0.5 ** np.arange(1, 7)
    part = np.concatenate([part, 1.0 - part])
    within = [ends[i] + (ends[i + 1] - ends[i]) * part for i in np.flatnonzero(kinds == Light.PARTIAL)]
    return Passages(shadow, edges, kinds, np.unique(np.concatenate([edges, *within])))


class ShadowHeight:
    """Distance of a body from a surface of the shadow, m, negative within; called with t, (...,), s.

    The surface is that of `celestial.shadow_heights`.
    """

    def __init__(self, orbit_path: OrbitPath, sun: PiecewisePolynomial, radius: float, side: float = 0.0):
        self.orbit_path, self.sun, self.radius, self.side = orbit_path, sun, radius, side
        speed = np.sqrt((velocity(orbit_path, samples(orbit_path)) ** 2).sum(axis=1)).max()
        self.max_rate = 1.01 * float(speed)  # m/s

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """(...), m."""
        stopping.check()
        t = np.asarray(t, dtype=float)
        return np.asarray(self._heights(t.reshape(-1))[0].reshape(t.shape))

    def is_ring(self, t: np.ndarray) -> np.ndarray:
        """(n,): whether the body is behind the tip of the umbra."""
        return self._heights(t)[1] < 0.0

    def _heights(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        r, sun = position(self.orbit_path, t), self.sun(t)
        return shadow_heights(r, sun, self.radius, self.side)


def _blocks(orbit_path: OrbitPath, start: float, stop: float) -> Iterator[np.ndarray]:
    """Equidistant instants in blocks that overlap by two, so that no extremum falls between blocks."""
    step = orbit_path.period / 360  # in which the height over the shadow has one minimum, or few
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

"""When a body on its orbit is in sunlight: outside the cylinder of the central body's shadow."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..orbit.path_states import evaluate, position, samples, velocity
from ..problem.initial_state import OrbitPath, PiecewisePolynomial

# Samples of a revolution; the height over the shadow has one lowest point in each, or few.
STEPS = 360
BLOCK = 200_000
ACCURACY = 1e-10  # s
ROUNDING = 4.5e-16  # of t: two of its last places, below which no interval can be halved


def sunlit(
    course: OrbitPath, sun: PiecewisePolynomial, radius: float, start: float, stop: float
) -> list[tuple[float, float]]:
    """Spans (s) from start to stop outside the shadow, ascending, disjoint.

    Every crossing between samples of opposite sides is found to ACCURACY (or the rounding of t); and where
    three samples on one side have an extreme between them that may reach over, it is looked for, so that no
    passage is too short to be seen but one shallower than the rounding of the position.
    """
    height = Height(course, sun, radius)
    crossings = np.concatenate([np.zeros(0), *(_crossings(height, t) for t in _blocks(course, start, stop))])
    edges = np.concatenate([[start], np.unique(crossings), [stop]])
    return _joined(edges, height(0.5 * (edges[1:] + edges[:-1])) > 0.0)


class Height:
    """How far a body is outside the shadow, m: negative within; called with t (n,), s.

    On the night side its distance from the cylinder's axis less the radius, on the day side that
    from the centre: one continuous function.
    """

    def __init__(self, course: OrbitPath, sun: PiecewisePolynomial, radius: float):
        self.course, self.sun, self.radius = course, sun, radius
        speed = np.sqrt((velocity(course, samples(course)) ** 2).sum(axis=1)).max()
        self.steepest = 1.01 * float(speed)  # m/s

    def __call__(self, t: np.ndarray) -> np.ndarray:
        t = np.asarray(t, dtype=float)
        r, sun = position(self.course, t.reshape(-1)), evaluate(self.sun, t.reshape(-1))
        sun = sun / np.sqrt((sun**2).sum(axis=1))[:, None]
        along = (r * sun).sum(axis=1)
        out = np.where((along < 0.0)[:, None], r - along[:, None] * sun, r)
        return (np.sqrt((out**2).sum(axis=1)) - self.radius).reshape(t.shape)


def _blocks(course: OrbitPath, start: float, stop: float) -> Iterator[np.ndarray]:
    """Instants even in time, in blocks that overlap by two so that no extreme falls between blocks."""
    step = course.period / STEPS
    count = max(4, int(np.ceil((stop - start) / step)) + 1)
    for first in range(0, count - 2, BLOCK):
        k = np.arange(first, min(first + BLOCK + 2, count))
        yield start + (stop - start) * (k / (count - 1))


def _crossings(height: Height, t: np.ndarray) -> np.ndarray:
    values = height(t)
    nodes = np.concatenate([t, _extremes(height, t, values), _extremes(height, t, values, -1.0)])
    nodes.sort()
    above = height(nodes) > 0.0
    turned = np.flatnonzero(above[1:] != above[:-1])
    return _roots(height, nodes[turned], nodes[turned + 1])


def _extremes(height: Height, t: np.ndarray, values: np.ndarray, sign: float = 1.0) -> np.ndarray:
    """Lowest points of height (sign -1: highest) that lie across 0 and between samples on this side."""
    from scipy.optimize.elementwise import find_minimum

    low, middle, high = sign * values[:-2], sign * values[1:-1], sign * values[2:]
    reach = height.steepest * (t[1] - t[0])
    near = np.flatnonzero((middle <= low) & (middle <= high) & (middle > 0.0) & (middle < reach))
    near = near[(middle < np.maximum(low, high))[near]]
    if near.size == 0:
        return np.zeros(0)
    found = find_minimum(lambda x: sign * height(x), (t[near], t[near + 1], t[near + 2]))
    return np.asarray(found.x)[np.asarray(found.f_x) <= 0.0]


def _roots(height: Height, below: np.ndarray, above: np.ndarray) -> np.ndarray:
    """The crossing in each interval, from `below` to `above` in time."""
    from scipy.optimize.elementwise import find_root

    if below.size == 0:
        return np.zeros(0)
    found = find_root(
        height, (below, above), tolerances={"xatol": ACCURACY, "xrtol": ROUNDING, "fatol": 0.0, "frtol": 0.0}
    )
    return np.asarray(found.x)


def _joined(edges: np.ndarray, lit: np.ndarray) -> list[tuple[float, float]]:
    """Spans between edges that are lit, neighbours as one."""
    begins = np.flatnonzero(lit & ~np.concatenate([[False], lit[:-1]]))
    ends = np.flatnonzero(lit & ~np.concatenate([lit[1:], [False]]))
    return [
        (float(edges[i]), float(edges[j + 1]))
        for i, j in zip(begins, ends, strict=True)
        if edges[i] < edges[j + 1]
    ]

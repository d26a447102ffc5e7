"""The span of a scene cut where its torques or its momentum change: between the cuts everything is smooth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse, CachedTorque


@dataclass(frozen=True)
class Arc:
    """A part of the span, in the direction in which it is integrated: from the epoch outwards.

    Attributes
    ----------
    start, stop : s since the epoch
    torques : those that act in it
    impulses : those at its start, in the order in which they are met
    """

    start: float
    stop: float
    torques: tuple[CachedTorque, ...]
    impulses: tuple[AppliedImpulse, ...] = ()

    @property
    def length(self) -> float:
        """Return its duration, s."""
        return abs(self.stop - self.start)


def arcs(
    initial_state: InitialState,
    torques: Sequence[CachedTorque],
    impulses: Sequence[AppliedImpulse],
    stop: float,
) -> list[Arc]:
    """Cut the span from the epoch to `stop` (s, of either sign) into arcs.

    The state at the epoch is that before an impulse then.
    """
    sign = 1.0 if stop >= 0.0 else -1.0
    spans = {id(torque): torque.intervals(initial_state) for torque in torques}
    met = [i for i in impulses if (0.0 <= i.seconds <= stop if stop >= 0.0 else stop < i.seconds < 0.0)]
    edges = {0.0, stop} | {impulse.seconds for impulse in met}
    for span in spans.values():
        edges |= {edge for interval in span or () for edge in interval if 0.0 < edge * sign < stop * sign}
    cuts = sorted(edges, reverse=sign < 0.0)
    if len(cuts) == 1 or any(impulse.seconds == stop for impulse in met):
        cuts.append(stop)  # an arc of no length, for what happens at its instant
    starting: dict[float, list[AppliedImpulse]] = {}
    for impulse in met:
        starting.setdefault(impulse.seconds, []).append(impulse)

    def acts(torque: CachedTorque, seconds: float) -> bool:
        span = spans[id(torque)]
        return span is None or any(begin <= seconds <= end for begin, end in span)

    return [
        Arc(
            a,
            b,
            tuple(torque for torque in torques if acts(torque, 0.5 * (a + b))),
            tuple(starting.get(a, ())),
        )
        for a, b in pairwise(cuts)
    ]


def arcs_by_direction(
    initial_state: InitialState, torques: Sequence[CachedTorque], impulses: Sequence[AppliedImpulse]
) -> list[list[Arc]]:
    """Arcs backwards, where the span begins before the epoch, and forwards."""
    start, stop = initial_state.start, initial_state.stop
    ends = ([start] if start < 0.0 else []) + ([stop] if stop >= 0.0 else [])
    return [arcs(initial_state, torques, impulses, end) for end in ends]


def instants_within(path: Sequence[Arc], seconds: np.ndarray, seconds_low: np.ndarray) -> list[np.ndarray]:
    """Indices into the two-part instants for each arc, in the order in which it meets them.

    One at a cut belongs to the later arc: the state then is the one after the impulse.
    """
    if not path:
        return []
    sign = 1.0 if path[-1].stop >= 0.0 else -1.0
    order = np.lexsort((sign * seconds_low, sign * seconds))
    ascending = sign * seconds[order]
    side: Literal["left", "right"] = "left" if sign > 0.0 else "right"
    edges = [int(np.searchsorted(ascending, sign * arc.start, side=side)) for arc in path]
    edges[0] = 0
    return [order[a:b] for a, b in zip(edges, [*edges[1:], len(order)], strict=True)]

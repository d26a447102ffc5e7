"""The span of a scene cut where its torques or its momentum change: between the cuts everything is smooth."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse, TorqueModel


@dataclass(frozen=True)
class Arc:
    """A part of the span, in the direction in which it is marched: from the epoch outwards.

    Attributes
    ----------
    start, stop : s since the epoch
    torques : those that act in it
    kicks : impulses at its start, in the order in which they are met
    """

    start: float
    stop: float
    torques: tuple[TorqueModel, ...]
    kicks: tuple[AppliedImpulse, ...] = ()

    @property
    def length(self) -> float:
        return abs(self.stop - self.start)


def legs(
    initial_state: InitialState, torques: Sequence[TorqueModel], kicks: Sequence[AppliedImpulse], stop: float
) -> list[Arc]:
    """From the epoch to `stop` (s, of either sign).

    The state at the epoch is that before an impulse then.
    """
    sign = 1.0 if stop >= 0.0 else -1.0
    spans = {id(torque): torque.intervals(initial_state) for torque in torques}
    met = [kick for kick in kicks if _is_met(kick.seconds, stop)]
    edges = {0.0, stop} | {kick.seconds for kick in met}
    for span in spans.values():
        edges |= {edge for interval in span or () for edge in interval if 0.0 < edge * sign < stop * sign}
    cuts = sorted(edges, reverse=sign < 0.0)
    if len(cuts) == 1 or any(kick.seconds == stop for kick in met):
        cuts.append(stop)  # a leg of no length, for what happens at its instant
    ordered = sorted(met, key=lambda kick: kick.seconds * sign)
    return [_leg(a, b, torques, spans, ordered) for a, b in pairwise(cuts)]


def _is_met(seconds: float, stop: float) -> bool:
    return 0.0 <= seconds <= stop if stop >= 0.0 else stop < seconds < 0.0


def _leg(
    start: float,
    stop: float,
    torques: Sequence[TorqueModel],
    spans: dict[int, list[tuple[float, float]] | None],
    kicks: list[AppliedImpulse],
) -> Arc:
    middle = 0.5 * (start + stop)
    acting = tuple(torque for torque in torques if _acts(spans[id(torque)], middle))
    return Arc(start, stop, acting, tuple(kick for kick in kicks if kick.seconds == start))


def _acts(span: list[tuple[float, float]] | None, seconds: float) -> bool:
    """Whether an instant is in one of the spans, which ascend and are disjoint."""
    if span is None:
        return True
    place = bisect_right(span, (seconds, np.inf)) - 1
    return place >= 0 and seconds <= span[place][1]


def instants_within(cut: Sequence[Arc], seconds: np.ndarray, rest: np.ndarray) -> list[np.ndarray]:
    """Indices into the instants for each leg, in the order in which it meets them.

    One at a cut belongs to the later leg: the state then is the one after the impulse.
    """
    if not cut:
        return []
    sign = 1.0 if cut[-1].stop >= 0.0 else -1.0
    order = np.lexsort((sign * rest, sign * seconds))
    ascending = sign * seconds[order]
    side: Literal["left", "right"] = "left" if sign > 0.0 else "right"
    edges = [int(np.searchsorted(ascending, sign * leg.start, side=side)) for leg in cut]
    edges[0] = 0
    return [order[a:b] for a, b in zip(edges, [*edges[1:], len(order)], strict=True)]

"""Events of a simulated motion: impulses, torques and light that begin and end, a tolerance exceeded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..kernels.solvers.plate_layout import Light
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse, CachedTorque
from ..samples.event import Event

# What an edge of a shadow is called, by the light before and after it.
PASSAGES = {
    (Light.FULL, Light.PARTIAL): "penumbra entry",
    (Light.PARTIAL, Light.FULL): "penumbra exit",
    (Light.FULL, Light.DARK): "shadow entry",
    (Light.PARTIAL, Light.DARK): "shadow entry",
    (Light.DARK, Light.PARTIAL): "shadow exit",
    (Light.DARK, Light.FULL): "shadow exit",
}


def impulse_events(kicks: Sequence[AppliedImpulse]) -> list[Event]:
    """An event for each impulse."""
    return [
        Event(
            kick.seconds,
            "impulse",
            f"angular impulse of {float(np.linalg.norm(kick.angular)):.6g} N m s",
            {"angular_impulse": kick.angular, "inertial": kick.inertial},
        )
        for kick in kicks
    ]


def switching_events(torques: Sequence[CachedTorque], initial_state: InitialState) -> list[Event]:
    """Where torques begin and end, and where the light does."""
    switched: list[tuple[float, str, str]] = []
    for torque in torques:
        for interval in torque.intervals(initial_state) or []:
            kinds = zip(interval, ("torque on", "torque off"), strict=True)
            switched += [(seconds, kind, torque.type) for seconds, kind in kinds]
        passages = torque.passages(initial_state)
        if passages is not None:
            for seconds, *light in zip(passages.edges, passages.kinds[:-1], passages.kinds[1:], strict=True):
                switched.append((float(seconds), PASSAGES[tuple(light)], torque.type))
    low, high = min(initial_state.start, 0.0), max(initial_state.stop, 0.0)
    return [Event(t, kind, f"{kind}: {cause}") for t, kind, cause in switched if low < t < high]


def limit_events(kept: tuple[float, float], initial_state: InitialState, tolerance: float) -> list[Event]:
    """Where the error is estimated above a tolerance, rad, from there on outwards.

    kept : s, the span in which it is not
    """
    text = f"estimated error above {tolerance:.1e} rad"
    ends = zip(kept, (initial_state.start, initial_state.stop), strict=True)
    return [Event(end, "tolerance exceeded", text) for end, last in ends if abs(end) < abs(last)]

"""The limit on elapsed time: the number of turns up to which two-part phases keep their digits."""

from __future__ import annotations

import numpy as np

from ..errors import ToleranceError
from ..kernels.layout import MAX_TURNS


def max_phase_rate(bodies: np.ndarray) -> float:
    """Turns/s of the fastest phase of these records; zero for no records."""
    phases = (bodies[name][..., 0] for name in ("precession", "argument"))
    return max(float(np.abs(rates).max(initial=0.0)) for rates in phases)


def refuse_too_far(turns_per_second: float, farthest: float) -> None:
    """Raise ToleranceError where the fastest phase makes more than MAX_TURNS turns up to an instant.

    turns_per_second : `max_phase_rate` of the bodies; farthest : s, greatest of the instants' absolute values
    """
    if farthest * turns_per_second > MAX_TURNS:
        raise ToleranceError(
            f"t: {farthest:.6g} s is beyond {MAX_TURNS / turns_per_second:.6g} s, where this body has made "
            f"{MAX_TURNS:.3g} turns and phases would lose digits; ask for nearer instants"
        )

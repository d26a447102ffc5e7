"""How far from the epoch phases keep their digits; beyond it, an error rather than a guess."""

from __future__ import annotations

import numpy as np

from ..errors import ToleranceError
from ..kernels.layout import MAX_TURNS


def pace(bodies: np.ndarray) -> float:
    """Turns a second of the fastest phase of these records; zero where there are none."""
    phases = (bodies[name][..., 0] for name in ("precession", "argument"))
    return max(float(np.abs(rates).max(initial=0.0)) for rates in phases)


def refuse_too_far(turns_per_second: float, farthest: float) -> None:
    """Raises ToleranceError where an instant is more turns from the epoch than phases can count.

    turns_per_second : `pace` of the bodies; farthest : s, greatest of the instants' absolute values
    """
    if farthest * turns_per_second > MAX_TURNS:
        raise ToleranceError(
            f"t: {farthest:.6g} s is beyond {MAX_TURNS / turns_per_second:.6g} s, where this body has made "
            f"{MAX_TURNS:.3g} turns and phases would lose digits; ask for nearer instants"
        )

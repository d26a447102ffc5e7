"""How far from the epoch phases keep their digits; beyond it, an error rather than a guess."""

from __future__ import annotations

import numpy as np

from . import units
from .errors import ToleranceError
from .kernels.layout import MAX_TURNS


def refuse_too_far(bodies: np.ndarray, seconds: np.ndarray) -> None:
    """Raises ToleranceError where an instant is more turns from the epoch than phases can count.

    bodies : array of INVARIANTS; seconds : array, s
    """
    if not seconds.size or not bodies.size:
        return
    rates = np.abs(bodies["precession"][..., 0]).max(), np.abs(bodies["argument"][..., 0]).max()
    first, last = units.extremes(seconds)
    farthest, turns_per_second = max(-first, last), float(max(rates))
    if farthest * turns_per_second > MAX_TURNS:
        raise ToleranceError(
            f"t: {farthest:.6g} s is beyond {MAX_TURNS / turns_per_second:.6g} s, where this body has made "
            f"{MAX_TURNS:.3g} turns and phases would lose digits; ask for nearer instants"
        )

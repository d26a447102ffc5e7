"""How far from the epoch phases keep their digits; beyond it, an error rather than a guess."""

from __future__ import annotations

import numpy as np

from .errors import ToleranceError
from .kernels.layout import MAX_TURNS


def refuse_too_far(bodies: np.ndarray, farthest: float) -> None:
    """Raises ToleranceError where an instant is more turns from the epoch than phases can count.

    bodies : array of INVARIANTS; farthest : s, greatest of the instants' absolute values
    """
    if not bodies.size:
        return
    rates = np.abs(bodies["precession"][..., 0]).max(), np.abs(bodies["argument"][..., 0]).max()
    turns_per_second = float(max(rates))
    if farthest * turns_per_second > MAX_TURNS:
        raise ToleranceError(
            f"t: {farthest:.6g} s is beyond {MAX_TURNS / turns_per_second:.6g} s, where this body has made "
            f"{MAX_TURNS:.3g} turns and phases would lose digits; ask for nearer instants"
        )

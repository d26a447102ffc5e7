"""Times at which a free body flips: the rate about its intermediate axis changes sign."""

from __future__ import annotations

import numpy as np

from ..kernels import layout
from ..motion import TorqueFreeMotion


def flips(motion: TorqueFreeMotion, count: int) -> np.ndarray:
    """(..., count), s: the first instants after the epoch at which that rate changes sign, eq. (E9).

    It is proportional to sn(u), u = u0 + u' t (docs/theory.md, section 2), and sn is zero at every 2K: half a
    polhode period from one to the next.  Infinite where there are no more: a body at a constant rate has
    none, one on the separatrix one at most.
    """
    bodies = motion._batch.fields("regime", "u_rate", "u0", "K")
    u0, rate, K = (bodies[name][..., None] for name in ("u0", "u_rate", "K"))
    with np.errstate(divide="ignore", invalid="ignore"):
        passed = np.where(np.isinf(K), 0.0, np.floor(u0 / (2.0 * K)) + 1.0)
        zeros = passed + np.arange(count)
        u = np.where(np.isinf(K), np.where(zeros == 0.0, 0.0, np.inf), 2.0 * K * zeros)
        seconds = (u - u0) / rate
    turning = (bodies["regime"][..., None] != layout.CONSTANT_RATE) & (seconds > 0.0)
    return np.where(turning, seconds, np.inf)

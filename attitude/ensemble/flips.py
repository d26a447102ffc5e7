"""Times at which a body flips, free or with rotors: the rate about its intermediate axis changes sign."""

from __future__ import annotations

import numpy as np

from ..kernels.layout import GyrostatRegime, Regime
from ..motion import TorqueFreeMotion
from ..rigid_body.constants_of_motion import Batch
from ..rigid_body.gyrostat_constants import GyrostatBatch
from ..times.instants import Instants


def flips(motion: TorqueFreeMotion, count: int) -> np.ndarray:
    """(..., count), s: the first instants after the epoch at which that rate changes sign, eq. (E9).

    It is proportional to sn(u), u = u0 + u' t (docs/theory.md (8)), and sn is zero at every 2K: half a
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
    turning = (bodies["regime"][..., None] != Regime.CONSTANT_RATE) & (seconds > 0.0)
    return np.where(turning, seconds, np.inf)


def flips_of_gyrostats(motion: GyrostatBatch, count: int) -> np.ndarray:
    """(n, count), s: as `flips`, of bodies (n,) with rotors.

    The momentum comes back after twice the period of gamma3, and the flips of that time with it; they are
    roots of the rate in closed form, four at most.  A rotor along another principal axis leaves them equally
    far apart: half periods of the momentum's path.
    """
    out = np.full((motion.size, count), np.inf)
    for i in range(motion.size):
        body = motion[i]
        record = body.fields("regime", "period", "argument", "argument0")[()]
        if record["regime"] == GyrostatRegime.CONSTANT:
            continue
        returns = bool(np.isfinite(record["period"]))
        # on a separatrix rates only fall from the argument 15 on, down to rounding at twice as much
        window = (15.0 + abs(record["argument0"][0])) / abs(record["argument"][0])
        span = 2.0 * float(record["period"]) if returns else float(window)
        roots = _roots(body, span)
        if roots.size:
            turns = np.arange(count)[:, None] if returns else np.zeros((1, 1))
            each = (roots + span * turns).reshape(-1)[:count]
            out[i, : each.size] = each
    return out


def _roots(body: Batch, span: float) -> np.ndarray:
    """Instants after 0, up to `span` s, at which that rate changes its sign, ascending."""
    axis = body.body.axes[np.argsort(body.body.moments, kind="stable")[1]]

    def rate(seconds: np.ndarray) -> np.ndarray:
        rates: np.ndarray = body.sample(Instants(seconds, None, None), quaternion=False, rate=True)[1]
        return rates @ axis

    grid = span * np.arange(513) / 512  # between two of them the rate changes its sign once at most
    values = rate(grid)
    # one that begins at zero flips after it, not then
    values[0] = rate(1e-9 * grid[1:2])[0] if values[0] == 0.0 else values[0]
    at = np.flatnonzero((values[:-1] != 0.0) & (np.sign(values[:-1]) != np.sign(values[1:])))
    low, high, falls = grid[at], grid[at + 1], values[at] > 0.0
    for _ in range(60):  # halves of an interval, down to neighbouring doubles
        middle = 0.5 * (low + high)
        before = (rate(middle) > 0.0) == falls
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return high

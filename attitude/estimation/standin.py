"""STAND-IN (this branch only): partials by central differences, until motion.partials is there."""

from typing import Any

import numpy as np

from ..frames import rotations
from ..motion import TorqueFreeMotion
from ..rigid_body.body import RigidBody
from .parameters import _exponential


def matrix(motion: TorqueFreeMotion, instants: Any) -> np.ndarray:
    if hasattr(motion, "partials"):
        return motion.partials(instants).matrix
    q, w = motion._batch.attitudes, motion._batch.rates
    II0, axes = motion.body.moments, motion.body.axes
    size = np.sqrt(w @ w) or 1.0
    qs, ws, ts = [], [], []
    steps = []
    for k in range(12):
        for sign in (1, -1):
            e = np.zeros(3)
            h = 1e-6 * (1.0 if k < 3 or k >= 9 else size if k < 6 else II0[k - 6])
            e[k % 3] = sign * h
            steps.append(h)
            qq, ww, II, aa = q, w, II0.copy(), axes
            if k < 3:
                qq = rotations.product(q, _exponential(e))
            elif k < 6:
                ww = w + e
            elif k < 9:
                II = I + e
            else:
                aa = rotations.rotate(_exponential(e), axes)
            qs.append(qq)
            ws.append(ww)
            ts.append((aa.T * II) @ aa)  # noqa: E702
    many = TorqueFreeMotion(
        RigidBody(np.array(ts), physical=False),
        np.array(qs),
        np.array(ws),
        motion.epoch,
        "wxyz",
        motion.frame,
    )
    out = many.ephemeris(instants, rate=True)
    Q, W = out.attitude, out.computed_rate
    n = instants.seconds.size
    result = np.empty((n, 6, 12))
    for k in range(12):
        h = steps[2 * k]
        result[:, :3, k] = rotations.rotation_vectors(Q[2 * k + 1], Q[2 * k]) / (2 * h)
        result[:, 3:, k] = (W[2 * k] - W[2 * k + 1]) / (2 * h)
    return result

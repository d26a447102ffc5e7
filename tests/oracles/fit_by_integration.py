"""A fit of torque-free motion that shares nothing with the library: integrated equations, differences."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation


def motion(moments, attitude, rate, seconds):
    """Attitudes (a Rotation) and rates (n, 3) at instants, by DOP853 on Euler's equations in both directions.

    moments : (3,); attitude : Rotation; rate : (3,), body axes; seconds : (n,) in any order
    """
    moments = np.asarray(moments, dtype=float)
    scale = max(np.linalg.norm(rate), 1e-300)

    def slope(_, y):
        q, w = y[:4], y[4:]
        qw, qv = q[0], q[1:]
        turn = 0.5 * np.array([-qv @ w, *(qw * w + np.cross(qv, w))])
        return np.array([*turn, *(np.cross(moments * w, w) / moments)]) / scale

    start = np.array([*attitude.as_quat(scalar_first=True), *rate])
    states = np.tile(start, (len(seconds), 1))
    for side in (1.0, -1.0):
        chosen = np.flatnonzero(np.asarray(seconds) * side > 0.0)
        if chosen.size:
            order = chosen[np.argsort(np.asarray(seconds)[chosen] * side)]
            phases = np.asarray(seconds)[order] * scale
            distinct, back = np.unique(phases * side, return_inverse=True)
            run = solve_ivp(
                slope, (0.0, phases[-1]), start, "DOP853", distinct * side, rtol=1e-11, atol=1e-12
            )
            states[order] = run.y.T[back]
    return Rotation.from_quat(states[:, :4], scalar_first=True), states[:, 4:]


def fit(seconds, residuals, moments, attitude, rate, **options):
    """scipy's result for 8 parameters: rotation vector from `attitude`; rate, over the size of the one given;
    ratios of moments to the third.

    residuals : of (attitudes, rates) at the instants, weighted
    """

    def at(x):
        state = attitude * Rotation.from_rotvec(x[:3])
        return np.ravel(residuals(*motion([x[6], x[7], 1.0], state, x[3:6] * size, seconds)))

    size = np.linalg.norm(rate)
    start = [0.0, 0.0, 0.0, *(rate / size), *(np.asarray(moments)[:2] / moments[2])]
    return least_squares(at, start, "3-point", **options)

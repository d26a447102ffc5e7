"""Partial derivatives of free rotation as differences of the oracle's attitudes and rates, at many digits.

Nothing of the library's is used.  A central difference with a step of 10^-step is off by its square times the
third derivative; the motions are computed to three times as many digits.
"""

from mpmath import mp, mpf

from attitude.oracle import truth
from attitude.oracle.exact import conjugate, multiply, normalised, rotate

ELEMENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def _rotation(axis, angle):
    """exp of an angle about a body axis, as a quaternion; also for angles whose square vanishes."""
    q = [mp.cos(angle / 2), mpf(0), mpf(0), mpf(0)]
    q[1 + axis] = mp.sin(angle / 2)
    return tuple(q)


def _sample(moved, body, q0, t, digits):
    """Attitude and rate of the body, its rate and attitude moved by (what, index, step)."""
    what, k, h = moved
    moments = [mpf(m) for m in body[0]] if isinstance(body[0][0], float) else body[0]
    omega = [mpf(w) for w in body[1]]
    q0 = normalised(q0)
    if what == "attitude":
        q0 = multiply(q0, _rotation(k, h))
    elif what == "rate":
        omega[k] += h
    elif what == "moment":
        moments = list(moments)
        moments[k] += h
    elif what == "axis":  # the same body seen along its turned axes
        S = _rotation(k, h)
        omega = rotate(conjugate(S), omega)
        q, w = truth.attitude_and_rate(moments, omega, multiply(q0, S), t, digits)
        return multiply(q, conjugate(S)), rotate(S, w)
    elif what == "element":
        tensor = [[mpf(x) for x in row] for row in body[0]]
        i, j = ELEMENTS[k]
        tensor[i][j] += h
        if i != j:
            tensor[j][i] += h
        return truth.attitude_and_rate_of_tensor(tensor, omega, q0, t, digits)
    if len(body[0]) == 3 and hasattr(body[0][0], "__len__"):
        return truth.attitude_and_rate_of_tensor(body[0], omega, q0, t, digits)
    return truth.attitude_and_rate(moments, omega, q0, t, digits)


def partials(body, q0, t, inertia="moments", step=30):
    """(6, 12) of mpf, rows and columns as of `attitude.rigid_body.partials.Partials`.

    body : (moments or tensor, rate), exact binary numbers; t : number or tuple (hi, lo), s
    """
    groups = [("attitude", 3), ("rate", 3)]
    groups += [("moment", 3), ("axis", 3)] if inertia == "moments" else [("element", 6)]
    digits = 3 * step + 10
    columns = []
    with mp.workdps(digits + 20):
        h = mpf(10) ** -step
        scale = {"attitude": mpf(1), "rate": max(map(abs, map(mpf, body[1]))) or mpf(1), "axis": mpf(1)}
        flat = body[0] if not hasattr(body[0][0], "__len__") else [x for row in body[0] for x in row]
        scale["moment"] = scale["element"] = max(map(abs, map(mpf, flat)))
        for what, count in groups:
            for k in range(count):
                d = h * scale[what]
                (qp, wp), (qm, wm) = (_sample((what, k, s * d), body, q0, t, digits) for s in (1, -1))
                turn = multiply(conjugate(qm), qp)
                sign = 1 if turn[0] > 0 else -1
                theta = [2 * sign * x / (2 * d) for x in turn[1:]]
                columns.append([*theta, *((a - b) / (2 * d) for a, b in zip(wp, wm, strict=True))])
    return [list(row) for row in zip(*columns, strict=True)]

"""Impulse at a single contact point with friction, solved directly.

In components along the normal and two directions across it: u the point's velocity, K its response
to an impulse, u' = u + K j.  Either the point ends up sticking, K j = -u, with an impulse in the cone
abs(j_t) <= mu j_n; or it slides at the end along a direction d of the plane, and

    j = j_n (n - mu d),        u'_t = s d,  s >= 0,

which is one equation for the angle of d, with j_n prescribed, or such that u'_n = 0.  Where it has several
solutions the direction nearest to that of the initial sliding is chosen.
"""

import math

from ..intrinsics import routine

# The circle is searched in so many sectors; if the sign changes in none of them, in more.
SECTOR_COUNTS = (32, 2048)
BISECTION_STEPS = 56
UNKNOWN_NORMAL = -1.0


@routine
def solve(K, u, friction, normal):
    """(solved, j), j along normal and across; `normal` its normal part, or UNKNOWN_NORMAL for u'_n = 0.

    K : rows of a symmetric positive definite matrix; u : three components; friction > 0
    """
    j = _sticking(K, u) if normal == UNKNOWN_NORMAL else _sticking_across(K, u, normal)
    if j[0] >= 0.0 and math.hypot(j[1], j[2]) <= friction * j[0]:
        return True, j
    first = math.atan2(u[2], u[1])
    for sectors in SECTOR_COUNTS:
        sector = 2.0 * math.pi / sectors
        for k in range(sectors // 2):
            for side in (sector, -sector):
                near, far = first + k * side, first + (k + 1) * side
                solved, j = _bisect(K, u, friction, normal, near, far)
                if solved:
                    return True, j
    return False, (0.0, 0.0, 0.0)


@routine
def _sticking_across(K, u, normal):
    """K_tt j_t = -(u_t + K_tn j_n)."""
    b1, b2 = -u[1] - K[1][0] * normal, -u[2] - K[2][0] * normal
    below = K[1][1] * K[2][2] - K[1][2] * K[1][2]
    return normal, (K[2][2] * b1 - K[1][2] * b2) / below, (K[1][1] * b2 - K[1][2] * b1) / below


@routine
def _sticking(K, u):
    """K j = -u: the normal part from Schur's complement of the part across."""
    _, a1, a2 = _sticking_across(K, (0.0, u[1], u[2]), 0.0)
    _, b1, b2 = _sticking_across(K, (0.0, 0.0, 0.0), 1.0)
    below = K[0][0] + K[0][1] * b1 + K[0][2] * b2
    normal = -(u[0] + K[0][1] * a1 + K[0][2] * a2) / below
    return normal, a1 + b1 * normal, a2 + b2 * normal


@routine
def _sliding(K, u, friction, normal, angle):
    """(impulse, u' across d, u' along d) for sliding along d; impulse zero where no sliding is possible."""
    c, s = math.cos(angle), math.sin(angle)
    if normal == UNKNOWN_NORMAL:
        below = K[0][0] - friction * (K[0][1] * c + K[0][2] * s)
        normal = -u[0] / below if below > 0.0 else 0.0
    j1, j2 = -friction * normal * c, -friction * normal * s
    u1 = u[1] + K[1][0] * normal + K[1][1] * j1 + K[1][2] * j2
    u2 = u[2] + K[2][0] * normal + K[2][1] * j1 + K[2][2] * j2
    return (normal, j1, j2), c * u2 - s * u1, c * u1 + s * u2


@routine
def _bisect(K, u, friction, normal, near, far):
    """(solved, impulse) for a direction between two angles, by bisection."""
    j, value, _along = _sliding(K, u, friction, normal, near)
    end, other, _along = _sliding(K, u, friction, normal, far)
    if not (j[0] > 0.0 and end[0] > 0.0) or (value > 0.0) == (other > 0.0):
        return False, j
    along = 0.0
    for _ in range(BISECTION_STEPS):
        middle = 0.5 * (near + far)
        j, now, along = _sliding(K, u, friction, normal, middle)
        if (now > 0.0) == (value > 0.0):
            near = middle
        else:
            far = middle
    return along >= 0.0 and j[0] > 0.0, j

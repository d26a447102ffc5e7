"""The exact motion of a free body over one step, in plain doubles: what splitting drifts by.

Set-up in two parts (`invariants`) would cost more than all the rest of a step, and a step needs no
phase that holds for ever: the change of the attitude over a short time, to rounding, is enough.
Equation numbers (T1) ... are those of docs/torques.md.
"""

import math

import numpy as np

from ..doubledouble import two_product, two_sum
from ..intrinsics import fma, inlined, routine
from ..layout import ATTITUDE, AXIAL, AXIAL_LOW, INVERSES, MOMENTS, MOMENTUM, ROTORS, SPIN, SPIN_LOW
from ..phase import ROUND, sine_cosine
from ..rotation import PER_TURN, about, conjugate, normalised, product, rotated_back
from ..vectors import dot, scaled

# Nodes and weights of Radau's quadrature on (0, 1]; the last node is the end of the step.
NODES = 8
RADAU_NODES = np.array(
    [
        0.022479386438712497,
        0.11467905316090424,
        0.26578982278458946,
        0.45284637366944464,
        0.6473752828868303,
        0.8197593082631076,
        0.9437374394630779,
        1.0,
    ]
)
RADAU_WEIGHTS = np.array(
    [
        0.0572544073721286,
        0.12482395066493249,
        0.17350739781725064,
        0.19578608372624678,
        0.1882587726945593,
        0.15206531032339257,
        0.09267907740148965,
        0.015625,
    ]
)
# u' t that one quadrature spans with an error below rounding (docs/torques.md, section 2).
LONGEST = 0.5
NOTHING = 1e-100
# Landen transformations until the modulus is gone, from whatever modulus a double can tell from 1.
LEVELS = 12


@inlined
def attitude_of(state):
    """The attitude of the axes: what the state keeps, and the turn about the axis of symmetry."""
    sine, cosine = sine_cosine(0.5 * state[SPIN], 0.5 * state[SPIN_LOW])
    q = state[ATTITUDE], state[ATTITUDE + 1], state[ATTITUDE + 2], state[ATTITUDE + 3]
    return turned_about_third(q, sine, cosine)


@inlined
def turned_about_third(q, sine, cosine):
    """A quaternion after a rotation about the third axis by twice this angle."""
    w = fma(q[0], cosine, -q[3] * sine)
    x = fma(q[1], cosine, q[2] * sine)
    y = fma(q[2], cosine, -q[1] * sine)
    z = fma(q[3], cosine, q[0] * sine)
    return w, x, y, z


@inlined
def drift_symmetric(state, body, time):
    """A body symmetric about its third axis: a turn about the momentum at L/I1, after one about the axis.

    q(t) = exp(L t / 2 I1) q(0) exp(e3 (m3 (1/I3 - 1/I1) - h3/I3) t / 2), h3 the momentum of rotors along
    the axis.  Both rates come from momenta that
    only torques change, and the turn about the axis is counted apart from the attitude: rounding of the
    attitude never feeds back into a rate, so that errors grow with the root of the number of steps.
    """
    L = state[MOMENTUM], state[MOMENTUM + 1], state[MOMENTUM + 2]
    q = state[ATTITUDE], state[ATTITUDE + 1], state[ATTITUDE + 2], state[ATTITUDE + 3]
    q = normalised(product(about(L, time * body[INVERSES]), q))
    for i in range(4):
        state[ATTITUDE + i] = q[i]
    rate = (body[INVERSES + 2] - body[INVERSES]) * PER_TURN
    spin = fma(state[AXIAL], rate, -body[INVERSES + 2] * body[ROTORS + 2] * PER_TURN)
    hi, lo = two_product(spin, time)
    lo = fma(state[AXIAL_LOW] * rate, time, lo)
    turns, rest = two_sum(state[SPIN], hi)
    rest += lo + state[SPIN_LOW]
    turns -= 2.0 * (((0.5 * turns) + ROUND) - ROUND)  # of two turns, after which the quaternion returns
    state[SPIN], state[SPIN_LOW] = two_sum(turns, rest)


@routine
def drift(state, body, time, work):
    """A body of three different moments, in ascending order along its axes.

    work : (6, NODES), scratch
    """
    q = state[ATTITUDE], state[ATTITUDE + 1], state[ATTITUDE + 2], state[ATTITUDE + 3]
    m = rotated_back(q, (state[MOMENTUM], state[MOMENTUM + 1], state[MOMENTUM + 2]))
    L = math.sqrt(dot(m, m))
    if L == 0.0:
        return
    q = normalised(product(q, _free_turn(scaled(1.0 / L, m), L, body, time, work)))
    for i in range(4):
        state[ATTITUDE + i] = q[i]


@routine
def _free_turn(gamma, L, body, time, work):
    """The turn of the body in a time, in its own axes: q(t) = q(0) * this; gamma the momentum's direction.

    In axes of which the third is the one that the momentum circles, on its side: an exchange of the
    first and last axis, a half turn about the second, or both.
    """
    lo, mid, hi = body[MOMENTS], body[MOMENTS + 1], body[MOMENTS + 2]
    D = gamma[2] * gamma[2] * (hi - mid) / hi - gamma[0] * gamma[0] * (mid - lo) / lo
    g1, g2, g3 = gamma
    a1, a2, a3 = body[INVERSES], body[INVERSES + 1], body[INVERSES + 2]
    I1, I3 = lo, hi
    if D < 0.0:
        g1, g2, g3 = g3, -g2, g1
        a1, a3 = a3, a1
        I1, I3 = I3, I1
    side = -1.0 if g3 < 0.0 else 1.0
    g1, g3 = g1 * side, g3 * side
    differences = (I1 - mid) * a1 * a2, (I1 - I3) * a1 * a3, (mid - I3) * a2 * a3
    w, x, y, z = _circling_turn((g1, g2, g3), L, (a1, a2, a3), differences, time, work)
    x, z = x * side, z * side
    if D < 0.0:
        x, y, z = z, -y, x
    return w, x, y, z


@routine
def _circling_turn(g, L, a, differences, time, work):
    """The turn, where the momentum circles the third axis and g3 >= 0; differences a21, a31, a32.

    From g1 = A1 cn u, g2 = A2 sn u, g3 = A3 dn u by the addition theorems (eq. T4), and with the
    angle about the momentum by quadrature (eq. T5).
    """
    a21, a31, a32 = differences
    c_a1 = fma(a21 * g[1], g[1], a31 * g[2] * g[2])  # c - a1
    a3_c = fma(a31 * g[0], g[0], a32 * g[1] * g[1])  # a3 - c
    c_a2 = fma(a32 * g[2], g[2], -a21 * g[0] * g[0])  # c - a2
    pace = math.sqrt(c_a1 * a32)  # u' / L
    if pace > NOTHING * abs(a31):
        k1 = min(math.sqrt(max(a31 * c_a2 / (a32 * c_a1), 0.0)), 1.0)
        coefficients = a32 / pace, -a31 / pace, a21 / pace, a21 / c_a1
    else:  # symmetric, and the momentum across the axis: nothing circles
        k1, pace, coefficients = 1.0, 0.0, (0.0, 0.0, 0.0, 0.0)
    levels, stretch = _landen(k1, work)
    u = L * pace * time
    parts = max(1, math.ceil(abs(u) / LONGEST))
    start, angle = g, 0.0
    for _ in range(parts):
        end, integral = _quadrature(g, coefficients, u / parts, levels, stretch, work)
        g = end
        angle += integral
    angle = L * time * fma(-a3_c, angle / parts, a[2])
    return _between(start, g, angle)


@routine
def _landen(k1, work):
    """Moduli of descending Landen transformations, in the last row; how many, and by how much u shrinks.

    Source: DLMF 19.8(ii), 22.7(i): k' -> 2 sqrt(k') / (1 + k'), k -> (1 - k') / (1 + k').
    """
    stretch, levels = 1.0, 0
    k1 = max(k1, 1e-30)
    for i in range(LEVELS):
        k = (1.0 - k1) / (1.0 + k1)
        work[2 + i // NODES, i % NODES] = k
        levels, stretch = i + 1, stretch * (1.0 + k)
        if k < 1e-8:
            break
        k1 = 2.0 * math.sqrt(k1) / (1.0 + k1)
    return levels, 1.0 / stretch


@routine
def _quadrature(g, coefficients, u, levels, stretch, work):
    """gamma after u, and the mean of 1/(1 + gamma3) on the way."""
    p1, p2, p3, kappa = coefficients
    sines, cosines = work[0], work[1]
    for i in range(NODES):
        sine, cosine = sine_cosine(u * RADAU_NODES[i] * stretch * PER_TURN, 0.0)
        sines[i], cosines[i] = sine, cosine
    deltas = work[4]
    for i in range(NODES):
        deltas[i] = 1.0
    for level in range(levels - 1, -1, -1):
        k = work[2 + level // NODES, level % NODES]
        for i in range(NODES):
            ks2 = k * sines[i] * sines[i]
            factor = 1.0 / (1.0 + ks2)
            sines[i] *= (1.0 + k) * factor
            cosines[i] *= deltas[i] * factor
            deltas[i] = (1.0 - ks2) * factor
    mean = 0.0
    g1, g2, g3 = 0.0, 0.0, 0.0
    below = work[5]
    for i in range(NODES):
        s, c, d = sines[i], cosines[i], deltas[i]
        below[i] = 1.0 / fma(-kappa * g[1] * g[1], s * s, 1.0)
        third = fma(g[2], d, p3 * g[0] * g[1] * s * c) * below[i]
        mean += RADAU_WEIGHTS[i] / (1.0 + third)
        g3 = third
    s, c, d = sines[NODES - 1], cosines[NODES - 1], deltas[NODES - 1]
    g1 = fma(g[0], c, p1 * g[1] * g[2] * s * d) * below[NODES - 1]
    g2 = fma(g[1] * c, d, p2 * g[0] * g[2] * s) * below[NODES - 1]
    size = fma(-0.5, dot((g1, g2, g3), (g1, g2, g3)), 1.5)
    return (g1 * size, g2 * size, g3 * size), mean


@routine
def _between(start, end, angle):
    """conj(B0) exp(angle/2 about the momentum) B1, B the shortest turn of the third axis to the momentum."""
    sine, cosine = sine_cosine(0.5 * PER_TURN * angle, 0.0)
    turned = product((cosine, 0.0, 0.0, sine), _upright(end))
    return product(conjugate(_upright(start)), turned)


@routine
def _upright(g):
    w = math.sqrt(0.5 * (1.0 + g[2]))
    factor = 0.5 / w
    return w, g[1] * factor, -g[0] * factor, 0.0

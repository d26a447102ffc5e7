"""Partial derivatives beside a constant rate, axis 3 along it (docs/partial-derivatives.md, section 5)."""

import math

import numpy as np

from ..doubledouble import pair, two_sum
from ..intrinsics import inlined, routine
from ..phase import phase, sine_cosine
from ..vectors import rows_of, scaled, three
from .blocks import PITCH, ROWS, put, put_attitude_columns, put_axis_columns, to_body_axes


@routine
def constant_block(record, t, t_low, window, rows, oscillates, tensor):
    """Fill rows, (ROWS * BLOCK,), at the instants first to last, no more than a block.

    oscillates : None where what departs from the rate grows, anything else where it turns about the momentum
    tensor : None for moments and axes, anything else for the elements of the tensor
    """
    P, L, J = rows_of(record.axes), record.momentum, three(record.inverse)
    differences, root = three(record.differences), record.u_rate
    turns = pair(record.turns[0]), pair(record.turns[1])
    w0 = scaled(L * J[2], P[2])
    x, y, z = initial_rate(record, P, 0), initial_rate(record, P, 1), initial_rate(record, P, 2)
    inertia = inertia_change(record, 0), inertia_change(record, 1), inertia_change(record, 2)
    if tensor is not None:
        others = inertia_change(record, 3), inertia_change(record, 4), inertia_change(record, 5)
    for i in range(np.uint64(window[1] - window[0])):
        at = t[np.uint64(window[0]) + i], 0.0 if t_low is None else t_low[np.uint64(window[0]) + i]
        if oscillates is None:
            motion = growing(turns[0], differences, root, L * at[0], at)
        else:
            motion = oscillating(turns, differences, root, at)
        constants = P, L, J, differences, L * at[0]
        Mx, My, Mz = (
            derivative(x, constants, motion),
            derivative(y, constants, motion),
            derivative(z, constants, motion),
        )
        put(rows, 3, i, Mx[0], Mx[1])
        put(rows, 4, i, My[0], My[1])
        put(rows, 5, i, Mz[0], Mz[1])
        put_inertia_columns(rows, 6, i, inertia, (constants, motion))
        C = turn_about(P[2], motion[0])
        if tensor is None:
            put_axis_columns(rows, i, C, (w0, w0), (Mx, My, Mz))
        else:
            put_inertia_columns(rows, 9, i, others, (constants, motion))
        put_attitude_columns(rows, i, C)


@routine
def rest_block(t, window, rows):
    """Fill rows for a body at rest."""
    for i in range(np.uint64(window[1] - window[0])):
        for n in range(ROWS):
            rows[np.uint64(n) * PITCH + i] = 0.0
        for n in range(3):
            rows[np.uint64(13 * n) * PITCH + i] = 1.0
            rows[np.uint64(13 * n + 3) * PITCH + i] = t[np.uint64(window[0]) + i]
            rows[np.uint64(13 * n + 39) * PITCH + i] = 1.0


@routine
def initial_rate(record, P, c):
    """What component c of the initial rate changes along axes 1, 2, 3: momentum over L; J in no way."""
    J, L = record.inverse, record.momentum
    return (P[0][c] / J[0] / L, P[1][c] / J[1] / L, P[2][c] / J[2] / L), (0.0, 0.0, 0.0)


@routine
def inertia_change(record, k):
    """What column k of the inertia changes: momentum over L, and dJ gamma."""
    J, per_size = record.inverse, 1.0 / record.size
    w = J[2] * per_size
    mu = w * record.mix[k, 4], w * record.mix[k, 5], w * record.mix[k, 2]
    return mu, (-J[0] * mu[0], -J[1] * mu[1], -J[2] * mu[2])


@inlined
def put_inertia_columns(rows, first, i, changes, now):
    """Three columns of the inertia."""
    for n in range(3):
        rotation, rate = derivative(changes[n], *now)
        put(rows, first + n, i, rotation, rate)


@inlined
def derivative(change, constants, motion):
    """Small rotation and rate along the body's axes of a change of momentum and of J."""
    ((x, y, z), (d1, d2, d3)), (P, L, J, (_a21, a31, a32), tau) = change, constants
    (cosine, sine), (both, row1, row2), (first, second) = motion
    theta1 = row1 * x - both * y + first * d1 + second * a31 * d2
    theta2 = both * x - row2 * y + first * d2 - second * a32 * d1
    # what is not C (gamma x mu), turned by a quarter about axis 3
    rest1, rest2 = theta1 - (sine * x - cosine * y), theta2 - (cosine * x + sine * y)
    rate = L * (d1 - J[0] * rest2), L * (d2 + J[1] * rest1), L * (J[2] * z + d3)
    return to_body_axes(P, (theta1, theta2, tau * (J[2] * z + d3))), to_body_axes(P, rate)


@inlined
def turn_about(axis, angle):
    """C, which turns by minus the angle about axis 3 (e): cosine 1 + (1 - cosine) e e^T - sine [e]x."""
    (x, y, z), (cosine, sine) = axis, angle
    rest = 1.0 - cosine
    return (
        (cosine + rest * x * x, rest * x * y + sine * z, rest * x * z - sine * y),
        (rest * x * y - sine * z, cosine + rest * y * y, rest * y * z + sine * x),
        (rest * x * z + sine * y, rest * y * z - sine * x, cosine + rest * z * z),
    )


@inlined
def growing(turns, differences, root, tau, instant):
    """What `oscillating` returns, where A = [[0, a31], [-a32, 0]] does not turn."""
    _a21, a31, a32 = differences
    sine, cosine = sine_cosine(*phase(turns, *instant))
    half = sine_cosine(*phase((0.5 * turns[0], 0.5 * turns[1]), *instant))[0]
    x = root * tau
    first = math.sinh(x) / root if root > 0.0 else tau
    second = 2.0 * (math.sinh(0.5 * x) / root) ** 2 if root > 0.0 else 0.5 * tau * tau
    both = -2.0 * half * half - root * root * second
    return (cosine, sine), (both, sine - a31 * first, a32 * first - sine), (first, second)


@inlined
def oscillating(turns, differences, root, instant):
    """C = [[cosine, sine], [-sine, cosine]], C - exp(A tau), and the integrals of exp(A tau).

    A turns by x = s sqrt(a31 a32) tau, C by y = a3 tau; differences of the two through (y + x)/2 and
    (y - x)/2, which needles need.  Returns the angle of C; of the difference the diagonal (one number) and
    the others of row 1 and row 2; two integrals.
    """
    (half_sum, half_difference), (a21, a31, a32) = turns, differences
    p, p_low = phase(half_sum, *instant)
    d, d_low = phase(half_difference, *instant)
    sine_p, cosine_p = sine_cosine(p, p_low)
    sine_d = sine_cosine(d, d_low)[0]
    x, low = two_sum(p, -d)
    y, low_y = two_sum(p, d)
    low, low_y = low + (p_low - d_low), low_y + (p_low + d_low)
    half = sine_cosine(0.5 * x, 0.5 * low)[0]
    sine_x = sine_cosine(x, low)[0]
    sine_y, cosine_y = sine_cosine(y, low_y)
    both = -2.0 * sine_p * sine_d
    turn = 2.0 * cosine_p * sine_d  # sin y - sin x
    skew1, skew2 = -a31 * a21 / (root * (root + a31)), a32 * a21 / (root * (root + a32))
    difference = both, turn + skew1 * sine_x, -(turn + skew2 * sine_x)
    return (cosine_y, sine_y), difference, (sine_x / root, 2.0 * (half / root) * (half / root))

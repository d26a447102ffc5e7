"""Partial derivatives beside a constant rate, with axis 3 along the momentum (docs/theory.md, section 12)."""

import math

from ..doubledouble import two_sum
from ..intrinsics import routine
from ..phase import phase, sine_cosine
from ..vectors import unit_vector
from .long_arcs import add_change_of_inertia, momentum_of, write_column

AXIS = (0.0, 0.0, 1.0)


@routine
def constant_spin(record, t, t_low, columns):
    """Write the nine columns at t; returns C as three rows and gamma."""
    tau = record.momentum * t
    root, a31, a32 = record.u_rate, record.differences[1], record.differences[2]
    if a31 * a32 > 0.0:
        C, difference, stretch = oscillating(record, t, t_low)
    else:
        sine, cosine = sine_cosine(*phase(record.turns[0, 0], record.turns[0, 1], t, t_low))
        half = sine_cosine(*phase(0.5 * record.turns[0, 0], 0.5 * record.turns[0, 1], t, t_low))[0]
        C = (cosine, sine, 0.0), (-sine, cosine, 0.0), AXIS
        x = root * tau
        first = math.sinh(x) / root if root > 0.0 else tau
        second = 2.0 * (math.sinh(0.5 * x) / root) ** 2 if root > 0.0 else 0.5 * tau * tau
        both = -2.0 * half * half - root * root * second
        difference = (both, sine - a31 * first), (a32 * first - sine, both)
        stretch = first, second
    for column in range(9):
        if column < 3:
            x, y, z = unit_vector(column)
            d1, d2, d3 = 0.0, 0.0, 0.0
        else:
            x, y, z = momentum_of(record, column - 3, AXIS)
            d1, d2, d3 = -record.inverse[0] * x, -record.inverse[1] * y, -record.inverse[2] * z
        v1, v2 = -y, x  # gamma x mu
        s1 = stretch[0] * d1 + stretch[1] * a31 * d2
        s2 = stretch[0] * d2 - stretch[1] * a32 * d1
        rotation = (
            difference[0][0] * v1 + difference[0][1] * v2 + s1,
            difference[1][0] * v1 + difference[1][1] * v2 + s2,
            tau * (record.inverse[2] * z + d3),
        )
        # what is not C (gamma x mu), turned by a quarter about axis 3
        rest1 = rotation[0] - (C[0][0] * v1 + C[0][1] * v2)
        rest2 = rotation[1] - (C[1][0] * v1 + C[1][1] * v2)
        write_column(columns, column, record, rotation, (-rest2, rest1, z))
    add_change_of_inertia(columns, record, AXIS)
    return C, AXIS


@routine
def oscillating(record, t, t_low):
    """C, C - exp(A tau), and the integrals of exp(A tau), where A turns by x = s sqrt(a31 a32) tau.

    C turns by y = a3 tau; differences of the two through (y + x)/2 and (y - x)/2, which needles need.
    """
    root, a21 = record.u_rate, record.differences[0]
    a31, a32 = record.differences[1], record.differences[2]
    p, p_low = phase(record.turns[0, 0], record.turns[0, 1], t, t_low)
    d, d_low = phase(record.turns[1, 0], record.turns[1, 1], t, t_low)
    sine_p, cosine_p = sine_cosine(p, p_low)
    sine_d = sine_cosine(d, d_low)[0]
    x, low = two_sum(p, -d)
    y, low_y = two_sum(p, d)
    low, low_y = low + (p_low - d_low), low_y + (p_low + d_low)
    half = sine_cosine(0.5 * x, 0.5 * low)[0]
    sine_x = sine_cosine(x, low)[0]
    sine_y, cosine_y = sine_cosine(y, low_y)
    C = (cosine_y, sine_y, 0.0), (-sine_y, cosine_y, 0.0), AXIS
    both = -2.0 * sine_p * sine_d
    turn = 2.0 * cosine_p * sine_d  # sin y - sin x
    skew1, skew2 = -a31 * a21 / (root * (root + a31)), a32 * a21 / (root * (root + a32))
    difference = (both, turn + skew1 * sine_x), (-(turn + skew2 * sine_x), both)
    return C, difference, (sine_x / root, 2.0 * (half / root) ** 2)

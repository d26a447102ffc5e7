"""What loops over a block of instants share: the numbers of a body that they need, and writing of columns.

The numbers are copies, as tuples: LLVM cannot tell whether what is read from an array within a loop was
changed by the loop's stores, and would make no vectors.  Nor would it for signed indices, which may wrap, or
for a column whose index is known at run time only.
"""

from typing import NamedTuple

import numpy as np

from ..doubledouble import pair
from ..intrinsics import inlined, routine
from ..vectors import add_scaled, cross, dot, five, four, scaled, three

# Instants at a time; rows of a block: the (6, 12) derivatives, one row of the block for each.
BLOCK, ROWS = 64, 72
PITCH = np.uint64(BLOCK)


class BodyInLoop(NamedTuple):
    """Fields of INVARIANTS."""

    precession: tuple
    argument: tuple
    argument0: tuple
    half_turn: tuple
    per_half_turn: float
    slip: float
    nome: float
    alpha_re: tuple
    alpha_im: tuple
    beta_re: tuple
    beta_im: tuple
    amplitude: tuple
    modulus: float
    complementary_modulus: float
    K_prime: float


class RecordInLoop(NamedTuple):
    """Fields of PARTIALS."""

    inverse: tuple
    differences: tuple
    start: tuple
    b2: float
    u_rate: float
    quaternion: tuple
    direction: tuple
    weight: tuple
    series: tuple
    quotient: float
    integral0: tuple


class Column(NamedTuple):
    """A column that begins with the momentum mu, over L, at t = 0."""

    mu: tuple
    n: tuple  # gamma0 x mu, body axes
    begun: float  # chi0.mu
    pushed: float  # g0.mu
    stay: float  # gamma0.mu
    drift: float  # J gamma0.mu
    weights: tuple  # of the elements 11, 22, 33, 12, 13, 23 of the inertia
    axis: tuple  # of a moment: its axis, body components, and that over moment and unit of moments
    axis_per_moment: tuple


@inlined
def copies(body, record):
    """The fields of both records."""
    own = BodyInLoop(
        pair(body.precession),
        pair(body.argument),
        pair(body.argument0),
        pair(body.half_turn),
        body.per_half_turn,
        body.slip,
        body.nome,
        four(body.alpha_re),
        four(body.alpha_im),
        four(body.beta_re),
        four(body.beta_im),
        three(body.amplitude),
        body.modulus,
        body.complementary_modulus,
        body.K_prime,
    )
    g = record.direction
    return own, RecordInLoop(
        three(record.inverse),
        three(record.differences),
        three(record.start),
        record.b2,
        record.u_rate,
        four(record.quaternion),
        (five(g[0]), five(g[1]), five(g[2]), five(g[3])),
        pair(record.weight),
        four(record.series),
        record.quotient,
        three(record.integral0),
    )


@inlined
def to_body_axes(P, v):
    """A vector along axes 1, 2, 3 (three rows) along the body's."""
    return (
        P[0][0] * v[0] + P[1][0] * v[1] + P[2][0] * v[2],
        P[0][1] * v[0] + P[1][1] * v[1] + P[2][1] * v[2],
        P[0][2] * v[0] + P[1][2] * v[1] + P[2][2] * v[2],
    )


@routine
def rate_column(record, P, start, c):
    """Derivatives by component c of the initial rate; start : gamma0, g0, chi0."""
    J, per_L = record.inverse, 1.0 / record.momentum
    mu = P[0][c] / J[0] * per_L, P[1][c] / J[1] * per_L, P[2][c] / J[2] * per_L
    return column(record, P, start, mu, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0))


@routine
def inertia_column(record, P, start, k):
    """Derivatives by column k of the inertia."""
    mix, per_size, gamma0 = record.mix, 1.0 / record.size, start[0]
    weights = (
        per_size * mix[k, 0],
        per_size * mix[k, 1],
        per_size * mix[k, 2],
        per_size * mix[k, 3],
        per_size * mix[k, 4],
        per_size * mix[k, 5],
    )
    w = record.inverse[0] * gamma0[0], record.inverse[1] * gamma0[1], record.inverse[2] * gamma0[2]
    mu = (
        weights[0] * w[0] + weights[3] * w[1] + weights[4] * w[2],
        weights[3] * w[0] + weights[1] * w[1] + weights[5] * w[2],
        weights[4] * w[0] + weights[5] * w[1] + weights[2] * w[2],
    )
    return column(record, P, start, mu, weights)


@routine
def column(record, P, start, mu, weights):
    """The constants of a column."""
    (gamma0, g0, chi0), J = start, record.inverse
    moved = J[0] * gamma0[0], J[1] * gamma0[1], J[2] * gamma0[2]
    n = to_body_axes(P, cross(gamma0, mu))
    axis = add_scaled(add_scaled(scaled(weights[0], P[0]), weights[1], P[1]), weights[2], P[2])
    axis = scaled(record.size, axis)
    inverse = weights[0] * J[0] + weights[1] * J[1] + weights[2] * J[2]
    return Column(
        mu,
        n,
        dot(chi0, mu),
        dot(g0, mu),
        dot(gamma0, mu),
        dot(moved, mu),
        weights,
        axis,
        scaled(inverse, axis),
    )


@inlined
def put(rows, column, i, rotation, rate):
    """Store a column of the derivatives at instant i of the block."""
    for r in range(3):
        rows[np.uint64(12 * r + column) * PITCH + i] = rotation[r]
        rows[np.uint64(12 * (3 + r) + column) * PITCH + i] = rate[r]


@inlined
def put_attitude_columns(rows, i, C):
    """The columns of the initial attitude: those of C."""
    for r in range(3):
        for c in range(3):
            rows[np.uint64(12 * r + c) * PITCH + i] = C[r][c]


@inlined
def put_axis_columns(rows, i, C, rates, by_rate):
    """The columns of turns of the axes: the state turned the other way, then turned back.

    rates : at t = 0 and now; by_rate : small rotation and rate by the three components of the initial rate
    """
    (w0, w), (x, y, z) = rates, by_rate
    put_axis_column(rows, 0, i, ((C[0][0] - 1.0, C[1][0], C[2][0]), (0.0, -w[2], w[1])), (y, z, w0[1], w0[2]))
    put_axis_column(rows, 1, i, ((C[0][1], C[1][1] - 1.0, C[2][1]), (w[2], 0.0, -w[0])), (z, x, w0[2], w0[0]))
    put_axis_column(rows, 2, i, ((C[0][2], C[1][2], C[2][2] - 1.0), (-w[1], w[0], 0.0)), (x, y, w0[0], w0[1]))


@inlined
def put_axis_column(rows, c, i, turned, changes):
    """The column of turns about axis c.

    turned : C e_c - e_c and e_c x w; changes : by the next two components of the initial rate, and these
    """
    (M1, N1), (M2, N2), w1, w2 = changes
    rotation = add_scaled(add_scaled(turned[0], w2, M1), -w1, M2)
    put(rows, 9 + c, i, rotation, add_scaled(add_scaled(turned[1], w2, N1), -w1, N2))

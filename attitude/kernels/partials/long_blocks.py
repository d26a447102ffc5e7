"""Partial derivatives by moments over long arcs, at a block of instants: straight-line code for vectors.

The same as `long_arcs`, less what is rare.  All columns are made of four vectors, turned to the body's axes
once: small rotations of C n, g, gamma, chi, and rates of J gamma, J gamma', J X.
"""

import numpy as np

from ..intrinsics import inlined, routine
from ..vectors import add_scaled, cross, dot, scaled
from .integrals import theta_integrals, theta_now, transformed_integrals, transformed_now
from .long_arcs import functionals, momentum_of, turn_since_start, vectors_along

# Instants at a time; rows of a block: the (6, 12) derivatives, one row of the block for each.
BLOCK, ROWS = 64, 72


@inlined
def to_body_axes(P, v):
    """A vector along axes 1, 2, 3 (three rows) along the body's."""
    return (
        P[0][0] * v[0] + P[1][0] * v[1] + P[2][0] * v[2],
        P[0][1] * v[0] + P[1][1] * v[1] + P[2][1] * v[2],
        P[0][2] * v[0] + P[1][2] * v[1] + P[2][2] * v[2],
    )


@routine
def column_constants(start, P, mu):
    """Of a column with momentum mu at t = 0: n = gamma0 x mu (body axes), chi0.mu, g0.mu, gamma0.mu, mu."""
    gamma0, g0, chi0 = start
    return to_body_axes(P, cross(gamma0, mu)), dot(chi0, mu), dot(g0, mu), dot(gamma0, mu), mu


@inlined
def derivative(constants, f, R, eps, turn, vectors):
    """Small rotation and rate of one column."""
    C, n = turn, constants[0]
    gamma, g, chi, J_gamma, J_slope, J_X = vectors
    rotation = dot(C[0], n), dot(C[1], n), dot(C[2], n)
    rotation = add_scaled(add_scaled(add_scaled(rotation, f, g), R, gamma), eps, chi)
    rate = add_scaled(add_scaled(scaled(constants[3], J_gamma), f, J_slope), eps, J_X)
    return rotation, rate


@inlined
def put(rows, column, i, rotation, rate):
    """Store a column of the derivatives at instant i of the block."""
    for r in range(3):
        rows[(12 * r + column) * BLOCK + i] = rotation[r]
        rows[(12 * (3 + r) + column) * BLOCK + i] = rate[r]


@routine
def rows_of(matrix):
    """A (3, 3) array as three rows."""
    return (
        (matrix[0, 0], matrix[0, 1], matrix[0, 2]),
        (matrix[1, 0], matrix[1, 1], matrix[1, 2]),
        (matrix[2, 0], matrix[2, 1], matrix[2, 2]),
    )


@inlined
def turned_rows(C, P):
    """P^T C P: a matrix along axes 1, 2, 3 along the body's."""
    half = (
        (
            C[0][0] * P[0][0] + C[0][1] * P[1][0] + C[0][2] * P[2][0],
            C[0][0] * P[0][1] + C[0][1] * P[1][1] + C[0][2] * P[2][1],
            C[0][0] * P[0][2] + C[0][1] * P[1][2] + C[0][2] * P[2][2],
        ),
        (
            C[1][0] * P[0][0] + C[1][1] * P[1][0] + C[1][2] * P[2][0],
            C[1][0] * P[0][1] + C[1][1] * P[1][1] + C[1][2] * P[2][1],
            C[1][0] * P[0][2] + C[1][1] * P[1][2] + C[1][2] * P[2][2],
        ),
        (
            C[2][0] * P[0][0] + C[2][1] * P[1][0] + C[2][2] * P[2][0],
            C[2][0] * P[0][1] + C[2][1] * P[1][1] + C[2][2] * P[2][1],
            C[2][0] * P[0][2] + C[2][1] * P[1][2] + C[2][2] * P[2][2],
        ),
    )
    x = to_body_axes(P, (half[0][0], half[1][0], half[2][0]))
    y = to_body_axes(P, (half[0][1], half[1][1], half[2][1]))
    z = to_body_axes(P, (half[0][2], half[1][2], half[2][2]))
    return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])


@routine
def constants_of_columns(body, record, P):
    """Of the columns of the initial rate (3) and of the moments of axes 1, 2, 3 (`column_constants`)."""
    J = record.inverse[0], record.inverse[1], record.inverse[2]
    gamma0, g0, _slope0, chi0, _X0 = vectors_along(
        body, record, (record.start[0], record.start[1], record.start[2])
    )
    start, per_L, per_size = (gamma0, g0, chi0), 1.0 / record.momentum, 1.0 / record.size
    return (
        column_constants(start, P, (P[0][0] / J[0] * per_L, P[1][0] / J[1] * per_L, P[2][0] / J[2] * per_L)),
        column_constants(start, P, (P[0][1] / J[0] * per_L, P[1][1] / J[1] * per_L, P[2][1] / J[2] * per_L)),
        column_constants(start, P, (P[0][2] / J[0] * per_L, P[1][2] / J[1] * per_L, P[2][2] / J[2] * per_L)),
        column_constants(start, P, scaled(per_size, momentum_of(record, 0, gamma0))),
        column_constants(start, P, scaled(per_size, momentum_of(record, 1, gamma0))),
        column_constants(start, P, scaled(per_size, momentum_of(record, 2, gamma0))),
    )


@inlined
def put_rate_column(rows, c, i, constants, passed):
    """The column of component c of the initial rate; returns it."""
    J, gamma0, tau, growth, momenta, C, vectors = passed
    mu = constants[4]
    f, push = growth * (dot(momenta, mu) - constants[1]), growth * constants[2]
    drift = tau * (J[0] * gamma0[0] * mu[0] + J[1] * gamma0[1] * mu[1] + J[2] * gamma0[2] * mu[2])
    rotation, rate = derivative(constants, f, drift, push, C, vectors)
    put(rows, 3 + c, i, rotation, rate)
    return rotation, rate


@inlined
def put_moment_column(rows, column, i, constants, own, passed):
    """The column of the moment of an axis; own : F, R, eps of a unit of it, and the rate that dJ adds."""
    growth, per_size, C, vectors = passed
    f = growth * (per_size * own[0] - constants[1])
    push = growth * (per_size * own[2] + constants[2])
    rotation, rate = derivative(constants, f, per_size * own[1], push, C, vectors)
    put(rows, column, i, rotation, add_scaled(rate, per_size * own[3], own[4]))


@inlined
def put_axis_column(rows, c, i, turned, rates):
    """The column of turns of the axes about axis c, and that of the initial attitude."""
    (column, unit), (w0, w, M, N) = turned, rates
    turn, now = cross(unit, w0), cross(unit, w)
    rotation = add_scaled(add_scaled(add_scaled(column, -1.0, unit), -turn[0], M[0]), -turn[1], M[1])
    rate = add_scaled(add_scaled(now, -turn[0], N[0]), -turn[1], N[1])
    put(rows, 9 + c, i, add_scaled(rotation, -turn[2], M[2]), add_scaled(rate, -turn[2], N[2]))
    for r in range(3):
        rows[(12 * r + c) * BLOCK + i] = column[r]


@routine
def long_block(body, record, t, t_low, window, rows, transformed):
    """Fill rows, (ROWS * BLOCK,), at the instants first to last, no more than a block.

    None of them on a short arc; the record of no needle and of no constant rate.

    transformed : None for theta functions, anything else for the transformed series
    """
    first, last = window
    P, L, per_size = rows_of(record.axes), record.momentum, 1.0 / record.size
    J = record.inverse[0], record.inverse[1], record.inverse[2]
    gamma0 = record.initial[0], record.initial[1], record.initial[2]
    x, y, z, one, two, three = constants_of_columns(body, record, P)
    first_place, second_place, third_place = (
        moment_column(record, 0),
        moment_column(record, 1),
        moment_column(record, 2),
    )
    w0 = to_body_axes(P, (L * J[0] * gamma0[0], L * J[1] * gamma0[1], L * J[2] * gamma0[2]))
    for i in range(np.uint64(last - first)):
        instant = t[first + i]
        low = 0.0 if t_low is None else t_low[first + i]
        tau = L * instant
        if transformed is None:
            q, hat, now = theta_now(body, record, instant, low)
            integrals = theta_integrals(body, record, record.u_rate * tau, now)
        else:
            q, hat, now = transformed_now(body, record, instant, low)
            integrals = transformed_integrals(body, record, record.u_rate * tau, now)
        C = turned_rows(turn_since_start(record, q), P)
        gamma, g, slope, chi, X = vectors_along(body, record, hat)
        momenta, F, R, eps = functionals(body, record, tau, hat, integrals, transformed)
        w = to_body_axes(P, (L * J[0] * gamma[0], L * J[1] * gamma[1], L * J[2] * gamma[2]))
        J_slope = to_body_axes(P, (L * J[0] * slope[0], L * J[1] * slope[1], L * J[2] * slope[2]))
        J_X = to_body_axes(P, (L * J[0] * X[0], L * J[1] * X[1], L * J[2] * X[2]))
        turned = to_body_axes(P, gamma), to_body_axes(P, g), to_body_axes(P, chi)
        vectors = (*turned, w, J_slope, J_X)
        passed = J, gamma0, tau, now[3], momenta, C, vectors
        Mx, Nx = put_rate_column(rows, 0, i, x, passed)
        My, Ny = put_rate_column(rows, 1, i, y, passed)
        Mz, Nz = put_rate_column(rows, 2, i, z, passed)
        scales = now[3], per_size, C, vectors
        own = F[0], R[0], eps[0], -L * J[0] * J[0] * gamma[0], P[0]
        put_moment_column(rows, first_place, i, one, own, scales)
        own = F[1], R[1], eps[1], -L * J[1] * J[1] * gamma[1], P[1]
        put_moment_column(rows, second_place, i, two, own, scales)
        own = F[2], R[2], eps[2], -L * J[2] * J[2] * gamma[2], P[2]
        put_moment_column(rows, third_place, i, three, own, scales)
        rates = w0, w, (Mx, My, Mz), (Nx, Ny, Nz)
        put_axis_column(rows, 0, i, ((C[0][0], C[1][0], C[2][0]), (1.0, 0.0, 0.0)), rates)
        put_axis_column(rows, 1, i, ((C[0][1], C[1][1], C[2][1]), (0.0, 1.0, 0.0)), rates)
        put_axis_column(rows, 2, i, ((C[0][2], C[1][2], C[2][2]), (0.0, 0.0, 1.0)), rates)


@routine
def moment_column(record, e):
    """Column of the derivatives by the moment of axis e."""
    for k in range(3):
        if record.mix[k, e] > 0.5:
            return 6 + k
    return 6 + e


@routine
def copy_block(rows, window, place, out):
    """Rows of the block to `out`, (6, 12, m, k); all but the body rate's by the initial attitude, zero."""
    first, last = window
    for r in range(6):
        for c in range(12):
            if r < 3 or c >= 3:
                for i in range(np.uint64(last - first)):
                    out[r, c, place, first + i] = rows[(12 * r + c) * BLOCK + i]

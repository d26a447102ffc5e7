"""Partial derivatives over long arcs, at a block of instants: straight-line code for vectors.

Equations (50) to (52) of docs/partial-derivatives.md, for all bodies but needles that spin about themselves
(`long_arcs.needle_arc`).  All columns are made of four vectors, turned to the body's axes once: small
rotations of C n, g, gamma, chi, and rates of J gamma, J gamma', J X.
"""

import numpy as np

from ..intrinsics import inlined, routine
from ..vectors import add_scaled, dot, rows_of, scaled
from .blocks import (
    copies,
    inertia_column,
    put,
    put_attitude_columns,
    put_axis_columns,
    rate_column,
    to_body_axes,
)
from .integrals import theta_integrals, theta_now, transformed_integrals, transformed_now
from .long_arcs import functionals, matrix_of, turn_since_start, vectors_along


@inlined
def derivative(column, f, R, eps, vectors):
    """Small rotation and rate of a column."""
    C, gamma, g, chi, J_gamma, J_slope, J_X = vectors
    rotation = dot(C[0], column.n), dot(C[1], column.n), dot(C[2], column.n)
    rotation = add_scaled(add_scaled(add_scaled(rotation, f, g), R, gamma), eps, chi)
    rate = add_scaled(add_scaled(scaled(column.stay, J_gamma), f, J_slope), eps, J_X)
    return rotation, rate


@inlined
def put_rate_column(rows, c, i, column, now):
    """The column of component c of the initial rate; returns it."""
    tau, growth, (momenta, _F, _R, _eps), vectors = now
    f = growth * (dot(momenta, column.mu) - column.begun)
    rotation, rate = derivative(column, f, tau * column.drift, growth * column.pushed, vectors)
    put(rows, 3 + c, i, rotation, rate)
    return rotation, rate


@inlined
def inertia_derivative(column, now, tensor):
    """Small rotation and rate of a column of the inertia; the rate less what dJ adds."""
    _tau, growth, (_momenta, F, R, eps), vectors = now
    f = growth * (weighted(column.weights, F, tensor) - column.begun)
    push = growth * (weighted(column.weights, eps, tensor) + column.pushed)
    return derivative(column, f, weighted(column.weights, R, tensor), push, vectors)


@inlined
def weighted(weights, elements, tensor):
    """Sum over the elements 11, 22, 33 of the inertia, and over all six of a tensor."""
    total = (
        weight(weights[0], elements[0]) + weight(weights[1], elements[1]) + weight(weights[2], elements[2])
    )
    if tensor is not None:
        total += weight(weights[3], elements[3]) + weight(weights[4], elements[4])
        total += weight(weights[5], elements[5])
    return total


@inlined
def weight(factor, x):
    """The product, zero where the factor is and x has no limit."""
    return factor * x if factor != 0.0 else 0.0


@inlined
def put_moment_column(rows, k, i, column, now):
    """The column of principal moment k."""
    rotation, rate = inertia_derivative(column, now, None)
    along = dot(column.axis, now[3][4])
    put(rows, 6 + k, i, rotation, add_scaled(rate, -along, column.axis_per_moment))


@inlined
def put_element_column(rows, place, i, column, inverse, now):
    """The column of an element of the tensor; place : its index, row and column; inverse : of the tensor."""
    k, m, n = place
    w = now[3][4]
    rotation, rate = inertia_derivative(column, now, 1)
    rate = add_scaled(rate, -w[n], inverse[m])
    if m != n:
        rate = add_scaled(rate, -w[m], inverse[n])
    put(rows, 6 + k, i, rotation, rate)


@routine
def inverse_tensor(record, P):
    """The inverse of the tensor along the body's axes, over the unit of moments, as three rows."""
    J, per_size = record.inverse, 1.0 / record.size
    rows = scaled(J[0] * per_size, P[0]), scaled(J[1] * per_size, P[1]), scaled(J[2] * per_size, P[2])
    x = rows[0][0], rows[1][0], rows[2][0]
    y = rows[0][1], rows[1][1], rows[2][1]
    z = rows[0][2], rows[1][2], rows[2][2]
    return to_body_axes(P, x), to_body_axes(P, y), to_body_axes(P, z)


@routine
def long_block(body, record, t, t_low, window, rows, transformed, tensor):
    """Fill rows, (ROWS * BLOCK,), at the instants first to last, no more than a block.

    None of them on a short arc; the record of no needle and of no constant rate.

    transformed : None for theta functions, anything else for the transformed series
    tensor : None for moments and axes, anything else for the elements of the tensor
    """
    P, L = rows_of(record.axes), record.momentum
    own, constants = copies(body, record)
    gamma0, g0, _slope0, chi0, _X0 = vectors_along(own, constants, constants.start)
    start, J = (gamma0, g0, chi0), constants.inverse
    x, y, z = (
        rate_column(record, P, start, 0),
        rate_column(record, P, start, 1),
        rate_column(record, P, start, 2),
    )
    a, b, c = (
        inertia_column(record, P, start, 0),
        inertia_column(record, P, start, 1),
        inertia_column(record, P, start, 2),
    )
    if tensor is not None:
        d, e, f = (
            inertia_column(record, P, start, 3),
            inertia_column(record, P, start, 4),
            inertia_column(record, P, start, 5),
        )
        inverse = inverse_tensor(record, P)
    w0 = to_body_axes(P, (L * J[0] * gamma0[0], L * J[1] * gamma0[1], L * J[2] * gamma0[2]))
    for i in range(np.uint64(window[1] - window[0])):
        instant = t[np.uint64(window[0]) + i]
        low = 0.0 if t_low is None else t_low[np.uint64(window[0]) + i]
        tau = L * instant
        if transformed is None:
            q, hat, state = theta_now(own, constants, instant, low)
            integrals = theta_integrals(own, constants, constants.u_rate * tau, state)
        else:
            q, hat, state = transformed_now(own, constants, instant, low)
            integrals = transformed_integrals(own, constants, constants.u_rate * tau, state)
        turn = turn_since_start(constants, q)
        C = matrix_of(turn[0], *to_body_axes(P, (turn[1], turn[2], turn[3])))
        gamma, g, slope, chi, X = vectors_along(own, constants, hat)
        w = to_body_axes(P, (L * J[0] * gamma[0], L * J[1] * gamma[1], L * J[2] * gamma[2]))
        J_slope = to_body_axes(P, (L * J[0] * slope[0], L * J[1] * slope[1], L * J[2] * slope[2]))
        J_X = to_body_axes(P, (L * J[0] * X[0], L * J[1] * X[1], L * J[2] * X[2]))
        vectors = C, to_body_axes(P, gamma), to_body_axes(P, g), to_body_axes(P, chi), w, J_slope, J_X
        now = tau, state[3], functionals(own, constants, tau, hat, integrals, transformed), vectors
        Mx = put_rate_column(rows, 0, i, x, now)
        My = put_rate_column(rows, 1, i, y, now)
        Mz = put_rate_column(rows, 2, i, z, now)
        if tensor is None:
            put_moment_column(rows, 0, i, a, now)
            put_moment_column(rows, 1, i, b, now)
            put_moment_column(rows, 2, i, c, now)
            put_axis_columns(rows, i, C, (w0, w), (Mx, My, Mz))
        else:
            put_element_column(rows, (0, 0, 0), i, a, inverse, now)
            put_element_column(rows, (1, 1, 1), i, b, inverse, now)
            put_element_column(rows, (2, 2, 2), i, c, inverse, now)
            put_element_column(rows, (3, 0, 1), i, d, inverse, now)
            put_element_column(rows, (4, 0, 2), i, e, inverse, now)
            put_element_column(rows, (5, 1, 2), i, f, inverse, now)
        put_attitude_columns(rows, i, C)

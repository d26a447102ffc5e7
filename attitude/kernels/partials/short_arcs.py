"""Partial derivatives over arcs in which the momentum hardly moves in the body: Gauss's quadrature.

Over abs(u) < 1/2 the differences of the closed form cancel; they are integrals of smooth functions
(docs/partial-derivatives.md, section 4).  Scaled by A1 as in `long_arcs`.
"""

from enum import IntEnum

from ..cayley_klein import exp_pair, half_turn_of, since_half_turn, theta_direction, transformed_direction
from ..doubledouble import pair
from ..intrinsics import fma, routine
from ..layout import PartialsKind, Route
from ..phase import argument, sine_cosine
from ..vectors import add_scaled, cross, dot, five, three, unit_vector
from .integrals import theta_now, transformed_now
from .long_arcs import (
    add_change_of_inertia,
    azimuth_turn,
    matrix_of,
    momentum_of,
    moved,
    needle_momentum,
    needle_part,
    turn_since_start,
    vectors_along,
    write_column,
)

NODES, SHORT = 8, 0.5  # SHORT: rad, of u


class ArcNode(IntEnum):
    """Rows of the workspace, by node, (3) each."""

    HAT = 0  # gamma1/A1, gamma2/A1, gamma3
    CHANGE = 3  # the same less their values at t = 0, the third over A1 too
    SLOPE = 6  # of HAT; then, in the first, of eps/A1


@routine
def at_node(work, row, j):
    """Three numbers of node j, from `row` on."""
    return work[row, j], work[row + 1, j], work[row + 2, j]


@routine
def direction_at(body, record, t, t_low):
    """(gamma1/A1, gamma2/A1, gamma3) at t."""
    x, rest = argument(pair(body.argument), t, t_low, pair(body.argument0))
    g = record.direction
    if body.route == Route.THETA:
        s, c = sine_cosine(x, rest)
        return theta_direction(s, c, fma(c, c, -s * s), (five(g[0]), five(g[1]), five(g[2]), five(g[3])))
    y, signs, _n = since_half_turn(x, rest, *half_turn_of(body))
    e, inverse = exp_pair(-2.0 * abs(y))
    return transformed_direction((e, body.nome * inverse, body.nome * e), signs, body.nome, three(g[0]))


@routine
def slope_of(body, record, hat):
    """Rate of (gamma1/A1, gamma2/A1, gamma3/A1), over L."""
    a21, a31, a32 = record.differences[0], record.differences[1], record.differences[2]
    x, y, z = hat
    return a32 * y * z, -a31 * z * x, a21 * body.amplitude[0] * x * y


@routine
def change_along(body, record, hat, now, d):
    """Changes of g/A1, gamma'/A1, A1 chi, A1 X as gamma/A1 changes by d, from hat to now."""
    A1, A3 = body.amplitude[0], body.amplitude[2]
    a21, a31, a32 = record.differences[0], record.differences[1], record.differences[2]
    d3 = A1 * d[2]
    g = -a31 * A3 * A3 * d[0], record.b2 * d[1], a31 * A1 * d3
    slope = (
        a32 * (d[1] * now[2] + hat[1] * d3),
        -a31 * (d[0] * now[2] + hat[0] * d3),
        a21 * A1 * (d[0] * now[1] + hat[0] * d[1]),
    )
    over = 1.0 / (a31 * now[2] * hat[2])
    chi = (hat[1] * d3 - hat[2] * d[1]) * over, (hat[2] * d[0] - hat[0] * d3) * over, 0.0
    X = -d[0] / a31, -d[1] / a31, -(d[2] / a31 + d[2] * over)
    return g, slope, chi, X


@routine
def inertia_change(record, e, gamma):
    """dJ gamma of element e: -J dI J gamma."""
    v = momentum_of(record, e, gamma)
    return -record.inverse[0] * v[0], -record.inverse[1] * v[1], -record.inverse[2] * v[2]


@routine
def fill_nodes(body, record, scheme, t, t_low, work):
    """Directions at the nodes and their changes since t = 0; returns the change up to t."""
    tau = record.momentum * t
    for j in range(NODES):
        low = 0.0 if t_low is None else t_low * scheme[0, j]
        hat = direction_at(body, record, t * scheme[0, j], low)
        for i in range(3):
            work[ArcNode.HAT + i, j] = hat[i]
    whole = 0.0, 0.0, 0.0
    for j in range(NODES):
        slope = slope_of(body, record, at_node(work, ArcNode.HAT, j))
        whole = add_scaled(whole, tau * scheme[1, j], slope)
        for i in range(3):
            work[ArcNode.SLOPE + i, j] = slope[i]
    for j in range(NODES):
        for i in range(3):
            total = 0.0
            for k in range(NODES):
                total = fma(scheme[2 + j, k], work[ArcNode.SLOPE + i, k], total)
            work[ArcNode.CHANGE + i, j] = tau * total
    return whole


@routine
def short_arc(body, record, scheme, t, t_low, work, columns):
    """Write the nine columns at t; returns C as three rows and gamma."""
    tau = record.momentum * t
    whole = fill_nodes(body, record, scheme, t, t_low, work)
    q, hat, _now = (
        theta_now(body, record, t, t_low)
        if body.route == Route.THETA
        else transformed_now(body, record, t, t_low)
    )
    C = matrix_of(*turn_since_start(record, q))
    vectors = vectors_along(body, record, hat)
    A1 = body.amplitude[0]
    start = record.start[0], record.start[1], record.start[2]
    gamma0, g0, _slope0, chi0, _X0 = vectors_along(body, record, start)
    change = change_along(body, record, start, hat, whole)
    h = advances(record, scheme, tau, work)
    for i in range(3):
        mu = unit_vector(i)
        state_column(record, i, mu, (C, tau, h, A1), (gamma0, g0, chi0), (vectors, change, whole), columns)
        if record.kind == PartialsKind.NEEDLE:
            turn = azimuth_turn(body, record, t, t_low)
            f, stay = A1 * gamma0[i] * h[i], tau * record.inverse[i] * gamma0[i]
            rotation = needle_part(body, record, (hat, start), turn, mu)
            rotation = add_scaled(add_scaled(rotation, f, vectors[1]), stay, vectors[0])
            third = needle_momentum(body, record, (hat, start), mu)
            third += (f - dot(chi0, mu)) * vectors[2][2]
            write_column(columns, i, record, rotation, (columns[i, 3], columns[i, 4], third))
    for e in range(record.elements):
        rotation, momentum = forced_column(body, record, e, scheme, tau, (hat, vectors, whole), work)
        mu = momentum_of(record, e, gamma0)
        for i in range(3):
            rotation = add_scaled(rotation, mu[i], (columns[i, 0], columns[i, 1], columns[i, 2]))
            momentum = add_scaled(momentum, mu[i], (columns[i, 3], columns[i, 4], columns[i, 5]))
        write_column(columns, 3 + e, record, rotation, momentum)
    add_change_of_inertia(columns, record, vectors[0])
    return C, vectors[0]


@routine
def advances(record, scheme, tau, work):
    """h1, h2, h3 at t."""
    a21, a31 = record.differences[0], record.differences[1]
    h1, h2, h3 = 0.0, 0.0, 0.0
    for j in range(NODES):
        x, y, z = at_node(work, ArcNode.HAT, j)
        weight = tau * scheme[1, j] / (z * z)
        h1 -= weight * a21 * y * y / a31
        h2 += weight * a21 * x * x / a31
        h3 += weight
    return h1, h2, h3


@routine
def state_column(record, i, mu, passed, start, now, columns):
    """Derivatives by the momentum mu along axis i."""
    (C, tau, h, A1), (gamma0, g0, chi0), (vectors, change, whole) = passed, start, now
    gamma, g, slope, _chi, _X = vectors
    v = cross(gamma0, mu)
    f, stay = A1 * gamma0[i] * h[i], gamma0[i]
    moved_v = moved(C, gamma0, mu)
    rotation = moved_v[0] - v[0], moved_v[1] - v[1], moved_v[2] - v[2]
    rotation = add_scaled(add_scaled(rotation, -chi0[i], change[0]), g0[i], change[2])
    rotation = add_scaled(add_scaled(rotation, f, g), tau * record.inverse[i] * stay, gamma)
    momentum = add_scaled(mu, stay, (A1 * whole[0], A1 * whole[1], A1 * whole[2]))
    momentum = add_scaled(add_scaled(momentum, -chi0[i], change[1]), g0[i], change[3])
    write_column(columns, i, record, rotation, add_scaled(momentum, f, slope))


@routine
def forced_column(body, record, e, scheme, tau, now, work):
    """Small rotation and momentum at t that a unit of element e drives, from the change dJ alone."""
    hat, vectors, whole = now
    gamma, g, slope, _chi, _X = vectors
    A1, a31 = body.amplitude[0], record.differences[1]
    for j in range(NODES):
        there = at_node(work, ArcNode.HAT, j)
        drive = inertia_change(record, e, (A1 * there[0], A1 * there[1], there[2]))
        work[ArcNode.SLOPE, j] = -dot(slope_of(body, record, there), drive)
    rotation, momentum, total, weighted = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0
    for j in range(NODES):
        there = at_node(work, ArcNode.HAT, j)
        since = at_node(work, ArcNode.CHANGE, j)
        rest = whole[0] - since[0], whole[1] - since[1], whole[2] - since[2]
        gamma_j, _g, _slope, _chi_j, X = vectors_along(body, record, there)
        drive = inertia_change(record, e, gamma_j)
        eps = 0.0
        for k in range(NODES):
            eps = fma(scheme[2 + j, k], work[ArcNode.SLOPE, k], eps)
        weight, eps = tau * scheme[1, j], tau * eps
        total += weight * eps
        x, y, z = there
        weighted += weight * eps * (x * x + y * y) / (a31 * z * z)
        change = change_along(body, record, there, hat, rest)
        along, stay = dot(X, drive), dot(gamma_j, drive)
        moved_gamma = A1 * rest[0], A1 * rest[1], A1 * rest[2]
        slope_j = work[ArcNode.SLOPE, j]
        part = add_scaled(add_scaled(drive, along, change[0]), slope_j, change[2])
        rotation = add_scaled(rotation, weight, add_scaled(part, stay, moved_gamma))
        part = add_scaled(add_scaled(cross(gamma_j, drive), along, change[1]), slope_j, change[3])
        momentum = add_scaled(momentum, weight, part)
    f = A1 * A1 * weighted
    rotation = add_scaled(add_scaled(rotation, f, g), A1 * total, gamma)
    return rotation, add_scaled(momentum, f, slope)

"""Partial derivatives along axes 1, 2, 3 where the rate is not constant.

Equations (49) to (52) of docs/partial-derivatives.md; needles are in its section 4.

Vectors over or times A1: g/A1, gamma'/A1, A1 chi, A1 X, A1 F, eps/A1, so that no amplitude is squared.
"""

import math

from ..doubledouble import pair, two_sum
from ..intrinsics import fma, inlined, routine
from ..phase import argument, phase, sine_cosine
from ..rotation import conjugate, product
from ..vectors import add_scaled, cross, dot, scaled, unit_vector
from .integrals import theta_integrals, theta_now

# Columns: momenta along axes 1, 2, 3, each of L; then the elements 11, 22, 33, 12, 13, 23 of the inertia.
# Rows of `columns`, by column: small rotation (3), momentum over L (3), rate over L (3).


@inlined
def turn_since_start(record, q):
    """The quaternion of C = R(t)^T R(0) along axes 1, 2, 3."""
    start = record.quaternion
    return product(conjugate(q), (start[0], start[1], start[2], start[3]))


@inlined
def matrix_of(w, x, y, z):
    """The matrix of a unit quaternion, as three rows."""
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


@inlined
def vectors_along(body, record, gamma):
    """(gamma, g/A1, gamma'/A1, A1 chi, A1 X) of (gamma1/A1, gamma2/A1, gamma3)."""
    A1, A3, (x, y, z) = body.amplitude[0], body.amplitude[2], gamma
    a21, a31, a32 = record.differences[0], record.differences[1], record.differences[2]
    over = 1.0 / (a31 * z)
    g = -a31 * A3 * A3 * x, record.b2 * y, a31 * A1 * z
    slope = a32 * y * z, -a31 * z * x, a21 * A1 * x * y
    chi = -y * over, x * over, 0.0
    X = x * (-1.0 / a31), y * (-1.0 / a31), A1 * (x * x + y * y) * over
    return (A1 * x, A1 * y, z), g, slope, chi, X


@inlined
def functionals(body, record, tau, gamma, integrals, transformed):
    """A1 F of unit momenta, A1 F, R and eps/A1 of the six elements of inertia; transformed : None or 1.

    F is less its part -chi0.mu, eps less g0.mu: `start_part` has those.
    """
    cn2, sn2, dn2, cd2, sd2, nd2 = integrals
    A1, A3 = body.amplitude[0], body.amplitude[2]
    a21, a31, a32 = record.differences[0], record.differences[1], record.differences[2]
    a1, a2, a3 = record.inverse[0], record.inverse[1], record.inverse[2]
    x0, y0, z0 = record.start[0], record.start[1], record.start[2]
    x, y, z = gamma
    start = A1 * x0, A1 * y0, z0
    # numbers of the body are divided by one another, not variables by them: loops divide but once
    per_rate = 1.0 / record.u_rate
    per_A3, per_a31 = per_rate / (A3 * A3), 1.0 / a31
    Q1, Q2 = cd2 * (per_A3 / a31), sd2 * (per_A3 / a32)  # Q11/b3, Q22/b3
    G1, G2 = cn2 * (per_rate / a31), sn2 * (per_rate / a32)
    H = Q1 + Q2
    h1, h2, h3 = -a21 * Q2, a21 * Q1, nd2 * per_A3
    dx, dy = x - x0, y - y0
    if transformed is None:
        g12 = -A1 * dy * (y + y0) / (a31 * (z + z0))  # G12/A1
        dz = a21 * g12
        own = 0.0 if z0 * z0 > 0.5 else 1.0
        d33 = own * dz * (z + z0) - (1.0 - own) * A1 * (dx * (x + x0) + dy * (y + y0))
        d22 = A1 * dy * (y + y0)
        f1 = start[0] * start[0] * (a1 * h1 - 0.5 * a1 * a1 * H) + 0.5 * a1 * a1 * (G1 + Q1)
        f2 = start[1] * start[1] * (a2 * h2 - 0.5 * a2 * a2 * H) + 0.5 * a2 * a2 * (G2 + Q2)
        f3 = z0 * z0 * (a3 * h3 - 0.5 * a3 * a3 * H) - 0.5 * a3 * a3 * (G1 + G2)
    else:
        dz = (z - z0) * (1.0 / A1)
        g12 = dz * (1.0 / a21)
        d33 = dz * (z + z0)
        d22 = -(A1 * dx * (x + x0) + d33)
        half = 0.5 * (start[0] * start[0] + z0 * z0)
        f1 = start[0] * start[0] * a1 * (tau + share(record, a1) * H) + 0.5 * a1 * a1 * (G1 + Q1)
        f2 = start[1] * start[1] * a2 * h2 + a2 * a2 * (half * H + 0.5 * (G2 - Q1))
        f3 = z0 * z0 * a3 * (tau + share(record, a3) * H) - 0.5 * a3 * a3 * (G1 + G2)
    momenta = A1 * start[0] * h1, A1 * start[1] * h2, A1 * z0 * h3
    w = a1 * start[0], a2 * start[1], a3 * z0  # rate over L
    F12 = momenta[0] * w[1] + momenta[1] * w[0]
    F12 += a1 * a2 * ((1.0 + 1.0 / (z * z0)) * g12 * per_a31 - A1 * start[0] * start[1] * H)
    F13 = momenta[0] * w[2] + momenta[2] * w[0] + a1 * a3 * (-dy * (per_a31 / a31) - A1 * start[0] * z0 * H)
    F23 = momenta[1] * w[2] + momenta[2] * w[1] + a2 * a3 * (dx * (per_a31 / a32) - A1 * start[1] * z0 * H)
    F = (
        A1 * f1,
        A1 * f2,
        A1 * f3,
        F12,
        F13,
        F23,
    )
    b3 = a31 * A1 * A1
    R = (
        0.5 * a1 * a1 * (tau * start[0] * start[0] - b3 * G1),
        0.5 * a2 * a2 * (tau * start[1] * start[1] - b3 * G2),
        0.5 * a3 * a3 * (tau * z0 * z0 - A3 * A3 * per_rate * dn2),
        a1 * a2 * (tau * start[0] * start[1] - A1 * g12),
        a1 * a3 * (tau * start[0] * z0 + A1 * per_a31 * dy),
        a2 * a3 * (tau * start[1] * z0 - A1 / a32 * dx),
    )
    eps = (
        0.5 * a1 * a1 * A1 * dx * (x + x0),
        0.5 * a2 * a2 * d22,
        0.5 * a3 * a3 * d33,
        a1 * a2 * A1 * (dx * y + x0 * dy),
        a1 * a3 * (dx * z + start[0] * dz),
        a2 * a3 * (dy * z + start[1] * dz),
    )
    return momenta, F, R, eps


@inlined
def share(record, inverse):
    """b_k - a_k/2 = a_k/2 - a2 + b2 of a_k, which vanishes on the separatrix for I_k = I2/2."""
    return 0.5 * (inverse - 2.0 * record.inverse[1]) + record.b2


@routine
def moved(C, gamma0, momentum):
    """C (gamma0 x momentum)."""
    v = cross(gamma0, momentum)
    return dot(C[0], v), dot(C[1], v), dot(C[2], v)


@inlined
def momentum_of(record, e, gamma0):
    """Momentum over L that a unit of element e of inertia adds at t = 0: dI w0/L."""
    w = record.inverse[0] * gamma0[0], record.inverse[1] * gamma0[1], record.inverse[2] * gamma0[2]
    x = w[0] if e == 0 else (w[1] if e == 3 else (w[2] if e == 4 else 0.0))
    y = w[1] if e == 1 else (w[0] if e == 3 else (w[2] if e == 5 else 0.0))
    z = w[2] if e == 2 else (w[0] if e == 4 else (w[1] if e == 5 else 0.0))
    return x, y, z


@routine
def write_column(columns, place, record, rotation, momentum):
    """Small rotation, momentum over L, and J times it."""
    for i in range(3):
        columns[place, i] = rotation[i]
        columns[place, 3 + i] = momentum[i]
        columns[place, 6 + i] = record.inverse[i] * momentum[i]


@routine
def add_change_of_inertia(columns, record, gamma):
    """Add dJ gamma of each element to the rates of its column: -J dI J gamma."""
    a1, a2, a3 = record.inverse[0], record.inverse[1], record.inverse[2]
    columns[3, 6] -= a1 * a1 * gamma[0]
    columns[4, 7] -= a2 * a2 * gamma[1]
    columns[5, 8] -= a3 * a3 * gamma[2]
    if record.elements < 6:
        return
    columns[6, 6] -= a1 * a2 * gamma[1]
    columns[6, 7] -= a1 * a2 * gamma[0]
    columns[7, 6] -= a1 * a3 * gamma[2]
    columns[7, 8] -= a1 * a3 * gamma[0]
    columns[8, 7] -= a2 * a3 * gamma[2]
    columns[8, 8] -= a2 * a3 * gamma[1]


@routine
def needle_arc(body, record, t, t_low, columns):
    """Write the nine columns at t of a needle that spins about itself; returns C as three rows and gamma.

    Without what is particular to it, terms I omega/L times as large would cancel.
    """
    tau = record.momentum * t
    q, hat, now = theta_now(body, record, t, t_low)
    integrals = theta_integrals(body, record, record.u_rate * tau, now)
    momenta, F, R, eps = functionals(body, record, tau, hat, integrals, None)
    gamma, g, slope, chi, X = vectors_along(body, record, hat)
    start = record.start[0], record.start[1], record.start[2]
    gamma0, g0, _slope0, chi0, _X0 = vectors_along(body, record, start)
    turn = azimuth_turn(body, record, t, t_low)
    for column in range(3 + record.elements):
        if column < 3:
            mu = unit_vector(column)
            f, shift, stay = momenta[column], 0.0, tau * record.inverse[column] * gamma0[column]
        else:
            mu = momentum_of(record, column - 3, gamma0)
            f, shift, stay = F[column - 3], eps[column - 3], R[column - 3]
        advance, pushed = f - dot(chi0, mu), dot(g0, mu)
        momentum = add_scaled(scaled(dot(gamma0, mu), gamma), advance, slope)
        third = advance * slope[2] + needle_momentum(body, record, (hat, start), mu)
        momentum = momentum[0] + pushed * X[0], momentum[1] + pushed * X[1], third
        rotation = needle_part(body, record, (hat, start), turn, mu)
        rotation = add_scaled(add_scaled(add_scaled(rotation, f, g), shift, chi), stay, gamma)
        write_column(columns, column, record, rotation, add_scaled(momentum, shift, X))
    add_change_of_inertia(columns, record, gamma)
    return matrix_of(*turn_since_start(record, q)), gamma


@routine
def azimuth_turn(body, record, t, t_low):
    """Sine, and 1 - cosine, of the angle by which axis 3 has turned about the momentum since t = 0."""
    turns, low = phase(pair(record.turns[0]), t, t_low)
    lead = (swing(body, record, t, t_low) - swing(body, record, 0.0, 0.0)) / (2.0 * math.pi)
    turns, joined = two_sum(turns, math.copysign(1.0, record.quotient) * lead)
    low += joined
    half = sine_cosine(0.5 * turns, 0.5 * low)[0]
    return sine_cosine(turns, low)[0], 2.0 * half * half


@routine
def swing(body, record, t, t_low):
    """arg(1 - E e^-2iv - q E' e^2iv + ...), the part of the azimuth that is periodic, rad."""
    x, rest = argument(pair(body.argument), t, t_low, pair(body.argument0))
    s, c = sine_cosine(x, rest)
    sine, cosine = 2.0 * s * c, fma(c, c, -s * s)
    q, E, E_prime = body.nome, record.nomes[0], record.nomes[1]
    near, far, near2, far2 = E, q * E_prime, (q * E) ** 2, (q * q * E_prime) ** 2
    real = 1.0 - (near + far) * cosine + (near2 + far2) * (2.0 * cosine * cosine - 1.0)
    return math.atan2((near - far) * sine - (near2 - far2) * 2.0 * sine * cosine, real)


@routine
def needle_momentum(body, record, directions, mu):
    """Third component of the momentum over L, less F gamma3'/A1, of a needle that spins about itself."""
    (x, y, z), (x0, y0, z0) = directions
    ratio = body.amplitude[0] * record.differences[0] / record.differences[1]
    return (z0 * mu[2] + ratio * (y0 * x * x * mu[1] - x0 * y * y * mu[0])) / z


@routine
def needle_part(body, record, directions, turn, mu):
    """C (gamma0 x mu) - g chi0.mu + chi g0.mu, of a needle that spins about itself.

    Along the unit vectors x to axis 3 across gamma and y = x x gamma; the three terms cancel by I omega/L.
    """
    (x, y, z), (x0, y0, z0), A1 = directions[0], directions[1], body.amplitude[0]
    ratio = record.differences[0] / record.differences[1]
    nu, nu0 = math.sqrt(x * x + y * y), math.sqrt(x0 * x0 + y0 * y0)
    across, side = (-z * x / nu, -z * y / nu, A1 * nu), (-y / nu, x / nu, 0.0)
    across0, side0 = (-z0 * x0 / nu0, -z0 * y0 / nu0, A1 * nu0), (-y0 / nu0, x0 / nu0, 0.0)
    rho = nu * z0 / (nu0 * z)  # over its value at t = 0
    lengthened = ratio * (y - y0) * (y + y0) / (z0 * z0 * nu * nu) / (1.0 + 1.0 / rho)  # 1 - 1/rho
    sine, versine = turn
    skew = ratio * (nu * x0 * y0 / (z * nu0) - nu0 * x * y / (z0 * nu))
    along, aside = dot(across0, mu), dot(side0, mu)
    first = (lengthened - versine) * aside + sine * along
    second = (rho * lengthened + versine) * along + (sine + skew) * aside
    return add_scaled(scaled(first, across), second, side)

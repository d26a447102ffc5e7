"""What partial derivatives of a motion need besides its constants, once per body.

Symbols are those of docs/partial-derivatives.md, sections 2 to 5; the numbers, those of `layout.PARTIALS`.
"""

import math

from ..doubledouble import (
    ONE,
    PER_TURN,
    ZERO,
    add,
    div,
    hypot,
    mul,
    neg,
    pair,
    power_of_two_near,
    scale,
    sqrt,
    store,
    sub,
)
from ..intrinsics import routine
from ..layout import PartialsGrowth, PartialsKind, Regime, Route
from ..polhode import components_along, scaled_moments
from ..regime import ascending
from .integrals import MAX_Y, theta_now, transformed_now

# A needle spun about itself: greatest I omega over L, and E = exp(-pi eta/K).
NEEDLE_RATIO, NEEDLE_E = 30.0, 1e-3


@routine
def partial_record(state, body, inertia_columns, record):
    """Fill the record of a body.

    Parameters
    ----------
    state : moments (3, 2), axes (3, 3, 2) and rates (3,), as of `invariants.invariants`
    body : of INVARIANTS
    inertia_columns : 3 for principal moments, 6 for elements of the tensor
    record : of PARTIALS, written where not zero
    """
    moments, axes, rates = state
    size = power_of_two_near(max(moments[0, 0], moments[1, 0], moments[2, 0]))
    unit = power_of_two_near(max(abs(rates[0]), abs(rates[1]), abs(rates[2])))
    inertia = scaled_moments(moments, 1.0 / size)
    omega = components_along(axes, rates, 1.0 / unit)
    record.size = size
    record.elements = inertia_columns  # along axes 1, 2, 3: the moments alone need no others
    if body.regime == Regime.CONSTANT_RATE:
        constant_record(inertia, omega, axes, unit, record)
    else:
        polhode_record(inertia, omega, axes, body, unit, record)
    if body.regime == Regime.CONSTANT_RATE or inertia_columns == 6:
        write_mix(axes, inertia_columns, record)


@routine
def write_mix(axes, columns, record):
    """Elements 11, 22, 33, 12, 13, 23 along axes 1, 2, 3 of a unit of each column of inertia."""
    P = record.axes
    for e in range(6):
        i, j = element(e)
        for k in range(columns):
            if (
                columns == 3
            ):  # a principal moment, whose axis is one of the record's but beside a constant rate
                record.mix[k, e] = along(P[i], axes[k]) * along(P[j], axes[k])
            else:
                m, n = element(k)
                record.mix[k, e] = P[i, m] * P[j, n] + (P[i, n] * P[j, m] if m != n else 0.0)


@routine
def element(e):
    """Row and column of element e of a symmetric matrix, in the order 11, 22, 33, 12, 13, 23."""
    if e < 3:
        return e, e
    return (1 if e == 5 else 0), (1 if e == 3 else 2)


@routine
def along(row, axis):
    """Component along a unit vector of a principal axis in two parts (3, 2)."""
    return row[0] * axis[0, 0] + row[1] * axis[1, 0] + row[2] * axis[2, 0]


@routine
def polhode_record(inertia, omega, axes, body, unit, record):
    """Fill the record of a motion whose rate is not constant."""
    lo, mid, hi = ascending(inertia)
    first, third = (hi, lo) if body.regime == Regime.LONG_AXIS else (lo, hi)
    order = (first, mid, third)
    I1, I2, I3 = inertia[first], inertia[mid], inertia[third]
    a1, a2, a3 = 1.0 / I1[0], 1.0 / I2[0], 1.0 / I3[0]
    record.inverse[0], record.inverse[1], record.inverse[2] = a1, a2, a3
    # what is subtracted has two parts; for all else one is enough
    a21, a31, a32 = sub(I1, I2)[0] * a1 * a2, sub(I1, I3)[0] * a1 * a3, sub(I2, I3)[0] * a2 * a3
    record.differences[0], record.differences[1], record.differences[2] = a21, a31, a32
    L1, L2, L3 = I1[0] * omega[first][0], I2[0] * omega[mid][0], I3[0] * omega[third][0]
    unit_of_L = power_of_two_near(max(abs(L1), abs(L2), abs(L3)))
    inverse_unit = 1.0 / unit_of_L  # so that no square leaves the range of a double
    L = unit_of_L * math.sqrt((L1 * inverse_unit) ** 2 + (L2 * inverse_unit) ** 2 + (L3 * inverse_unit) ** 2)
    sign1, sign3 = -1.0 if L1 < 0.0 else 1.0, -1.0 if L3 < 0.0 else 1.0
    sign2 = sign1 * sign3 * (1.0 if (mid - first) % 3 == 1 else -1.0)
    signs = (sign1, sign2, sign3)
    for i in range(3):
        record.mix[order[i], i] = 1.0  # of principal moments
        for j in range(3):
            record.axes[i, j] = signs[i] * axes[order[i], j, 0]
    record.momentum = L * unit
    gamma = (abs(L1) / L, sign2 * L2 / L, abs(L3) / L)
    record.initial[0], record.initial[1], record.initial[2] = gamma
    A1, A3 = body.amplitude[0], body.amplitude[2]
    record.start[0], record.start[1], record.start[2] = gamma[0] / A1, gamma[1] / A1, gamma[2]
    k1 = body.complementary_modulus
    record.b2 = -a32 * (k1 * A3) * (k1 * A3)
    record.u_rate = A3 * math.sqrt(abs(a31)) * math.sqrt(abs(a32))
    write_series(body, record)
    write_start(body, record)
    write_needle(-math.copysign(1.0, a31), body, record)


@routine
def write_series(body, record):
    """Coefficients of gamma over A1 and of the zeta function."""
    A1, A2, A3 = body.amplitude[0], body.amplitude[1], body.amplitude[2]
    q = body.nome
    for j in range(5):
        record.direction[0, j] = body.direction[0, j] / A1
        record.direction[1, j] = body.direction[1, j] / A1
        record.direction[2, j], record.direction[3, j] = body.direction[2, j], body.direction[3, j]
    record.quotient = math.copysign(A1 / A2 * A3, body.direction[1, 0])
    if body.route == Route.THETA:
        q_over_m = over_parameter(q)
        record.weight[0] = second_kind(q, q_over_m, body.K)
        q3, q8 = q**3, q**8
        factor = 0.5 * math.pi / body.K * q_over_m
        record.series[0] = factor * (4.0 - 12.0 * q8)
        record.series[1] = factor * (64.0 * q8 * q**7 - 16.0 * q3)
        record.series[2] = factor * 48.0 * q8
        record.series[3] = factor * -128.0 * q8 * q**7
    else:
        # exp(4 y), which entries may reach, is beyond a double for y of 177
        grows = body.per_half_turn == 0.0 or body.half_turn[0] > 200.0
        record.grows = PartialsGrowth.POSSIBLE if grows else PartialsGrowth.BOUNDED
        if abs(body.argument0[0]) > MAX_Y:
            record.grows = PartialsGrowth.LOST
        p_over_m1 = over_parameter(q * q)
        record.weight[0] = second_kind(q * q, p_over_m1, body.K_prime)
        record.direction[0, 0] = body.direction[0, 0] / A1
        record.direction[0, 1] = body.direction[0, 1] / A1
        record.direction[0, 2] = body.direction[0, 2]
        record.series[0] = q * q
        record.series[1] = 4.0 * p_over_m1
    record.weight[1] = 1.0 - record.weight[0]


@routine
def second_kind(q, q_over_m, K):
    """D/K = (1 - E/K)/m = (pi/2K)^2 theta4''(0)/(m theta4(0)) of a nome, which may be zero."""
    q3, q8 = q**3, q**8
    above = 8.0 * (1.0 - 4.0 * q3 + 9.0 * q8 - 16.0 * q8 * q3 * q3 * q)
    below = 1.0 - 2.0 * q * (1.0 - q3 + q8 - q8 * q3 * q3 * q)
    ratio = 0.5 * math.pi / K
    return ratio * ratio * q_over_m * above / below


@routine
def over_parameter(q):
    """q/m of a nome: (theta3(0)/theta2(0))^4 q."""
    above = 1.0 + 2.0 * (q + q**4 + q**9 + q**16)
    below = 1.0 + q**2 + q**6 + q**12 + q**20
    ratio = above / below
    return ratio**4 / 16.0


@routine
def write_start(body, record):
    """Attitude and integrals at t = 0, by the functions that make them at t."""
    if body.route == Route.THETA:
        q, _gamma, now = theta_now(body, record, 0.0, 0.0)
    else:
        q, _gamma, now = transformed_now(body, record, 0.0, 0.0)
    for i in range(4):
        record.quaternion[i] = q[i]
    for i in range(3):
        record.integral0[i] = now[i]


@routine
def write_needle(s, body, record):
    """Whether it is a needle spun about itself; turns of its axis about the momentum: 2 lambda + s v'."""
    record.kind = PartialsKind.LONG_ARCS
    if body.route != Route.THETA:
        return
    least = min(record.inverse[0], record.inverse[1], record.inverse[2])
    square = (
        (record.inverse[0] * record.start[0] * body.amplitude[0]) ** 2
        + (record.inverse[1] * record.start[1] * body.amplitude[0]) ** 2
        + (record.inverse[2] * record.start[2]) ** 2
    )
    E = math.exp(-math.pi * body.eta / body.K) if square > (NEEDLE_RATIO * least) ** 2 else 1.0
    if E < NEEDLE_E:
        record.kind = PartialsKind.NEEDLE
        record.nomes[0], record.nomes[1] = E, body.nome / E if E > 0.0 else 0.0
        turn = scale(pair(body.argument), s)
        store(record.turns[0], add(scale(pair(body.precession), 2.0), turn))


@routine
def constant_record(inertia, omega, axes, unit, record):
    """Fill the record of a constant rate: axis 3 along the momentum, both turns of what departs from it."""
    record.kind, record.elements = PartialsKind.CONSTANT_RATE, 6
    speed = hypot(hypot(omega[0], omega[1]), omega[2])
    if speed[0] == 0.0:
        speed = ONE
        unit = 0.0
        omega = (ZERO, ZERO, ONE)
    # components nearer to zero than two parts resolve are zero
    x = (
        div(omega[0], speed) if abs(omega[0][0]) > 1e-28 * speed[0] else ZERO,
        div(omega[1], speed) if abs(omega[1][0]) > 1e-28 * speed[0] else ZERO,
        div(omega[2], speed) if abs(omega[2][0]) > 1e-28 * speed[0] else ZERO,
    )
    p = 0 if abs(x[0][0]) <= abs(x[1][0]) and abs(x[0][0]) <= abs(x[2][0]) else 1
    p = 2 if abs(x[2][0]) < abs(x[p][0]) else p
    largest = 0 if abs(x[0][0]) >= abs(x[1][0]) and abs(x[0][0]) >= abs(x[2][0]) else 1
    largest = 2 if abs(x[2][0]) > abs(x[largest][0]) else largest
    other = 3 - p - largest
    I3 = inertia[largest]
    I1 = I3 if x[p][0] != 0.0 else inertia[p]
    I2 = I3 if x[other][0] != 0.0 else inertia[other]
    write_constant_axes(x, p, axes, record)
    a3 = div(ONE, I3)
    a31, a32 = mul(div(sub(I1, I3), I1), a3), mul(div(sub(I2, I3), I2), a3)
    record.inverse[0], record.inverse[1], record.inverse[2] = div(ONE, I1)[0], div(ONE, I2)[0], a3[0]
    record.differences[0] = div(sub(I1, I2), mul(I1, I2))[0]
    record.differences[1], record.differences[2] = a31[0], a32[0]
    record.momentum = mul(I3, speed)[0] * unit
    record.start[2] = record.initial[2] = 1.0
    record.grows = PartialsGrowth.POSSIBLE if a31[0] * a32[0] < 0.0 else PartialsGrowth.BOUNDED
    write_turns((a3, a31, a32), (div(ONE, I1), div(ONE, I2)), scale(mul(I3, speed), unit), record)


@routine
def write_constant_axes(x, p, axes, record):
    """Rows: axis p less its part along the rate's direction x (principal components), one across, x."""
    xs = (x[0][0], x[1][0], x[2][0])
    first = (
        (1.0 if p == 0 else 0.0) - xs[p] * xs[0],
        (1.0 if p == 1 else 0.0) - xs[p] * xs[1],
        (1.0 if p == 2 else 0.0) - xs[p] * xs[2],
    )
    size = math.sqrt(first[0] ** 2 + first[1] ** 2 + first[2] ** 2)
    first = (first[0] / size, first[1] / size, first[2] / size)
    second = (
        xs[1] * first[2] - xs[2] * first[1],
        xs[2] * first[0] - xs[0] * first[2],
        xs[0] * first[1] - xs[1] * first[0],
    )
    for j in range(3):
        record.axes[0, j] = first[0] * axes[0, j, 0] + first[1] * axes[1, j, 0] + first[2] * axes[2, j, 0]
        record.axes[1, j] = second[0] * axes[0, j, 0] + second[1] * axes[1, j, 0] + second[2] * axes[2, j, 0]
        record.axes[2, j] = xs[0] * axes[0, j, 0] + xs[1] * axes[1, j, 0] + xs[2] * axes[2, j, 0]


@routine
def write_turns(third, others, momentum, record):
    """Half sum and half difference of the turns a3 and s sqrt(a31 a32); of no oscillation u_rate alone."""
    a3, a31, a32 = third
    product = mul(a31, a32)
    if product[0] <= 0.0:
        record.u_rate = math.sqrt(-product[0])
        store(record.turns[0], mul(mul(momentum, PER_TURN), a3))
        return
    root = sqrt(product)
    turns = scale(mul(momentum, PER_TURN), 0.5)
    if a31[0] > 0.0:  # a3 - sqrt(a31 a32) = [a3 (a1 + a2) - a1 a2] / (a3 + root)
        rest = sub(mul(a3, add(others[0], others[1])), mul(others[0], others[1]))
        difference = div(rest, add(a3, root))
    else:
        difference = add(a3, root)
        root = neg(root)
    record.u_rate = root[0]
    store(record.turns[0], mul(turns, add(a3, root)))
    store(record.turns[1], mul(turns, difference))

"""Samples with the integrals of squares of Jacobi's functions (docs/partial-derivatives.md, section 3).

The integrals of cn^2, sn^2, dn^2, cd^2, sd^2 and nd^2 from t = 0 are combinations of u and of one more
function: Jacobi's zeta (53), or the two functions that the modular transform makes of it.
"""

import math

from ..cayley_klein import (
    compose,
    cubic,
    exp_pair,
    half_turn_of,
    quartic,
    series_of,
    since_half_turn,
    theta_direction,
    theta_pair,
    transformed_direction,
    transformed_pair,
)
from ..doubledouble import pair, two_sum
from ..intrinsics import fma, inlined
from ..phase import argument, phase, sine_cosine
from ..vectors import five, four, three

# Beyond this what grows as exp(4 y) would leave the range of a double: it is evaluated here, and multiplied.
MAX_Y = 170.0


@inlined
def theta_now(body, record, t, t_low):
    """q_MP, (gamma1/A1, gamma2/A1, gamma3), and (Z, S, half turns, growth) at t by theta functions."""
    x, rest = argument(pair(body.argument), t, t_low, pair(body.argument0))
    s, c = sine_cosine(x, rest)
    w = fma(c, c, -s * s)
    turns, low = phase(pair(body.precession), t, t_low)
    q = compose(*theta_pair(s, c, w, series_of(body)), *sine_cosine(turns, low))
    g = record.direction
    gamma = theta_direction(s, c, w, (five(g[0]), five(g[1]), five(g[2]), five(g[3])))
    zeta = 2.0 * s * c * cubic(*four(record.series), w) / quartic(*five(g[3]), w)
    return q, gamma, (zeta, record.quotient * gamma[0] * gamma[1] / gamma[2], 0.0, 1.0)


@inlined
def theta_integrals(body, record, u, now):
    """(cn2, sn2, dn2, cd2, sd2, nd2) from t = 0; now : as of `theta_now`."""
    m, m1 = body.modulus * body.modulus, body.complementary_modulus * body.complementary_modulus
    dZ, dS = now[0] - record.integral0[0], now[1] - record.integral0[1]
    sn2 = fma(record.weight[0], u, -dZ)
    cn2 = fma(record.weight[1], u, dZ)
    cd2, sd2 = sn2 + dS, (cn2 - dS) * (1.0 / m1)
    return cn2, sn2, u - m * sn2, cd2, sd2, cd2 + sd2


@inlined
def transformed_now(body, record, t, t_low):
    """q_MP, (gamma1/A1, gamma2/A1, gamma3), and (T2, T3, half turns, growth) at t after the transform."""
    y, rest = argument(pair(body.argument), t, t_low, pair(body.argument0))
    y, signs, n = since_half_turn(y, rest, *half_turn_of(body))
    turns, low = phase(pair(body.precession), t, t_low)
    turns, joined = two_sum(turns, body.slip * y)
    growth = exp_pair(-2.0 * max(abs(y) - MAX_Y, 0.0))[1]
    size, Q = min(abs(y), MAX_Y), body.nome
    e, inverse = exp_pair(-2.0 * size)
    powers = e, Q * inverse, Q * e
    q = compose(*transformed_pair(powers, signs, series_of(body)), *sine_cosine(turns, low + joined))
    gamma = transformed_direction(powers, signs, Q, three(record.direction[0]))
    return q, gamma, (*transformed_pair_of_zeta(powers, signs[0], record.series), n, growth)


@inlined
def transformed_pair_of_zeta(powers, sign, series):
    """T2 and T3: the two parts of the zeta function after the modular transform.

    powers : e, Q/e, Q e; series : p = Q^2, 4 p/m1.  Both fractions have factors 2 e and e^2.
    """
    e, z, _far = powers
    p = series[0]
    e2, z2, p2 = e * e, z * z, p * p
    e4, z4, p4 = e2 * e2, z2 * z2, p2 * p2
    third, third_far = z4 * e2, p2 * e4
    fifth, fifth_far = z4 * p4, p2 * p4 * e2 * e4
    up = (1.0 - e2) + 3.0 * (third - third_far) + 5.0 * (fifth - fifth_far)
    down = (1.0 + e2) + (third + third_far) + (fifth + fifth_far)
    fourth, fourth_far = z2 * p2, p2 * p * e2 * e4
    sixth, sixth_far = z4 * p2 * p4, p4 * p4 * e4 * e4
    up3 = 0.5 * (1.0 - e4) + (fourth - fourth_far) + 1.5 * (sixth - sixth_far)
    down3 = e2 + p * ((1.0 + e4) + (fourth + fourth_far) + (sixth * p + p4 * p4 * e4 * e4))
    return sign * up / down, sign * series[1] * up3 / down3


@inlined
def transformed_integrals(body, record, u, now):
    """(cn2, sn2, dn2, cd2, sd2, nd2) from t = 0; now : as of `transformed_now`."""
    m, m1 = body.modulus * body.modulus, body.complementary_modulus * body.complementary_modulus
    # where the start is half way between two half turns, rounding decides whose it is
    c, n = 0.5 * math.pi / body.K_prime, now[2] - record.integral0[2]
    D, B = record.weight[0] * u, record.weight[1] * u
    dT2 = (now[0] - record.integral0[0]) + 2.0 * n
    dT3 = now[1] - record.integral0[1]
    m1nd2 = fma(m1, D, c * fma(m1, dT3, 2.0 * n))
    dT3 += 2.0 * n / m1 if n != 0.0 else 0.0
    cn2 = (c * dT2 - m1 * B) / m
    return cn2, u - cn2, fma(m1, D, c * dT2), (u - m1nd2) / m, (c * dT3 - B) / m, fma(c, dT3, D)

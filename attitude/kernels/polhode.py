"""The polhode: the path of the momentum's direction in the body (docs/theory.md, section 3), in two parts.

Squares that could leave the range of a double are avoided: the formulas are in roots (r21, S3, k, k1...).
"""

from typing import NamedTuple

from .doubledouble import ONE, absolute, add, div, hypot, mul, pair, scale, sqrt, square, sub
from .intrinsics import routine


class Polhode(NamedTuple):
    """The polhode and the start of the motion on it (theory, section 3)."""

    s: float
    gamma: tuple
    r21: tuple  # sqrt abs(a2 - a1), and so on
    r31: tuple
    r32: tuple
    A1: tuple
    A2: tuple
    A3: tuple
    k: tuple
    k1: tuple
    u_rate: tuple
    spin_rates: tuple  # L a1, L a2, L a3
    mean_rate: tuple  # L/2 (a1 + a31 A3), the part of lambda outside the series


@routine
def component_along(axis, rate, factor):
    """Component of factor * rate along a two-part axis (3, 2)."""
    total = mul(pair(axis[0]), (rate[0] * factor, 0.0))
    total = add(total, mul(pair(axis[1]), (rate[1] * factor, 0.0)))
    return add(total, mul(pair(axis[2]), (rate[2] * factor, 0.0)))


@routine
def components_along(axes, rate, factor):
    """Components of factor * rate along three two-part axes (3, 3, 2)."""
    return (
        component_along(axes[0], rate, factor),
        component_along(axes[1], rate, factor),
        component_along(axes[2], rate, factor),
    )


@routine
def scaled_moments(moments, power_of_two):
    """Three two-part moments (3, 2), times a power of two."""
    return (
        scale(pair(moments[0]), power_of_two),
        scale(pair(moments[1]), power_of_two),
        scale(pair(moments[2]), power_of_two),
    )


@routine
def root_of_difference(I_i, I_j):
    """sqrt(abs(1/I_j - 1/I_i)) from the difference of the moments."""
    return div(sqrt(absolute(sub(I_i, I_j))), mul(sqrt(I_i), sqrt(I_j)))


@routine
def polhode_of(inertia, omega, first, mid, third, root_D):
    """Amplitudes, moduli and rate of gamma (theory, eqs. 6 to 11), and the signs of the axes."""
    I1, I2, I3 = inertia[first], inertia[mid], inertia[third]
    L1, L2, L3 = mul(I1, omega[first]), mul(I2, omega[mid]), mul(I3, omega[third])
    L = hypot(hypot(L1, L3), L2)
    sign1 = -1.0 if L1[0] < 0.0 else 1.0
    sign3 = -1.0 if L3[0] < 0.0 else 1.0
    parity = 1.0 if (mid - first) % 3 == 1 else -1.0
    sign2 = parity * sign1 * sign3
    inverse = div(ONE, L)
    gamma = (mul(scale(L1, sign1), inverse), mul(scale(L2, sign2), inverse), mul(scale(L3, sign3), inverse))
    s = -1.0 if I3[0] < I1[0] or (I3[0] == I1[0] and I3[1] < I1[1]) else 1.0
    r21, r31, r32 = root_of_difference(I2, I1), root_of_difference(I3, I1), root_of_difference(I3, I2)
    S1 = hypot(mul(r21, gamma[1]), mul(r31, gamma[2]))  # sqrt abs(c - a1)
    S3 = hypot(mul(r31, gamma[0]), mul(r32, gamma[1]))  # sqrt abs(a3 - c)
    S2 = div(root_D, mul(sqrt(I2), L))  # sqrt abs(c - a2)
    A1, A2, A3 = div(S3, r31), div(S3, r32), div(S1, r31)
    r32_S1 = mul(r32, S1)
    k, k1 = div(mul(S3, r21), r32_S1), div(mul(r31, S2), r32_S1)
    spin_rates = div(L, I1), div(L, I2), div(L, I3)
    # a1 + a31 A3 = a1 (1 - A3) + a3 A3: for a needle a1 is huge and 1 - A3 as small
    share1 = div(square(A1), add(ONE, A3))
    mean_rate = scale(add(mul(spin_rates[0], share1), mul(spin_rates[2], A3)), 0.5)
    u_rate = mul(L, r32_S1)
    polhode = Polhode(s, gamma, r21, r31, r32, A1, A2, A3, k, k1, u_rate, spin_rates, mean_rate)
    return polhode, (sign1, sign2, sign3)

"""Conserved numbers of a body with a rotor along axis 3: the only sums of the closed form that lose digits.

With the momentum M instead of its direction, A_i = W a_i and K = W L k, they are polynomials of the input; W
is any factor that makes the A_i exact.  They are summed as expansions
((39) and (40) of docs/gyrostats.md).
"""

from typing import NamedTuple

from ..doubledouble import add, div, mul, neg, scale, sqrt, square
from ..expansion import append_product, append_row, clear, value
from ..intrinsics import routine
from ..layout import Sum
from ..vectors import scaled


class Conserved(NamedTuple):
    """The rotor's problem and what it conserves, in two parts; of axes 1 and 2 exchanged with `exchanged`."""

    a: tuple
    a12: tuple
    a13: tuple
    a23: tuple
    k: tuple
    gamma: tuple
    L: tuple
    above: tuple  # 1 - gamma3
    below: tuple  # 1 + gamma3
    b1: tuple
    b2: tuple
    disc1: tuple
    disc2: tuple
    upper: tuple  # D+
    lower: tuple  # D-
    poles: tuple  # D+ D-
    J: tuple
    U: tuple
    U_exchanged: tuple


@routine
def conserved(rows, W, a, momentum):
    """The invariants, from expansions of M, A_ij and K in the first rows; W, a_i and true L in two parts.

    The momentum is zero where L is the length of M; M may have any length.
    """
    _squares_and_linear_sums(rows)
    L = sqrt(value(rows[Sum.LL]))
    inverse = div((1.0, 0.0), L)
    per_W = div((1.0, 0.0), W)
    first = mul(per_W, inverse)  # of what is linear in M and A
    second = square(first)
    K_L, total = mul(value(rows[Sum.K]), L), value(rows[Sum.X])
    third = mul(per_W, square(inverse))
    poles = mul(_poles(rows), square(third))
    upper, lower = at_poles(mul(total, third), scale(mul(K_L, third), 2.0), poles)
    M1, M2, M3 = value(rows[Sum.M1]), value(rows[Sum.M2]), value(rows[Sum.M3])
    gamma = mul(M1, inverse), mul(M2, inverse), mul(M3, inverse)
    above, below = distances_from_poles(gamma)
    return Conserved(
        a,
        mul(value(rows[Sum.A12]), per_W),
        mul(value(rows[Sum.A13]), per_W),
        mul(value(rows[Sum.A23]), per_W),
        mul(value(rows[Sum.K]), first),
        gamma,
        momentum if momentum[0] > 0.0 else L,
        above,
        below,
        mul(value(rows[Sum.B1]), first),
        mul(value(rows[Sum.B2]), first),
        mul(discriminant(rows, Sum.B1, Sum.A23, Sum.M11, -1.0), second),
        mul(discriminant(rows, Sum.B2, Sum.A13, Sum.M22, 1.0), second),
        upper,
        lower,
        poles,
        mul(_J(rows), second),
        mul(_U(rows, 1.0, Sum.M22, Sum.A13), third),
        mul(_U(rows, -1.0, Sum.M11, Sum.A23), third),
    )


@routine
def _squares_and_linear_sums(rows):
    for result, M in ((Sum.M11, Sum.M1), (Sum.M22, Sum.M2), (Sum.M33, Sum.M3)):
        clear(rows[result])
        append_product(rows[result], 1.0, rows[M], rows[M])
    clear(rows[Sum.LL])
    for one in (Sum.M11, Sum.M22, Sum.M33):
        append_row(rows[Sum.LL], 1.0, rows[one])
    for result, A in ((Sum.B1, Sum.A23), (Sum.B2, Sum.A13)):
        clear(rows[result])
        append_product(rows[result], 1.0, rows[A], rows[Sum.M3])
        append_row(rows[result], 1.0, rows[Sum.K])
    clear(rows[Sum.X])
    append_product(rows[Sum.X], 1.0, rows[Sum.A13], rows[Sum.M11])
    append_product(rows[Sum.X], 1.0, rows[Sum.A23], rows[Sum.M22])
    append_product(rows[Sum.X], -2.0, rows[Sum.K], rows[Sum.M3])


@routine
def _poles(rows):
    """X^2 - 4 K^2 L^2, which is D+ D-."""
    clear(rows[Sum.PRODUCT])
    append_product(rows[Sum.PRODUCT], 1.0, rows[Sum.K], rows[Sum.K])
    clear(rows[Sum.TOTAL])
    append_product(rows[Sum.TOTAL], 1.0, rows[Sum.X], rows[Sum.X])
    append_product(rows[Sum.TOTAL], -4.0, rows[Sum.PRODUCT], rows[Sum.LL])
    return value(rows[Sum.TOTAL])


@routine
def at_poles(total, twice_k, poles):
    """D+ and D- = total +- 2k; the one that cancels is the quotient of their exact product."""
    positive = (total[0] >= 0.0) == (twice_k[0] >= 0.0)
    larger = add(total, twice_k if positive else neg(twice_k))
    smaller = div(poles, larger) if larger[0] != 0.0 else (0.0, 0.0)
    if positive:
        return larger, smaller
    return smaller, larger


@routine
def distances_from_poles(gamma):
    """1 - gamma3 and 1 + gamma3, the smaller one from the other two components."""
    across = add(square(gamma[0]), square(gamma[1]))
    if gamma[2][0] > 0.0:
        far = add((1.0, 0.0), gamma[2])
        return div(across, far), far
    far = add((1.0, 0.0), neg(gamma[2]))
    return far, div(across, far)


@routine
def discriminant(rows, b, A, MM, sign):
    """b^2 + sign A12 A MM."""
    clear(rows[Sum.PRODUCT])
    append_product(rows[Sum.PRODUCT], sign, rows[Sum.A12], rows[A])
    clear(rows[Sum.TOTAL])
    append_product(rows[Sum.TOTAL], 1.0, rows[b], rows[b])
    append_product(rows[Sum.TOTAL], 1.0, rows[Sum.PRODUCT], rows[MM])
    return value(rows[Sum.TOTAL])


@routine
def _J(rows):
    """A12 (A13 M1^2 - A23 M2^2) - 2 B1 B2."""
    clear(rows[Sum.PART])
    append_product(rows[Sum.PART], 1.0, rows[Sum.A13], rows[Sum.M11])
    append_product(rows[Sum.PART], -1.0, rows[Sum.A23], rows[Sum.M22])
    clear(rows[Sum.TOTAL])
    append_product(rows[Sum.TOTAL], 1.0, rows[Sum.A12], rows[Sum.PART])
    append_product(rows[Sum.TOTAL], -2.0, rows[Sum.B1], rows[Sum.B2])
    return value(rows[Sum.TOTAL])


@routine
def _U(rows, sign, MM, A):
    """sign A12 (2 L^2 - MM) - A (L^2 + M3^2) - 2 K M3."""
    clear(rows[Sum.TOTAL])
    clear(rows[Sum.PART])
    append_row(rows[Sum.PART], 2.0, rows[Sum.LL])
    append_row(rows[Sum.PART], -1.0, rows[MM])
    append_product(rows[Sum.TOTAL], sign, rows[Sum.A12], rows[Sum.PART])
    clear(rows[Sum.PART])
    append_row(rows[Sum.PART], 1.0, rows[Sum.LL])
    append_row(rows[Sum.PART], 1.0, rows[Sum.M33])
    append_product(rows[Sum.TOTAL], -1.0, rows[A], rows[Sum.PART])
    append_product(rows[Sum.TOTAL], -2.0, rows[Sum.K], rows[Sum.M3])
    return value(rows[Sum.TOTAL])


# -- other names of the axes: the conserved numbers along them, and their rows ----------------------------


@routine
def flipped(c, R):
    """After half a turn about axis 1: (x, y, z) -> (x, -y, -z)."""
    x, y, z = c.gamma
    now = Conserved(
        c.a, c.a12, c.a13, c.a23, neg(c.k), (x, neg(y), neg(z)), c.L, c.below, c.above, neg(c.b1), neg(c.b2),
        c.disc1, c.disc2, c.lower, c.upper, c.poles, c.J, c.U, c.U_exchanged,
    )  # fmt: skip
    return now, (R[0], scaled(-1.0, R[1]), scaled(-1.0, R[2]))


@routine
def exchanged(c, R):
    """After a quarter turn about axis 3: (x, y, z) -> (y, -x, z)."""
    x, y, z = c.gamma
    now = Conserved(
        (c.a[1], c.a[0], c.a[2]), neg(c.a12), c.a23, c.a13, c.k, (y, neg(x), z), c.L, c.above, c.below,
        c.b2, c.b1, c.disc2, c.disc1, c.upper, c.lower, c.poles, c.J, c.U_exchanged, c.U,
    )  # fmt: skip
    return now, (R[1], scaled(-1.0, R[0]), R[2])


@routine
def turned(c, R):
    """After half a turn about axis 3: (x, y, z) -> (-x, -y, z)."""
    x, y, z = c.gamma
    now = Conserved(
        c.a, c.a12, c.a13, c.a23, c.k, (neg(x), neg(y), z), c.L, c.above, c.below, c.b1, c.b2,
        c.disc1, c.disc2, c.upper, c.lower, c.poles, c.J, c.U, c.U_exchanged,
    )  # fmt: skip
    return now, (scaled(-1.0, R[0]), scaled(-1.0, R[1]), R[2])

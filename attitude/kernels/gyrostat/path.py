"""The closed path of the momentum in a body with a rotor along axis 3: labels, ends, moduli.

Equations (40a) to (42a) of docs/gyrostats.md; every number is formed without cancellation from the conserved
ones.
"""

from enum import IntEnum
from typing import NamedTuple

from ..doubledouble import ONE, ZERO, absolute, add, div, hypot, less, mul, neg, scale, sqrt, square, sub
from ..elliptic import carlson_rf
from ..intrinsics import routine
from .conserved import exchanged, flipped, turned


class Family(IntEnum):
    """Families of paths (docs/gyrostats.md, section 2)."""

    CIRCLING = 0  # gamma goes round axis 3
    SWINGING = 1  # it stays on one side of it


class Path(NamedTuple):
    """Constants of the path, in two parts, and how its axes lie in those of the body."""

    family: Family
    s: float
    M: tuple  # M, N and nu: what the means that give the nome start from; mu has its sign
    N: tuple
    nu: tuple
    mu: float
    rate: (
        tuple  # multiples of the rate of the argument, of the place of the pole, and of the argument at t = 0
    )
    pole: tuple
    other_pole: tuple
    start: tuple
    beyond: bool  # the start is counted from the other end
    sign: float  # of the argument at t = 0
    mean_rate: tuple  # of arg alpha at the upper end
    rho: tuple  # |alpha| and |beta| there
    tau: tuple
    axes: tuple  # rows: the axes of the path along those of the body; entries 0, 1 or -1


@routine
def labelled(c):
    """Decide which axes are 1, 2 and 3: (conserved numbers along them, family, rows of these axes)."""
    R = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    # axis 3 has the greatest or least moment, beyond both others
    if c.a13[0] * c.a23[0] > 0.0:
        c, family, R = _labelled_extreme(c, R)
    else:
        c, family, R = _labelled_middle(c, R)
    if c.gamma[0][0] < 0.0:
        c, R = turned(c, R)
    return c, family, R


@routine
def _labelled_extreme(c, R):
    """`labelled`, where axis 3 has the greatest or least moment."""
    # axis 2 becomes the middle one: a12 and a23 of one sign
    if c.a12[0] * c.a23[0] < 0.0:
        c, R = exchanged(c, R)
    s = 1.0 if c.a12[0] > 0.0 else -1.0
    outside = s * c.upper[0] >= 0.0 and s * c.lower[0] >= 0.0
    if s * c.upper[0] < 0.0 or (outside and less(absolute(c.upper), absolute(c.lower))):
        c, R = flipped(c, R)
    if s * c.lower[0] < 0.0:
        return c, Family.CIRCLING, R
    if c.disc1[0] >= 0.0 and less(absolute(mul(c.k, c.a12)), mul(absolute(c.a23), sqrt(c.disc2))):
        if c.b1[0] * c.a23[0] < 0.0:
            c, R = flipped(c, R)
        return c, Family.CIRCLING, R
    return c, Family.SWINGING, R


@routine
def _labelled_middle(c, R):
    """`labelled`, where axis 3 has the middle moment."""
    if less(absolute(c.upper), absolute(c.lower)):
        c, R = flipped(c, R)
    s = 1.0 if c.a12[0] > 0.0 else -1.0
    if s * c.upper[0] >= 0.0 and s * c.lower[0] >= 0.0:
        return c, Family.SWINGING, R
    if s * c.upper[0] >= 0.0:
        return c, Family.CIRCLING, R
    family = Family.SWINGING if s * c.lower[0] < 0.0 else Family.CIRCLING
    c, R = exchanged(c, R)
    return c, family, R


@routine
def roots(b, constant, discriminant):
    """Roots of A x^2 + 2 b x + constant: the one nearer to zero, and A times the farther one."""
    root = sqrt(discriminant)
    t = add(b, root if b[0] >= 0.0 else neg(root))
    near = neg(div(constant, t)) if t[0] != 0.0 else ZERO
    return near, neg(t)


@routine
def ends_of_pair(near, far, A, positive):
    """(the root of the wanted sign, |A| times the other one): near and A * far are given."""
    if positive:
        return near, absolute(far)
    return div(far, A), mul(absolute(A), absolute(near))


@routine
def _upper_end(c, s):
    near, far = roots(c.b2, neg(mul(c.a12, square(c.gamma[1]))), c.disc2)
    is_near = near[0] > 0.0 or (near[0] == 0.0 and s * c.b2[0] > 0.0)
    return ends_of_pair(near, far, c.a13, is_near)


@routine
def lower_end(c, s, extreme):
    """x1 <= 0, from gamma3 to the lower end, and |a23 x4|."""
    near, far = roots(c.b1, mul(c.a12, square(c.gamma[0])), c.disc1)
    is_near = extreme or near[0] < 0.0 or (near[0] == 0.0 and s * c.b1[0] > 0.0)
    return ends_of_pair(near, far, c.a23, is_near)


@routine
def _product3(x, y, z):
    return mul(mul(x, y), z)


@routine
def circling_path(c, axes):
    """The path of a body whose momentum circles axis 3 (docs/gyrostats.md, (42), C)."""
    s = 1.0 if c.a12[0] > 0.0 else -1.0
    extreme = c.a13[0] * c.a23[0] > 0.0
    a12, a13, a23 = absolute(c.a12), absolute(c.a13), absolute(c.a23)
    x2, a13x3 = _upper_end(c, s)
    x1, a23x4 = lower_end(c, s, extreme)
    r = sqrt(mul(c.disc1, c.disc2))
    w1, w2 = scale(sqrt(c.disc1), 2.0), scale(sqrt(c.disc2), 2.0)
    product = mul(square(c.a12), c.poles)
    if c.J[0] < 0.0:
        J_minus = sub(c.J, scale(r, 2.0))
        J_plus = div(product, J_minus)
    else:
        J_plus = add(c.J, scale(r, 2.0))
        J_minus = div(product, J_plus)
    M, N, nu = sqrt(absolute(J_minus)), scale(sqrt(r), 2.0), sqrt(absolute(J_plus))
    span = sub(x2, x1)
    t3 = add(mul(a13, c.above), a13x3)
    upper_above, lower_above = div(absolute(c.upper), t3), sub(c.above, x1)  # 1 - e2, 1 - e1
    upper_below = add(c.below, x2)  # 1 + e2
    t3_below = div(absolute(c.lower), upper_below)
    if extreme:
        c24 = add(mul(a23, x2), a23x4)
        c31 = div(absolute(J_minus), c24)
        t4 = add(mul(a23, c.above), a23x4)
        lower_below = div(mul(span, c31), mul(a12, lower_above))
        t4_below = div(absolute(c.lower), lower_below)
    else:
        t4_below = add(mul(a23, c.below), a23x4)
        lower_below = div(absolute(c.lower), t4_below)
        t4 = div(absolute(c.upper), lower_above)
        c24 = div(_product3(a12, upper_above, upper_below), span)
        c31 = div(_product3(a12, lower_above, lower_below), span)
    pole = mul(
        sqrt(upper_above),
        carlson_rf(
            sqrt(_product3(lower_above, w2, c24)),
            sqrt(_product3(t4, span, w2)),
            sqrt(_product3(t3, span, c24)),
        ),
    )
    other = ZERO
    if lower_below[0] > 0.0:
        other = mul(
            sqrt(lower_below),
            carlson_rf(
                sqrt(_product3(upper_below, c31, w1)),
                sqrt(_product3(t4_below, span, c31)),
                sqrt(_product3(t3_below, span, w1)),
            ),
        )
    start = mul(
        sqrt(x2),
        carlson_rf(
            sqrt(_product3(neg(x1), w2, c24)),
            sqrt(_product3(a13x3, span, c24)),
            sqrt(_product3(a23x4, span, w2)),
        ),
    )
    # zero over zero cannot be, and J_minus = 0 alone is the limit of interlacing roots
    mu = J_plus[0] / J_minus[0] if J_minus[0] != 0.0 else -1.0
    sign = 1.0 if s * c.gamma[1][0] >= 0.0 else -1.0
    return Path(
        Family.CIRCLING, s, M, N, nu, mu, scale(c.L, 0.5), pole, other, start, False, sign,
        rate_at_upper_end(c, upper_above),
        sqrt(scale(upper_below, 0.5)), sqrt(scale(upper_above, 0.5)), axes,
    )  # fmt: skip


@routine
def rate_at_upper_end(c, upper_above):
    """L/2 [a3 e2 - k + a1 (1 - e2)]: of arg alpha where gamma2 = 0."""
    a1, _a2, a3 = c.a
    return scale(mul(c.L, sub(add(mul(a3, sub(ONE, upper_above)), mul(a1, upper_above)), c.k)), 0.5)


@routine
def swinging_path(c, axes):
    """The path of a body whose momentum swings on one side of axis 3 (docs/gyrostats.md, (42), L)."""
    s = 1.0 if c.a12[0] > 0.0 else -1.0
    a12, a13 = absolute(c.a12), absolute(c.a13)
    x2, a13x3 = _upper_end(c, s)
    ratio = div(a13, a12)
    T = div(c.U, c.a12)
    span = div(scale(sqrt(c.disc2), 2.0), a13)
    n = div(sqrt(absolute(c.poles)), a13)
    S = scale(add(n, hypot(n, span)), 0.5)
    S_minus = div(square(span), scale(S, 4.0))
    quotient = div(c.disc1, square(c.a12))
    if T[0] > 0.0:
        B = scale(add(T, mul(ratio, n)), 0.5)
        A = div(quotient, B)
    else:
        A = scale(sub(T, mul(ratio, n)), 0.5)
        B = div(quotient, A)
    M, N = sqrt(mul(S, B)), sqrt(n)
    nu = sqrt(mul(S_minus, absolute(A)))
    x1 = div(a13x3, a13)
    lower_above = add(c.above, x1)
    upper_above = div(div(absolute(c.upper), a13), lower_above)
    upper_below = add(c.below, x2)
    lower_below = div(div(absolute(c.lower), a13), upper_below)
    G1x2 = mul(sqrt(mul(lower_above, lower_below)), x2)
    G2x1 = mul(sqrt(mul(upper_above, upper_below)), x1)
    pole = scale(carlson_rf(sqrt(S), sqrt(S_minus), sqrt(_product3(ratio, S, S_minus))), 0.5)
    start = ZERO
    if c.gamma[1][0] != 0.0:
        start = mul(
            div(absolute(c.gamma[1]), sqrt(ratio)),
            carlson_rf(absolute(sub(G2x1, G1x2)), add(G2x1, G1x2), absolute(mul(span, c.gamma[0]))),
        )
    mu = S_minus[0] * A[0]
    sign = 1.0 if s * c.gamma[1][0] >= 0.0 else -1.0
    return Path(
        Family.SWINGING, s, M, N, nu, mu, scale(mul(c.L, sqrt(mul(a12, a13))), 0.5), pole, ZERO, start,
        less(G2x1, G1x2), sign, rate_at_upper_end(c, upper_above),
        sqrt(scale(upper_below, 0.5)), sqrt(scale(upper_above, 0.5)), axes,
    )  # fmt: skip

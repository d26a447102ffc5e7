"""Rotors along any axis: the Lorentz transformation to a body with its rotor along axis 3.

The path of X = (gamma, 1) is where the cone X.Q_A.X = 0, Q_A = diag(1, 1, 1, -1), meets a quadric
X.Q_B.X = 0.  Two eigenvectors of the pencil become axes 1 and 2 (docs/gyrostats.md, (46) to (48)).
"""

import math
from typing import NamedTuple

from ..doubledouble import ONE, ZERO, add, div, mul, neg, scale, sqrt, square, sub
from ..intrinsics import routine
from ..regime import ascending

# Of the greatest number of the problem: a component of k below is none, since two parts hold 1e-32.
SMALLEST_K = 1e-40


class Boosted(NamedTuple):
    """The problem with its rotor along axis 3, of one momentum and time, and the way back; in two parts."""

    a: tuple  # less `shift`
    a12: tuple
    a13: tuple
    a23: tuple
    k: tuple
    gamma: tuple
    shift: tuple  # the middle one of the inverse moments
    axes: tuple  # rows: axes of the problem along those of the body
    w: tuple  # space part of E0 over 1 + its time part, along the body's axes
    condition: float  # G0 + sqrt(G0^2 - 1)


class Gap(NamedTuple):
    """The interval of z between two poles of f = z - c - sum k^2/(a - z), in plain doubles."""

    width: float
    left: float  # a - c at its left end
    right: float
    third_left: float  # the third pole less the left end, and less the right one
    third_right: float
    k2: tuple  # k^2 at the left end, the right one, the third


@routine
def dot(x, y):
    """Scalar product of three pairs with three."""
    return add(add(mul(x[0], y[0]), mul(x[1], y[1])), mul(x[2], y[2]))


@routine
def lorentz(x, y):
    """x.Q_A.y."""
    return sub(dot(x, y), mul(x[3], y[3]))


@routine
def _scaled4(factor, x):
    return mul(factor, x[0]), mul(factor, x[1]), mul(factor, x[2]), mul(factor, x[3])


@routine
def _sum4(x, y):
    return add(x[0], y[0]), add(x[1], y[1]), add(x[2], y[2]), add(x[3], y[3])


@routine
def at(gap, derivative, side, x):
    """f, or its first or second derivative (half of it), at x from the left (0) or right (1) end."""
    if side == 0:
        left, right, third, z = -x, gap.width - x, gap.third_left - x, gap.left + x
    else:
        left, right, third, z = x - gap.width, x, gap.third_right + x, gap.right - x
    total = z if derivative == 0 else (1.0 if derivative == 1 else 0.0)
    for k2, d in ((gap.k2[0], left), (gap.k2[1], right), (gap.k2[2], third)):
        if k2 != 0.0:
            total -= k2 / d if derivative == 0 else (k2 / (d * d) if derivative == 1 else k2 / (d * d * d))
    return total


@routine
def bisect(gap, derivative, rising, low, high):
    """The place between two others where a derivative changes its sign; a place is (side, distance)."""
    half = 0.5 * gap.width
    for _ in range(2200):
        if low[0] == 0 and high[0] == 1:
            if low[1] < half:
                middle = (0, half)
            elif high[1] < half:
                middle = (1, half)
            else:
                break
        else:
            a, b = low[1], high[1]
            x = math.sqrt(a) * math.sqrt(b) if max(a, b) > 4.0 * min(a, b) else 0.5 * (a + b)
            if x in (a, b):
                break
            middle = (low[0], x)
        if (at(gap, derivative, middle[0], middle[1]) > 0.0) != rising:
            low = middle
        else:
            high = middle
        if low[0] == 0 and low[1] == half:
            low = (1, half)
        if high[0] == 1 and high[1] == half and low[0] == 0:
            high = (0, half)
    return low


@routine
def spacelike_root(gap, smallest):
    """The place of the root where f falls steepest."""
    first, last = (0, min(smallest, 1e-3 * gap.width)), (1, min(smallest, 1e-3 * gap.width))
    turning = bisect(gap, 2, False, first, last)
    if at(gap, 1, turning[0], turning[1]) <= 0.0:
        return bisect(gap, 0, False, first, last)
    least = bisect(gap, 1, True, first, turning)
    greatest = bisect(gap, 1, False, turning, last)
    before = at(gap, 0, least[0], least[1]) < 0.0
    after = at(gap, 0, greatest[0], greatest[1]) > 0.0
    if not after:
        return bisect(gap, 0, False, first, least)
    if not before:
        return bisect(gap, 0, False, greatest, last)
    one, two = bisect(gap, 0, False, first, least), bisect(gap, 0, False, greatest, last)
    return one if at(gap, 1, one[0], one[1]) < at(gap, 1, two[0], two[1]) else two


@routine
def eigenvector(a, k, c, left, right, third, smallest):
    """(a_e, d, vector of norm 1) of the root z = a_e - d in the gap between two of the a."""
    width = sub(a[right], a[left])[0]
    gap = Gap(
        width,
        sub(a[left], c)[0],
        sub(a[right], c)[0],
        sub(a[third], a[left])[0],
        sub(a[third], a[right])[0],
        (k[left][0] * k[left][0], k[right][0] * k[right][0], k[third][0] * k[third][0]),
    )
    side, x = spacelike_root(gap, smallest)
    end, other = (left, right) if side == 0 else (right, left)
    d = (-x if side == 0 else x, 0.0)
    to_other, to_third = sub(a[other], a[end]), sub(a[third], a[end])
    k2, free = square(k[end]), sub(a[end], c)
    has_third = k[third][0] != 0.0
    for _ in range(4):
        q1 = div(square(k[other]), add(to_other, d))
        q2 = div(square(k[third]), add(to_third, d)) if has_third else ZERO
        bracket = sub(sub(free, d), add(q1, q2))
        slope = bracket[0] + d[0] * (q1[0] / (to_other[0] + d[0]) - 1.0)
        if has_third:
            slope += d[0] * q2[0] / (to_third[0] + d[0])
        d = sub(d, (sub(mul(d, bracket), k2)[0] / slope, 0.0))
    at_other = div(mul(d, k[other]), add(to_other, d))
    at_third = div(mul(d, k[third]), add(to_third, d)) if has_third else ZERO
    norm2 = sub(add(k2, add(square(at_other), square(at_third))), square(d))
    inverse = div(ONE, sqrt(norm2))
    at_end, at_other, at_third = mul(k[end], inverse), mul(at_other, inverse), mul(at_third, inverse)
    vector = (
        at_end if end == 0 else (at_other if other == 0 else at_third),
        at_end if end == 1 else (at_other if other == 1 else at_third),
        at_end if end == 2 else (at_other if other == 2 else at_third),
        mul(d, inverse),
    )
    return a[end], d, vector


@routine
def unit(i):
    """Unit vector along axis i of four."""
    return ONE if i == 0 else ZERO, ONE if i == 1 else ZERO, ONE if i == 2 else ZERO, ONE if i == 3 else ZERO


@routine
def _determinant(x, y, z):
    first = mul(x[0], sub(mul(y[1], z[2]), mul(y[2], z[1])))
    second = mul(x[1], sub(mul(y[0], z[2]), mul(y[2], z[0])))
    return add(sub(first, second), mul(x[2], sub(mul(y[0], z[1]), mul(y[1], z[0]))))


@routine
def _without(x, i):
    return x[1] if i == 0 else x[0], x[2] if i <= 1 else x[1], x[2] if i == 3 else x[3]


@routine
def completing(x, y, z):
    """The vector orthogonal to three others, of norm 1: det[x y . z] > 0."""
    c0 = _determinant(_without(x, 0), _without(y, 0), _without(z, 0))
    c1 = neg(_determinant(_without(x, 1), _without(y, 1), _without(z, 1)))
    c2 = _determinant(_without(x, 2), _without(y, 2), _without(z, 2))
    c3 = neg(_determinant(_without(x, 3), _without(y, 3), _without(z, 3)))
    vector = c0, c1, c2, neg(c3)
    return _scaled4(div(ONE, sqrt(lorentz(vector, vector))), vector)


@routine
def quadric(a, k, c, x, y):
    """x.Q_B.y."""
    total = add(add(mul(a[0], mul(x[0], y[0])), mul(a[1], mul(x[1], y[1]))), mul(a[2], mul(x[2], y[2])))
    return sub(sub(total, add(mul(dot(k, x), y[3]), mul(dot(k, y), x[3]))), mul(c, mul(x[3], y[3])))


@routine
def boosted(inertia, k, gamma):
    """Boost from moments, k and gamma along principal axes, all in two parts.

    At least two components of k are not zero, and none of these is below SMALLEST_K of the greatest number of
    the problem; of two axes with equal moments one has k = 0.
    """
    hi, mid, lo = ascending(inertia)  # of the inverse moments
    a = (
        less_middle(inertia, 0, mid),
        less_middle(inertia, 1, mid),
        less_middle(inertia, 2, mid),
    )
    greatest = max(abs(a[lo][0]), abs(a[hi][0]), abs(k[0][0]), abs(k[1][0]), abs(k[2][0]))
    c = sub(
        dot((mul(a[0], gamma[0]), mul(a[1], gamma[1]), mul(a[2], gamma[2])), gamma),
        scale(dot(k, gamma), 2.0),
    )
    smallest = 1e-3 * SMALLEST_K * SMALLEST_K * greatest
    if k[lo][0] == 0.0:
        first = a[lo], ZERO, unit(lo)
        second = eigenvector(a, k, c, mid, hi, lo, smallest)
    elif k[mid][0] == 0.0:
        first = a[mid], ZERO, unit(mid)
        second = eigenvector(a, k, c, lo, hi, mid, smallest)
    elif k[hi][0] == 0.0:
        first = a[hi], ZERO, unit(hi)
        second = eigenvector(a, k, c, lo, mid, hi, smallest)
    else:
        first = eigenvector(a, k, c, lo, mid, hi, smallest)
        second = eigenvector(a, k, c, mid, hi, lo, smallest)
    return _transformed_problem(a, k, c, gamma, first, second, div(ONE, inertia[mid]))


@routine
def less_middle(inertia, i, mid):
    """a_i - a_mid."""
    return div(sub(inertia[mid], inertia[i]), mul(inertia[i], inertia[mid]))


@routine
def _transformed_problem(a, k, c, gamma, first, second, shift):
    """The problem along eigenvectors E1 and E2 (48); E0 is the time axis, made orthogonal to both."""
    (end1, d1, E1), (end2, d2, E2) = first, second
    z1, z2 = sub(end1, d1), sub(end2, d2)
    E0 = _sum4((ZERO, ZERO, ZERO, ONE), _sum4(_scaled4(E1[3], E1), _scaled4(E2[3], E2)))
    strength = sqrt(add(ONE, add(square(E1[3]), square(E2[3]))))
    E0 = _scaled4(div(ONE, strength), E0)
    E3 = completing(E1, E2, E0)
    a3, k3 = quadric(a, k, c, E3, E3), neg(quadric(a, k, c, E3, E0))
    X = gamma[0], gamma[1], gamma[2], ONE
    time = div(ONE, neg(lorentz(E0, X)))
    base = mul(lorentz(E1, X), time), mul(lorentz(E2, X), time), mul(lorentz(E3, X), time)
    per = div(ONE, add(ONE, E0[3]))
    w = mul(E0[0], per), mul(E0[1], per), mul(E0[2], per)
    axes = axis(E1, E0, w), axis(E2, E0, w), axis(E3, E0, w)
    G0 = E0[3][0]
    return Boosted(
        (z1, z2, a3),
        sub(sub(end1, end2), sub(d1, d2)),
        sub(z1, a3),
        sub(z2, a3),
        k3,
        base,
        shift,
        axes,
        w,
        G0 + math.sqrt(max(G0 * G0 - 1.0, 0.0)),
    )


@routine
def axis(E, E0, w):
    """An axis of the problem along those of the body: the rotation in the Lorentz transformation."""
    turn = sub(dot(w, E), E[3])
    return add(E[0], mul(E0[0], turn)), add(E[1], mul(E0[1], turn)), add(E[2], mul(E0[2], turn))

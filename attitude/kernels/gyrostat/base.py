"""How the problem of a body with any rotors becomes that of a body with a rotor along its axis 3.

docs/gyrostats.md: (38) where the motion is two turns, section 2 for a rotor along a principal axis, section 6
for any other.
"""

from typing import NamedTuple

from ..doubledouble import ONE, ZERO, add, div, equal, hypot, mul, neg, two_product
from ..expansion import append, append_pair, append_product, assign, clear, value
from ..intrinsics import routine
from ..layout import Sum
from ..regime import ascending
from .boost import SMALLEST_K, boosted, dot, unit
from .conserved import Conserved, conserved

# The other two axes before a given one, right-handed.
BEFORE = ((1, 2), (2, 0), (0, 1))


class Base(NamedTuple):
    """A problem with its rotor along axis 3, what it conserves, and the way back to the body."""

    conserved: Conserved
    two_turns: bool  # the motion is elementary: a symmetric body with its rotor along the axis, or a sphere
    L: tuple
    shift: tuple  # a that was subtracted from all a_i
    axes: tuple  # rows: axes of the problem along the principal ones
    w: tuple  # of the Lorentz transformation, along the principal axes
    any_rotor: bool  # the rotor is along no principal axis
    condition: float  # of what takes the problem's attitude to the body's


@routine
def momenta(tensor, rate, h, R, diagonal, rows):
    """Write the whole momentum along the principal axes to its rows; returns that of the rotors along them.

    Exact for a diagonal tensor; of any other, exact in the body's axes and turned in two parts.
    """
    for i in range(3):
        clear(rows[Sum.PRINCIPAL + i])
        for j in range(3):
            append_pair(rows[Sum.PRINCIPAL + i], 1.0, two_product(tensor[i, j], rate[j]))
        append(rows[Sum.PRINCIPAL + i], h[i])
    rotors = (h[0], 0.0), (h[1], 0.0), (h[2], 0.0)
    if diagonal:
        return rotors
    body = _momentum(rows)
    for i in range(3):
        assign(rows[Sum.PRINCIPAL + i], dot(R[i], body))
    return dot(R[0], rotors), dot(R[1], rotors), dot(R[2], rotors)


@routine
def matrix_product(A, B):
    """A B, of three rows of three pairs each."""
    columns = (B[0][0], B[1][0], B[2][0]), (B[0][1], B[1][1], B[2][1]), (B[0][2], B[1][2], B[2][2])
    return (
        (dot(A[0], columns[0]), dot(A[0], columns[1]), dot(A[0], columns[2])),
        (dot(A[1], columns[0]), dot(A[1], columns[1]), dot(A[1], columns[2])),
        (dot(A[2], columns[0]), dot(A[2], columns[1]), dot(A[2], columns[2])),
    )


@routine
def _momentum(rows):
    return value(rows[Sum.PRINCIPAL]), value(rows[Sum.PRINCIPAL + 1]), value(rows[Sum.PRINCIPAL + 2])


@routine
def base_problem(inertia, h, rows):
    """The problem of moments and rotors along principal axes, whose momentum is in its rows."""
    h = without_negligible(inertia, h, rows)
    identity = unit(0)[:3], unit(1)[:3], unit(2)[:3]
    if equal(inertia[0], inertia[1]) and equal(inertia[1], inertia[2]):
        return sphere(inertia, h, rows)
    for axis in range(3):
        i, j = BEFORE[axis]
        if equal(inertia[i], inertia[j]):
            if h[i][0] == 0.0 and h[j][0] == 0.0:
                return _two_turns(inertia, h, axis, rows)
            inverse = div(ONE, hypot(h[i], h[j]))
            axes = axes_along(mul(h[i], inverse), mul(h[j], inverse), axis)
            m = _momentum(rows)
            for n in range(3):
                assign(rows[Sum.PRINCIPAL + n], dot(axes[n], m))
            h = hypot(h[i], h[j]), ZERO, h[axis]
            return without_symmetry((inertia[i], inertia[j], inertia[axis]), h, axes, rows)
    return without_symmetry(inertia, h, identity, rows)


@routine
def without_negligible(inertia, h, rows):
    """The rotors without components that two parts of the rest do not resolve, where there are several."""
    m = _momentum(rows)
    greatest = max(abs(m[0][0]), abs(m[1][0]), abs(m[2][0]))
    spread = max(
        abs(1.0 / inertia[0][0] - 1.0 / inertia[1][0]), abs(1.0 / inertia[1][0] - 1.0 / inertia[2][0])
    )
    rates = abs(h[0][0] / inertia[0][0]), abs(h[1][0] / inertia[1][0]), abs(h[2][0] / inertia[2][0])
    least = SMALLEST_K * max(greatest * spread, rates[0], rates[1], rates[2])
    return (
        h[0] if rates[0] > least or rates[1] + rates[2] == 0.0 else ZERO,
        h[1] if rates[1] > least or rates[2] + rates[0] == 0.0 else ZERO,
        h[2] if rates[2] > least or rates[0] + rates[1] == 0.0 else ZERO,
    )


@routine
def without_symmetry(inertia, h, axes, rows):
    """The problem of moments that differ where rotors tell them apart; axes : rows, along the principal."""
    along = int(h[0][0] != 0.0) + int(h[1][0] != 0.0) + int(h[2][0] != 0.0)
    if along > 1:
        return _any_rotor(inertia, h, axes, rows)
    axis = 0 if h[0][0] != 0.0 else (1 if h[1][0] != 0.0 else 2)
    if along == 0:  # a free body: an axis that is not the middle one
        axis = ascending(inertia)[2]
    i, j = BEFORE[axis]
    W = axis_rows(inertia, h, axis, rows)
    c = conserved(rows, W, (div(ONE, inertia[i]), div(ONE, inertia[j]), div(ONE, inertia[axis])), ZERO)
    return Base(c, False, c.L, ZERO, (axes[i], axes[j], axes[axis]), (ZERO, ZERO, ZERO), False, 1.0)


@routine
def axis_rows(inertia, h, axis, rows):
    """Write M, A_ij and K of a rotor along a principal axis to their rows; returns W = I1 I2 I3."""
    i, j = BEFORE[axis]
    for row, source in ((Sum.M1, i), (Sum.M2, j), (Sum.M3, axis)):
        clear(rows[row])
        for n in range(1, int(rows[Sum.PRINCIPAL + source][0]) + 1):
            append(rows[row], rows[Sum.PRINCIPAL + source][n])
    # W (a_p - a_q) = (I_q - I_p) I_r
    for row, p, q, r in ((Sum.A12, i, j, axis), (Sum.A13, i, axis, j), (Sum.A23, j, axis, i)):
        assign(rows[Sum.PART], inertia[q])
        append_pair(rows[Sum.PART], -1.0, inertia[p])
        assign(rows[Sum.PRODUCT], inertia[r])
        clear(rows[row])
        append_product(rows[row], 1.0, rows[Sum.PART], rows[Sum.PRODUCT])
    assign(rows[Sum.PART], inertia[i])
    assign(rows[Sum.PRODUCT], inertia[j])
    clear(rows[Sum.TOTAL])
    append_product(rows[Sum.TOTAL], 1.0, rows[Sum.PART], rows[Sum.PRODUCT])
    assign(rows[Sum.PART], h[axis])
    clear(rows[Sum.K])
    append_product(rows[Sum.K], 1.0, rows[Sum.PART], rows[Sum.TOTAL])
    return mul(mul(inertia[i], inertia[j]), inertia[axis])


@routine
def _any_rotor(inertia, h, axes, rows):
    m = _momentum(rows)
    L = hypot(hypot(m[0], m[1]), m[2])
    inverse = div(ONE, L)
    gamma = mul(m[0], inverse), mul(m[1], inverse), mul(m[2], inverse)
    k = (
        div(mul(h[0], inverse), inertia[0]),
        div(mul(h[1], inverse), inertia[1]),
        div(mul(h[2], inverse), inertia[2]),
    )
    new = boosted(inertia, k, gamma)
    for row, x in ((Sum.M1, new.gamma[0]), (Sum.M2, new.gamma[1]), (Sum.M3, new.gamma[2])):
        assign(rows[row], x)
    for row, x in ((Sum.A12, new.a12), (Sum.A13, new.a13), (Sum.A23, new.a23), (Sum.K, new.k)):
        assign(rows[row], x)
    c = conserved(rows, ONE, new.a, L)
    w = combination(new.w, axes)
    return Base(c, False, L, new.shift, matrix_product(new.axes, axes), w, True, new.condition)


@routine
def combination(x, rows):
    """x1 row1 + x2 row2 + x3 row3."""
    return (
        dot(x, (rows[0][0], rows[1][0], rows[2][0])),
        dot(x, (rows[0][1], rows[1][1], rows[2][1])),
        dot(x, (rows[0][2], rows[1][2], rows[2][2])),
    )


@routine
def axes_along(c, s, axis):
    """Axes in the plane of two equal moments, the first along (c, s) there; and the third axis."""
    i, j = BEFORE[axis]
    plane = unit(i)[:3], unit(j)[:3], unit(axis)[:3]
    return combination((c, s, ZERO), plane), combination((neg(s), c, ZERO), plane), plane[2]


@routine
def _two_turns(inertia, h, axis, rows):
    """A symmetric body with its rotor along the axis of symmetry."""
    i, j = BEFORE[axis]
    m = _momentum(rows)
    across = hypot(m[i], m[j])
    W = axis_rows(inertia, h, axis, rows)
    assign(rows[Sum.M1], across)
    clear(rows[Sum.M2])
    a = div(ONE, inertia[i])
    c = conserved(rows, W, (a, a, div(ONE, inertia[axis])), ZERO)
    inverse = div(ONE, across) if across[0] > 0.0 else ZERO
    x, y = (mul(m[i], inverse), mul(m[j], inverse)) if across[0] > 0.0 else (ONE, ZERO)
    return Base(c, True, c.L, ZERO, axes_along(x, y, axis), (ZERO, ZERO, ZERO), False, 1.0)


@routine
def sphere(inertia, h, rows):
    """All moments equal: the rotor's axis is one of symmetry."""
    m = _momentum(rows)
    size = hypot(hypot(h[0], h[1]), h[2])
    inverse = div(ONE, size)
    third = mul(h[0], inverse), mul(h[1], inverse), mul(h[2], inverse)
    m3 = dot(third, m)
    x = (
        add(m[0], neg(mul(m3, third[0]))),
        add(m[1], neg(mul(m3, third[1]))),
        add(m[2], neg(mul(m3, third[2]))),
    )
    across = hypot(hypot(x[0], x[1]), x[2])
    inverse = div(ONE, across)
    first = mul(x[0], inverse), mul(x[1], inverse), mul(x[2], inverse)
    second = (
        add(mul(third[1], first[2]), neg(mul(third[2], first[1]))),
        add(mul(third[2], first[0]), neg(mul(third[0], first[2]))),
        add(mul(third[0], first[1]), neg(mul(third[1], first[0]))),
    )
    for row in (Sum.M2, Sum.A12, Sum.A13, Sum.A23):
        clear(rows[row])
    assign(rows[Sum.M1], across)
    assign(rows[Sum.M3], m3)
    a = div(ONE, inertia[0])
    assign(rows[Sum.K], mul(a, size))
    c = conserved(rows, ONE, (a, a, a), ZERO)
    return Base(c, True, c.L, ZERO, (first, second, third), (ZERO, ZERO, ZERO), False, 1.0)

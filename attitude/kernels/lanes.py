"""Constants of the motion of many bodies at once, in vector lanes: of bodies on the theta route.

The same constants as `invariants`, by formulas without branches, logarithms or loops of unknown length: what
is to be decided is decided by selection, and LLVM turns the loop over a block of bodies into vector
instructions.  The other bodies are listed for `invariants`.  Which ones is decided by a body's own numbers:
no bit of one depends on its company.  Equations: docs/theory.md, sections 3, 4 and 7.1.

The workspace has a row for each number of a record, in its order, then those that describe the body
(layout.LaneRow.ROWS).
"""

import math
from collections import namedtuple
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from . import quaternion
from .doubledouble import ONE, PER_TURN, PI, TURN, ZERO, less, mul, scale, sqrt, square, two_part
from .doubledouble import quick_add as add
from .doubledouble import quick_div as div
from .doubledouble import quick_sub as sub
from .doubledouble import sub as exact_sub
from .intrinsics import bits_of, double_of, fma, inlined, kernel
from .layout import INVARIANTS, LANE_BLOCK, LANE_PITCH, LaneRow, Regime, Route
from .theta_coefficients import (
    TRANSFORM_BELOW,
    frame_matrix,
    sum4,
    theta_direction,
    theta_functions,
    theta_start,
    theta_terms,
)

PITCH = np.uint64(LANE_PITCH)
OFFSETS = {name: field[1] // 8 for name, field in (INVARIANTS.fields or {}).items()}
ROW: Any = namedtuple("ROW", OFFSETS)(**OFFSETS)
# A number of a body, scaled to order one, that is smaller and not zero is left to `invariants`.
SMALLEST = 1e-26
# Left to it as well: needles, and tensors of nearly equal moments, whose axes have few digits.
LEAST_MOMENT, LEAST_RANGE = 1e-10, 1e-10
ARC_TANGENT = tuple(two_part(Fraction(1, n)) for n in (3, 5, 7, 9, 11))  # of its series


class LanePath(NamedTuple):
    """The path of the momentum's direction; squares of roots that `polhode.Polhode` has."""

    s: float
    indices: tuple  # of axes 1, 2, 3
    signs: tuple
    A1: tuple
    A2: tuple
    A3: tuple
    k: tuple
    k1: tuple
    u_rate: tuple
    spin_rates: tuple
    sine: tuple  # of the initial amplitude
    cotangents: tuple  # of the amplitudes of eta and of K' - eta
    served: bool


class GaussMeans(NamedTuple):
    """Means of the AGM from 1 and k1, and of Gauss's transformation along it (theory, section 7.1)."""

    a: tuple
    g: tuple
    c2: tuple
    near: tuple  # cotangent of the amplitude of eta, times a
    far: tuple  # of that of K' - eta
    x: tuple  # over the sine of the initial amplitude, times a
    sine2: tuple  # square of that sine


@inlined
def at(rows, row, i):
    """A number of body i."""
    return rows[np.uint64(row) * PITCH + i]


@inlined
def pairs_at(rows, row, i):
    """Three two-part numbers of body i."""
    return (
        (at(rows, row, i), at(rows, row + 1, i)),
        (at(rows, row + 2, i), at(rows, row + 3, i)),
        (at(rows, row + 4, i), at(rows, row + 5, i)),
    )


@inlined
def put(rows, row, i, x):
    """Write a number of body i."""
    rows[np.uint64(row) * PITCH + i] = x


@inlined
def put_pair(rows, row, i, a):
    """Write both parts of a number of body i."""
    put(rows, row, i, a[0])
    put(rows, row + 1, i, a[1])


@inlined
def put3(rows, row, i, a):
    """Write three numbers of body i."""
    put(rows, row, i, a[0])
    put(rows, row + 1, i, a[1])
    put(rows, row + 2, i, a[2])


@inlined
def put4(rows, row, i, a):
    """Write four numbers of body i."""
    put3(rows, row, i, a)
    put(rows, row + 3, i, a[3])


@inlined
def heads(a):
    """The first parts of four pairs."""
    return a[0][0], a[1][0], a[2][0], a[3][0]


@inlined
def select(condition, a, b):
    """The pair a where the condition holds, else b."""
    return a[0] if condition else b[0], a[1] if condition else b[1]


@inlined
def pick(index, a):
    """One of three pairs, by an index that is a double."""
    return select(index == 0.0, a[0], select(index == 1.0, a[1], a[2]))


@inlined
def power_of_two_below(x, y, z):
    """The power of two in (m/2, m] of the greatest size m of three numbers; 1 for zero."""
    x, y, z = abs(x), abs(y), abs(z)
    x = x if x > y else y
    x = x if x > z else z
    power = double_of(bits_of(x) & 0x7FF0000000000000)
    return power if power > 0.0 else 1.0


@inlined
def order(a):
    """Indices of the least, middle and greatest of three pairs; equal ones keep their order."""
    swap = less(a[1], a[0])
    lo, mid, hi = 1.0 if swap else 0.0, 0.0 if swap else 1.0, 2.0
    swap = less(a[2], pick(mid, a))
    mid, hi = hi if swap else mid, mid if swap else hi
    swap = less(pick(mid, a), pick(lo, a))
    return mid if swap else lo, lo if swap else mid, hi


@inlined
def usable(x):
    """Whether a scaled number is zero, or large enough for its products to keep their digits."""
    return (x[0] == 0.0) | (x[0] >= SMALLEST)


@inlined
def path_of(inertia, omega, smallest_range):
    """The path of a body with these moments and rates along its principal axes, both of order one.

    smallest_range : of the moments, below which the body is left to `invariants`
    """
    lo, mid, hi = order(inertia)
    I_lo, I2, I_hi = pick(lo, inertia), pick(mid, inertia), pick(hi, inertia)
    # to all digits also where moments nearly agree: A1^2 + A3^2 = 1 rests on d31 = d21 + d32
    d_lo, d_hi, d31 = exact_sub(I2, I_lo), exact_sub(I_hi, I2), exact_sub(I_hi, I_lo)
    e_lo, e_hi = mul(I_lo, square(pick(lo, omega))), mul(I_hi, square(pick(hi, omega)))
    e2 = mul(I2, square(pick(mid, omega)))
    D = sub(mul(d_hi, e_hi), mul(d_lo, e_lo))  # eq. (6), whose terms differ by a thirtieth at the least
    short = D[0] > 0.0
    moments = select(short, I_lo, I_hi), I2, select(short, I_hi, I_lo)
    energies = select(short, e_lo, e_hi), e2, select(short, e_hi, e_lo)
    differences = select(short, d_lo, d_hi), d31, select(short, d_hi, d_lo)
    indices = lo if short else hi, mid, hi if short else lo
    s = 1.0 if short else -1.0
    in_range = (d31[0] >= smallest_range) & (I_lo[0] >= LEAST_MOMENT)
    in_range &= usable(d_lo) & usable(d_hi) & usable(e_lo) & usable(e2) & usable(e_hi)
    return path_along(
        s, indices, signs_of(indices, omega), (moments, energies, differences), scale(D, s), in_range
    )


@inlined
def signs_of(indices, omega):
    """Signs that turn axes 1 and 3 towards the momentum, and axis 2 to the right hand; sign of its rate."""
    first, mid, third = indices
    sign1 = -1.0 if pick(first, omega)[0] < 0.0 else 1.0
    sign3 = -1.0 if pick(third, omega)[0] < 0.0 else 1.0
    turn = mid - first
    sign2 = sign1 * sign3 * (1.0 if (turn == 1.0) | (turn == -2.0) else -1.0)
    return sign1, sign2, sign3, -1.0 if pick(mid, omega)[0] < 0.0 else 1.0


@inlined
def path_along(s, indices, signs, numbers, size_of_D, in_range):
    """Amplitudes, moduli and rates (eqs. 8 to 12), from sums whose terms have one sign."""
    (I1, I2, I3), (e1, e2, e3), (d21, d31, d32) = numbers
    U1, U3 = add(mul(d21, e2), mul(d31, e3)), add(mul(d31, e1), mul(d32, e2))
    d32_U1, L2 = mul(d32, U1), add(add(mul(I1, e1), mul(I2, e2)), mul(I3, e3))
    L, d31_L2 = sqrt(L2), mul(d31, L2)
    k12 = div(mul(d31, size_of_D), d32_U1)
    A1, A3 = sqrt(div(mul(U3, I1), d31_L2)), sqrt(div(mul(U1, I3), d31_L2))
    return LanePath(
        s=s,
        indices=indices,
        signs=signs,
        A1=A1,
        A2=sqrt(div(mul(U3, I2), mul(d32, L2))),
        A3=A3,
        k=sqrt(div(mul(U3, d21), d32_U1)),
        k1=sqrt(k12),
        u_rate=sqrt(div(d32_U1, mul(mul(I1, I2), I3))),
        spin_rates=(div(L, I1), div(L, I2), div(L, I3)),
        sine=scale(sqrt(div(mul(d32, e2), U3)), s * signs[1] * signs[3]),
        cotangents=(sqrt(div(mul(d21, I3), mul(d32, I1))), div(A1, A3)),
        served=in_range & (k12[0] >= TRANSFORM_BELOW) & (U3[0] > 0.0) & (d32[0] > 0.0),
    )


@inlined
def next_means(m):
    """One step of all means, which leaves K and the integrals to all amplitudes as they are."""
    a, g = scale(add(m.a, m.g), 0.5), sqrt(mul(m.a, m.g))
    near = scale(add(m.near, sqrt(add(square(m.near), m.c2))), 0.5)
    far = scale(add(m.far, sqrt(add(square(m.far), m.c2))), 0.5)
    x = scale(add(m.x, sqrt(sub(square(m.x), mul(m.sine2, m.c2)))), 0.5)
    return GaussMeans(a, g, square(div(scale(m.c2, 0.25), a)), near, far, x, m.sine2)


@inlined
def last_means(path):
    """(a, near, far, x) after six steps: the next change is 1e-44 of them where k1^2 is 0.03."""
    near, far = path.cotangents
    m = next_means(GaussMeans(ONE, path.k1, square(path.k), near, far, ONE, square(path.sine)))
    m = next_means(next_means(next_means(next_means(m))))
    quarter = 0.25 * m.c2[0]  # the last step needs no root: c^2 is of the second part
    a, far = sub(m.a, (quarter / m.a[0], 0.0)), add(m.far, (quarter / m.far[0], 0.0))
    near = add(m.near, (quarter / (m.near[0] if m.near[0] > 0.0 else 1.0), 0.0))
    return a, near, far, sub(m.x, (quarter * m.sine2[0] / m.x[0], 0.0))


@inlined
def exponential(cotangent, a):
    """exp(-2 asinh(a/cotangent))."""
    return square(div(cotangent, add(a, sqrt(add(square(a), square(cotangent))))))


@inlined
def half_tangent(t):
    """tan(v/2) from tan v."""
    return div(t, add(ONE, sqrt(add(ONE, square(t)))))


@inlined
def turns_of(sine, cosine):
    """The angle, -1/4 to 1/4 turns, of a sine and cosine: four half angles, a series of the arc tangent."""
    third, fifth, seventh, ninth, eleventh = ARC_TANGENT
    t = half_tangent(half_tangent(half_tangent(div(sine, add(ONE, cosine)))))
    r2 = square(t)
    r = -r2[0]
    p = fma(r, fma(r, fma(r, 1.0 / 25.0, 1.0 / 23.0), 1.0 / 21.0), 1.0 / 19.0)
    p = fma(r, fma(r, fma(r, p, 1.0 / 17.0), 1.0 / 15.0), 1.0 / 13.0)
    series = sub(ninth, mul(r2, add(eleventh, (r * p, 0.0))))
    series = sub(third, mul(r2, sub(fifth, mul(r2, sub(seventh, mul(r2, series))))))
    return scale(mul(mul(t, sub(ONE, mul(r2, series))), PER_TURN), 16.0)


@inlined
def mean_slope(q, E, E_prime, terms):
    """The slope of arg theta4 at u = 0, sum 2n b_n / sum a_n, n to 5; a_4 and on are of the second part."""
    a, b, _c, _d = terms
    q4 = q[0] * q[0] * q[0] * q[0]
    q8 = q4 * q4
    q28 = q8 * q8 * q8 * q4
    P4, E4 = E_prime[0] * E_prime[0] * E_prime[0] * E_prime[0], E[0] * E[0] * E[0] * E[0]
    near4, far4 = q28 * P4, q28 * q4 * E4
    near5, far5 = near4 * q8 * q8 * q[0] * E_prime[0], far4 * q8 * q8 * q[0] * q[0] * E[0]
    below = add(sum4(a), ((near4 + far4) - (near5 + far5), 0.0))
    above = add(scale(b[1], 2.0), add(scale(b[2], 4.0), mul(b[3], (6.0, 0.0))))
    return div(add(above, (8.0 * (near4 - far4) - 10.0 * (near5 - far5), 0.0)), below)


@inlined
def precession_of(path, v_rate, slope):
    """lambda (eq. 20), rad/s: the mean rate of arg alpha at u = 0 less the rate of theta4 there."""
    share1 = div(square(path.A1), add(ONE, path.A3))
    mean = scale(add(mul(path.spin_rates[0], share1), mul(path.spin_rates[2], path.A3)), 0.5)
    return sub(mean, scale(mul(v_rate, slope), path.s))


@inlined
def put_record(rows, i, unit, path, axes):
    """Write all numbers of a record, from the path and the principal axes (rows of pairs)."""
    a, near, far, x = last_means(path)
    E, E_prime = exponential(near, a), exponential(far, a)
    q, sine = mul(E, E_prime), div(mul(a, path.sine), x)
    cosine = sqrt(mul(sub(ONE, sine), add(ONE, sine)))
    terms = theta_terms(q, E, E_prime)
    functions = theta_functions(path.s, path.A1, path.A3, terms)
    put_phases(rows, i, unit, path, (a, mean_slope(q, E, E_prime, terms), turns_of(sine, cosine)))
    put4(rows, ROW.alpha_re, i, heads(functions[0]))
    put4(rows, ROW.alpha_im, i, heads(functions[1]))
    put4(rows, ROW.beta_re, i, heads(functions[2]))
    put4(rows, ROW.beta_im, i, heads(functions[3]))
    put_direction(rows, i, theta_direction((path.A1, scale(path.A2, path.s), path.A3), q))
    put_frame(rows, i, unit, path, axes, theta_start(functions, sine, cosine))
    put(rows, ROW.nome, i, q[0])
    put3(rows, LaneRow.NOMES, i, (q[0], E[0], E_prime[0]))
    # nearer to a quarter period the cosine loses digits of the argument
    put(rows, LaneRow.SERVED, i, 1.0 if path.served & (cosine[0] > 1e-10) else 0.0)


@inlined
def put_phases(rows, i, unit, path, arguments):
    """Write the rates of the phases and what users ask about; arguments : agm(1, k1), slope of theta4, v0."""
    a, slope, v0 = arguments
    v_rate = mul(path.u_rate, a)
    put_pair(rows, ROW.precession, i, scale(mul(precession_of(path, v_rate, slope), PER_TURN), unit))
    put_pair(rows, ROW.argument, i, scale(mul(v_rate, PER_TURN), unit))
    put_pair(rows, ROW.argument0, i, v0)
    put4(rows, ROW.half_turn, i, (0.0, 0.0, 0.0, 0.0))  # and its inverse, and the slip
    put(rows, ROW.route, i, double_of(Route.THETA))
    put(rows, ROW.regime, i, double_of(Regime.SHORT_AXIS if path.s > 0.0 else Regime.LONG_AXIS))
    put3(rows, ROW.amplitude, i, (path.A1[0], path.A2[0], path.A3[0]))
    put(rows, ROW.modulus, i, path.k[0])
    put(rows, ROW.complementary_modulus, i, path.k1[0])
    put(rows, ROW.K, i, div(scale(PI, 0.5), a)[0])
    put(rows, ROW.u_rate, i, path.u_rate[0] * unit)
    put(rows, ROW.u0, i, mul(div(v0, a), TURN)[0])


@inlined
def put_direction(rows, i, direction):
    """Write the theta quotients of the momentum's direction."""
    g1, g2, g3, below = direction
    put4(rows, ROW.direction, i, heads(g1))
    put4(rows, ROW.direction + 5, i, heads(g2))
    put4(rows, ROW.direction + 10, i, heads(g3))
    put4(rows, ROW.direction + 15, i, heads(below))
    put4(rows, ROW.direction + 16, i, (below[1][0], below[2][0], below[3][0], below[4][0]))
    put(rows, ROW.direction + 4, i, g1[4][0])
    put(rows, ROW.direction + 9, i, g2[4][0])
    put(rows, ROW.direction + 14, i, g3[4][0])


@inlined
def put_frame(rows, i, unit, path, axes, start):
    """Write the matrices that lead to the attitude and to the rate; start : alpha and beta at t = 0."""
    R1 = axis(path.indices[0], path.signs[0], axes)
    R2 = axis(path.indices[1], path.signs[1], axes)
    R3 = axis(path.indices[2], path.signs[2], axes)
    (w, z), (x, y) = start
    attitude = quaternion.of_doubles(
        (
            at(rows, LaneRow.ATTITUDE, i),
            at(rows, LaneRow.ATTITUDE + 1, i),
            at(rows, LaneRow.ATTITUDE + 2, i),
            at(rows, LaneRow.ATTITUDE + 3, i),
        )
    )
    q_PB = quaternion.from_rotation_matrix((R1, R2, R3))
    frame = frame_matrix(q_PB, (w, x, y, z), quaternion.normalised(attitude))
    put4(rows, ROW.frame, i, frame[0])
    put4(rows, ROW.frame + 4, i, frame[1])
    put4(rows, ROW.frame + 8, i, frame[2])
    put4(rows, ROW.frame + 12, i, frame[3])
    put3(rows, ROW.rate, i, rate_row((R1[0], R2[0], R3[0]), path.spin_rates, unit))
    put3(rows, ROW.rate + 3, i, rate_row((R1[1], R2[1], R3[1]), path.spin_rates, unit))
    put3(rows, ROW.rate + 6, i, rate_row((R1[2], R2[2], R3[2]), path.spin_rates, unit))


@inlined
def axis(index, sign, axes):
    """The principal axis of this index, times its sign."""
    a, b, c = axes
    return (
        scale(pick(index, (a[0], b[0], c[0])), sign),
        scale(pick(index, (a[1], b[1], c[1])), sign),
        scale(pick(index, (a[2], b[2], c[2])), sign),
    )


@inlined
def rate_row(R, spin_rates, unit):
    """A row of R_BP diag(L/I)."""
    x, y, z = mul(R[0], spin_rates[0]), mul(R[1], spin_rates[1]), mul(R[2], spin_rates[2])
    return x[0] * unit, y[0] * unit, z[0] * unit


@inlined
def component(a, rate):
    """The component of a rate along a two-part axis."""
    return add(add(mul(a[0], rate[0]), mul(a[1], rate[1])), mul(a[2], rate[2]))


@inlined
def lane(rows, i, turned):
    """Constants of body i, from the rows that describe it.

    turned : None where the body's axes are principal ones, else anything
    """
    moments = pairs_at(rows, LaneRow.MOMENTS, i)
    per_size = 1.0 / power_of_two_below(moments[0][0], moments[1][0], moments[2][0])
    inertia = scale(moments[0], per_size), scale(moments[1], per_size), scale(moments[2], per_size)
    x, y, z = at(rows, LaneRow.RATE, i), at(rows, LaneRow.RATE + 1, i), at(rows, LaneRow.RATE + 2, i)
    unit = power_of_two_below(x, y, z)
    per_unit = 1.0 / unit
    rate = (x * per_unit, 0.0), (y * per_unit, 0.0), (z * per_unit, 0.0)
    if turned is None:
        axes = (ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE)
        put_record(rows, i, unit, path_of(inertia, rate, 0.0), axes)
    else:
        axes = (
            pairs_at(rows, LaneRow.AXES, i),
            pairs_at(rows, LaneRow.AXES + 6, i),
            pairs_at(rows, LaneRow.AXES + 12, i),
        )
        omega = component(axes[0], rate), component(axes[1], rate), component(axes[2], rate)
        put_record(rows, i, unit, path_of(inertia, omega, LEAST_RANGE), axes)


@inlined
def describe(rows, i, moments, axes, rate, attitude):
    """Write the rows that describe body i."""
    for n in range(3):
        put_pair(rows, LaneRow.MOMENTS + 2 * n, i, moments[n])
        put(rows, LaneRow.RATE + n, i, rate[n])
        if axes is not None:
            for m in range(3):
                put_pair(rows, LaneRow.AXES + 6 * n + 2 * m, i, axes[n, m])
    for n in range(4):
        put(rows, LaneRow.ATTITUDE + n, i, attitude[n])


@kernel
def theta_invariants(moments, axes, rates, attitudes, out, others, rows):
    """Fill the records of the bodies that these formulas serve, and list the others.

    Parameters
    ----------
    moments, axes, rates, attitudes : as in `invariants.invariants`; axes None for the axes of the body
    out : (n, LaneRow.SERVED), the records as doubles, written
    others : (n + 1,), written: the number of those not served, their indices
    rows : (layout.LaneRow.ROWS * layout.LANE_PITCH,), scratch
    """
    listed = 0
    for start in range(0, out.shape[0], LANE_BLOCK):
        bodies = min(LANE_BLOCK, out.shape[0] - start)
        padded = (bodies + 7) & ~7  # whole vectors, so that all bodies take the same code
        for j in range(padded):
            b = start + min(j, bodies - 1)
            own = None if axes is None else axes[b]
            describe(rows, np.uint64(j), moments[b], own, rates[b], attitudes[b])
        for i in range(np.uint64(padded)):
            lane(rows, i, axes)
        for j in range(bodies):
            if at(rows, LaneRow.SERVED, np.uint64(j)) > 0.0:
                read_record(rows, np.uint64(j), out[start + j])
            else:
                listed += 1
                others[listed] = start + j
    others[0] = listed


@inlined
def read_record(rows, i, out):
    """Copy a record from the rows; K' and eta by logarithms of the nome and of exp(-pi eta/K)."""
    for n in range(LaneRow.SERVED):
        out[n] = at(rows, n, i)
    log_E, log_E_prime = math.log(at(rows, LaneRow.NOMES + 1, i)), math.log(at(rows, LaneRow.NOMES + 2, i))
    per_log = -out[ROW.K] / math.pi
    out[ROW.K_prime], out[ROW.eta] = per_log * (log_E + log_E_prime), per_log * log_E

"""Coefficients of the two theta functions, and of the momentum's direction, in two parts.

Without branches or loops of unknown length, so that they serve one body as well as a vector of them
(`lanes`).  Equation numbers are those of docs/theory.md.
"""

from typing import NamedTuple

from . import quaternion
from .doubledouble import ONE, ZERO, mul, neg, scale, sqrt, square
from .doubledouble import quick_add as add
from .doubledouble import quick_div as div
from .doubledouble import quick_sub as sub
from .intrinsics import inlined

# At this complementary parameter (m = 0.97, q = 0.207) the degree-four polynomials of eq. (31) leave
# out 2 q^25 = 1.6e-17; below it the transformed series, with Q < 0.044, is shorter.
TRANSFORM_BELOW = 0.03


class Series(NamedTuple):
    """Coefficients of the two theta functions, and the rates of their phases."""

    precession: tuple
    argument: tuple
    argument0: tuple
    alpha_re: tuple
    alpha_im: tuple
    beta_re: tuple
    beta_im: tuple
    alpha: tuple  # at t = 0, unit together with beta
    beta: tuple


@inlined
def polynomial(p, w):
    """p0 + p1 w + p2 w^2 + p3 w^3."""
    return add(p[0], mul(w, add(p[1], mul(w, add(p[2], mul(w, p[3]))))))


@inlined
def alternating(x):
    """The first four, every second with its sign changed."""
    return x[0], neg(x[1]), x[2], neg(x[3])


@inlined
def theta_terms(q, E, E_prime):
    """a_n, b_n of theta4 and c_k, d_k of theta1 relative to its first, n and k from 0 to 3 (eqs. 17, 18).

    The d_k are (1 - E) times sums of one sign, sinh (2k+1)h / sinh h = sum_j e^2jh: where the two
    moments beside axis 1 are nearly equal h is as small, and all of beta is of that size.
    """
    q2, P2, E2 = square(q), square(E_prime), square(E)
    q3, q4 = mul(q2, q), square(q2)
    q8, P3, E3 = square(q4), mul(P2, E_prime), mul(E2, E)
    near1, far1 = mul(q, E_prime), mul(q2, E)
    near2, far2 = mul(mul(q4, q2), P2), mul(q8, E2)
    near3, far3 = mul(mul(q8, mul(q4, q3)), P3), mul(mul(square(q8), q2), E3)
    a = ONE, neg(add(near1, far1)), add(near2, far2), neg(add(near3, far3))
    b = ZERO, neg(sub(near1, far1)), sub(near2, far2), neg(sub(near3, far3))
    q10, q21 = mul(q8, q2), mul(mul(square(q8), q4), q)
    near1, far1 = mul(q3, E_prime), mul(q4, E2)
    near2, far2 = mul(q10, P2), mul(mul(q8, q4), E3)
    near3, far3 = mul(q21, P3), mul(mul(q21, q3), square(E2))
    c = add(ONE, E), neg(add(near1, far1)), add(near2, far2), neg(add(near3, far3))
    sum1 = add(near1, mul(q4, add(ONE, E)))
    sum2 = add(near2, mul(q10, add(mul(q, E_prime), mul(q2, add(ONE, add(E, E2))))))
    far3 = mul(q2, add(E_prime, mul(q, add(add(ONE, E), add(E2, E3)))))
    sum3 = add(near3, mul(q21, add(mul(q, P2), far3)))
    first = sub(ONE, E)
    d = first, neg(mul(first, sum1)), mul(first, sum2), neg(mul(first, sum3))
    return a, b, c, d


@inlined
def sum4(x):
    """The sum of the first four."""
    return add(add(x[0], x[1]), add(x[2], x[3]))


@inlined
def factors_at_start(A1, A3, sum_alpha, sum_beta):
    """Factors that make abs(alpha)^2 = (1 + A3)/2 and abs(beta)^2 = (1 - A3)/2 at u = 0 (eq. 19)."""
    root = sqrt(scale(add(ONE, A3), 0.5))
    return div(root, sum_alpha), div(scale(div(A1, root), 0.5), sum_beta)


@inlined
def times(factor, x):
    """The first four, each times the factor."""
    return mul(factor, x[0]), mul(factor, x[1]), mul(factor, x[2]), mul(factor, x[3])


@inlined
def linear(w0, w1, w2, w3, x):
    """w0 x0 + w1 x1 + w2 x2 + w3 x3 with small whole weights."""
    total = add(mul(x[0], (w0, 0.0)), mul(x[1], (w1, 0.0)))
    return add(total, add(mul(x[2], (w2, 0.0)), mul(x[3], (w3, 0.0))))


@inlined
def powers_of_cosine(a, b, c, d):
    """Convert coefficients of multiple angles to those of powers of w = cos 2v (eq. 22)."""
    alpha_re = (
        linear(1.0, 0.0, -1.0, 0.0, a),
        linear(0.0, 1.0, 0.0, -3.0, a),
        linear(0.0, 0.0, 2.0, 0.0, a),
        linear(0.0, 0.0, 0.0, 4.0, a),
    )
    alpha_im = linear(0.0, 1.0, 0.0, -1.0, b), scale(b[2], 2.0), scale(b[3], 4.0), ZERO
    beta_re = (
        linear(1.0, 1.0, -1.0, -1.0, c),
        linear(0.0, 2.0, 2.0, -4.0, c),
        linear(0.0, 0.0, 4.0, 4.0, c),
        scale(c[3], 8.0),
    )
    beta_im = (
        neg(linear(1.0, -1.0, -1.0, 1.0, d)),
        neg(linear(0.0, 2.0, -2.0, -4.0, d)),
        neg(linear(0.0, 0.0, 4.0, -4.0, d)),
        scale(d[3], -8.0),
    )
    return alpha_re, alpha_im, beta_re, beta_im


@inlined
def even_cosines(x):
    """Coefficients of 1 + 2 x1 cos 2v + 2 x2 cos 4v + ... as powers of w = cos 2v."""
    p0 = add(sub(ONE, scale(x[2], 2.0)), scale(x[4], 2.0))
    p2 = sub(scale(x[2], 4.0), scale(x[4], 16.0))
    return p0, sub(scale(x[1], 2.0), scale(x[3], 6.0)), p2, scale(x[3], 8.0), scale(x[4], 16.0)


@inlined
def odd_cosines(x):
    """sum x_n cos (2n+1)v / cos v as powers of w; with every second sign changed, of sines in -w."""
    p0 = add(sub(sub(x[0], x[1]), sub(x[2], x[3])), x[4])
    p1 = add(sub(scale(x[1], 2.0), scale(x[2], 2.0)), sub(scale(x[4], 4.0), scale(x[3], 4.0)))
    p2 = sub(sub(scale(x[2], 4.0), scale(x[3], 4.0)), mul(x[4], (12.0, 0.0)))
    return p0, p1, p2, sub(scale(x[3], 8.0), scale(x[4], 8.0)), scale(x[4], 16.0)


@inlined
def theta_direction(amplitudes, q):
    """gamma = (A1 cn, s A2 sn, A3 dn) as theta quotients of nome q (eq. 31), made exact at u = 0 and K.

    amplitudes : A1, s A2, A3.  Returns four rows of five: three numerators as powers of cos 2v, the divisor.
    """
    q2 = square(q)
    q4 = square(q2)
    q6, q8, q9 = mul(q4, q2), square(q4), mul(square(q4), q)
    even = (ONE, q, q4, q9, square(q8))  # q^(n^2)
    odd = (ONE, q2, q6, square(q6), mul(square(q8), q4))  # q^(n(n+1))
    theta3, theta2 = even_cosines(even), odd_cosines(odd)
    theta4, theta1 = (*alternating(theta3), theta3[4]), (*alternating(theta2), theta2[4])
    at_zero2 = add(sum4(theta2), theta2[4])
    at_zero3, at_zero4 = add(sum4(theta3), theta3[4]), add(sum4(theta4), theta4[4])
    factor1 = mul(amplitudes[0], div(at_zero4, at_zero2))
    factor2 = mul(amplitudes[1], div(at_zero3, at_zero2))
    factor3 = mul(amplitudes[2], div(at_zero4, at_zero3))
    return (
        (*times(factor1, theta2), mul(factor1, theta2[4])),
        (*times(factor2, theta1), mul(factor2, theta1[4])),
        (*times(factor3, theta3), mul(factor3, theta3[4])),
        theta4,
    )


@inlined
def theta_functions(s, A1, A3, terms):
    """alpha and beta as powers of w = cos 2v (eq. 22), with their real and imaginary factors.

    terms : `theta_terms`
    """
    a, b, c, d = terms
    factor_a, factor_b = factors_at_start(A1, A3, sum4(a), sum4(d))
    a, b = times(factor_a, a), times(scale(factor_a, s), b)
    c, d = times(scale(factor_b, s), c), times(factor_b, d)
    return powers_of_cosine(a, b, c, d)


@inlined
def theta_start(functions, sine, cosine):
    """(alpha, beta), each of two parts, where v has this sine and cosine (eq. 21)."""
    alpha_re, alpha_im, beta_re, beta_im = functions
    w = sub(square(cosine), square(sine))
    alpha = polynomial(alpha_re, w), mul(scale(mul(sine, cosine), 2.0), polynomial(alpha_im, w))
    return alpha, (mul(sine, polynomial(beta_re, w)), mul(cosine, polynomial(beta_im, w)))


@inlined
def frame_matrix(q_PB, q_MP, attitude):
    """Rows of doubles: q(t) = q_IM * q_MP(t) * q_PB with q_IM from q(0), as one matrix on q_MP (eq. 5)."""
    q_MP = quaternion.conjugate(quaternion.normalised(q_MP))
    w, x, y, z = quaternion.product(quaternion.product(attitude, quaternion.conjugate(q_PB)), q_MP)
    columns = (
        quaternion.rounded_product((w, x, y, z), q_PB),
        quaternion.rounded_product((neg(x), w, z, neg(y)), q_PB),
        quaternion.rounded_product((neg(y), neg(z), w, x), q_PB),
        quaternion.rounded_product((neg(z), y, neg(x), w), q_PB),
    )
    a, b, c, d = columns
    return (
        (a[0], b[0], c[0], d[0]),
        (a[1], b[1], c[1], d[1]),
        (a[2], b[2], c[2], d[2]),
        (a[3], b[3], c[3], d[3]),
    )

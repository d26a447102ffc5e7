"""From the path of the momentum to the two theta functions of the attitude.

Equations (41) to (44) of docs/gyrostats.md, and its section 4 beside and on the separatrices.

The nome p is signed: p < 0 where the other two ends of the path's quartic are complex or interlace.
"""

import math
from typing import NamedTuple

from ..doubledouble import ONE, PI, ZERO, add, div, exp, expm1, mul, neg, scale, sin_cos, sqrt, square, sub
from ..elliptic import mean_with_one
from ..intrinsics import routine
from ..layout import GyrostatRoute
from .path import Family

LARGEST_NOME = 0.04321391826377226  # exp(-pi): the transformed series is as short there


class Coefficients(NamedTuple):
    """The two theta functions and the rates of their phases, rad a unit of time; two parts but for flags."""

    route: int
    even: bool  # alpha is a series of even multiples of w
    swaps: bool  # alpha and beta change places at every step
    rate: tuple  # of the common phase
    argument_rate: tuple
    argument0: tuple
    step: tuple
    slip: tuple
    nome: tuple  # Q, or its root where alpha and beta change places
    first_step: float
    turns_per_step: float
    swap_ratio: tuple
    alpha_re: tuple
    alpha_im: tuple
    beta_re: tuple
    beta_im: tuple


@routine
def _mean(x):
    """agm(1, x), which is 0 for x = 0."""
    return mean_with_one(x) if x[0] > 0.0 else ZERO


@routine
def _quotient(a, b):
    return div(a, b) if a[0] > 0.0 else ZERO


@routine
def coefficients(path):
    """The shorter of the two series of the path's motion."""
    greater = path.M if path.mu >= 0.0 else path.N
    lesser = path.N if path.mu >= 0.0 else path.M
    complement = _mean(_quotient(path.nu, greater))
    mean = _mean(_quotient(lesser, greater))
    p, ratio = ZERO, ZERO
    if path.mu != 0.0 and complement[0] != 0.0:  # else the mean of nu underflows
        ratio = mul(PI, div(mean, complement))  # -log |p|
        p = exp(neg(ratio))
    if p[0] > LARGEST_NOME:
        return transformed(path, mul(greater, complement), ratio)
    if path.family == Family.CIRCLING:
        return circling_series(path, p, mul(greater, mean), ratio)
    return swinging_series(path, p, mul(greater, mean))


@routine
def powers(x):
    """1, x, ... x^4."""
    x2 = square(x)
    return ONE, x, x2, mul(x2, x), square(x2)


@routine
def _sums(E):
    """The sums of E^j, j from 0 to 2n, for n to 4: sinh (2n+1)h / sinh h times E^n."""
    s1 = add(ONE, add(E, square(E)))
    E3 = mul(square(E), E)
    s2 = add(s1, add(E3, mul(E3, E)))
    E5 = mul(E3, square(E))
    s3 = add(s2, add(E5, mul(E5, E)))
    E7 = mul(E5, square(E))
    return ONE, s1, s2, s3, add(s3, add(E7, mul(E7, E)))


@routine
def circling_series(path, p, mean, ratio):
    """alpha from theta4 and beta from theta1 of v - i s h, nome p."""
    s, ep = path.s, -1.0 if path.mu < 0.0 else 1.0
    v_rate, h = mul(path.rate, mean), mul(path.pole, mean)
    v0 = scale(mul(path.start, mean), path.sign)
    E = exp(scale(h, -2.0))
    beyond = mul(path.other_pole, mean)
    if ep < 0.0 and beyond[0] < h[0]:
        E2, E = exp(scale(beyond, -2.0)), exp(sub(scale(beyond, 2.0), ratio))
    elif path.mu != 0.0:
        E2 = exp(sub(scale(h, 2.0), ratio))
    else:
        E2 = ZERO
    other = neg(expm1(sub(scale(h, 2.0), ratio))) if path.mu > 0.0 else add(ONE, E2)
    one_less_E = neg(expm1(scale(h, -2.0)))
    drift = circling_drift(p, E, E2, ep, other)
    rate = add(path.mean_rate, scale(mul(v_rate, drift), 2.0 * s))

    P, F, G = powers(p), powers(E2), powers(E)
    P4, P6, P9 = P[4], mul(P[3], P[3]), mul(square(P[4]), p)
    P12 = square(P6)
    near = F[1], mul(P[2], F[2]), mul(P6, F[3])  # p^(n^2-n) E2^n
    far = mul(p, G[1]), mul(P4, G[2]), mul(P9, G[3])  # p^(n^2) E^n
    a = ONE, scale(add(near[0], far[0]), -ep), add(near[1], far[1]), scale(add(near[2], far[2]), -ep)
    b = ZERO, scale(sub(near[0], far[0]), -ep), sub(near[1], far[1]), scale(sub(near[2], far[2]), -ep)
    lead = ONE, mul(p, F[1]), mul(P4, F[2]), mul(P9, F[3])  # p^(j^2) E2^j
    last = E, mul(P[2], G[2]), mul(P6, G[3]), mul(P12, G[4])
    c = add(lead[0], last[0]), neg(add(lead[1], last[1])), add(lead[2], last[2]), neg(add(lead[3], last[3]))
    sums = _sums(E)
    d = (
        one_less_E,
        neg(mul(one_less_E, mul(lead[1], sums[1]))),
        mul(one_less_E, mul(lead[2], sums[2])),
        neg(mul(one_less_E, mul(lead[3], sums[3]))),
    )
    factor_a = div(path.rho, add(add(a[0], a[1]), add(a[2], a[3])))
    factor_b = _quotient(path.tau, add(add(d[0], d[1]), add(d[2], d[3])))
    alpha_re = _times(factor_a, even_cosines(a))
    alpha_im = _times(scale(factor_a, s), even_sines(b))
    beta_re = _times(scale(factor_b, s), sines_over_first((c[0], c[1], c[2], c[3], ZERO)))
    beta_im = _times(neg(factor_b), cosines_over_first((d[0], d[1], d[2], d[3], ZERO)))
    return Coefficients(
        GyrostatRoute.CIRCLING, False, False, rate, v_rate, v0, ZERO, ZERO, p, 0.0, 0.0, ONE,
        alpha_re, alpha_im, beta_re, beta_im,
    )  # fmt: skip


@routine
def circling_drift(p, E, E2, ep, other):
    """sum_n [(ep E2)^n - (ep p E)^n] / (1 - p^2n); `other` is 1 - ep E2."""
    e2, pE = scale(E2, ep), scale(mul(p, E), ep)
    total = sub(div(e2, other), div(pE, sub(ONE, pE)))
    near, far, p2 = ONE, ONE, square(p)
    power = ONE
    for _ in range(40):
        near, far, power = mul(near, e2), mul(far, pE), mul(power, p2)
        if power[0] <= 1e-34:
            break
        total = add(total, mul(sub(near, far), div(power, sub(ONE, power))))
    return total


@routine
def swinging_series(path, p, mean):
    """alpha from theta2 and beta from theta1 of v - i s h, nome sqrt(p)."""
    s, ep = path.s, -1.0 if path.mu < 0.0 else 1.0
    v_rate, h = mul(path.rate, mean), mul(path.pole, mean)
    v0 = mul(path.start, mean)
    if path.beyond:
        v0 = sub(scale(PI, 0.5), v0)
    E = exp(scale(h, -2.0))
    root = sqrt(p)
    E2 = _quotient(root, E)
    one_less_E = neg(expm1(scale(h, -2.0)))
    drift = sub(div(one_less_E, add(ONE, E)), scale(swinging_drift(p, mul(root, E2), mul(p, E), ep), 2.0))
    rate = sub(path.mean_rate, scale(mul(v_rate, drift), s))
    # |p|^(n^2/2) E2^n and the sign of p^(n(n+1)/2)
    R, F, P = powers(root), powers(E2), powers(p)
    lead = ONE, mul(R[1], F[1]), mul(P[2], F[2]), mul(mul(P[4], R[1]), F[3]), mul(square(P[4]), F[4])
    lead = ONE, scale(lead[1], ep), scale(lead[2], ep), lead[3], lead[4]
    sums, G = _sums(E), powers(E)
    C = (
        mul(lead[0], add(ONE, E)),
        mul(lead[1], add(ONE, G[3])),
        mul(lead[2], add(ONE, mul(G[4], E))),
        mul(lead[3], add(ONE, mul(G[4], G[3]))),
        mul(lead[4], add(ONE, mul(square(G[4]), E))),
    )
    D = _times(one_less_E, _products(lead, sums))
    factor_a = div(path.rho, _sum(C))
    alternating = _alternating(D)
    factor_b = _quotient(path.tau, _sum(alternating))
    return Coefficients(
        GyrostatRoute.SWINGING, False, False, rate, v_rate, scale(v0, path.sign), ZERO, ZERO, p,
        0.0, 0.0, ONE,
        _times(factor_a, cosines_over_first(C)),
        _times(scale(factor_a, s), sines_over_first(D)),
        _times(scale(factor_b, s), sines_over_first(_alternating(C))),
        _times(neg(factor_b), cosines_over_first(alternating)),
    )  # fmt: skip


@routine
def swinging_drift(p, near_step, far_step, ep):
    """sum_n (-1)^n ep^n (near^n - far^n) / (1 - p^n): 2 sinh(2nh) p^n is their difference."""
    total, near, far, signed, sign = ZERO, ONE, ONE, ONE, 1.0
    for _ in range(60):
        near, far, sign = mul(near, near_step), mul(far, far_step), -sign * ep
        signed = scale(mul(signed, p), ep)
        total = add(total, scale(div(sub(near, far), sub(ONE, signed)), sign))
        if near[0] <= 1e-34:
            break
    return total


@routine
def _times(factor, x):
    return mul(factor, x[0]), mul(factor, x[1]), mul(factor, x[2]), mul(factor, x[3]), mul(factor, x[4])


@routine
def _products(x, y):
    return mul(x[0], y[0]), mul(x[1], y[1]), mul(x[2], y[2]), mul(x[3], y[3]), mul(x[4], y[4])


@routine
def _sum(x):
    return add(add(add(x[0], x[1]), add(x[2], x[3])), x[4])


@routine
def _alternating(x):
    return x[0], neg(x[1]), x[2], neg(x[3]), x[4]


@routine
def cosines_over_first(x):
    """Coefficients of sum x_n cos (2n+1)v / cos v as powers of w = cos 2v."""
    p0 = add(sub(sub(x[0], x[1]), sub(x[2], x[3])), x[4])
    p1 = add(sub(scale(x[1], 2.0), scale(x[2], 2.0)), sub(scale(x[4], 4.0), scale(x[3], 4.0)))
    p2 = sub(sub(scale(x[2], 4.0), scale(x[3], 4.0)), mul(x[4], (12.0, 0.0)))
    return p0, p1, p2, sub(scale(x[3], 8.0), scale(x[4], 8.0)), scale(x[4], 16.0)


@routine
def sines_over_first(x):
    """Coefficients of sum x_n sin (2n+1)v / sin v as powers of w = cos 2v."""
    return _alternating(cosines_over_first(_alternating(x)))


@routine
def even_cosines(x):
    """Coefficients of sum x_n cos 2nv, n to 3, as powers of w = cos 2v."""
    p1 = sub(x[1], mul(x[3], (3.0, 0.0)))
    return sub(x[0], x[2]), p1, scale(x[2], 2.0), scale(x[3], 4.0), ZERO


@routine
def even_sines(x):
    """Coefficients of sum x_n sin 2nv / sin 2v, n to 3, as powers of w = cos 2v."""
    return sub(x[1], x[3]), scale(x[2], 2.0), scale(x[3], 4.0), ZERO, ZERO


@routine
def transformed(path, f, ratio):
    """Beside and on the separatrices: nome Q = exp(-H), argument w = s x + i y."""
    s, negative = path.s, path.mu < 0.0
    swinging = path.family != Family.CIRCLING
    swaps, even = swinging and negative, swinging != negative
    if swinging and not negative:
        f = scale(f, 2.0)
    y_rate, x, y0 = mul(path.rate, f), mul(path.pole, f), mul(path.start, f)
    infinite = ratio[0] == 0.0
    H, Q = (math.inf, 0.0), ZERO
    if not infinite:
        # pi / R, R being ratio / pi; twice that where alpha and beta have one sign at every step
        H = div(square(PI), ratio)
        if swinging and not negative:
            H = scale(H, 2.0)
        Q = exp(neg(H))
    first_step = 0.0
    if path.beyond:
        if swaps:
            y0, first_step = neg(y0), path.sign
        else:
            y0 = sub(scale(H, 0.5), y0)
    slip, step = ZERO, H
    if not infinite:
        slip = scale(div(x, H), (4.0 if swaps else 2.0) * s)
    if swaps:
        step = scale(H, 0.5)
    drift = transformed_drift(x, Q, swaps, even, negative)
    rate = sub(add(path.mean_rate, scale(mul(y_rate, drift), s)), mul(slip, y_rate))
    cosines, sines = multiples(x)
    root = exp(neg(step)) if not infinite else ZERO  # what z and far are made of
    if swaps:
        R = powers(root)
        R9, R16 = mul(square(R[4]), root), square(square(R[4]))
        # Q^(j(j+1)/2) e^(2j|y|) = +- root^(j^2) z^j; the signs are those of (-1)^(j(j+1)/2)
        weights = ONE, neg(root), neg(R[4]), R9, R16
        odd_weights = weights
    else:
        R = powers(Q)
        odd_weights = ONE, Q, R[4], mul(square(R[4]), Q), ZERO
        sign = 1.0 if negative else -1.0
        weights = odd_weights
        if even:
            R6 = square(R[3])
            weights = (0.5, 0.0), scale(ONE, sign), R[2], scale(R6, sign), square(R6)
    odd_cosines, odd_sines = cosines[1::2], sines[1::2]
    alpha_re = _products(weights, cosines[::2] if even else odd_cosines)
    alpha_im = _products(weights, sines[::2] if even else odd_sines)
    odd_weights = _alternating(odd_weights)
    beta_re, beta_im = _products(odd_weights, odd_cosines), _products(odd_weights, odd_sines)
    # both over what they are at y = 0
    factor_a, factor_b = div(path.rho, polynomial(alpha_re, root)), div(path.tau, polynomial(beta_im, root))
    return Coefficients(
        GyrostatRoute.TRANSFORMED, even, swaps, rate, y_rate, scale(y0, path.sign), step, slip, root,
        first_step, 0.25 if swaps else (0.5 if swinging else 0.0), div(factor_b, factor_a),
        _times(factor_a, alpha_re),
        _times(scale(factor_a, -s), alpha_im),
        _times(scale(factor_b, s), beta_re),
        _times(neg(factor_b), beta_im),
    )  # fmt: skip


@routine
def polynomial(p, w):
    """p0 + p1 w + ... + p4 w^4, in two parts."""
    return add(p[0], mul(w, add(p[1], mul(w, add(p[2], mul(w, add(p[3], mul(w, p[4]))))))))


@routine
def multiples(x):
    """cos jx and sin jx for j = 0 ... 9."""
    sine, cosine = sin_cos(x)
    twice = scale(cosine, 2.0)
    c2, s2 = sub(mul(twice, cosine), ONE), mul(twice, sine)
    c3, s3 = sub(mul(twice, c2), cosine), sub(mul(twice, s2), sine)
    c4, s4 = sub(mul(twice, c3), c2), sub(mul(twice, s3), s2)
    c5, s5 = sub(mul(twice, c4), c3), sub(mul(twice, s4), s3)
    c6, s6 = sub(mul(twice, c5), c4), sub(mul(twice, s5), s4)
    c7, s7 = sub(mul(twice, c6), c5), sub(mul(twice, s6), s5)
    c8, s8 = sub(mul(twice, c7), c6), sub(mul(twice, s7), s6)
    c9, s9 = sub(mul(twice, c8), c7), sub(mul(twice, s8), s7)
    return (ONE, cosine, c2, c3, c4, c5, c6, c7, c8, c9), (ZERO, sine, s2, s3, s4, s5, s6, s7, s8, s9)


@routine
def transformed_drift(x, Q, swaps, even, negative):
    """What the theta function of alpha adds to the phase rate within a step, over s y'."""
    sine, cosine = sin_cos(x)
    total = ZERO if even else div(sine, cosine)
    twice_cos2x = scale(sub(ONE, scale(square(sine), 2.0)), 2.0)
    before, now = ZERO, scale(mul(sine, cosine), 2.0)  # sin 0, sin 2x; then sin 2nx by recurrence
    step = Q if swaps or even else square(Q)
    below_step = scale(Q, -1.0) if swaps else square(Q)
    sign_step = 1.0 if swaps or (even and not negative) else -1.0
    power, below, sign = step, below_step, -4.0 * sign_step
    for _ in range(40):
        if power[0] <= 1e-34:
            break
        total = add(total, scale(mul(div(power, sub(ONE, below)), now), sign))
        power, below, sign = mul(power, step), mul(below, below_step), sign * sign_step
        before, now = now, sub(mul(twice_cos2x, now), before)
    return total

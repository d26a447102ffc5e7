"""Normal deviates of random words, one each, by the inverse of the normal distribution.

A deviate takes one word, so that a body's deviates never depend on those of others.  All operations are ones
that IEEE 754 defines to the last bit, so that deviates are the same on every machine.
"""

import math

from numpy import uint64

from ..doubledouble import LN2
from ..intrinsics import bits_of, double_of, fma, inlined, routine

HALF = uint64(2**52)
LAST = uint64(2**53 - 1)
CENTRAL = 0.425

# Numerators and denominators, highest power first: M. Wichura, "Algorithm AS 241: the percentage points of
# the normal distribution", Applied Statistics 37 (1988) 477, PPND16.
CENTRE = (
    (
        2509.0809287301226727,
        33430.575583588128105,
        67265.770927008700853,
        45921.953931549871457,
        13731.693765509461125,
        1971.5909503065514427,
        133.14166789178437745,
        3.387132872796366608,
    ),
    (
        5226.495278852854561,
        28729.085735721942674,
        39307.89580009271061,
        21213.794301586595867,
        5394.1960214247511077,
        687.1870074920579083,
        42.313330701600911252,
        1.0,
    ),
)
NEAR = (
    (
        7.7454501427834140764e-4,
        0.0227238449892691845833,
        0.24178072517745061177,
        1.27045825245236838258,
        3.64784832476320460504,
        5.7694972214606914055,
        4.6303378461565452959,
        1.42343711074968357734,
    ),
    (
        1.05075007164441684324e-9,
        5.475938084995344946e-4,
        0.0151986665636164571966,
        0.14810397642748007459,
        0.68976733498510000455,
        1.6763848301838038494,
        2.05319162663775882187,
        1.0,
    ),
)
FAR = (
    (
        2.01033439929228813265e-7,
        2.71155556874348757815e-5,
        0.0012426609473880784386,
        0.026532189526576123093,
        0.29656057182850489123,
        1.7848265399172913358,
        5.4637849111641143699,
        6.6579046435011037772,
    ),
    (
        2.04426310338993978564e-15,
        1.4215117583164458887e-7,
        1.8463183175100546818e-5,
        7.868691311456132591e-4,
        0.0148753612908506148525,
        0.13692988092273580531,
        0.59983220655588793769,
        1.0,
    ),
)


@inlined
def rational(coefficients, x):
    """The quotient of two polynomials of degree seven."""
    above, below = coefficients[0][0], coefficients[1][0]
    for k in range(1, 8):
        above, below = fma(above, x, coefficients[0][k]), fma(below, x, coefficients[1][k])
    return above / below


@routine
def minus_log(x):
    """-log x of a normal x < 1/2, within two ulps: 2 artanh((m - 1)/(m + 1)) of the fraction m."""
    bits = bits_of(x)
    power = float((bits >> 52) - 1023)
    m = double_of((bits & 0x000FFFFFFFFFFFFF) | 0x3FF0000000000000)
    if m > 1.4142135623730951:
        m *= 0.5
        power += 1.0
    s = (m - 1.0) / (m + 1.0)
    s2 = s * s
    p = 1.0 / 23.0
    for k in range(21, 0, -2):
        p = fma(p, s2, 1.0 / k)
    return -fma(power, LN2[0], 2.0 * s * p)


@routine
def normal(word):
    """Return the normal deviate of a word: the quantile at (k + 1/2) / 2^53, k its upper 53 bits.

    Within 1e-15 of its size; at most 8.3 away from zero.
    """
    k = word >> uint64(11)
    below = k < HALF
    r = (float(k if below else LAST - k) + 0.5) * 2.0**-53  # the probability of the nearer tail, exactly
    q = 0.5 - r
    if q <= CENTRAL:
        x = q * rational(CENTRE, fma(-q, q, CENTRAL * CENTRAL))
    else:
        root = math.sqrt(minus_log(r))
        x = rational(NEAR, root - 1.6) if root <= 5.0 else rational(FAR, root - 5.0)
    return -x if below else x

"""Elliptic integrals in two parts, from moduli and roots rather than parameters.

Convention: parameter m = k^2, complement m1 = k1^2 = 1 - m.  Everything here takes k and k1
(each to its own digits, neither formed from the other): near the separatrix k1, and near a
principal axis k, may be 1e-300, where their squares underflow.
Source: DLMF 19.8(i) (AGM), 19.25.5 and 19.36(i) (R_F).
"""

import math

from .doubledouble import ONE, PI, ZERO, mul, scale, sqrt, square
from .doubledouble import quick_add as add
from .doubledouble import quick_div as div
from .doubledouble import quick_sub as sub
from .intrinsics import routine


@routine
def quarter_period(complementary_modulus):
    """K = pi/2 / agm(1, k1); infinite (hi part) for k1 = 0."""
    if complementary_modulus[0] == 0.0:
        return math.inf, 0.0
    return div(scale(PI, 0.5), mean_with_one(complementary_modulus))


@routine
def mean_with_one(x):
    """agm(1, x), the arithmetic-geometric mean, for x > 0."""
    a, g = ONE, x
    while abs(a[0] - g[0]) > 1e-8 * a[0]:
        a, g = scale(add(a, g), 0.5), sqrt(mul(a, g))
    # one more mean, whose error (a-g)^2/16a falls below the two parts after it
    a, g = scale(add(a, g), 0.5), sqrt(mul(a, g))
    return scale(add(a, g), 0.5)


@routine
def carlson_rf(root_x, root_y, root_z):
    """R_F(x, y, z) from the square roots of its arguments; at most one of them zero."""
    x, y, z = root_x, root_y, root_z
    pairs = add(add(mul(x, y), mul(x, z)), mul(y, z))
    x, y, z = square(x), square(y), square(z)
    for _ in range(64):  # a handful, and log2 of the arguments' exponents more where they are tiny
        x, y, z = scale(add(x, pairs), 0.25), scale(add(y, pairs), 0.25), scale(add(z, pairs), 0.25)
        middle = (x[0] + y[0] + z[0]) / 3.0
        if max(abs(middle - x[0]), abs(middle - y[0]), abs(middle - z[0])) <= 5e-5 * middle:
            break
        a, b, c = sqrt(x), sqrt(y), sqrt(z)
        pairs = add(add(mul(a, b), mul(a, c)), mul(b, c))
    mean = div(add(add(x, y), z), (3.0, 0.0))
    return div(carlson_series(x, y, mean), sqrt(mean))


@routine
def carlson_series(x, y, mean):
    """The symmetric series about the mean, through degree 7 (DLMF 19.36.1); the next term is 3e-32."""
    inverse = div(ONE, mean)
    X = sub(ONE, mul(x, inverse))
    Y = sub(ONE, mul(y, inverse))
    Z = sub(sub(ZERO, X), Y)
    XY = mul(X, Y)
    E2 = sub(XY, square(Z))
    E3 = mul(XY, Z)
    # terms past the third are below 1e-17 of the sum: plain doubles carry them
    e2, e3 = E2[0], E3[0]
    high = e2 * (e2 / 24.0 - 3.0 * e3 / 44.0 - 5.0 * e2 * e2 / 208.0 + e2 * e3 / 16.0) + 3.0 * e3 * e3 / 104.0
    low = sub(div(E3, (14.0, 0.0)), div(E2, (10.0, 0.0)))
    return add(ONE, add(low, (high, 0.0)))

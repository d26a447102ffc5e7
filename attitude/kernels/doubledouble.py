"""Two-part arithmetic: a number is a pair (hi, lo) with hi = fl(hi + lo), about 32 digits.

Used once per body, for the constants and the phase rates: a phase is a rate times a time, so
that a rate needs as many digits beyond those of the phase as the time has.

Error bounds (in units of 2**-106, relative): add 3, mul 5, div 10, sqrt 25/8.
Source: Joldes, Muller, Popescu, "Tight and rigorous error bounds for basic building blocks
of double-word arithmetic", ACM TOMS 44 (2017), algorithms 6, 12 and 17 (the quick ones 5 and 17 with one
division less); for the square root Lefevre, Louvet, Muller, Picot, Rideau, "Accurate calculation of
Euclidean norms using double-word arithmetic", ACM TOMS 49 (2023).
"""

import math
from fractions import Fraction

import numpy as np

from .intrinsics import bits_of, double_of, fma, inlined, routine

ZERO = (0.0, 0.0)
ONE = (1.0, 0.0)
PI = (3.141592653589793, 1.2246467991473532e-16)
LN2 = (0.6931471805599453, 2.3190468138462996e-17)
TURN = (6.283185307179586, 2.4492935982947064e-16)  # radians
PER_TURN = (0.15915494309189535, -9.839338337591243e-18)  # turns per radian


def two_part(exact):
    """The two doubles nearest to a fraction."""
    return float(exact), float(exact - Fraction(float(exact)))


INVERSE_FACTORIAL = np.array([two_part(Fraction(1, math.factorial(n))) for n in range(24)])


@inlined
def two_sum(a, b):
    """a + b = hi + lo exactly."""
    hi = a + b
    t = hi - a
    return hi, (a - (hi - t)) + (b - t)


@inlined
def fast_two_sum(a, b):
    """a + b = hi + lo exactly, for abs(a) >= abs(b) or a = 0."""
    hi = a + b
    return hi, b - (hi - a)


@inlined
def two_product(a, b):
    """a * b = hi + lo exactly (short of underflow)."""
    hi = a * b
    return hi, fma(a, b, -hi)


@inlined
def pair(array):
    """The two numbers of an array."""
    return array[0], array[1]


@routine
def store(array, a):
    """Write a pair to an array of two numbers."""
    array[0] = a[0]
    array[1] = a[1]


@inlined
def neg(a):
    """-a."""
    return -a[0], -a[1]


@inlined
def less(a, b):
    """a < b."""
    return (a[0] < b[0]) | ((a[0] == b[0]) & (a[1] < b[1]))


@inlined
def equal(a, b):
    """a = b."""
    return (a[0] == b[0]) & (a[1] == b[1])


@inlined
def absolute(a):
    """The magnitude of a."""
    return a if a[0] >= 0.0 else neg(a)


@inlined
def scale(a, power_of_two):
    """Exact: the factor is a power of two."""
    return a[0] * power_of_two, a[1] * power_of_two


@inlined
def add(a, b):
    """a + b."""
    s, e = two_sum(a[0], b[0])
    t, f = two_sum(a[1], b[1])
    s, e = fast_two_sum(s, e + t)
    return fast_two_sum(s, e + f)


@inlined
def sub(a, b):
    """a - b."""
    return add(a, (-b[0], -b[1]))


@inlined
def mul(a, b):
    """a * b."""
    p, e = two_product(a[0], b[0])
    e = fma(a[1], b[0], fma(a[0], b[1], fma(a[1], b[1], e)))
    return fast_two_sum(p, e)


@inlined
def square(a):
    """a * a."""
    return mul(a, a)


@inlined
def div(a, b):
    """a / b."""
    q1 = a[0] / b[0]
    r = sub(a, mul(b, (q1, 0.0)))
    q2 = r[0] / b[0]
    r = sub(r, mul(b, (q2, 0.0)))
    q, e = fast_two_sum(q1, q2)
    return fast_two_sum(q, e + r[0] / b[0])


@inlined
def quick_add(a, b):
    """a + b, off by 3 units of the greater of a and b where signs differ: for numbers rounded themselves."""
    s, e = two_sum(a[0], b[0])
    return fast_two_sum(s, e + (a[1] + b[1]))


@inlined
def quick_sub(a, b):
    """a - b, as `quick_add`."""
    return quick_add(a, (-b[0], -b[1]))


@inlined
def quick_div(a, b):
    """a / b, off by 15 units at most."""
    q = a[0] / b[0]
    p, e = two_product(b[0], q)
    p, e = fast_two_sum(p, fma(b[1], q, e))
    return fast_two_sum(q, ((a[0] - p) + (a[1] - e)) / b[0])


@inlined
def sqrt(a):
    """Square root; zero gives zero."""
    if a[0] <= 0.0:
        return 0.0, 0.0
    s = math.sqrt(a[0])
    return fast_two_sum(s, (fma(-s, s, a[0]) + a[1]) / (2.0 * s))


@routine
def power_of_two_near(x):
    """The power of two in (abs(x)/2, abs(x)], and 1 for zero: multiplying by it is exact."""
    if x == 0.0:
        return 1.0
    power = double_of(bits_of(x) & 0x7FF0000000000000)  # its exponent alone; zero for a subnormal
    return max(2.0**-1021, min(2.0**1020, power))


@routine
def hypot(a, b):
    """sqrt(a^2 + b^2) with no square leaving the range of a double."""
    unit = power_of_two_near(max(abs(a[0]), abs(b[0])))
    inverse = 1.0 / unit
    x, y = scale(a, inverse), scale(b, inverse)
    return scale(sqrt(add(square(x), square(y))), unit)


@routine
def _small_expm1(a):
    """e^a - 1 for abs(a) <= 0.35."""
    r = scale(a, 1.0 / 256.0)
    s = mul(r, pair(INVERSE_FACTORIAL[10]))
    for n in range(9, 0, -1):
        s = mul(r, add(s, pair(INVERSE_FACTORIAL[n])))
    for _ in range(8):  # expm1(2r) = 2 expm1(r) + expm1(r)^2
        s = add(scale(s, 2.0), square(s))
    return s


@routine
def expm1(a):
    """e^a - 1, with the digits of a small one."""
    return _small_expm1(a) if abs(a[0]) < 0.35 else sub(exp(a), ONE)


@routine
def exp(a):
    """e^a; zero where that is below the range of a double."""
    if a[0] < -745.0:
        return 0.0, 0.0
    k = np.rint(a[0] / LN2[0])
    s = add(_small_expm1(sub(a, mul(LN2, (k, 0.0)))), ONE)
    half = int(k) >> 1  # in two steps, since e^-745 = 2^-1075 is no power that a normal double holds
    first, second = double_of((half + 1023) << 52), double_of((int(k) - half + 1023) << 52)
    return s[0] * first * second, s[1] * first * second


@routine
def sin_cos(a):
    """Sine and cosine for abs(a) <= 2 rad."""
    r = scale(a, 1.0 / 16.0)
    r2 = square(r)
    s, c1 = ZERO, ZERO  # c1 = 1 - cos: keeps its digits through the doublings
    for n in range(9, -1, -1):
        s = sub(pair(INVERSE_FACTORIAL[2 * n + 1]), mul(r2, s))
        c1 = sub(pair(INVERSE_FACTORIAL[2 * n + 2]), mul(r2, c1))
    s, c1 = mul(r, s), mul(r2, c1)
    for _ in range(4):  # sin 2r = 2 sin r cos r,  1 - cos 2r = 2 sin^2 r
        s, c1 = scale(mul(s, sub(ONE, c1)), 2.0), scale(square(s), 2.0)
    return s, sub(ONE, c1)

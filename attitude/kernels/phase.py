"""Phases as a rate times a time in two parts, and their sine and cosine.

Straight-line arithmetic without calls or branches, so that LLVM turns each loop into vector
instructions.  A fused multiply-add is written where one is wanted, and nowhere left to the compiler:
the two-part products depend on it.
"""

from .doubledouble import TURN, two_sum
from .intrinsics import bits_of, double_of, fma, inlined

# Adding and subtracting this rounds to the nearest whole number, and leaves it in the low bits.
ROUND = 1.5 * 2.0**52


@inlined
def phase(rate, t, t_low):
    """rate * time in two parts, the first product exact."""
    hi = rate[0] * t
    lo = fma(rate[1], t, fma(rate[0], t, -hi))
    if t_low is None:
        return hi, lo
    return hi, fma(rate[0], t_low, lo)


@inlined
def argument(rate, t, t_low, start):
    """start + rate * time in two parts."""
    x, rest = phase(rate, t, t_low)
    x, joined = two_sum(x, start[0])
    return x, rest + (joined + start[1])


@inlined
def sine_cosine(turns, rest):
    """Sine and cosine of 2 pi (turns + rest), rest small; whole quarter turns are removed exactly.

    Polynomials: Chebyshev interpolation of sin(2 pi r) and cos(2 pi r) on abs(r) <= 1/8 + 1/512
    (error at most 2e-17), leading coefficients in two parts.
    """
    shifted = fma(turns, 4.0, ROUND)
    quarter = bits_of(shifted)
    r = (turns - 0.25 * (shifted - ROUND)) + rest
    r2 = r * r
    p = fma(r2, 3.7853823143371303, -15.094016647383457)
    p = fma(r2, p, 42.05868871747735)
    p = fma(r2, p, -76.70585973332197)
    p = fma(r2, p, 81.60524927604779)
    p = fma(r2, p, -41.341702240399755)
    sine = fma(r, TURN[0], r * fma(r2, p, TURN[1]))
    p = fma(r2, -1.7008083860210004, 7.903290410841581)
    p = fma(r2, p, -26.426254729094907)
    p = fma(r2, p, 60.24464136411913)
    p = fma(r2, p, -85.45681720668301)
    p = fma(r2, p, 64.9393940226683)
    cosine = 1.0 + fma(r2, -19.739208802178716, r2 * fma(r2, p, -1.2530591017479423e-15))
    swap = (quarter & 1) != 0
    s = cosine if swap else sine
    c = sine if swap else cosine
    s = double_of(bits_of(s) ^ ((quarter & 2) << 62))
    c = double_of(bits_of(c) ^ (((quarter + 1) & 2) << 62))
    return s, c

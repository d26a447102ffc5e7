"""States of bodies drawn about a nominal state, each from random words of its own."""

from enum import IntEnum

from numpy import uint64

from ..intrinsics import kernel, routine
from ..layout import MAX_DRAWS, WORDS_PER_BODY
from ..rotation import about, product
from .normal import normal
from .philox import four_words

COUNTERS = uint64(WORDS_PER_BODY // 4)  # of a body


class Counter(IntEnum):
    """Which of a body's counters a quantity is drawn from."""

    MOMENTS, RATE, ATTITUDE = range(3)


@routine
def three_deviates(body, attempt, quantity, key_0, key_1):
    """Draw normal deviates of the first three words of a quantity's counter, of this attempt.

    As in numpy's generator, the counter is incremented before it is encrypted.
    """
    counter = uint64(body) * COUNTERS + uint64(quantity) + uint64(1)
    words = four_words((counter, uint64(0), uint64(0), uint64(attempt)), key_0, key_1)
    return normal(words[0]), normal(words[1]), normal(words[2])


@routine
def is_physical(m):
    """Whether moments are positive, none greater than the sum of the others; quarters cannot overflow."""
    a, b, c = 0.25 * m[0], 0.25 * m[1], 0.25 * m[2]
    return a > 0.0 and b > 0.0 and c > 0.0 and a <= b + c and b <= c + a and c <= a + b


@routine
def draw_moments(nominal, spread, body, key_0, key_1, out):
    """Draw moments until they are physical; returns the number of attempts, zero if all have failed."""
    for attempt in range(MAX_DRAWS):
        n = three_deviates(body, attempt, Counter.MOMENTS, key_0, key_1)
        m = (
            nominal[0] * (1.0 + spread[0] * n[0]),
            nominal[1] * (1.0 + spread[1] * n[1]),
            nominal[2] * (1.0 + spread[2] * n[2]),
        )
        if is_physical(m):
            out[0], out[1], out[2] = m
            return attempt + 1
    return 0


@kernel
def draw(key, first, nominal, spread, moments, rates, attitudes, attempts):
    """Moments, body rates and attitudes of bodies first, first + 1, ...

    Parameters
    ----------
    key : (2,), int64: the bits of the key's two words, lowest first
    nominal : (10,): moments (3), body rate (3), attitude (4)
    spread : (9,): standard deviations, of moments relative, of rates in their unit, of the attitude as a
        rotation vector along the body's axes, rad
    moments, rates, attitudes : (n, 3), (n, 3), (n, 4), written; or (0, ...), where they are not spread
    attempts : (n,), int64, written with the moments: the number of draws, 0 where 1000 were too few
    """
    key_0, key_1 = uint64(key[0]), uint64(key[1])
    q = nominal[6], nominal[7], nominal[8], nominal[9]
    for i in range(moments.shape[0]):
        attempts[i] = draw_moments(nominal[0:3], spread[0:3], first + i, key_0, key_1, moments[i])
    for i in range(rates.shape[0]):
        n = three_deviates(first + i, 0, Counter.RATE, key_0, key_1)
        for j in range(3):
            rates[i, j] = nominal[3 + j] + spread[3 + j] * n[j]
    for i in range(attitudes.shape[0]):
        n = three_deviates(first + i, 0, Counter.ATTITUDE, key_0, key_1)
        turn = about((spread[6] * n[0], spread[7] * n[1], spread[8] * n[2]), 1.0)
        turned = product(q, turn)
        for j in range(4):
            attitudes[i, j] = turned[j]

"""Doubles to the shortest decimal text that reads back to the same bits, and text to doubles.

Text is bytes; a place in it is an index.  Sources: R. Giulietti, "The Schubfach way to render doubles"
(2021); D. Lemire, "Number parsing at a gigabyte per second" (2021, after M. Eisel), and N. Mushtak and
D. Lemire, "Fast number parsing without fallback" (2023); W. Clinger, "How to read floating point numbers
accurately" (1990).  Whoever calls leaves layout.TEXT_MARGIN bytes behind the end of a text: it is read and
written by words of eight.
"""

import numpy as np

from .intrinsics import bits_of, double_of, high_product, inlined, load, routine, store, zeros_ahead
from .powers import EXACT, HIGH, LEAST, LOW

U = np.uint64
BYTE = np.uint8
ZERO, NINE = 48, 57
POINT, PLUS, MINUS, SMALL_E, LARGE_E = 46, 43, 45, 101, 69
FRACTION = U(2**52 - 1)
HIDDEN = U(2**52)
ZEROS = U(0x3030303030303030)
TEN_TO = np.array([10**i for i in range(20)], dtype=np.uint64)
EXACT_TENS = np.array([float(10**i) for i in range(23)])


# -- to text ----------------------------------------------------------------------------------------


@routine
def put_number(text, place, value):
    """Write a finite double, with a decimal point and a digit on either side of it; where it ends.

    Up to 1e16 and from 1e-5 on without an exponent.
    """
    bits = U(bits_of(value))
    if bits >> U(63):
        store(text, place, BYTE(MINUS))
        place += 1
        bits &= U(0x7FFFFFFFFFFFFFFF)
    if bits == U(0):
        store(text, place, U(0x302E30))  # 0.0
        return place + 3
    digits, power = _shortest(bits)
    lacking = np.int64(digits < U(10**16)) + np.int64(digits < U(10**15))  # of 17, nearly always
    digits *= TEN_TO[lacking]
    power -= lacking
    while digits < U(10**16):
        digits *= U(10)
        power -= 1
    return _put_digits(text, place, digits, power + 17)


@inlined
def _shortest(bits):
    """(digits, power): the shortest decimal, and of those the nearest, that rounds to this double > 0.

    Zeros at the end of the digits mean nothing.
    """
    fraction, exponent = bits & FRACTION, np.int64(bits >> U(52))
    c, q = (fraction | HIDDEN, exponent - 1075) if exponent > 0 else (fraction, np.int64(-1074))
    odd = c & U(1)
    # The neighbour below is nearer where the fraction is zero.
    nearer = fraction == U(0) and exponent > 1
    k = (q * 1262611 - (524031 if nearer else 0)) >> 22
    shift = U(q + ((-k * 1741647) >> 19) + 1)
    high, low = HIGH[-k - LEAST], LOW[-k - LEAST]
    if -k > EXACT:
        low += U(1)  # rounded upwards; none of the table is all ones
    four = c << U(2)
    lower = _scaled(high, low, (four - (U(1) if nearer else U(2))) << shift) + odd
    middle = _scaled(high, low, four << shift)
    upper = _scaled(high, low, (four + U(2)) << shift) - odd
    # Candidates: a digit less, below and above, of which one fits at most; else the two about the number,
    # of which the one that fits, or the nearer.  Without branches, of which half would be guessed wrong.
    s = middle >> U(2)
    tens = s // U(10)
    above_tens = U(40) * tens + U(40) <= upper
    is_ten = (s >= U(10)) & ((lower <= U(40) * tens) != above_tens)
    below, above = lower <= (s << U(2)), (s << U(2)) + U(4) <= upper
    half = (s << U(2)) + U(2)
    nearer_above = (middle > half) | ((middle == half) & ((s & U(1)) == U(1)))
    up = above if below != above else nearer_above
    digits = (tens + U(above_tens)) if is_ten else (s + U(up))
    return digits, k + np.int64(is_ten)


@inlined
def _scaled(high, low, x):
    """x times the power of ten, over 2**128; the last bit is one where anything was left off."""
    lowest = high_product(low, x)
    part = high * x
    total = part + lowest
    whole = high_product(high, x) + (U(1) if total < part else U(0))
    return whole | (U(1) if total > U(1) else U(0))


@inlined
def _put_digits(text, place, digits, point):
    """digits (17 of them) as 0.ddd times ten to the `point`; where they end."""
    first, rest = digits // U(10**16), digits % U(10**16)
    one, two = spread(rest // U(10**8)), spread(rest % U(10**8))
    # Significant digits: zeros at the end are the highest bytes.
    count = 17 - (zeros_ahead(two) >> 3) if two != U(0) else 9 - (zeros_ahead(one) >> 3)
    lead, one, two = BYTE(first + U(ZERO)), one | ZEROS, two | ZEROS
    if -5 < point <= 0:
        store(text, place, U(0x3030303030302E30))  # 0.000000
        place += 2 - point
        _put_seventeen(text, place, lead, one, two)
        return place + count
    if 0 < point <= 16:
        _put_seventeen(text, place, lead, one, two)
        after, last = load(text, place + point, U(0)), load(text, place + point + 8, U(0))
        store(text, place + point, BYTE(POINT))
        store(text, place + point + 1, after)
        store(text, place + point + 9, last)
        return place + 1 + max(count, point + 1)
    store(text, place, lead)
    store(text, place + 1, BYTE(POINT))
    store(text, place + 2, one)
    store(text, place + 10, two)
    return _put_exponent(text, place + 1 + max(count, 2), point - 1)


@inlined
def _put_seventeen(text, place, lead, one, two):
    store(text, place, lead)
    store(text, place + 1, one)
    store(text, place + 9, two)


@inlined
def spread(value):
    """The eight digits of a number, a byte each, the first one lowest."""
    fours = (value // U(10000)) | ((value % U(10000)) << U(32))
    hundreds = ((fours * U(10486)) >> U(20)) & U(0x0000007F0000007F)
    twos = hundreds | ((fours - U(100) * hundreds) << U(16))
    tens = ((twos * U(103)) >> U(10)) & U(0x000F000F000F000F)
    return tens | ((twos - U(10) * tens) << U(8))


@routine
def _put_exponent(text, place, power):
    store(text, place, BYTE(SMALL_E))
    store(text, place + 1, BYTE(MINUS if power < 0 else PLUS))
    place += 2
    power = abs(power)
    for unit in (100, 10):
        if power >= unit:
            store(text, place, BYTE(ZERO + power // unit % 10))
            place += 1
    store(text, place, BYTE(ZERO + power % 10))
    return place + 1


# -- and back ---------------------------------------------------------------------------------------


@inlined
def eight_digits(word):
    """Whether eight bytes are all digits."""
    return (
        (word & U(0xF0F0F0F0F0F0F0F0)) | (((word + U(0x0606060606060606)) & U(0xF0F0F0F0F0F0F0F0)) >> U(4))
    ) == U(0x3333333333333333)


@inlined
def value_of_eight(word):
    """Of eight digits."""
    word -= ZEROS
    word = word * U(10) + (word >> U(8))
    even, odd = word & U(0x000000FF000000FF), (word >> U(16)) & U(0x000000FF000000FF)
    return (even * U(0x000F424000000064) + odd * U(0x0000271000000001)) >> U(32)


@inlined
def take_digits(text, place, value):
    """value times ten to the number of digits here, and they; where they end.  Modulo 2**64."""
    word = load(text, place, U(0))
    while eight_digits(word):
        value = value * U(100000000) + value_of_eight(word)
        place += 8
        word = load(text, place, U(0))
    digit = (word & U(0xFF)) - U(ZERO)
    while digit <= U(9):
        value = value * U(10) + digit
        place += 1
        word >>= U(8)
        digit = (word & U(0xFF)) - U(ZERO)
    return value, place


@routine
def take_number(text, place):
    """(value, end) of the decimal number here, nearest to it; end is -1 for what is left to others.

    Those are what is no number, has more than 19 significant digits, or is not a normal double.
    """
    sign = load(text, place, BYTE(0))
    if sign == BYTE(MINUS) or sign == BYTE(PLUS):
        place += 1
    begin = place
    value, place = take_digits(text, place, U(0))
    count, power = place - begin, np.int64(0)
    if load(text, place, BYTE(0)) == BYTE(POINT):
        behind = place + 1
        value, place = take_digits(text, behind, value)
        power = behind - place
        count -= power
    if count == 0 or (count > 19 and count - _zeros_first(text, begin) > 19):
        return 0.0, np.int64(-1)
    if (load(text, place, BYTE(0)) | BYTE(32)) == BYTE(SMALL_E):
        tens, place = _exponent(text, place + 1)
        if place < 0:
            return 0.0, place
        power += tens
    bits = _nearest(value, power)
    if bits == U(0) and value != U(0):
        return 0.0, np.int64(-1)
    if sign == BYTE(MINUS):
        bits |= U(1) << U(63)
    return double_of(np.int64(bits)), place


@routine
def _zeros_first(text, place):
    """How many zeros a number begins with, before its point and behind it."""
    count = 0
    character = load(text, place, BYTE(0))
    while character == BYTE(ZERO) or character == BYTE(POINT):
        if character == BYTE(ZERO):
            count += 1
        place += 1
        character = load(text, place, BYTE(0))
    return count


@routine
def _exponent(text, place):
    """(value, end) of what follows an e; end is -1 for none, or one of more than four digits."""
    sign = load(text, place, BYTE(0))
    if sign == BYTE(MINUS) or sign == BYTE(PLUS):
        place += 1
    value, end = np.int64(0), place
    character = load(text, end, BYTE(0))
    while BYTE(ZERO) <= character <= BYTE(NINE) and end < place + 5:
        value = value * 10 + np.int64(character) - ZERO
        end += 1
        character = load(text, end, BYTE(0))
    if end == place or end == place + 5:
        return np.int64(0), np.int64(-1)
    return (-value if sign == BYTE(MINUS) else value), end


@inlined
def _nearest(value, power):
    """The bits of the double nearest to value * 10**power; 0 too where it is not a normal one."""
    if value == U(0):
        return value
    if value <= (U(1) << U(53)) and -22 <= power <= 22:
        exact = float(value)
        return U(bits_of(exact / EXACT_TENS[-power] if power < 0 else exact * EXACT_TENS[power]))
    if power < LEAST or power > 308:
        return U(0)
    ahead = zeros_ahead(value)
    value <<= U(ahead)
    high, low = HIGH[power - LEAST], LOW[power - LEAST]
    lower, upper = value * high, high_product(value, high)
    if (upper & U(0x1FF)) == U(0x1FF):  # the table's second half may decide
        more = high_product(value, low)
        lower += more
        if lower < more:
            upper += U(1)
        if lower == U(0xFFFFFFFFFFFFFFFF) and not -27 <= power <= EXACT:
            return U(0)
    top = upper >> U(63)
    mantissa = upper >> (top + U(9))
    exponent = ((217706 * power) >> 16) + 63 + np.int64(top) - ahead + 1023
    if exponent <= 0:
        return U(0)
    # Half-way between two doubles, which needs few powers of five: to the even one.
    half = lower <= U(1) and -4 <= power <= 23 and (mantissa & U(3)) == U(1)
    if half and (mantissa << (top + U(9))) == upper:
        mantissa &= ~U(1)
    mantissa = (mantissa + (mantissa & U(1))) >> U(1)
    if mantissa >= (HIDDEN << U(1)):
        mantissa = HIDDEN
        exponent += 1
    if exponent >= 2047:
        return U(0)
    return (mantissa & FRACTION) | (U(exponent) << U(52))

"""Powers of ten to 128 bits: what decimal text and doubles are turned into each other with."""

import numpy as np

LEAST, GREATEST = -342, 324
EXACT = 55  # 5 to this is the greatest power that 128 bits hold


def _leading_bits(power):
    """The first 128 bits of 10**power, rounded down; upwards where the power is negative."""
    if power >= 0:
        five = 5**power
        return five << 128 >> five.bit_length()
    five = 5**-power
    # two to a power, in so far as the quotient has 128 bits
    return (1 << (127 + five.bit_length())) // five + 1


_BITS = [_leading_bits(power) for power in range(LEAST, GREATEST + 1)]
# 10**(LEAST + i) is (HIGH[i] 2**64 + LOW[i]) 2**(binary_exponent - 127), to less than one in LOW.
HIGH = np.array([bits >> 64 for bits in _BITS], dtype=np.uint64)
LOW = np.array([bits & (2**64 - 1) for bits in _BITS], dtype=np.uint64)

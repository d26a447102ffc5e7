"""Counter-based random words: word j of a key is computed without those before it.

Philox 4x64 with ten rounds: a bijection of 256-bit counters, keyed by 128 bits, that passes every known
test for randomness.  Source: J. Salmon, M. Moraes, R. Dror and D. Shaw, "Parallel random numbers: as easy
as 1, 2, 3" (SC11); multipliers and key increments are theirs, and those of numpy's `Philox`.
"""

from numpy import uint64

from ..intrinsics import high_product, inlined, routine

MULTIPLIER_0, MULTIPLIER_1 = uint64(0xD2E7470EE14C6C93), uint64(0xCA5A826395121157)
INCREMENT_0, INCREMENT_1 = uint64(0x9E3779B97F4A7C15), uint64(0xBB67AE8584CAA73B)


@inlined
def philox_round(c, key_0, key_1):
    """One round on the four words of a counter."""
    high_0, low_0 = high_product(MULTIPLIER_0, c[0]), MULTIPLIER_0 * c[0]
    high_1, low_1 = high_product(MULTIPLIER_1, c[2]), MULTIPLIER_1 * c[2]
    return high_1 ^ c[1] ^ key_0, low_1, high_0 ^ c[3] ^ key_1, low_0


@routine
def four_words(counter, key_0, key_1):
    """Four words of 64 bits for a counter of four, lowest first; all of them uint64."""
    c = counter
    for _ in range(10):
        c = philox_round(c, key_0, key_1)
        key_0 += INCREMENT_0
        key_1 += INCREMENT_1
    return c

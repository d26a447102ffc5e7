"""Random numbers of each body, whoever asks for them: a counter-based generator, keyed by the seed.

Body i has three counters of numpy's `Philox(key=seed)`, of four 64-bit words each:

    counter = 3 i + attempt 2^192        moments        (words 0, 1, 2; the last one is not used)
              3 i + 1                    body rate
              3 i + 2                    attitude

as `numpy.random.Philox(key=seed, counter=counter).random_raw(3)` gives them.  Moments that no body has are
drawn again, the next attempt in another range of counters.  A word w becomes the normal deviate at the
probability (floor(w / 2^11) + 1/2) / 2^53.  So a body's numbers depend on seed and index alone, and those of
its rate not on whether its moments are spread too.  attitude/kernels computes all of it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import InputError


def check_seed(seed: Any) -> int:
    whole = isinstance(seed, (int, np.integer)) and not isinstance(seed, bool)
    if not whole or not 0 <= seed < 2**128:
        raise InputError("seed", seed, "a whole number from 0 to 2**128 - 1")
    return int(seed)


def key_words(seed: int) -> tuple[int, int]:
    """The key's two words, lowest first, as the signed integers that kernels take."""
    low, high = np.array([seed & (2**64 - 1), seed >> 64], dtype=np.uint64).view(np.int64)
    return int(low), int(high)

"""Random numbers by body: a counter-based generator, keyed by the seed.

Body i has three counters of numpy's `Philox(key=seed)`, of four 64-bit words each:

    counter = 3 i + attempt 2^192        moments        (words 0, 1, 2; word 3 is not used)
              3 i + 1                    body rate
              3 i + 2                    attitude

as `numpy.random.Philox(key=seed, counter=counter).random_raw(3)` returns them.  Unphysical moments are drawn
again, the next attempt from another range of counters.  A word w becomes the normal deviate at the
probability (floor(w / 2^11) + 1/2) / 2^53.  So a body's numbers depend on seed and index alone, and those of
its rate do not depend on a spread of its moments.  `attitude.kernels.statistics` computes them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import InputError


def check_seed(seed: Any) -> int:
    """Return the seed.  Raises InputError unless it is a whole number from 0 to 2**128 - 1."""
    whole = isinstance(seed, (int, np.integer)) and not isinstance(seed, bool)
    if not whole or not 0 <= seed < 2**128:
        raise InputError("seed", seed, "a whole number from 0 to 2**128 - 1")
    return int(seed)


def key_words(seed: int) -> np.ndarray:
    """(2,), int64: the bits of the key's two words, lowest first."""
    return np.array([seed & (2**64 - 1), seed >> 64], dtype=np.uint64).view(np.int64)

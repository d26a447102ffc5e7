"""Error-free sum of doubles, for times that are kept in two parts."""

from __future__ import annotations

import numpy as np


def two_sum(a: float | np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a + b rounded to doubles, and the rounding error exactly (Knuth's two-sum)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)

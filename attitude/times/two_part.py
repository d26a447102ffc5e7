"""Sums of doubles in two parts: the rounded sum and what the rounding left."""

from __future__ import annotations

from fractions import Fraction
from typing import TypeVar

import numpy as np


def two_part(exact: Fraction) -> tuple[float, float]:
    """The two doubles whose sum is nearest to a fraction."""
    return float(exact), float(exact - Fraction(float(exact)))


Doubles = TypeVar("Doubles", float, np.ndarray)


def two_sum(a: float | Doubles, b: Doubles) -> tuple[Doubles, Doubles]:
    """a + b rounded to doubles, and its rounding error, exact unless the sum overflows.

    a, b : floats, or arrays that broadcast

    Source: D. E. Knuth, The Art of Computer Programming, vol. 2, section 4.2.2, theorem B.
    """
    total = a + b
    b_rounded = total - a
    return total, (a - (total - b_rounded)) + (b - b_rounded)

"""Sums of products without rounding, for exact decisions.

An expansion is a list of doubles whose exact sum is the value; appending a term keeps the
parts from overlapping, so the last part has the sign of the sum and is zero only if the sum is.
Source: Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
predicates", Discrete Comput. Geom. 18 (1997), section 2.
"""

from .doubledouble import fast_two_sum, two_product, two_sum
from .intrinsics import routine


@routine
def grow(parts, count, x):
    """Add x to the expansion parts[:count]; the new count."""
    length = 0
    for i in range(count):
        x, low = two_sum(x, parts[i])
        if low != 0.0:
            parts[length] = low
            length += 1
    parts[length] = x
    return length + 1


@routine
def add_product(parts, count, factors, work):
    """Add the exact product of the two-part numbers in `factors` (n, 2); the new count.

    `work` (2, 4**n) is scratch.  Zero parts are left out, so that plain doubles cost 2**n terms.
    """
    terms = 1
    work[0, 0] = 1.0
    for i in range(factors.shape[0]):
        products = 0
        for j in range(terms):
            for part in range(2):
                if factors[i, part] != 0.0:
                    hi, lo = two_product(work[0, j], factors[i, part])
                    if hi != 0.0:
                        work[1, products] = hi
                        products += 1
                    if lo != 0.0:
                        work[1, products] = lo
                        products += 1
        for j in range(products):
            work[0, j] = work[1, j]
        terms = products
    for j in range(terms):
        count = grow(parts, count, work[0, j])
    return count


@routine
def two_part_value(parts, count):
    """The expansion's value as a pair."""
    hi, lo = 0.0, 0.0
    for i in range(count):  # ascending magnitude
        hi, e = fast_two_sum(parts[i], hi)
        lo += e
    # second sweep: lo holds the sum of the parts below the largest
    return fast_two_sum(hi, lo)

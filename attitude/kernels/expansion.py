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


# -- expansions in rows of a scratch array: row[0] is the number of parts, which follow -------------------


@routine
def clear(row):
    """Set the expansion to zero."""
    row[0] = 0.0


@routine
def append(row, x):
    """Add a double to the expansion in a row, exactly."""
    if x != 0.0:
        row[0] = grow(row[1:], int(row[0]), x)


@routine
def append_pair(row, factor, a):
    """Add factor times a two-part number; the factor is a power of two, or its negative."""
    append(row, factor * a[1])
    append(row, factor * a[0])


@routine
def assign(row, a):
    """Set the expansion to a two-part number."""
    clear(row)
    append_pair(row, 1.0, a)


@routine
def append_row(row, factor, other):
    """Add factor times the expansion in another row, exactly; the factor as in `append_pair`."""
    for i in range(1, int(other[0]) + 1):
        append(row, factor * other[i])
    _compress(row)


@routine
def append_product(row, factor, a, b):
    """Add factor * a * b, exactly, of the expansions in rows a and b; the factor as in `append_pair`."""
    for i in range(1, int(a[0]) + 1):
        for j in range(1, int(b[0]) + 1):
            hi, lo = two_product(factor * a[i], b[j])
            append(row, lo)
            append(row, hi)
    _compress(row)


@routine
def _compress(row):
    """Fewest parts of the same sum, the last the greatest (Shewchuk's section 2.8); none for zero."""
    count = int(row[0])
    if count == 0:
        return
    bottom, top = count, 1
    total = row[count]
    for i in range(count - 1, 0, -1):
        total, low = fast_two_sum(total, row[i])
        if low != 0.0:
            row[bottom] = total
            bottom -= 1
            total = low
    row[bottom] = total
    for i in range(bottom + 1, count + 1):
        total, low = fast_two_sum(row[i], total)
        if low != 0.0:
            row[top] = low
            top += 1
    row[top] = total
    row[0] = top if total != 0.0 else 0.0


@routine
def value(row):
    """The expansion's value as a pair."""
    if row[0] == 0.0:
        return 0.0, 0.0
    return two_part_value(row[1:], int(row[0]))

"""Vectors as tuples of three doubles, and matrices as tuples of three rows."""

import math

from .intrinsics import fma, inlined, routine


@inlined
def pair_at(row, first):
    """Two numbers of a row, from `first` on."""
    return row[first], row[first + 1]


@inlined
def three(row, first=0):
    """Three numbers of a row, from `first` on."""
    return row[first], row[first + 1], row[first + 2]


@inlined
def four(row, first=0):
    """Four numbers of a row, from `first` on."""
    return row[first], row[first + 1], row[first + 2], row[first + 3]


@inlined
def five(row):
    """The first five numbers of a row."""
    return row[0], row[1], row[2], row[3], row[4]


@routine
def rows_of(matrix):
    """A (3, 3) array as three rows."""
    return three(matrix[0]), three(matrix[1]), three(matrix[2])


@inlined
def unit_vector(i):
    """Unit vector along axis i, counted from 0."""
    return 1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0


@inlined
def dot(a, b):
    """Scalar product."""
    return fma(a[0], b[0], fma(a[1], b[1], a[2] * b[2]))


@inlined
def cross(a, b):
    """Vector product."""
    x = fma(a[1], b[2], -a[2] * b[1])
    y = fma(a[2], b[0], -a[0] * b[2])
    z = fma(a[0], b[1], -a[1] * b[0])
    return x, y, z


@routine
def norm(a):
    """Length of a vector."""
    return math.sqrt(dot(a, a))


@inlined
def add_scaled(a, factor, b):
    """a + factor b."""
    return fma(factor, b[0], a[0]), fma(factor, b[1], a[1]), fma(factor, b[2], a[2])


@inlined
def scaled(factor, a):
    """factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


@routine
def across(a):
    """Two unit vectors that make a right-handed frame with this one."""
    least = (1.0, 0.0, 0.0) if abs(a[0]) < 0.8 else (0.0, 1.0, 0.0)
    first = cross(a, least)
    first = scaled(1.0 / norm(first), first)
    return first, cross(a, first)


@routine
def times(rows, a):
    """The matrix of these three rows on a."""
    return dot(rows[0], a), dot(rows[1], a), dot(rows[2], a)


@routine
def rotation(q):
    """Rows of R of a unit quaternion (w, x, y, z): v_inertial = R v_body."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    inverse = 2.0 / (w * w + x * x + y * y + z * z)
    return (
        (1.0 - inverse * (y * y + z * z), inverse * (x * y - w * z), inverse * (x * z + w * y)),
        (inverse * (x * y + w * z), 1.0 - inverse * (x * x + z * z), inverse * (y * z - w * x)),
        (inverse * (x * z - w * y), inverse * (y * z + w * x), 1.0 - inverse * (x * x + y * y)),
    )


@routine
def transposed(rows):
    """The transpose of a matrix of three rows."""
    a, b, c = rows
    return (a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2])

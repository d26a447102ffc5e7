"""The convention of quaternions, and their arithmetic in two parts.

A quaternion is (w, x, y, z), unit, with the Hamilton product; it is the active rotation from
body to inertial:

    v_inertial = q * (0, v_body) * conj(q)

Components are pairs, for the constants; `cayley_klein` has the same order.
"""

from .doubledouble import ONE, mul, neg, scale, sqrt, square, two_product, two_sum
from .doubledouble import quick_add as add
from .doubledouble import quick_div as div
from .doubledouble import quick_sub as sub
from .intrinsics import fma, inlined


@inlined
def of_doubles(q):
    """Four doubles as a quaternion of pairs."""
    return (q[0], 0.0), (q[1], 0.0), (q[2], 0.0), (q[3], 0.0)


@inlined
def product(p, q):
    """Hamilton product p * q."""
    w = sub(sub(mul(p[0], q[0]), mul(p[1], q[1])), add(mul(p[2], q[2]), mul(p[3], q[3])))
    x = add(add(mul(p[0], q[1]), mul(p[1], q[0])), sub(mul(p[2], q[3]), mul(p[3], q[2])))
    y = add(add(mul(p[0], q[2]), mul(p[2], q[0])), sub(mul(p[3], q[1]), mul(p[1], q[3])))
    z = add(add(mul(p[0], q[3]), mul(p[3], q[0])), sub(mul(p[1], q[2]), mul(p[2], q[1])))
    return w, x, y, z


@inlined
def rounded_product(p, q):
    """p * q as four doubles: products of pairs, with one compensated sum for each component."""
    return (
        _dot4(p, (q[0], neg(q[1]), neg(q[2]), neg(q[3]))),
        _dot4(p, (q[1], q[0], q[3], neg(q[2]))),
        _dot4(p, (q[2], neg(q[3]), q[0], q[1])),
        _dot4(p, (q[3], q[2], neg(q[1]), q[0])),
    )


@inlined
def _dot4(p, q):
    a, a_low = _product(p[0], q[0])
    b, b_low = _product(p[1], q[1])
    c, c_low = _product(p[2], q[2])
    d, d_low = _product(p[3], q[3])
    total, e = two_sum(a, b)
    total, f = two_sum(total, c)
    total, g = two_sum(total, d)
    return total + (((e + f) + g) + ((a_low + b_low) + (c_low + d_low)))


@inlined
def _product(a, b):
    high, low = two_product(a[0], b[0])
    return high, fma(a[1], b[0], fma(a[0], b[1], low))


@inlined
def conjugate(q):
    """The inverse of a unit quaternion."""
    return q[0], neg(q[1]), neg(q[2]), neg(q[3])


@inlined
def normalised(q):
    """The unit quaternion along q."""
    norm2 = add(add(square(q[0]), square(q[1])), add(square(q[2]), square(q[3])))
    inverse = div(ONE, sqrt(norm2))
    return mul(q[0], inverse), mul(q[1], inverse), mul(q[2], inverse), mul(q[3], inverse)


@inlined
def from_rotation_matrix(R):
    """The quaternion of a proper rotation matrix R (three rows of pairs), v' = R v.

    The divisor is the largest component, so that no digits are lost.
    Source: Shepperd, J. Guidance and Control 1 (1978) 223.
    """
    trace = R[0][0][0] + R[1][1][0] + R[2][2][0]
    a, b, c = R[0][0][0], R[1][1][0], R[2][2][0]
    skew = sub(R[2][1], R[1][2]), sub(R[0][2], R[2][0]), sub(R[1][0], R[0][1])
    xy, xz, yz = add(R[0][1], R[1][0]), add(R[0][2], R[2][0]), add(R[1][2], R[2][1])
    if trace >= max(a, b, c):
        largest = add(ONE, add(R[0][0], add(R[1][1], R[2][2])))
        q = (largest, skew[0], skew[1], skew[2])
    elif a >= max(b, c):
        largest = add(ONE, sub(R[0][0], add(R[1][1], R[2][2])))
        q = (skew[0], largest, xy, xz)
    elif b >= c:
        largest = add(ONE, sub(R[1][1], add(R[0][0], R[2][2])))
        q = (skew[1], xy, largest, yz)
    else:
        largest = add(ONE, sub(R[2][2], add(R[0][0], R[1][1])))
        q = (skew[2], xz, yz, largest)
    inverse = div(ONE, scale(sqrt(largest), 2.0))
    return mul(q[0], inverse), mul(q[1], inverse), mul(q[2], inverse), mul(q[3], inverse)

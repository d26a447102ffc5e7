"""Quaternions (w, x, y, z) as tuples of plain doubles, for the solvers.

Order and direction are those of `quaternion`: v_inertial = q * (0, v_body) * conj(q).
"""

import math

from .intrinsics import fma, inlined
from .phase import sine_cosine
from .vectors import add_scaled, cross, dot

PER_TURN = 0.15915494309189535


@inlined
def product(p, q):
    """Hamilton product."""
    w = fma(p[0], q[0], -fma(p[1], q[1], fma(p[2], q[2], p[3] * q[3])))
    x = fma(p[0], q[1], fma(p[1], q[0], fma(p[2], q[3], -p[3] * q[2])))
    y = fma(p[0], q[2], fma(p[2], q[0], fma(p[3], q[1], -p[1] * q[3])))
    z = fma(p[0], q[3], fma(p[3], q[0], fma(p[1], q[2], -p[2] * q[1])))
    return w, x, y, z


@inlined
def conjugate(q):
    """The inverse of a unit quaternion."""
    return q[0], -q[1], -q[2], -q[3]


@inlined
def rotated(q, v):
    """R(q) v: body components to inertial."""
    u = q[1], q[2], q[3]
    c = cross(u, v)
    c = c[0] + c[0], c[1] + c[1], c[2] + c[2]
    return add_scaled(add_scaled(v, q[0], c), 1.0, cross(u, c))


@inlined
def rotated_back(q, v):
    """R(q)^T v: inertial components to body."""
    return rotated(conjugate(q), v)


@inlined
def turned_about_third(q, cosine, sine):
    """A quaternion after a rotation about the third axis, by twice the angle of this cosine and sine."""
    w = fma(q[0], cosine, -q[3] * sine)
    x = fma(q[1], cosine, q[2] * sine)
    y = fma(q[2], cosine, -q[1] * sine)
    z = fma(q[3], cosine, q[0] * sine)
    return w, x, y, z


@inlined
def upright(direction):
    """A quaternion that takes the third axis to a unit vector; 1 for a vector of zeros."""
    side = -1.0 if direction[2] < 0.0 else 1.0  # below, half a turn about the first axis comes last
    w = math.sqrt(0.5 + 0.5 * side * direction[2])
    w = 1.0 if direction[0] == 0.0 and direction[1] == 0.0 else w
    x, y = -side * direction[1] * (0.5 / w), direction[0] * (0.5 / w)
    if side < 0.0:
        return -x, w, 0.0, y
    return w, x, y, 0.0


@inlined
def about(vector, time):
    """Rotation by the rate `vector` over `time` (rad/s and s, or any two whose product is an angle)."""
    rate = math.sqrt(dot(vector, vector))
    if rate == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    sine, cosine = sine_cosine(0.5 * PER_TURN * rate * time, 0.0)
    factor = sine / rate
    return cosine, vector[0] * factor, vector[1] * factor, vector[2] * factor

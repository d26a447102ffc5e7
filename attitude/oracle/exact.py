"""Exact rational inputs, and the quaternion arithmetic of all routes.

A float is an exact binary fraction; ratios such as m and 1 - m, rational in moments and rate, are formed as
`Fraction` and rounded once, so that no route starts with rounded constants.

Quaternions are tuples (w, x, y, z), Hamilton product, active: ``v_inertial = q * v_body * conj(q)``.
"""

from fractions import Fraction
from numbers import Rational
from typing import NamedTuple

from mpmath import mp, mpf


def fraction(value):
    """The exact value of a float, int, numpy scalar, Fraction or mpf."""
    if isinstance(value, Rational):
        return Fraction(int(value)) if not isinstance(value, Fraction) else value
    if hasattr(value, "_mpf_"):
        sign, mantissa, exponent, _ = value._mpf_
        if not mantissa and exponent:
            raise ValueError(f"not finite: {value}")
        return Fraction(-int(mantissa) if sign else int(mantissa)) * Fraction(2) ** int(exponent)
    return Fraction(*value.as_integer_ratio())


def fractions(values):
    """The exact values as a tuple of Fractions."""
    return tuple(fraction(value) for value in values)


def elapsed(t):
    """Exact seconds of a number, or of the sum of a tuple (hi, lo)."""
    return sum(fractions(t), Fraction(0)) if isinstance(t, tuple) else fraction(t)


def real(value):
    """A Fraction rounded to the working precision."""
    return mpf(value.numerator) / value.denominator


def reals(vector):
    """The exact values of a vector, each rounded to the working precision."""
    return [real(component) for component in fractions(vector)]


def norm(vector):
    """Length of a vector, at the working precision."""
    return mp.sqrt(sum(component * component for component in vector))


def symmetric(tensor):
    """A (3, 3) tensor as rows of Fractions; ValueError where it is not symmetric."""
    exact = [fractions(row) for row in tensor]
    if any(exact[i][j] != exact[j][i] for i in range(3) for j in range(i)):
        raise ValueError("the tensor is not symmetric")
    return exact


def decades(ratio):
    """Whole decimal digits by which a positive Fraction lies below one; never negative."""
    bits = ratio.denominator.bit_length() - ratio.numerator.bit_length()
    return max(0, int(bits * 0.30103) + 1)


# Circulation: the invariants as rational numbers


class Circulation(NamedTuple):
    """How the momentum direction gamma = I omega / L moves in the body; all entries exact.

    `axes[k]` is the body axis called k + 1: axis 3 is circulated about, axis 2 has the middle moment.
    `signs` turn gamma1 and gamma3 non-negative, sign of axis 2 making the frame right-handed, so that
    ``gamma = (A1 cn u, s A2 sn u, A3 dn u)`` with s = sign(I2 - I1).
    """

    regime: str
    axes: tuple
    signs: tuple
    inverse: tuple
    gamma_squared: tuple
    amplitude_squared: tuple
    m: Fraction
    m1: Fraction
    u_rate_squared: Fraction

    def along_axes(self, vector):
        """Components of a body vector along axes 1, 2, 3."""
        return [sign * vector[axis] for sign, axis in zip(self.signs, self.axes, strict=True)]


def is_parallel(moments, omega):
    """Whether omega is parallel to I omega (rest and sphere too), by an exact test."""
    (I1, I2, I3), (w1, w2, w3) = moments, omega
    return w1 * w2 * (I1 - I2) == w2 * w3 * (I2 - I3) == w3 * w1 * (I3 - I1) == 0


def circulation(moments, omega):
    """Regime, axes and invariants of a body; moments and rate are Fractions.

    Regimes: ``constant_rate``, ``symmetric`` (m = 0), ``separatrix``, ``short_axis`` and ``long_axis``.
    For ``constant_rate`` all entries but the regime are zero or trivial.
    """
    if is_parallel(moments, omega):
        zero = (Fraction(0),) * 3
        return Circulation("constant_rate", (0, 1, 2), (1, 1, 1), zero, zero, zero, zero[0], zero[0], zero[0])
    lo, mid, hi = sorted(range(3), key=lambda axis: moments[axis])
    D = sum(moments[k] * (moments[k] - moments[mid]) * omega[k] ** 2 for k in (lo, hi))
    about_hi = D > 0 or (D == 0 and moments[mid] != moments[hi])
    axes = (lo, mid, hi) if about_hi else (hi, mid, lo)
    momentum = [moments[axis] * omega[axis] for axis in axes]
    inverse = tuple(1 / moments[axis] for axis in axes)
    L2 = sum(component**2 for component in momentum)
    gamma_squared = tuple(component**2 / L2 for component in momentum)
    even = axes in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
    first, third = (-1 if momentum[k] < 0 else 1 for k in (0, 2))
    signs = first, (1 if even else -1) * first * third, third
    a1, a2, a3 = inverse
    g1, g2, g3 = gamma_squared
    c_a1 = (a2 - a1) * g2 + (a3 - a1) * g3
    c_a2 = (a1 - a2) * g1 + (a3 - a2) * g3
    a3_c = (a3 - a1) * g1 + (a3 - a2) * g2
    amplitude_squared = (a3_c / (a3 - a1), a3_c / (a3 - a2), c_a1 / (a3 - a1))
    m = a3_c * (a2 - a1) / ((a3 - a2) * c_a1)
    m1 = (a3 - a1) * c_a2 / ((a3 - a2) * c_a1)
    regime = "separatrix" if D == 0 else "short_axis" if D > 0 else "long_axis"
    regime = "symmetric" if m == 0 else regime
    return Circulation(
        regime, axes, signs, inverse, gamma_squared, amplitude_squared, m, m1, L2 * c_a1 * (a3 - a2)
    )


# Quaternions


def multiply(p, q):
    """Hamilton product p * q."""
    pw, px, py, pz = p
    qw, qx, qy, qz = q
    return (
        pw * qw - px * qx - py * qy - pz * qz,
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
    )


def conjugate(q):
    """The inverse of a unit quaternion."""
    return q[0], -q[1], -q[2], -q[3]


def normalised(q):
    """The unit quaternion along q, at the working precision."""
    parts = reals(q)
    length = norm(parts)
    return tuple(component / length for component in parts)


def half_turn(axis, half_angle):
    """exp(axis * half_angle): the rotation by twice `half_angle` about a unit vector."""
    c, s = mp.cos_sin(half_angle)
    return (c, *(s * component for component in axis))


def constant_rotation(rate, seconds):
    """exp(rate seconds / 2): the rotation at a constant rate."""
    speed = norm(rate)
    if not speed:
        return mpf(1), mpf(0), mpf(0), mpf(0)
    return half_turn([component / speed for component in rate], speed * seconds / 2)


def rotate(q, vector):
    """q * vector * conj(q)."""
    return multiply(multiply(q, (mpf(0), *vector)), conjugate(q))[1:]


def quaternion_of_matrix(matrix):
    """Quaternion, either sign, of a proper rotation matrix (rows indexable); Shepperd's choice of pivot."""
    R = matrix
    trace = R[0][0] + R[1][1] + R[2][2]
    pivot = max(range(-1, 3), key=lambda k: trace if k < 0 else R[k][k])
    if pivot < 0:
        q = [1 + trace, R[2][1] - R[1][2], R[0][2] - R[2][0], R[1][0] - R[0][1]]
    else:
        i, j, k = pivot, (pivot + 1) % 3, (pivot + 2) % 3
        q = [R[k][j] - R[j][k], None, None, None]
        q[1 + i] = 1 - trace + 2 * R[i][i]
        q[1 + j] = R[i][j] + R[j][i]
        q[1 + k] = R[i][k] + R[k][i]
    length = sum(component * component for component in q) ** 0.5
    return tuple(component / length for component in q)

"""Route 3: the closed form as van Zon & Schofield published it (J. Comput. Phys. 225, 2007, 145-164).

The formulas stand as published, cancellations included, since how they fail beside the separatrix and beside
an axis is part of what the tests show. They are read with nome exp(-pi K'/K), Theta = theta1, F(x|m) of the
sine of the amplitude, e1 = (L1 L3, L2 L3, -Lperp^2) / (L Lperp), xi = exp(pi eta / K).

The context chooses the precision: `mpmath.mp` at its current digits, `DOUBLES` for floats and scipy.special.
A = T1' U(-psi z) T1'(0)^T A(0) takes inertial to body components; q is the active rotation of its transpose.
"""

import math
from types import SimpleNamespace

import mpmath
from scipy import special

from attitude.oracle.exact import elapsed, multiply, quaternion_of_matrix, real

DOUBLES = SimpleNamespace(
    mpf=float,
    pi=math.pi,
    eps=2.0**-52,
    sqrt=math.sqrt,
    exp=math.exp,
    sin=math.sin,
    cos=math.cos,
    sinh=math.sinh,
    cosh=math.cosh,
    asin=math.asin,
    atan2=math.atan2,
    fsum=math.fsum,
    nint=round,
    ellipk=lambda m: float(special.ellipk(m)),
    ellipf=lambda amplitude, m: float(special.ellipkinc(amplitude, m)),
    ellipfun=lambda name, u, m: float(special.ellipj(u, m)[("sn", "cn", "dn").index(name)]),
)


class PublishedMotion:
    """Constants and attitude of a generic body by the published formulas.

    Parameters
    ----------
    moments, omega : 3 floats each; principal moments in any order, body rate, rad/s
    context : mpmath.mp or DOUBLES

    Attributes
    ----------
    m, K, K_prime, nome, omega_p, epsilon, eta, A1, A2 : the paper's constants (nome is its q)
    order : body axes called 1, 2, 3; decreasing moments if 2 E I2 > L^2, increasing otherwise
    amplitudes : (omega1m, omega2m, omega3m) about those axes

    Raises
    ------
    ValueError : equal moments, the separatrix, or a spin about a principal axis
    """

    def __init__(self, moments, omega, context=mpmath.mp):
        self.context = ctx = context
        moments, omega = ([ctx.mpf(component) for component in vector] for vector in (moments, omega))
        L = [moment * w for moment, w in zip(moments, omega, strict=True)]
        self.L2 = ctx.fsum(component**2 for component in L)
        self.E2 = ctx.fsum(component * w for component, w in zip(L, omega, strict=True))
        self.order = sorted(range(3), key=lambda k: moments[k])
        if self.E2 * moments[self.order[1]] > self.L2:
            self.order.reverse()
        self.signs = (1, 1 if _is_even(self.order) else -1, 1)
        self.moments = [moments[k] for k in self.order]
        self.omega0 = self._ordered(omega)
        self._require_generic()
        self._set_constants()
        self.A1 = self._argument(0)
        self.A2 = self._secular_rate()

    def _ordered(self, vector):
        return [sign * vector[k] for sign, k in zip(self.signs, self.order, strict=True)]

    def _require_generic(self):
        I1, I2, I3 = self.moments
        if I1 == I2 or I2 == I3:
            raise ValueError("two moments are equal")
        if self.L2 == self.E2 * I2:
            raise ValueError("on the separatrix")
        if sum(component != 0 for component in self.omega0) < 2:
            raise ValueError("constant rate")

    def _set_constants(self):
        """Equations 25, 30-35."""
        ctx, (I1, I2, I3), (w1, w2, w3) = self.context, self.moments, self.omega0
        toward3, toward1 = self.L2 - I3 * self.E2, self.L2 - I1 * self.E2
        sign1, sign3 = _sign(w1), _sign(w3)
        self.m = toward3 * (I1 - I2) / (toward1 * (I3 - I2))
        omega1m = sign1 * ctx.sqrt(toward3 / (I1 * (I1 - I3)))
        omega2m = -sign1 * ctx.sqrt(toward3 / (I2 * (I2 - I3)))
        omega3m = sign3 * ctx.sqrt(toward1 / (I3 * (I3 - I1)))
        self.amplitudes = omega1m, omega2m, omega3m
        self.omega_p = _sign(I2 - I3) * sign3 * ctx.sqrt(toward1 * (I3 - I2) / (I1 * I2 * I3))
        self.K, self.K_prime = ctx.ellipk(self.m), ctx.ellipk(1 - self.m)
        self.nome = ctx.exp(-ctx.pi * self.K_prime / self.K)
        self.epsilon = self._first_kind(w2 / omega2m, self.m)
        self.eta = sign3 * self.K_prime - self._first_kind(I3 * omega3m / ctx.sqrt(self.L2), 1 - self.m)

    def _first_kind(self, sine, m):
        """Incomplete integral of the first kind, of the sine of the amplitude (equation 24)."""
        return self.context.ellipf(self.context.asin(sine), m)

    def _secular_rate(self):
        """A2, equation 42."""
        ctx = self.context
        xi, total, n = ctx.exp(ctx.pi * self.eta / self.K), ctx.mpf(0), 0
        while True:
            n += 1
            weight = self.nome ** (2 * n) / (1 - self.nome ** (2 * n))
            term = weight * (xi**n - xi**-n)
            total += term
            if abs(term) <= ctx.eps * abs(total):
                break
        bracket = (xi + 1) / (xi - 1) - 2 * total
        return ctx.sqrt(self.L2) / self.moments[0] + ctx.pi * self.omega_p / (2 * self.K) * bracket

    def _theta1(self, v, h):
        """theta1(v - i h), as the two real sums of equations 38 and 39 without the factor 2 q^(1/4)."""
        ctx, real, imaginary, n = self.context, self.context.mpf(0), self.context.mpf(0), 0
        while True:
            weight = (-1) ** n * self.nome ** (n * (n + 1))
            k = 2 * n + 1
            real += weight * ctx.cosh(k * h) * ctx.sin(k * v)
            imaginary -= weight * ctx.sinh(k * h) * ctx.cos(k * v)
            if abs(weight) * ctx.cosh(k * h) <= ctx.eps * ctx.cosh(h):
                return real, imaginary
            n += 1

    def _argument(self, t):
        """arg theta1(pi (omega_p t + epsilon - i eta) / 2K), continuous in t (equations 40 and 41)."""
        ctx = self.context
        v, h = ctx.pi * (self.omega_p * t + self.epsilon) / (2 * self.K), ctx.pi * self.eta / (2 * self.K)
        half_turns = ctx.nint(v / ctx.pi)
        real, imaginary = self._theta1(v - half_turns * ctx.pi, h)
        side = _sign(h)
        # i sign(h) theta1 has a positive real part for |v| < pi/2
        return side * half_turns * ctx.pi - side * ctx.pi / 2 + ctx.atan2(side * real, -side * imaginary)

    def psi(self, t):
        """Angle about the momentum, rad, psi(0) = 0, not wrapped (equation 43)."""
        return self.A1 + self.A2 * t - self._argument(t)

    def omega(self, t):
        """Rate along axes 1, 2, 3 (equations 27 to 29)."""
        u = self.omega_p * t + self.epsilon
        values = [self.context.ellipfun(name, u, self.m) for name in ("cn", "sn", "dn")]
        return [amplitude * value for amplitude, value in zip(self.amplitudes, values, strict=True)]

    def _tilt(self, omega):
        """T1', with columns e1, e2 and the momentum direction (equations 16 and 19), as rows."""
        L1, L2, L3 = (moment * w for moment, w in zip(self.moments, omega, strict=True))
        perp, L = self.context.sqrt(L1 * L1 + L2 * L2), self.context.sqrt(self.L2)
        return [
            [L1 * L3 / (L * perp), -L2 / perp, L1 / L],
            [L2 * L3 / (L * perp), L1 / perp, L2 / L],
            [-perp / L, self.context.mpf(0), L3 / L],
        ]

    def attitude_and_rate(self, q0, t):
        """Attitude (wxyz, either sign) and body rate at time t, from the attitude q0 at 0."""
        ctx, omega = self.context, self.omega(t)
        psi = self.psi(t)
        c, s = ctx.cos(psi), ctx.sin(psi)
        turn = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
        P = _matmul(_matmul(self._tilt(omega), turn), _transpose(self._tilt(self.omega0)))
        ordered = list(zip(self.signs, self.order, strict=True))
        frame = [[sign * int(k == axis) for sign, k in ordered] for axis in range(3)]
        relative = quaternion_of_matrix(_matmul(_matmul(frame, _transpose(P)), _transpose(frame)))
        norm = ctx.sqrt(ctx.fsum(ctx.mpf(component) ** 2 for component in q0))
        q = multiply([ctx.mpf(component) / norm for component in q0], relative)
        return q, tuple(_apply(frame, omega))


def attitude_and_rate(moments, omega, q0, t, digits=None):
    """Attitude (wxyz, either sign) and body rate by the published route; `digits=None` for plain doubles.

    Digits are those worked with, not those left; in doubles the failures are those of the formulas:
    ValueError from asin or sqrt, OverflowError from cosh, or nan.
    """
    if digits is None:
        return PublishedMotion(moments, omega, DOUBLES).attitude_and_rate(q0, float(elapsed(t)))
    with mpmath.workdps(digits):
        return PublishedMotion(moments, omega).attitude_and_rate(q0, real(elapsed(t)))


def _sign(value):
    return -1 if value < 0 else 1


def _is_even(order):
    return tuple(order) in ((0, 1, 2), (1, 2, 0), (2, 0, 1))


def _transpose(matrix):
    return [list(row) for row in zip(*matrix, strict=True)]


def _matmul(A, B):
    return _transpose([_apply(A, column) for column in zip(*B, strict=True)])


def _apply(matrix, vector):
    return [sum(a * b for a, b in zip(row, vector, strict=True)) for row in matrix]

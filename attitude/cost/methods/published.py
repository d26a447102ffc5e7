"""The closed form as van Zon & Schofield published it (J. Comput. Phys. 225, 2007, 145-164).

The formulas stand as published, cancellations included: the digits they lose beside the separatrix and beside
a principal axis are part of the measurement.  Only slips of the print are mended: nome exp(-pi K'/K),
Theta = theta1, F(x|m) of the sine of the amplitude, xi = exp(pi eta / K),
e1 = (L1 L3, L2 L3, -Lperp^2) / (L Lperp).  Equal moments, a spin about a principal axis and the separatrix
have no generic formula.

The arithmetic is a parameter: NumPy and scipy.special on all instants at once, as users would run it, or
mpmath on arrays of mpf, as the tests do.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy import special
from scipy.spatial.transform import Rotation

from ..initial_value_problem import InitialValueProblem
from ..method import Method, Solve
from .principal_frame import principal_axes

LONGEST_SERIES = 10_000  # terms; beside the separatrix, where the nome nears one, the series fails

DOUBLES: Any = SimpleNamespace(
    zero=0.0,
    pi=np.pi,
    eps=2.0**-52,
    **{name: getattr(np, name) for name in ("sqrt", "exp", "sin", "cos", "sinh", "cosh", "arcsin")},
    arctan2=np.arctan2,
    rint=np.rint,
    isfinite=np.isfinite,
    ellipk=special.ellipk,
    ellipf=lambda amplitude, m: float(special.ellipkinc(amplitude, m)),
    ellipj=lambda u, m: special.ellipj(u, m)[:3],
)
"""Arithmetic in doubles: what `PublishedMotion` takes as `arithmetic`."""


def methods() -> list[Method]:
    """One method: the formulas have no accuracy to choose."""
    return [Method("van Zon & Schofield (SciPy)", "", prepare, steps=False)]


def prepare(problem: InitialValueProblem) -> Solve:
    """The constants of the motion; the function that evaluates the formulas.

    Raises
    ------
    ArithmeticError : a formula leaves its domain or overflows, here or when the solution is evaluated.
    """
    moments, axes = principal_axes(problem)
    attitude = Rotation.from_quat(problem.attitude, scalar_first=True).as_matrix() @ axes
    with _floating_point_errors_named():
        motion = PublishedMotion(moments, axes.T @ problem.angular_velocity)

    def solve(instants: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        with _floating_point_errors_named():
            turns, rates = motion.turn_and_rate(instants)
            turned = Rotation.from_matrix(attitude @ turns @ axes.T)
        return turned.as_quat(scalar_first=True), rates @ axes.T

    return solve


@contextmanager
def _floating_point_errors_named() -> Iterator[None]:
    """Domain errors, divisions by zero and overflows of NumPy as ArithmeticError; underflow is none."""
    with np.errstate(divide="raise", over="raise", invalid="raise", under="ignore"):
        try:
            yield
        except FloatingPointError as error:
            raise ArithmeticError(f"the published formulas: {error}") from error


class PublishedMotion:
    """Constants and attitude of a generic body by the published formulas.

    Parameters
    ----------
    moments, omega : (3,) each; principal moments in any order, body rate, rad/s
    arithmetic : elementary and elliptic functions, elementwise on arrays; `DOUBLES` lists them

    Attributes
    ----------
    m, K, K_prime, nome, omega_p, epsilon, eta, A1, A2 : the paper's constants (nome is its q)
    order : body axes called 1, 2, 3; decreasing moments if 2 E I2 > L^2, increasing otherwise
    amplitudes : (omega1m, omega2m, omega3m) about those axes

    Raises
    ------
    ArithmeticError : equal moments, the separatrix, a spin about a principal axis, no convergence.
    """

    def __init__(self, moments: np.ndarray, omega: np.ndarray, arithmetic: Any = DOUBLES):
        self.functions = arithmetic
        self.L2 = ((moments * omega) ** 2).sum()
        self.E2 = (moments * omega**2).sum()
        order = np.argsort(moments, kind="stable")
        self.order = order[::-1] if self.E2 * moments[order[1]] > self.L2 else order
        # axes taken in odd order make a left-handed frame, which the second axis turned round mends
        even = tuple(self.order.tolist()) in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
        self.signs = np.array([1.0, 1.0 if even else -1.0, 1.0])
        self.moments = moments[self.order]
        self.omega0 = self.signs * omega[self.order]
        I1, I2, I3 = self.moments
        if I2 in (I1, I3):
            raise ArithmeticError("the published formulas: two moments are equal")
        if self.L2 == self.E2 * I2:
            raise ArithmeticError("the published formulas: on the separatrix")
        if (self.omega0 != 0.0).sum() < 2:
            raise ArithmeticError("the published formulas: spin about a principal axis")
        self._set_constants()
        self._set_series()
        self.A1 = self._argument(np.zeros(1) + arithmetic.zero)[0]
        self.A2 = self._secular_rate()

    def _set_constants(self) -> None:
        """Equations 25, 30-35."""
        f, (I1, I2, I3), (w1, w2, w3) = self.functions, self.moments, self.omega0
        toward3, toward1 = self.L2 - I3 * self.E2, self.L2 - I1 * self.E2
        sign1, sign3 = _sign(w1), _sign(w3)
        self.m = toward3 * (I1 - I2) / (toward1 * (I3 - I2))
        omega1m = sign1 * f.sqrt(toward3 / (I1 * (I1 - I3)))
        omega2m = -sign1 * f.sqrt(toward3 / (I2 * (I2 - I3)))
        omega3m = sign3 * f.sqrt(toward1 / (I3 * (I3 - I1)))
        self.amplitudes = np.array([omega1m, omega2m, omega3m])
        self.omega_p = _sign(I2 - I3) * sign3 * f.sqrt(toward1 * (I3 - I2) / (I1 * I2 * I3))
        self.K, self.K_prime = f.ellipk(self.m), f.ellipk(1.0 - self.m)
        self.nome = f.exp(-f.pi * self.K_prime / self.K)
        # F(x | m) of the sine x of the amplitude (equation 24)
        self.epsilon = f.ellipf(f.arcsin(w2 / omega2m), self.m)
        self.eta = sign3 * self.K_prime - f.ellipf(f.arcsin(I3 * omega3m / f.sqrt(self.L2)), 1.0 - self.m)
        self._require_finite(self.K, self.K_prime, self.nome, self.epsilon, self.eta)

    def _set_series(self) -> None:
        """Coefficients of the two real sums of theta1(v - i h), equations 38 and 39, without 2 q^(1/4)."""
        f = self.functions
        h = f.pi * self.eta / (2.0 * self.K)
        self.side = _sign(h)
        sines, cosines = [], []
        for n in range(LONGEST_SERIES):
            k, weight = 2 * n + 1, (-1) ** n * self.nome ** (n * (n + 1))
            sines.append(weight * f.cosh(k * h))
            cosines.append(-weight * f.sinh(k * h))
            if abs(sines[-1]) <= f.eps * f.cosh(h):
                self.sines, self.cosines = np.array(sines), np.array(cosines)
                return
        raise ArithmeticError("the published formulas: the theta series does not converge")

    def _secular_rate(self) -> float:
        """A2, equation 42."""
        f = self.functions
        xi, total = f.exp(f.pi * self.eta / self.K), f.zero
        for n in range(1, LONGEST_SERIES):
            power = self.nome ** (2 * n)
            term = power / (1.0 - power) * (xi**n - xi**-n)
            total += term
            if abs(term) <= f.eps * abs(total):
                bracket = (xi + 1.0) / (xi - 1.0) - 2.0 * total
                return f.sqrt(self.L2) / self.moments[0] + f.pi * self.omega_p / (2.0 * self.K) * bracket
        raise ArithmeticError("the published formulas: the series of the secular rate does not converge")

    def _argument(self, t: np.ndarray) -> np.ndarray:
        """arg theta1(pi (omega_p t + epsilon - i eta) / 2K), continuous in t (equations 40 and 41)."""
        f = self.functions
        v = f.pi * (self.omega_p * t + self.epsilon) / (2.0 * self.K)
        half_turns = f.rint(v / f.pi)
        v = v - half_turns * f.pi
        real, imaginary = np.zeros_like(v), np.zeros_like(v)
        for n, (sine, cosine) in enumerate(zip(self.sines, self.cosines, strict=True)):
            real += sine * f.sin((2 * n + 1) * v)
            imaginary += cosine * f.cos((2 * n + 1) * v)
        # i sign(h) theta1 has a positive real part for |v| < pi/2
        within = f.arctan2(self.side * real, -self.side * imaginary)
        return self.side * (half_turns * f.pi - f.pi / 2.0) + within

    def psi(self, t: np.ndarray) -> np.ndarray:
        """Angle about the momentum (n,), rad, psi(0) = 0, not wrapped (equation 43)."""
        return self.A1 + self.A2 * t - self._argument(t)

    def omega(self, t: np.ndarray) -> np.ndarray:
        """Rates (n, 3) along axes 1, 2, 3 (equations 27 to 29)."""
        sn, cn, dn = self.functions.ellipj(self.omega_p * t + self.epsilon, self.m)
        return self.amplitudes * np.stack([cn, sn, dn], axis=-1)

    def turn_and_rate(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rotations (n, 3, 3) that carry the axes at 0 to those at t, and rates (n, 3), in principal axes."""
        omega, psi = self.omega(t), self.psi(t)
        self._require_finite(omega, psi)
        turn = np.zeros((*psi.shape, 3, 3), psi.dtype)  # U(-psi z)
        turn[..., 0, 0] = turn[..., 1, 1] = self.functions.cos(psi)
        turn[..., 0, 1] = self.functions.sin(psi)
        turn[..., 1, 0] = -turn[..., 0, 1]
        turn[..., 2, 2] = 1.0
        to_axes = self._tilt(omega) @ turn @ self._tilt(self.omega0).T
        frame = np.zeros((3, 3))
        frame[self.order, range(3)] = self.signs
        return frame @ np.swapaxes(to_axes, -1, -2) @ frame.T, omega @ frame.T

    def _tilt(self, omega: np.ndarray) -> np.ndarray:
        """T1' (..., 3, 3), with columns e1, e2 and the momentum direction (equations 16 and 19)."""
        L1, L2, L3 = np.moveaxis(self.moments * omega, -1, 0)
        perp, L = self.functions.sqrt(L1 * L1 + L2 * L2), self.functions.sqrt(self.L2)
        rows = [
            [L1 * L3 / (L * perp), -L2 / perp, L1 / L],
            [L2 * L3 / (L * perp), L1 / perp, L2 / L],
            [-perp / L, np.zeros_like(L3), L3 / L],
        ]
        return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

    def _require_finite(self, *values: Any) -> None:
        """Raise where scipy.special returned nan or infinity in silence."""
        if not all(np.all(self.functions.isfinite(value)) for value in values):
            raise ArithmeticError("the published formulas: nan or infinity among the elliptic functions")


def _sign(value: float) -> float:
    return -1.0 if value < 0.0 else 1.0

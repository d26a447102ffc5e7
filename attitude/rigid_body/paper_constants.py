"""The constants of the motion under the names of van Zon and Schofield's paper."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .. import units
from ..kernels.layout import Regime, Route
from ..runtime import compiled
from .error_bounds import max_phase_rate, refuse_too_far


@dataclass(frozen=True)
class PaperConstants:
    """Constants of torque-free rotation, each of the batch's shape.

    Axes 1, 2, 3 are the principal axes in the paper's order (3 is the one the momentum circles),
    turned so that the momentum has no negative component along 1 and 3; all its signs are then +.

    Attributes
    ----------
    m : elliptic parameter (k^2)
    K, K_prime : quarter periods K(m) and K(1 - m)
    q : nome exp(-pi K'/K)
    omega_p : rad/s, rate of the elliptic argument; negative where I1 < I2 < I3
    epsilon : elliptic argument at the epoch
    eta : imaginary part of the theta function's argument, K' - F(I3 omega_3m / L | 1 - m)
    A1, A2 : rad and rad/s, constant and rate in psi(t) = A1 + A2 t - arg Theta

    Source: van Zon and Schofield, J. Comput. Phys. 225 (2007) 145, section 3, with omega_p,
    epsilon, A1 and A2 as docs/van-zon-schofield.md derives them from two-part phases.
    """

    m: np.ndarray
    K: np.ndarray
    K_prime: np.ndarray
    q: np.ndarray
    omega_p: np.ndarray
    epsilon: np.ndarray
    eta: np.ndarray
    A1: np.ndarray
    A2: np.ndarray
    _bodies: np.ndarray = field(repr=False)

    @classmethod
    def from_invariants(cls, bodies: np.ndarray) -> PaperConstants:
        """Constants from records of the motion, of any batch shape; none of a constant rate."""
        sense = _sense(bodies)
        with np.errstate(invalid="ignore"):
            nome = np.where(np.isinf(bodies["K"]), 1.0, np.exp(-np.pi * bodies["K_prime"] / bodies["K"]))
        nome = np.where(bodies["route"] == Route.THETA, bodies["nome"], nome)
        turn = 2.0 * np.pi
        start = _azimuth(bodies, np.zeros(1))[..., 0]
        angle = np.pi - start
        return cls(
            m=bodies["modulus"] ** 2,
            K=bodies["K"][()],
            K_prime=bodies["K_prime"][()],
            q=nome[()],
            omega_p=-sense * bodies["u_rate"],
            epsilon=-sense * bodies["u0"],
            eta=bodies["eta"][()],
            A1=(angle - turn * np.round(angle / turn))[()],
            A2=(2.0 * turn * bodies["precession"][..., 0])[()],
            _bodies=bodies,
        )

    def psi(self, t: Any) -> np.ndarray:
        """Angle turned about the momentum by axis 3 since the epoch, rad; continuous, psi(0) = 0.

        t : seconds (float array or Quantity) of any shape; the result has shape batch + t.shape.
        Raises ToleranceError where `TorqueFreeMotion.at` would.
        """
        seconds = units.si_array(t, units.SECOND, "t")
        refuse_too_far(max_phase_rate(self._bodies), float(np.abs(seconds).max(initial=0.0)))
        start = _azimuth(self._bodies, np.zeros(1))
        turned = _azimuth(self._bodies, seconds.reshape(-1)) - start
        return turned.reshape(self._bodies.shape + seconds.shape)[()]


def _sense(bodies: np.ndarray) -> np.ndarray:
    """s: +1 about the greatest moment (and on the separatrix), -1 about the least."""
    return np.where(bodies["regime"] == Regime.LONG_AXIS, -1.0, 1.0)[()]


def _azimuth(bodies: np.ndarray, seconds: np.ndarray) -> np.ndarray:
    angles = np.empty((*bodies.shape, seconds.size))
    sense = np.ascontiguousarray(_sense(bodies)).reshape(-1)
    records = np.ascontiguousarray(bodies).reshape(-1)
    compiled.azimuth(records, sense, seconds, angles.reshape(-1, seconds.size))
    return angles

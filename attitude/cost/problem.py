"""What every method is given: one body and its state, as the doubles they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError

if TYPE_CHECKING:
    from ..motion import TorqueFreeMotion


@dataclass(frozen=True)
class Problem:
    """A free body at its epoch.

    Attributes
    ----------
    tensor : (3, 3), kg m2; moments : (3,), kg m2, or None where the tensor is not diagonal
    attitude : (4,), wxyz, body to inertial; angular_velocity : (3,), rad/s, body frame
    unit : s; what horizons are counted in: the polhode period, or the turn 2 pi / abs(omega) where
        there is none (constant rate, separatrix), or 1 s for a body at rest
    unit_name : str
    """

    tensor: np.ndarray
    moments: np.ndarray | None
    attitude: np.ndarray
    angular_velocity: np.ndarray
    unit: float
    unit_name: str

    @classmethod
    def of_motion(cls, motion: TorqueFreeMotion) -> Problem:
        if motion.shape:
            raise InputError("motion", f"shape {motion.shape}", "one body")
        tensor, rate = motion.body.tensor, motion._batch.rates
        diagonal = np.array_equal(tensor, np.diag(np.diag(tensor)))
        moments = np.diag(tensor).copy() if diagonal else None
        return cls(tensor, moments, motion._batch.attitudes, rate, *_unit(float(motion.polhode_period), rate))


def counted(number: float, unit_name: str) -> str:
    """ "1 polhode period", "10000 polhode periods"."""
    first, space, rest = unit_name.partition(" of ")
    return f"{number:.15g} {first.removesuffix('s') if number == 1.0 else first}{space}{rest}"


def _unit(period: float, rate: np.ndarray) -> tuple[float, str]:
    if np.isfinite(period):
        return period, "polhode periods"
    speed = float(np.linalg.norm(rate))
    return (2.0 * np.pi / speed, "turns of the body rate") if speed > 0.0 else (1.0, "seconds")

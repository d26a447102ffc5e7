"""Which motion is exact: the closed form that effects leave a body, if they leave it one; decided once.

no torque                        free rotation
rotors of constant momentum      a gyrostat
anything else                    none: it is integrated

Impulses end one stretch of closed form and begin another; they are no torque here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import RegimeError
from ..kernels import layout
from ..problem.initial_state import InitialState
from ..problem.torque_model import CachedTorque
from ..problem.torque_rows import turned
from ..rigid_body.body import RigidBody
from ..rigid_body.constants_of_motion import Batch, check_rates
from ..rigid_body.gyrostat_constants import GyrostatBatch


@dataclass(frozen=True)
class ExactMotion:
    """A motion in closed form between impulses.

    Attributes
    ----------
    rotors : (3,), N m s, momentum of rotors relative to the body, body components; zeros for a free body
    """

    rotors: np.ndarray

    @property
    def is_free(self) -> bool:
        """Whether no rotor turns."""
        return not self.rotors.any()

    def of(self, body: RigidBody, attitudes: np.ndarray, rates: np.ndarray) -> Batch:
        """The motion of bodies (...) from attitudes (..., 4) wxyz and rates (..., 3), rad/s, body frame.

        Raises InputError for rates out of range, RegimeError as `GyrostatBatch`.
        """
        rates = check_rates(rates)
        if self.is_free:
            return Batch(body, attitudes, rates, body.shape)
        return GyrostatBatch(body, attitudes, rates, self.rotors, body.shape)

    def momentum(self, body: RigidBody, rates: np.ndarray) -> np.ndarray:
        """(..., 3), N m s, body components, with that of the rotors."""
        return turned(body.tensor, rates) + self.rotors

    def rate(self, body: RigidBody, momentum: np.ndarray) -> np.ndarray:
        """(..., 3), rad/s, of the whole momentum, both in body components."""
        return np.linalg.solve(body.tensor, (momentum - self.rotors)[..., None])[..., 0]


FREE_ROTATION = ExactMotion(np.zeros(3))


def exact_motion(
    initial_state: InitialState, torques: Sequence[CachedTorque], solver: str | None = None
) -> ExactMotion | None:
    """The closed form of motion under these torques; None where there is none.

    Nor is there one where the motion of the body from the epoch ends at a merger of equilibria.
    solver : that the user asked for by name, to which torques are left then
    """
    rotors = np.zeros(3)
    for torque in torques:
        rows = torque.own_rows
        are_rotors = (rows[:, 0] == layout.WHEELS).all() and torque.intervals(initial_state) is None
        if solver not in (None, "automatic") or not are_rotors or not torque.follows_axes:
            return None
        rotors = rotors + rows[:, 1:4].sum(axis=0)
    exact = ExactMotion(rotors)
    if not exact.is_free:
        try:
            exact.of(initial_state.body, initial_state.attitude, initial_state.rate)
        except RegimeError:
            return None
    return exact

"""Which motion is exact: the closed form that effects leave a body, if they leave it one; decided once.

no torque                                   free rotation
rotors of constant momentum                 a gyrostat
torques that turn no momentum               free rotation in a time of its own (`momentum_direction`)
anything else                               none: it is integrated

Impulses end one stretch of closed form and begin another; they are no torque here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import RegimeError
from ..kernels.layout import EffectCode
from ..problem.initial_state import InitialState
from ..problem.torque_model import CachedTorque
from ..problem.torque_rows import turned
from ..rigid_body.body import RigidBody
from ..rigid_body.constants_of_motion import Batch, check_rates
from ..rigid_body.driven_motion import DrivenBatch, MomentumLaw
from ..rigid_body.error_bounds import BOUND_SOURCE, GYROSTAT_BOUND_SOURCE
from ..rigid_body.gyrostat_constants import GyrostatBatch
from .momentum_direction import momentum_law


@dataclass(frozen=True)
class ExactMotion:
    """A motion in closed form between impulses.

    Attributes
    ----------
    rotors : (3,), N m s, momentum of rotors relative to the body, body components; zeros without
    law : how the size of the momentum changes, where torques act along it; None where none act
    from_rest : (3,) rad/s, the rate of the law's reference, of a body at rest; else None
    """

    rotors: np.ndarray
    law: MomentumLaw | None = None
    from_rest: np.ndarray | None = None

    @property
    def is_free(self) -> bool:
        """Whether no rotor turns and no torque acts."""
        return not self.rotors.any() and self.law is None

    @property
    def bound_source(self) -> str:
        """Where the bound on the error of one stretch comes from."""
        return GYROSTAT_BOUND_SOURCE if self.rotors.any() else BOUND_SOURCE

    def of(self, body: RigidBody, attitudes: np.ndarray, rates: np.ndarray) -> Batch:
        """The motion of bodies (...) from attitudes (..., 4) wxyz and rates (..., 3), rad/s, body frame.

        Raises InputError for rates out of range, RegimeError as `GyrostatBatch`.
        """
        rates = check_rates(rates)
        if self.law is not None:
            rates = rates if self.from_rest is None else check_rates(self.from_rest)
            return DrivenBatch(body, attitudes, rates, body.shape, self.law)
        if self.rotors.any():
            return GyrostatBatch(body, attitudes, rates, self.rotors, body.shape)
        return Batch(body, attitudes, rates, body.shape)

    def momentum(self, body: RigidBody, rates: np.ndarray) -> np.ndarray:
        """(..., 3), N m s, body components, with that of the rotors."""
        return turned(body.tensor, rates) + self.rotors

    def rate(self, body: RigidBody, momentum: np.ndarray) -> np.ndarray:
        """(..., 3), rad/s, of the whole momentum, both in body components."""
        return np.linalg.solve(body.tensor, (momentum - self.rotors)[..., None])[..., 0]


FREE_ROTATION = ExactMotion(np.zeros(3))


def exact_motion(
    initial_state: InitialState,
    torques: Sequence[CachedTorque],
    solver: str | None = None,
    impulses: bool = False,
) -> ExactMotion | None:
    """The closed form of motion under these torques; None where there is none.

    Nor is there one where the motion of the body from the epoch ends at a merger of equilibria.

    solver : that the user asked for by name, to which torques are left then
    impulses : whether impulses change the state besides
    """
    if not torques:
        return FREE_ROTATION
    at_all_times = all(torque.intervals(initial_state) is None for torque in torques)
    if solver not in (None, "automatic") or not at_all_times or not all(t.follows_axes for t in torques):
        return None
    rows = np.concatenate([torque.own_rows for torque in torques])
    if not (rows[:, 0] == EffectCode.WHEELS).all():
        law, rate = momentum_law(initial_state, rows, impulses) or (None, None)
        return law and ExactMotion(np.zeros(3), law, rate if law.start == 0.0 else None)
    exact = ExactMotion(rows[:, 1:4].sum(axis=0))
    try:
        exact.of(initial_state.body, initial_state.attitude, initial_state.rate)
    except RegimeError:
        return None
    return exact

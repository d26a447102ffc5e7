"""Gravity-gradient torque: gravity is stronger on the near side of the body than on the far side."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from ..errors import InputError
from ..kernels.layout import EffectCode
from ..orbit.path_states import least_distance
from ..problem.initial_state import InitialState, Spin
from .effect import BodyDependentTorque, required_orbit_path, row


class GravityGradient(BodyDependentTorque):
    """`{"type": "gravity_gradient"}`: torque 3 mu / r^3 (n x I n), n from the central body to this one.

    The first term of the series in the body's size over r (Hughes 2004, section 8.1), with the full tensor.
    """

    NEEDS_ORBIT: ClassVar[bool] = True

    type: Literal["gravity_gradient"]

    def rows(self, initial_state: InitialState) -> np.ndarray:
        """One row: the gravitational parameter."""
        return row(EffectCode.GRAVITY_GRADIENT, _mu(initial_state))[None]

    def sizes(self, initial_state: InitialState, moments: np.ndarray, spin: Spin) -> np.ndarray:
        """Reached at the nearest point of the orbit, 45 degrees between least and greatest moment."""
        distance = least_distance(required_orbit_path(initial_state))
        spread = moments.max(axis=-1) - moments.min(axis=-1)
        return 1.5 * _mu(initial_state) / distance**3 * spread


def _mu(initial_state: InitialState) -> float:
    if initial_state.central_body is None:
        raise InputError("orbit", None, "an orbit about a body whose gravity is known")
    return initial_state.central_body.mu

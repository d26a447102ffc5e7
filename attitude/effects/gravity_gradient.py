"""Gravity gradient: the near side of the body is pulled harder than the far side."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from ..errors import InputError
from ..kernels import layout
from ..orbit.path_states import least_distance
from ..problem.initial_state import InitialState
from ..problem.spin_bound import Spin
from .effect import BodyDependentTorque, row


class GravityGradient(BodyDependentTorque):
    """`{"type": "gravity_gradient"}`: torque 3 mu / r^3 (n x I n), n from the central body to this one.

    The first term of the series in the body's size over r (Hughes 2004, section 8.1), with the full tensor.
    """

    NEEDS_ORBIT: ClassVar[bool] = True

    type: Literal["gravity_gradient"]

    def rows(self, initial_state: InitialState) -> np.ndarray:
        return row(layout.GRAVITY_GRADIENT, _mu(initial_state))[None]

    def sizes(self, initial_state: InitialState, moments: np.ndarray, spin: Spin) -> np.ndarray:
        """Reached at the nearest point of the orbit, 45 degrees between least and greatest moment."""
        if initial_state.course is None:
            raise InputError("orbit", None, "an orbit")
        spread = moments.max(axis=-1) - moments.min(axis=-1)
        return 1.5 * _mu(initial_state) / least_distance(initial_state.course) ** 3 * spread


def _mu(initial_state: InitialState) -> float:
    if initial_state.course is None or initial_state.course.central is None:
        raise InputError("orbit", None, "an orbit about a body whose gravity is known")
    return initial_state.course.central.mu

"""The library's own closed form."""

from __future__ import annotations

import numpy as np

from ...motion import TorqueFreeMotion
from ...rigid_body.body import RigidBody
from ...times.instants import as_instants
from ..initial_value_problem import InitialValueProblem
from ..method import Method, Solve


def methods() -> list[Method]:
    """The closed form; it has no accuracy to choose."""
    return [Method("closed form", "", prepare, steps=False)]


def prepare(problem: InitialValueProblem) -> Solve:
    """The motion of the problem."""
    body = RigidBody(problem.tensor if problem.moments is None else problem.moments)
    motion = TorqueFreeMotion(body, problem.attitude, problem.angular_velocity, order="wxyz")

    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        ephemeris = motion.ephemeris(as_instants(t, None), rate=True)
        return ephemeris.quaternion("wxyz"), ephemeris.angular_velocity

    return solve

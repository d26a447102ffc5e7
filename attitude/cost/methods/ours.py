"""The library's own closed form."""

from __future__ import annotations

import numpy as np

from ... import elapsed
from ...body import RigidBody
from ...motion import TorqueFreeMotion
from ..method import Method, Solve
from ..problem import Problem


def ladder() -> list[Method]:
    return [Method("closed form", "", _exact_phases, steps=False)]


def _exact_phases(problem: Problem) -> Solve:
    motion = _motion(problem)

    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        ephemeris = motion.ephemeris(elapsed.instants(t, None), rate=True)
        return ephemeris.quaternion("wxyz"), ephemeris.angular_velocity

    return solve


def _motion(problem: Problem) -> TorqueFreeMotion:
    body = RigidBody(problem.tensor if problem.moments is None else problem.moments)
    return TorqueFreeMotion(body, problem.attitude, problem.angular_velocity, order="wxyz")

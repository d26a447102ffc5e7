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
    return [Method("closed form", "", lambda problem: _solve(_motion(problem)), steps=False)]


def plain() -> list[Method]:
    """The closed form with its phases in plain doubles: the cost and the gain of two-part phases."""
    return [Method("closed form, phases in doubles", "", _plain_phases, steps=False)]


def _plain_phases(problem: InitialValueProblem) -> Solve:
    motion = _motion(problem)
    motion._batch.plain_phases = 1
    return _solve(motion)


def _solve(motion: TorqueFreeMotion) -> Solve:
    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        ephemeris = motion.ephemeris(as_instants(t, None), rate=True)
        return ephemeris.quaternion("wxyz"), ephemeris.angular_velocity

    return solve


def _motion(problem: InitialValueProblem) -> TorqueFreeMotion:
    body = RigidBody(problem.tensor if problem.moments is None else problem.moments)
    return TorqueFreeMotion(body, problem.attitude, problem.angular_velocity, order="wxyz")

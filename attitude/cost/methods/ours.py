"""The library's own closed form."""

from __future__ import annotations

import numpy as np

from ...motion import TorqueFreeMotion
from ...rigid_body.body import RigidBody
from ...times.instants import as_instants
from ..method import Method, Solve
from ..problem import Problem


def ladder() -> list[Method]:
    return [Method("closed form", "", _exact_phases, steps=False)]


def plain() -> list[Method]:
    return [Method("closed form, phases in doubles", "", _plain_phases, steps=False)]


def _exact_phases(problem: Problem) -> Solve:
    return _samples(_motion(problem))


def _plain_phases(problem: Problem) -> Solve:
    """The same set-up, calls and loop, but for the second parts of phases: what they cost and buy."""
    motion = _motion(problem)
    motion._batch.plain_phases = 1
    return _samples(motion)


def _samples(motion: TorqueFreeMotion) -> Solve:
    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        ephemeris = motion.ephemeris(as_instants(t, None), rate=True)
        return ephemeris.quaternion("wxyz"), ephemeris.angular_velocity

    return solve


def _motion(problem: Problem) -> TorqueFreeMotion:
    body = RigidBody(problem.tensor if problem.moments is None else problem.moments)
    return TorqueFreeMotion(body, problem.attitude, problem.angular_velocity, order="wxyz")

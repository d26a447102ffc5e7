"""The library's own closed form."""

from __future__ import annotations

import numpy as np

from ... import compiled, elapsed
from ...body import RigidBody
from ...motion import TorqueFreeMotion
from ..method import Method, Solve
from ..problem import Problem


def ladder() -> list[Method]:
    return [Method("closed form", "", _exact_phases, steps=False)]


def plain() -> list[Method]:
    return [Method("closed form, phases in doubles", "", _plain_phases, steps=False)]


def _exact_phases(problem: Problem) -> Solve:
    motion = _motion(problem)

    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        ephemeris = motion.ephemeris(elapsed.instants(t, None), rate=True)
        return ephemeris.quaternion("wxyz"), ephemeris.angular_velocity

    return solve


def _plain_phases(problem: Problem) -> Solve:
    """The same set-up and loop without the second parts: what exact phases cost, and what they buy."""
    motion = _motion(problem)
    (_, records), *_ = motion._batch.blocks(0, 1)

    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        quaternions, rates = np.empty((4, 1, t.size)), np.empty((3, 1, t.size))
        compiled.sample(records, np.ascontiguousarray(t), None, quaternions, rates, 1, 0, 0, t.size)
        return quaternions[:, 0].T, rates[:, 0].T

    return solve


def _motion(problem: Problem) -> TorqueFreeMotion:
    body = RigidBody(problem.tensor if problem.moments is None else problem.moments)
    return TorqueFreeMotion(body, problem.attitude, problem.angular_velocity, order="wxyz")

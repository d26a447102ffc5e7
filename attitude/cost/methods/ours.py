"""The library's own closed form."""

from __future__ import annotations

from functools import partial

import numpy as np

from ...motion import TorqueFreeMotion
from ...rigid_body.body import RigidBody
from ...times.instants import as_instants
from ..initial_value_problem import InitialValueProblem
from ..method import Method, Solve


def methods() -> list[Method]:
    """The closed form; it has no accuracy to choose."""
    return [Method("closed form", "", prepare, steps=False)]


def plain() -> list[Method]:
    """The closed form with its phases in plain doubles: the cost and the gain of two-part phases."""
    return [Method("closed form, phases in doubles", "", partial(prepare, plain_phases=1), steps=False)]


def prepare(problem: InitialValueProblem, plain_phases: int | None = None) -> Solve:
    """The motion of the problem; `plain_phases` as in `Batch`."""
    body = RigidBody(problem.tensor if problem.moments is None else problem.moments)
    motion = TorqueFreeMotion(body, problem.attitude, problem.angular_velocity, order="wxyz")
    motion._batch.plain_phases = plain_phases

    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        ephemeris = motion.ephemeris(as_instants(t, None), rate=True)
        return ephemeris.quaternion("wxyz"), ephemeris.angular_velocity

    return solve

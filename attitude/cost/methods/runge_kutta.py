"""The classical fourth-order Runge-Kutta method at fixed steps, compiled."""

from __future__ import annotations

from functools import partial

import numpy as np

from ..method import Method, Solve
from ..problem import Problem
from .euler import Equations, runge_kutta

STEPS = (32, 128, 512, 2048)


def ladder() -> list[Method]:
    return [
        Method("RK4", f"{steps} steps a period", partial(prepare, steps=steps), steps=True) for steps in STEPS
    ]


def prepare(problem: Problem, steps: int) -> Solve:
    """So many steps in the problem's unit of time."""
    equations = Equations.of(problem)
    h = problem.unit * equations.second / steps

    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        y = np.empty((t.size, 7))
        runge_kutta(equations.start, equations.k, h, t * equations.second, y)
        return equations.answer(y)

    return solve

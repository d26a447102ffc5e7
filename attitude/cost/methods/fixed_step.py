"""The classical fourth-order Runge-Kutta method at fixed steps, compiled."""

from __future__ import annotations

from functools import partial

import numpy as np

from ... import stopping
from ..initial_value_problem import InitialValueProblem
from ..method import Method, Solve
from .euler import FreeEquations, runge_kutta


def methods() -> list[Method]:
    """RK4 from 32 to 2048 steps in a polhode period."""
    return [
        Method("RK4", f"{steps} steps a period", partial(prepare, steps=steps), steps=True)
        for steps in (32, 128, 512, 2048)
    ]


def prepare(problem: InitialValueProblem, steps: int) -> Solve:
    """Integration with `steps` steps in the problem's unit of time."""
    equations = FreeEquations.of(problem)
    h = problem.unit * equations.second / steps

    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        y = np.empty((t.size, 7))
        stop = stopping.current()
        runge_kutta(equations.start, equations.k, h, t * equations.second, y, stop.flag)
        stop.check()
        return equations.to_body(y)

    return solve

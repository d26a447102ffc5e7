"""SciPy's `solve_ivp` along a ladder of tolerances, its right-hand side compiled."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.integrate import solve_ivp

from ..method import Method, Solve
from ..problem import Problem
from . import torques
from .euler import Equations, derivative

# The last is the least that SciPy takes, 100 eps; smaller ones it raises to this, with a warning.
TOLERANCES = {"rtol 1e-6": 1e-6, "rtol 1e-9": 1e-9, "rtol 1e-12": 1e-12, "rtol 2.3e-14": 2.3e-14}


def dop853() -> list[Method]:
    return _ladder("DOP853")


def lsoda() -> list[Method]:
    return _ladder("LSODA")


def _ladder(name: str) -> list[Method]:
    return [
        Method(f"{name} (SciPy)", setting, partial(prepare, name=name, rtol=rtol), steps=True)
        for setting, rtol in TOLERANCES.items()
    ]


def prepare(problem: Problem, name: str, rtol: float) -> Solve:
    """Components are of order one, so the absolute tolerance is the relative one."""
    if problem.world is not None:
        return partial(_under_torques, problem, name, rtol)
    equations = Equations.of(problem)

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        return derivative(y, equations.k)

    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        times = t * equations.second
        found = solve_ivp(rates, (0.0, times[-1]), equations.start, name, times, rtol=rtol, atol=rtol)
        if not found.success:
            raise ArithmeticError(found.message)
        return equations.answer(found.y.T)

    return solve


def _under_torques(problem: Problem, name: str, rtol: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    def integrate(
        equations: torques.Equations, y: np.ndarray, begin: float, end: float, instants: np.ndarray
    ) -> np.ndarray:
        args, times = equations.arguments, np.unique(np.append(instants, end))
        found = solve_ivp(torques.derivative, (begin, end), y, name, times, args=args, rtol=rtol, atol=rtol)
        if not found.success:
            raise ArithmeticError(found.message)
        return found.y.T[np.append(np.searchsorted(times, instants), -1)]

    return torques.over_legs(problem, t, integrate)

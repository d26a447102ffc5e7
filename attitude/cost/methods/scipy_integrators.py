"""SciPy's `solve_ivp` at several tolerances, its right-hand side compiled."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.integrate import solve_ivp

from ..initial_value_problem import InitialValueProblem
from ..method import Method, Solve
from . import torques
from .euler import FreeEquations, derivative


def dop853() -> list[Method]:
    """DOP853 at each tolerance."""
    return _at_tolerances("DOP853")


def lsoda() -> list[Method]:
    """LSODA at each tolerance."""
    return _at_tolerances("LSODA")


def _at_tolerances(name: str) -> list[Method]:
    return [
        Method(f"{name} (SciPy)", f"rtol {rtol}", partial(prepare, name=name, rtol=float(rtol)), steps=True)
        for rtol in ("1e-6", "1e-9", "1e-12", "2.3e-14")  # the last is the smallest SciPy accepts, 100 eps
    ]


def prepare(problem: InitialValueProblem, name: str, rtol: float) -> Solve:
    """The integration; the absolute tolerance is the relative one, since components are of order one."""
    if problem.environment is not None:
        return partial(_under_torques, problem, name, rtol)
    equations = FreeEquations.of(problem)

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        return derivative(y, equations.k)

    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        times = t * equations.second
        span = (0.0, float(times[-1]))
        return equations.to_body(_integrated(rates, span, equations.start, name, times, rtol))

    return solve


def _under_torques(
    problem: InitialValueProblem, name: str, rtol: float, t: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    def integrate(
        equations: torques.TorqueEquations, y: np.ndarray, begin: float, end: float, instants: np.ndarray
    ) -> np.ndarray:
        def rates(time: float, y: np.ndarray) -> np.ndarray:
            return torques.derivative(time, y, equations.arguments)

        times = np.unique(np.append(instants, end))
        states = _integrated(rates, (begin, end), y, name, times, rtol)
        return states[np.append(np.searchsorted(times, instants), -1)]

    return torques.over_arcs(problem, t, integrate)


def _integrated(
    rates: Callable[[float, np.ndarray], np.ndarray],
    span: tuple[float, float],
    start: np.ndarray,
    name: str,
    times: np.ndarray,
    rtol: float,
) -> np.ndarray:
    """States (n, 7) at the times.

    Raises
    ------
    ArithmeticError : SciPy's message, where the integration fails.
    """
    solution = solve_ivp(rates, span, start, name, times, rtol=rtol, atol=rtol)
    if not solution.success:
        raise ArithmeticError(solution.message)
    return solution.y.T

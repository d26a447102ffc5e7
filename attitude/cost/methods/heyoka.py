"""heyoka.py: the equations of motion by Taylor's method, compiled (Biscani & Izzo, MNRAS 504, 2021).

Quaternion and rate in principal axes: seven equations whose only parameters are (I2 - I3) / I1 and its like.
Its tolerance is absolute while all of the state is below one and relative above, so it means the same at any
scale in a time that makes the rate of order one.  Compact mode and plain sums: for these equations the others
are no faster and no more exact.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ..initial_value_problem import InitialValueProblem
from ..method import AbsentError, Method, Solve
from . import torques
from .euler import FreeEquations

FAMILY = "heyoka"
TOLERANCES = {"tol 1e-6": 1e-6, "tol 1e-9": 1e-9, "tol 1e-12": 1e-12, "tol eps": 2.0**-52}


def methods() -> list[Method]:
    """heyoka at tolerances from 1e-6 to the rounding unit."""
    return [
        Method(FAMILY, setting, partial(prepare, tolerance=tolerance), steps=True)
        for setting, tolerance in TOLERANCES.items()
    ]


def prepare(problem: InitialValueProblem, tolerance: float) -> Solve:
    """The integrator, compiled; heyoka caches it, so that a second body costs less.

    Raises
    ------
    AbsentError : heyoka is not installed, or a torque is not written for it.
    ArithmeticError : the integration ends before the last instant; raised when the solution is evaluated.
    """
    if problem.environment is not None:
        _heyoka()
        from .heyoka_torques import equations_of_motion

        system, under_torques = equations_of_motion(problem)
        return _solve(_adaptive(system, under_torques.start.tolist(), [], tolerance), under_torques)
    equations = FreeEquations.of(problem)
    return _solve(_integrator(equations, tolerance), equations)


def _solve(integrator: Any, equations: FreeEquations | torques.TorqueEquations) -> Solve:

    def solve(instants: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        integrator.time = 0.0
        integrator.state[:] = equations.start
        return equations.to_body(_propagate(integrator, instants * equations.second))

    return solve


def _heyoka() -> Any:
    try:
        import heyoka
    except ImportError as error:
        raise AbsentError("heyoka is not installed: pip install 'attitude[peers]'") from error
    return heyoka


def _integrator(problem: FreeEquations, tolerance: float) -> Any:
    heyoka = _heyoka()
    q0, q1, q2, q3, x, y, z = heyoka.make_vars("q0", "q1", "q2", "q3", "x", "y", "z")
    equations = [
        (q0, -0.5 * (q1 * x + q2 * y + q3 * z)),
        (q1, 0.5 * (q0 * x + q2 * z - q3 * y)),
        (q2, 0.5 * (q0 * y + q3 * x - q1 * z)),
        (q3, 0.5 * (q0 * z + q1 * y - q2 * x)),
        (x, heyoka.par[0] * (y * z)),
        (y, heyoka.par[1] * (z * x)),
        (z, heyoka.par[2] * (x * y)),
    ]
    return _adaptive(equations, problem.start.tolist(), problem.k.tolist(), tolerance)


def _adaptive(
    equations: list[tuple[Any, Any]], start: list[float], parameters: list[float], tolerance: float
) -> Any:
    return _heyoka().taylor_adaptive(equations, start, pars=parameters, tol=tolerance, compact_mode=True)


def _propagate(integrator: Any, grid: np.ndarray) -> np.ndarray:
    """The state (n, 7) at ascending instants from 0."""
    outcome, *_, path = integrator.propagate_grid(grid)
    if outcome.name != "time_limit":  # heyoka's name for the end of the grid
        raise ArithmeticError(f"heyoka: {outcome.name} at t = {integrator.time:.6g} of {grid[-1]:.6g}")
    return np.asarray(path)

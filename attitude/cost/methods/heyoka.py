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


def methods() -> list[Method]:
    """heyoka at tolerances from 1e-6 to the rounding unit."""
    return [
        Method("heyoka", f"tol {setting}", partial(prepare, tolerance=tolerance), steps=True)
        for setting, tolerance in (("1e-6", 1e-6), ("1e-9", 1e-9), ("1e-12", 1e-12), ("eps", 2.0**-52))
    ]


def prepare(problem: InitialValueProblem, tolerance: float) -> Solve:
    """The integrator, compiled; heyoka caches it, so that a second body costs less.

    Raises
    ------
    AbsentError : heyoka is not installed, or a torque is not written for it.
    ArithmeticError : the integration ends before the last instant; raised when the solution is evaluated.
    """
    try:
        import heyoka
    except ImportError as error:
        raise AbsentError("heyoka is not installed: pip install 'attitude[peers]'") from error
    from .heyoka_torques import equations_of_motion

    equations: FreeEquations | torques.TorqueEquations
    if problem.environment is not None:
        (system, equations), parameters = equations_of_motion(problem), []
    else:
        equations = FreeEquations.of(problem)
        system, parameters = free_motion(heyoka), equations.k.tolist()
    integrator = heyoka.taylor_adaptive(
        system, equations.start.tolist(), pars=parameters, tol=tolerance, compact_mode=True
    )

    def solve(instants: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        integrator.time = 0.0
        integrator.state[:] = equations.start
        return equations.to_body(propagate(integrator, instants * equations.second))

    return solve


def free_motion(heyoka: Any) -> list[tuple[Any, Any]]:
    """Euler's equations: pairs of variable and its rate of change."""
    q0, q1, q2, q3, x, y, z = heyoka.make_vars("q0", "q1", "q2", "q3", "x", "y", "z")
    return [
        (q0, -0.5 * (q1 * x + q2 * y + q3 * z)),
        (q1, 0.5 * (q0 * x + q2 * z - q3 * y)),
        (q2, 0.5 * (q0 * y + q3 * x - q1 * z)),
        (q3, 0.5 * (q0 * z + q1 * y - q2 * x)),
        (x, heyoka.par[0] * (y * z)),
        (y, heyoka.par[1] * (z * x)),
        (z, heyoka.par[2] * (x * y)),
    ]


def propagate(integrator: Any, grid: np.ndarray) -> np.ndarray:
    """The state (n, 7) at ascending instants from 0."""
    outcome, *_, path = integrator.propagate_grid(grid)
    if outcome.name != "time_limit":  # heyoka's name for the end of the grid
        raise ArithmeticError(f"heyoka: {outcome.name} at t = {integrator.time:.6g} of {grid[-1]:.6g}")
    return np.asarray(path)

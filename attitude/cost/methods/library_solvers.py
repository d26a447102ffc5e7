"""The library under torques: its solver, in steps of several lengths and of its choice; the closed form."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ...dynamics import arc_integration, integration, solver
from ...dynamics.batch_states import TorqueProblem
from ...dynamics.exact_motion import exact_motion
from ...problem.torque_model import CachedTorque
from ...times.instants import as_instants
from ..initial_value_problem import InitialValueProblem, environment_of
from ..method import AbsentError, Method, Solve


def automatic() -> list[Method]:
    """`Scene.run` at several tolerances: trials, solution, solution for its error."""

    def prepare(tolerance: float, problem: InitialValueProblem) -> Solve:
        environment = environment_of(problem)

        def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            initial_state = replace(environment.initial_state, start=0.0, stop=float(t[-1]))
            torques = tuple(CachedTorque(effect, initial_state) for effect in environment.effects)
            posed = TorqueProblem(initial_state, torques, (), tolerance)
            return _columns(integration.solve(posed, as_instants(t, None), integration.choose(posed)).rows)

        return solve

    return [
        Method("automatic", f"tol 1e-{digits}", partial(prepare, float(f"1e-{digits}")), steps=True)
        for digits in (6, 9, 12)
    ]


def gauss() -> list[Method]:
    """Gauss's collocation, by the step in radians of the fastest motion."""

    def prepare(radians: float, problem: InitialValueProblem) -> Solve:
        return partial(integrate, problem, radians / environment_of(problem).pace)

    return [
        Method(solver.NAME, f"{radians:g} rad", partial(prepare, radians), steps=True)
        for radians in (12.0, 8.0, 5.0, 2.5)
    ]


def exact() -> list[Method]:
    """The closed form, where these torques leave one (`dynamics.exact_motion`)."""

    def prepare(problem: InitialValueProblem) -> Solve:
        environment = environment_of(problem)
        initial_state = environment.initial_state
        motion = exact_motion(initial_state, environment.torques)
        if motion is None:
            leaves = "which rotors alone do, or torques along the momentum"
            raise AbsentError(f"exact: these torques leave no closed form, {leaves}")
        batch = motion.of(initial_state.body, initial_state.attitude, initial_state.rate)
        return lambda t: batch.sample(as_instants(t, None), quaternion=True, rate=True)

    return [Method("exact", "", prepare, steps=False)]


def load(problem: InitialValueProblem) -> None:
    """Compile the solver, or load it from disk."""
    integrate(problem, 1.0, np.array([1e-3 / environment_of(problem).pace]))


def integrate(
    problem: InitialValueProblem, step: float, t: np.ndarray, decay: float = 1e-15
) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions (n, 4) and rates (n, 3) at ascending instants, in steps of so many s.

    decay : size of a step's last Legendre coefficients above which it is halved, where torques break

    Raises
    ------
    ArithmeticError : the iteration of an implicit step did not converge.
    """
    environment = environment_of(problem)
    initial_state = replace(environment.initial_state, start=0.0, stop=float(t[-1]))
    posed, at = TorqueProblem(initial_state, environment.torques), np.array([t, np.zeros_like(t)])
    setting = solver.StepSetting(np.array([step]), np.array([decay]))
    solution = arc_integration.integrate(posed, posed.body, at, setting)
    if solution.failed[0]:
        raise ArithmeticError(f"after {solution.steps[0]} steps one did not converge")
    return _columns(solution.rows[0])


def _columns(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions (n, 4) and rates (n, 3)."""
    return rows[:4].T, rows[4:7].T

"""The library's solvers under torques: each at several settings, and the automatic choice of `Scene.run`."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ...dynamics import arc_integration, integration
from ...dynamics.batch_states import Bodies, TorqueProblem
from ...dynamics.solvers import COLLOCATION, RUNGE_KUTTA, SPLITTINGS, Solver, can_take, endless_steps
from ...problem.torque_model import CachedTorque
from ...times.instants import as_instants
from ..initial_value_problem import InitialValueProblem, environment_of
from ..method import AbsentError, Method, Solve


def automatic() -> list[Method]:
    """`Scene.run` at several tolerances: trials, choice of solver, solution, solution for its error."""
    return [
        Method("automatic", f"tol 1e-{digits}", partial(_chosen, tolerance=float(f"1e-{digits}")), steps=True)
        for digits in (6, 9, 12)
    ]


def splitting() -> list[Method]:
    """Splitting schemes of each order, by the step in radians of the fastest motion."""
    return [method for solver in SPLITTINGS for method in _at_steps(solver, (4.0, 2.0, 1.0, 0.5, 0.25))]


def gauss() -> list[Method]:
    """Gauss's collocation, by the step in radians of the fastest motion."""
    return _at_steps(COLLOCATION, (8.0, 4.0, 2.0, 1.0))


def compiled() -> list[Method]:
    """The library's Dormand-Prince method, by the error of a step."""

    def at_error(problem: InitialValueProblem, error: float) -> Solve:
        return partial(integrate, problem, RUNGE_KUTTA, error)

    return [
        Method(
            "dop853 compiled", f"tol 1e-{digits}", partial(at_error, error=float(f"1e-{digits}")), steps=True
        )
        for digits in (6, 9, 12, 15)
    ]


def _at_steps(solver: Solver, steps: tuple[float, ...]) -> list[Method]:
    return [
        Method(solver.name, f"{radians:g} rad", partial(_at_step, solver=solver, radians=radians), steps=True)
        for radians in steps
    ]


def _at_step(problem: InitialValueProblem, solver: Solver, radians: float) -> Solve:
    environment = environment_of(problem)
    body = Bodies.of(environment.initial_state)
    for arc in environment.arcs(environment.initial_state.stop):
        if not can_take(solver, solver.prepare(environment.initial_state, body, arc.torques))[0]:
            raise AbsentError(
                f"{solver.name} does not take these effects: its error would not have that order"
            )
    return partial(integrate, problem, solver, radians / environment.pace)


def _chosen(problem: InitialValueProblem, tolerance: float) -> Solve:
    environment = environment_of(problem)

    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        initial_state = replace(environment.initial_state, start=0.0, stop=float(t[-1]))
        torques = tuple(CachedTorque(effect, initial_state) for effect in environment.effects)
        posed = TorqueProblem(initial_state, torques, (), tolerance, environment.solver)
        solution = integration.solve(posed, as_instants(t, None), integration.choose(posed))
        return _columns(solution.rows)

    return solve


def load(problem: InitialValueProblem) -> None:
    """Compile every solver, or load it from disk."""
    for solver, setting in ((COLLOCATION, 1.0), (SPLITTINGS[0], 1.0), (RUNGE_KUTTA, 1e-3)):
        integrate(problem, solver, setting, np.array([1e-3 / environment_of(problem).pace]))


def integrate(
    problem: InitialValueProblem, solver: Solver, setting: float, t: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions (n, 4) and rates (n, 3) at ascending instants; `setting` is the solver's step or error.

    Raises
    ------
    ArithmeticError : the iteration of an implicit step did not converge.
    """
    environment = environment_of(problem)
    initial_state = replace(environment.initial_state, start=0.0, stop=float(t[-1]))
    posed, at = TorqueProblem(initial_state, environment.torques), np.array([t, np.zeros_like(t)])
    solution = arc_integration.integrate(posed, posed.body, at, solver, np.array([setting]))
    if solution.failed[0] and solver is RUNGE_KUTTA:
        raise endless_steps(setting)
    if solution.failed[0]:
        raise ArithmeticError(f"{solution.failed[0]} of {solution.steps[0]} steps did not converge")
    return _columns(solution.rows[0])


def _columns(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions (n, 4) and rates (n, 3)."""
    return rows[:4].T, rows[4:7].T

"""The library's own solvers under torques: each at several settings, and the choice that a scene is given."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ...dynamics import integration
from ...dynamics.arc_integration import integrate
from ...dynamics.batch_states import Bodies, TorqueProblem
from ...dynamics.solvers import COLLOCATION, RUNGE_KUTTA, SPLITTINGS, Solver, can_take, endless_steps
from ...problem.torque_model import CachedTorque
from ...times.instants import as_instants
from ..method import AbsentError, Method, Solve
from ..problem import Problem, of_world

# Steps, in radians of the fastest motion; errors of a step; tolerances of a scene.
SPLITTING_STEPS = (4.0, 2.0, 1.0, 0.5, 0.25)
GAUSS_STEPS = (8.0, 4.0, 2.0, 1.0)
ERRORS = {"tol 1e-6": 1e-6, "tol 1e-9": 1e-9, "tol 1e-12": 1e-12, "tol 1e-15": 1e-15}
TOLERANCES = {"tol 1e-6": 1e-6, "tol 1e-9": 1e-9, "tol 1e-12": 1e-12}


def automatic() -> list[Method]:
    """What `Scene.run` does: trials, the choice, the solution and the one that tells its error."""
    return [
        Method("automatic", setting, partial(_chosen, tolerance=tolerance), steps=True)
        for setting, tolerance in TOLERANCES.items()
    ]


def splitting() -> list[Method]:
    return [method for solver in SPLITTINGS for method in _ladder(solver, SPLITTING_STEPS)]


def gauss() -> list[Method]:
    return _ladder(COLLOCATION, GAUSS_STEPS)


def compiled() -> list[Method]:
    return [
        Method("dop853 compiled", setting, partial(_at_error, error=error), steps=True)
        for setting, error in ERRORS.items()
    ]


def _ladder(solver: Solver, steps: tuple[float, ...]) -> list[Method]:
    return [
        Method(solver.name, f"{radians:g} rad", partial(_at_step, solver=solver, radians=radians), steps=True)
        for radians in steps
    ]


def _at_step(problem: Problem, solver: Solver, radians: float) -> Solve:
    world = of_world(problem)
    body = Bodies.of(world.initial_state)
    for leg in world.legs(world.initial_state.stop):
        if not can_take(solver, solver.prepare(world.initial_state, body, leg.torques))[0]:
            raise AbsentError(f"{solver.name} is not for these effects: its error has not that order")
    return partial(march, problem, solver, radians / world.pace)


def _at_error(problem: Problem, error: float) -> Solve:
    return partial(march, problem, RUNGE_KUTTA, error)


def _chosen(problem: Problem, tolerance: float) -> Solve:
    world = of_world(problem)

    def solve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        initial_state = replace(world.initial_state, start=0.0, stop=float(t[-1]))
        torques = tuple(CachedTorque(effect, initial_state) for effect in world.effects)
        posed = TorqueProblem(initial_state, torques, (), tolerance, world.solver)
        return _columns(integration.solve(posed, as_instants(t, None), integration.choose(posed)).rows)

    return solve


def load(problem: Problem) -> None:
    """Every solver once: what a process compiles, or reads from disk, is there then."""
    for solver, setting in ((COLLOCATION, 1.0), (SPLITTINGS[0], 1.0), (RUNGE_KUTTA, 1e-3)):
        march(problem, solver, setting, np.array([1e-3 / of_world(problem).pace]))


def march(problem: Problem, solver: Solver, setting: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions and rates at ascending instants, by a solver at a setting of its own kind."""
    world = of_world(problem)
    initial_state = replace(world.initial_state, start=0.0, stop=float(t[-1]))
    posed, at = TorqueProblem(initial_state, world.torques), np.array([t, np.zeros_like(t)])
    solution = integrate(posed, posed.body, at, solver, np.array([setting]))
    if solution.failed[0] and solver is RUNGE_KUTTA:
        raise endless_steps(setting)
    if solution.failed[0]:
        raise ArithmeticError(f"{solution.failed[0]} of {solution.steps[0]} steps did not settle")
    return _columns(solution.rows[0])


def _columns(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions (n, 4) and rates (n, 3)."""
    return rows[:4].T, rows[4:7].T

"""Motion under torques, of one body or many: the solver, its steps for the tolerance, the attitudes.

One body is a block of one.  For many the solver, and how fine, is chosen once; every body's error is
estimated by itself, and one whose estimate stays above the tolerance is solved as a scene of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import InputError, ToleranceError
from ..times.instants import Instants
from .arc_integration import two_part
from .batch_states import Bodies, TorqueProblem, named
from .error_estimate import compared_instants
from .refinement import SHARE_OF_TOLERANCE, refine_step, short_arc_trial
from .solver_selection import Candidate, candidates
from .solvers import COLLOCATION, OUTPUTS, RUNGE_KUTTA, SPLITTINGS, endless_steps

STATES = 7  # the first rows, which ensembles keep: attitude (4) and rate (3)
# Attempts at all bodies of a block together; those that are left then are solved as scenes of their own.
MAX_BLOCK_ATTEMPTS = 2
# Numbers of rows that a block of bodies may fill: it stays in a processor's cache, or not far from it.
MAX_NUMBERS_PER_BLOCK = 1 << 18


@dataclass(frozen=True)
class TorquedSolution:
    """Attitudes of one body under torques.

    Attributes
    ----------
    rows : (OUTPUTS, m): attitude wxyz (4), rate (3, body), momentum (3, inertial) at the instants
    error : rad, estimated greatest error of an attitude
    candidate : the solver and setting that were used
    steps, torques : steps made, and torques computed in them
    """

    rows: np.ndarray
    error: float
    candidate: Candidate
    steps: int
    torques: int


def choose(problem: TorqueProblem, body: Bodies | None = None) -> list[Candidate]:
    """Solvers and settings for the problem's span, cheapest first.

    body : a block of one; without, the scene's own

    Raises
    ------
    InputError : the kind of solver asked for cannot take these effects.
    """
    choice = candidates(problem, problem.body if body is None else body)
    if not choice:
        raise InputError(
            "solver", problem.kind, "a solver that takes these effects: automatic, gauss or dop853"
        )
    return choice


def solve(
    problem: TorqueProblem, instants: Instants, choice: Sequence[Candidate], body: Bodies | None = None
) -> TorquedSolution:
    """Attitudes at the instants, off by less than the tolerance by comparison with a coarser solution.

    Parameters
    ----------
    choice : by `choose`
    body : a block of one; without, the scene's own

    Raises
    ------
    ToleranceError : steps however small do not bring the estimate below the tolerance.
    """
    body, at = problem.body if body is None else body, two_part(instants)
    least, nearest = np.inf, choice[0].solver
    rows = np.empty((1, OUTPUTS, at.shape[1]))
    for cheapest in _worth_trying(problem, body, choice):
        candidate = short_arc_trial(problem, body, cheapest)
        (refined,) = refine_step(problem, body, at, candidate, rows)
        if refined.reached:
            used = refined.candidate
            return TorquedSolution(rows[0], refined.error, used, refined.steps, refined.torques)
        if refined.failed:
            raise endless_steps(candidate.setting)
        if refined.error < least:
            least, nearest = refined.error, candidate.solver
    if not np.isfinite(least):
        raise ToleranceError(
            f"tolerance: no steps of {nearest.name} lead to the end of the span: the torque is not finite "
            "somewhere in it, or far too great for the body"
        )
    raise ToleranceError(
        f"tolerance: {problem.tolerance:.1e} rad cannot be reached over this span in double precision by "
        f"{nearest.name} (estimated error {least:.1e} rad); ask for more than that"
    )


def _worth_trying(problem: TorqueProblem, body: Bodies, choice: Sequence[Candidate]) -> list[Candidate]:
    """Return the cheapest candidate and, where it is another, the one for what trials do not show.

    Where torques are not smooth, that which finds for itself where they break; after a splitting collocation,
    for trials in which errors do not show: a body at rest spun up about one axis.
    """
    smooth = RUNGE_KUTTA.prepare(problem.template, body, problem.torques).is_smooth
    other = COLLOCATION if choice[0].solver in SPLITTINGS else choice[0].solver
    other = other if smooth else RUNGE_KUTTA
    return [choice[0], *(candidate for candidate in choice[1:] if candidate.solver is other)]


# -- many bodies ------------------------------------------------------------------------------------------


def choose_for_all(problem: TorqueProblem, instants: Instants, probes: Bodies | None = None) -> Candidate:
    """The solver and setting for all bodies of an ensemble, by a few of them, or by the scene's own.

    The solver that most of them would choose, with the finest setting of those; on the first of them its
    estimate over the whole span is brought to half of the tolerance.

    Raises
    ------
    InputError, ToleranceError : as `choose`.
    """
    bodies = problem.body if probes is None or not len(probes) else replace(probes, index=None)
    blocks = [bodies[i : i + 1] for i in range(len(bodies))]
    cheapest = [choose(problem, body)[0] for body in blocks]
    names = [candidate.solver.name for candidate in cheapest]
    commonest = max(names, key=names.count)
    alike = [candidate for candidate in cheapest if candidate.solver.name == commonest]
    finest = min(alike, key=lambda candidate: candidate.setting)
    body, at = blocks[names.index(commonest)], two_part(instants)
    at = at[:, compared_instants(at.shape[1])]
    for tolerance in (SHARE_OF_TOLERANCE * problem.tolerance, problem.tolerance):
        aimed = replace(problem, tolerance=tolerance)
        candidate = short_arc_trial(aimed, body, finest)
        (refined,) = refine_step(aimed, body, at, candidate, np.empty((1, STATES, at.shape[1])))
        if refined.failed:
            raise endless_steps(candidate.setting)
        if refined.reached:
            return refined.candidate
    return finest


def solve_each(
    problem: TorqueProblem,
    bodies: Bodies,
    instants: Instants,
    candidate: Candidate,
    lost: list[int] | None = None,
) -> np.ndarray:
    """(n, STATES, m): attitude and rate of each body at the instants.

    No bit of a body's rows depends on the other bodies.

    lost : takes the indices of bodies that cannot be computed to the tolerance, whose rows are NaN then

    Raises
    ------
    ToleranceError, InputError : as `solve` and `choose`, of the body that is named.
    """
    at = two_part(instants)
    out = np.empty((len(bodies), STATES, at.shape[1]))
    size = max(1, MAX_NUMBERS_PER_BLOCK // (OUTPUTS * max(1, at.shape[1])))
    for first in range(0, len(bodies), size):
        block = bodies[first : first + size]
        refined = refine_step(
            problem, block, at, candidate, out[first : first + size], attempts=MAX_BLOCK_ATTEMPTS
        )
        for i in (i for i, one in enumerate(refined) if not one.reached):
            with named(block, i, lost):
                out[first + i] = np.nan
                out[first + i] = solve_alone(problem, block[i : i + 1], instants)
    return out


def solve_alone(problem: TorqueProblem, body: Bodies, instants: Instants) -> np.ndarray:
    """(STATES, m): of one body of an ensemble, with a solver and steps of its own."""
    body = replace(body, index=None)
    return solve(problem, instants, choose(problem, body), body).rows[:STATES]

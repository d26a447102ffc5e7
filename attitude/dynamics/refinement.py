"""Steps made finer until the estimate of the error is below the tolerance, body by body."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .angular_rates import max_angular_rates
from .batch_states import Bodies, TorqueProblem
from .error_estimate import compare, estimate
from .solver_selection import Candidate
from .solvers import RUNGE_KUTTA, endless_steps

MAX_ATTEMPTS = 6
# Trials on a short arc: of spans longer than this, rad, the first of so many parts, at so many instants; the
# part of the tolerance that the estimate is brought to; errors grow with this power of time.
MIN_RADIANS_OF_TRIAL, PARTS_OF_SPAN, INSTANTS_OF_TRIAL = 1e4, 12.0, 8
SHARE_OF_TOLERANCE, ERROR_GROWTH_EXPONENT = 0.5, 1.1
# Of an attempt's setting, what the next takes at most: more would hardly change the number of steps.
MAX_STEP_FACTOR = 0.9
# Of the first attempt's steps, what a later one takes at most: where torques break, more is of little use.
MAX_TOTAL_REFINEMENT = 30.0


@dataclass
class Refinement:
    """Attempts at one body.

    Attributes
    ----------
    setting : of the last attempt where the tolerance is reached, else of the next
    error : rad, the least estimate of the attempts
    steps, torques : of the last
    reached : whether its estimate is below the tolerance; failed : whether its steps had no end
    stalled : attempts in more steps that hardly made the estimate smaller
    """

    setting: float
    error: float = np.inf
    steps: int = 0
    torques: int = 0
    reached: bool = False
    failed: bool = False
    stalled: int = 0


def refine_step(
    problem: TorqueProblem,
    bodies: Bodies,
    instants: np.ndarray,
    candidate: Candidate,
    out: np.ndarray,
    attempts: int = MAX_ATTEMPTS,
) -> list[Refinement]:
    """Finer and finer until each estimate is below the tolerance, twice has hardly fallen, or is rounding.

    out : (n, k, m), written where the tolerance is reached: the first k rows of `Solution.rows`
    """
    solver = candidate.solver
    angles = max_angular_rates(problem.template, bodies, problem.torques, problem.impulses)
    angles = angles * problem.max_abs_seconds
    all_of_them = [Refinement(candidate.setting) for _ in range(len(bodies))]
    left = np.arange(len(bodies))
    for _ in range(attempts):
        if not left.size:
            break
        settings = np.array([all_of_them[i].setting for i in left])
        part = bodies if left.size == len(bodies) else bodies[left]
        compared = compare(problem, part, instants, solver, settings)
        errors, rounding = estimate(solver, compared, angles[left])
        reached = errors <= problem.tolerance
        out[left[reached]] = compared.fine.rows[reached, : out.shape[1]]
        again = []
        for k, i in enumerate(left.tolist()):
            one, fine = all_of_them[i], compared.fine
            if errors[k] > 0.5 * one.error and fine.steps[k] > one.steps:
                one.stalled += 1  # of few steps, a setting somewhat finer may make as many again
            one.error, one.steps = min(one.error, float(errors[k])), int(fine.steps[k])
            one.torques, one.reached = int(fine.torques[k]), bool(reached[k])
            one.failed = solver is RUNGE_KUTTA and bool(fine.failed[k])
            if one.reached:
                continue
            mine = replace(candidate, setting=one.setting)
            one.setting = finer(mine, problem.tolerance / float(errors[k]), fine.smooth, one.steps).setting
            broken = not fine.smooth and solver is not RUNGE_KUTTA
            enough = broken and one.setting * MAX_TOTAL_REFINEMENT < candidate.setting
            if not (enough or one.failed or one.stalled == 2 or rounding[k] > problem.tolerance):
                again.append(i)
        left = np.array(again, dtype=int)
    return all_of_them


def finer(candidate: Candidate, ratio: float, smooth: bool, steps: int) -> Candidate:
    """A setting whose error is smaller by a ratio, and a little more; of few steps, one that makes others."""
    order = min(candidate.solver.order, 14 if smooth else 2)
    share = (0.5 * ratio) ** (1.0 / order) if ratio > 0.0 else 0.5  # nothing known: it did not settle
    setting = candidate.setting * min(MAX_STEP_FACTOR, 1.0 - 1.0 / max(2, steps), max(0.02, share))
    if candidate.solver is RUNGE_KUTTA:
        setting = max(setting, 1e-15)
    return replace(candidate, setting=setting)


def short_arc_trial(problem: TorqueProblem, body: Bodies, candidate: Candidate) -> Candidate:
    """The candidate with a setting that has kept its share of the tolerance over the first part of the span.

    To find only at the end of a long span that steps were too long would cost all of it again.

    Raises
    ------
    ToleranceError : steps that shrink to nothing.
    """
    rate = float(max_angular_rates(problem.template, body, problem.torques, problem.impulses)[0])
    angle = rate * problem.max_abs_seconds / PARTS_OF_SPAN
    if angle * PARTS_OF_SPAN < MIN_RADIANS_OF_TRIAL:
        return candidate
    start, stop = problem.template.start / PARTS_OF_SPAN, problem.template.stop / PARTS_OF_SPAN
    part = replace(problem, template=replace(problem.template, start=start, stop=stop))
    instants = np.array([np.linspace(start, stop, INSTANTS_OF_TRIAL), np.zeros(INSTANTS_OF_TRIAL)])
    share = SHARE_OF_TOLERANCE * problem.tolerance / PARTS_OF_SPAN**ERROR_GROWTH_EXPONENT
    for _ in range(MAX_ATTEMPTS):
        compared = compare(part, body, instants, candidate.solver, np.array([candidate.setting]))
        (error,), (rounding,) = estimate(candidate.solver, compared, np.array([angle]))
        if candidate.solver is RUNGE_KUTTA and compared.fine.failed[0]:
            raise endless_steps(candidate.setting)
        if error <= share or rounding > share:
            break
        candidate = finer(candidate, share / error, compared.fine.smooth, int(compared.fine.steps[0]))
    return candidate

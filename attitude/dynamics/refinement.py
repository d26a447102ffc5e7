"""Steps made finer until the estimate of the error is below the tolerance, body by body."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .angular_rates import max_angular_rates
from .arc_integration import Solution
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
    candidate : with the setting of the last attempt where the tolerance is reached, else of the next
    first_setting : of the first attempt
    error : rad, the least estimate of the attempts
    steps, torques : of the last
    reached : whether its estimate is below the tolerance; failed : whether its steps had no end
    stalled : attempts in more steps that hardly made the estimate smaller
    """

    candidate: Candidate
    first_setting: float
    error: float = np.inf
    steps: int = 0
    torques: int = 0
    reached: bool = False
    failed: bool = False
    stalled: int = 0

    def add(self, error: float, rounding: float, fine: Solution, k: int, tolerance: float) -> bool:
        """Add the k-th body's attempt; returns whether another, finer one is worth making."""
        if error > 0.5 * self.error and fine.steps[k] > self.steps:
            self.stalled += 1  # of few steps, a setting somewhat finer may make as many again
        self.error = min(self.error, error)
        self.steps, self.torques = int(fine.steps[k]), int(fine.torques[k])
        self.reached = error <= tolerance
        if self.reached:
            return False
        adaptive = self.candidate.solver is RUNGE_KUTTA
        self.failed = adaptive and bool(fine.failed[k])
        self.candidate = finer(self.candidate, tolerance / error, fine.smooth, self.steps)
        fine_enough = self.candidate.setting * MAX_TOTAL_REFINEMENT < self.first_setting
        hopeless = self.failed or self.stalled == 2 or rounding > tolerance
        return not hopeless and (fine.smooth or adaptive or not fine_enough)


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
    rates = max_angular_rates(problem.template, bodies, problem.torques, problem.impulses)
    angles = rates * problem.max_abs_seconds
    refinements = [Refinement(candidate, candidate.setting) for _ in range(len(bodies))]
    left = np.arange(len(bodies))
    for _ in range(attempts):
        if not left.size:
            break
        settings = np.array([refinements[i].candidate.setting for i in left])
        part = bodies if left.size == len(bodies) else bodies[left]
        compared = compare(problem, part, instants, candidate.solver, settings)
        errors, rounding = estimate(candidate.solver, compared, angles[left])
        reached = errors <= problem.tolerance
        out[left[reached]] = compared.fine.rows[reached, : out.shape[1]]
        again = [
            refinements[i].add(float(errors[k]), float(rounding[k]), compared.fine, k, problem.tolerance)
            for k, i in enumerate(left.tolist())
        ]
        left = left[again]
    return refinements


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

"""What a motion under torques will be off by, and take, as plans say it before it is computed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..kernels.layout import EffectCode
from ..problem.spin_bound import reached_spin
from .angular_rates import max_angular_rates
from .batch_states import TorqueProblem
from .error_estimate import MAX_COMPARED_INSTANTS
from .integration import Refinement, refine
from .solver import OUTPUTS
from .step_selection import Candidate

MAX_SECONDS = 0.3  # that a prediction may take
NEXT_PART = 4.0  # from one part of the span to the next that is solved for it
GROWTH_OF_ERROR = 2.0  # the power of time that errors are taken to grow with beyond the part that was solved


@dataclass(frozen=True)
class Prediction:
    """Predicted error and work of one body over the span of its scene.

    Attributes
    ----------
    error : rad
    seconds : of the solution, without samples
    kept : s, the span in which the tolerance is kept; None for all of it
    """

    error: float
    seconds: float
    kept: tuple[float, float] | None = None


def predict(problem: TorqueProblem, candidate: Candidate) -> Prediction:
    """Predict for the scene's own body, from a solution over as much of the span as takes MAX_SECONDS.

    What errors grow to, and how fast a body turns that torques spin up, depends on the motion.  Where a
    torque is a user's, whose cost is not known, the trial of the steps is the prediction.
    """
    if any((torque.own_rows[:, 0] == EffectCode.USER).any() for torque in problem.torques):
        return _beyond(problem, candidate.error, candidate.seconds, 1.0)
    part, work, growth = _first_part(problem, candidate), 0.0, 1.0
    span = problem.max_abs_seconds
    while True:
        refined, before = _solved(problem, candidate, part), work
        # steps made, of those that the candidate expects in the whole span; none in a span of no length
        work = refined.steps * min(candidate.step, span) / span if span else 0.0
        work = part if candidate.ends_at_edges else work
        if before:
            growth = max(1.0, math.log(work / before, NEXT_PART))
            growth = min(2.0, growth)  # a body that spins up steadily turns by the square of time
        if part == 1.0:
            break
        faster = _rate_bound(problem, NEXT_PART * part) / _rate_bound(problem, part)
        if not candidate.seconds * work * NEXT_PART * faster <= MAX_SECONDS:
            break
        part = min(1.0, NEXT_PART * part)
    seconds = candidate.seconds * work / part**growth
    if refined.reached or problem.best:
        return _beyond(problem, refined.error, seconds, part)
    return Prediction(refined.error / part**GROWTH_OF_ERROR, seconds, refined.kept)


def _first_part(problem: TorqueProblem, candidate: Candidate) -> float:
    """Return the part of the span that is solved in MAX_SECONDS, whatever the torques make of the spin."""
    rate = float(max_angular_rates(problem.template, problem.body, problem.torques, problem.impulses)[0])
    part = 1.0
    while part > NEXT_PART**-30:  # where spins have no bound: eddies, far backwards
        faster = max(1.0, _rate_bound(problem, part) / rate if rate else 1.0)
        if part * candidate.seconds * faster <= MAX_SECONDS:
            break
        part /= NEXT_PART
    return part


def _rate_bound(problem: TorqueProblem, part: float) -> float:
    """rad/s, over a part of the span; infinite where eddies are followed far backwards."""
    first = problem.over(part * problem.template.start, part * problem.template.stop)
    return reached_spin(first.template, problem.torques, problem.impulses).rate


def _solved(problem: TorqueProblem, candidate: Candidate, part: float) -> Refinement:
    """What steps come to over a part of the span."""
    start, stop = part * problem.template.start, part * problem.template.stop
    seconds = np.linspace(start, stop, MAX_COMPARED_INSTANTS)
    instants, rows = np.array([seconds, np.zeros_like(seconds)]), np.empty((1, OUTPUTS, seconds.size))
    return refine(problem.over(start, stop), problem.body, instants, candidate, rows)[0]


def _beyond(problem: TorqueProblem, reached: float, seconds: float, part: float) -> Prediction:
    """Extrapolate from the error that a part of the span ends with."""
    share = part * (problem.tolerance / reached) ** (1.0 / GROWTH_OF_ERROR) if reached > 0.0 else 1.0
    error = reached / part**GROWTH_OF_ERROR
    if problem.best or share >= 1.0:
        return Prediction(error, seconds)
    return Prediction(error, seconds, (share * problem.template.start, share * problem.template.stop))

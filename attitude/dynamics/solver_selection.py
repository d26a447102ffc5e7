"""Which solver, and how fine: measured on a short part of the motion, for the tolerance asked for.

Every candidate is tried on the first few turns at a ladder of steps; its errors there, against a much finer
solution, say what it would need over the whole span, and what that would cost by the table of measured costs
(docs/performance.md).  The same scene is always solved in the same way: no clock is read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np

from ..errors import ToleranceError
from ..frames import rotations
from ..kernels import layout
from .angular_rates import max_angular_rates, rates_after
from .arcs import Arc, arcs_by_direction
from .batch_states import Bodies, TorqueProblem
from .momentum import impulse_sums, initial_momenta
from .solver_arguments import SolverArguments
from .solvers import (
    COLLOCATION,
    OUTPUTS,
    RUNGE_KUTTA,
    SPLITTINGS,
    Solver,
    SolverSpan,
    SolverTask,
    SolverWork,
    can_take,
    endless_steps,
)

# Radians of the fastest motion: what a trial runs over, and the steps it tries.
RADIANS_OF_TRIAL = 40.0
STEPS_RADIANS = (5.6, 4.0, 2.8, 2.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.125)
TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12, 1e-14)
REFERENCE_STEP_RADIANS, REFERENCE_TOLERANCE = 0.5, 1e-15
# Steps that solvers may choose to make of it: far more than any torque that can be followed over the span.
MAX_STEPS_OF_TRIAL = 2e5
# Errors below this are rounding: no order is read off them.
ROUNDING = 3e-13
# Of the tolerance, what the estimate is to be: the rest is for what the trial did not meet.
SHARE_OF_TOLERANCE = 0.25
# The power of time that errors are taken to grow with: cautious, since the order is high.
# A trial on a short arc corrects it where spans are long.
ERROR_GROWTH_EXPONENT = 1.5

# Measured costs, ns (tests/benchmarks/torques_table.py costs).
DRIFT_SYMMETRIC_NS, DRIFT_GENERAL_NS, KICK_NS = 60.0, 330.0, 110.0
SWEEP_NS, COLLOCATION_STEP_NS = 190.0, 400.0
STAGE_NS = 85.0
EFFECT_NS = 15.0  # each further effect, wherever the torque is computed
SECONDS_PER_SAMPLE = 4e-6  # each instant: a step of its own


@dataclass(frozen=True)
class Candidate:
    """What a solver would need.

    Attributes
    ----------
    solver : Solver
    setting : step, s, or tolerance of a step, rad
    error : rad, predicted at the end of the span
    seconds : predicted cost
    """

    solver: Solver
    setting: float
    error: float = 0.0
    seconds: float = 0.0


def candidates(problem: TorqueProblem, body: Bodies) -> list[Candidate]:
    """All solvers that can be used for one body, with their settings, cheapest first.

    Raises
    ------
    ToleranceError : a body that turns too fast for any steps.
    """
    span = problem.max_abs_seconds
    arc, added = _fastest_arc(problem, body)
    spinning = replace(body, rate=rates_after(body, added))
    rate = float(max_angular_rates(problem.template, spinning, arc.torques)[0])
    if rate == 0.0 or span == 0.0:
        return [Candidate(COLLOCATION, max(span, 1.0))]
    if not RADIANS_OF_TRIAL / rate > 0.0:
        raise ToleranceError(
            f"effects: the angular rate of this body, {rate:.3g} rad/s, is too high to integrate numerically"
        )
    trial = TrialRun(problem, body, arc, rate, added)
    tried: list[Candidate] = []
    for solver in (COLLOCATION, *reversed(SPLITTINGS), RUNGE_KUTTA):
        if problem.kind in (None, solver.kind):
            reached = [one.seconds for one in tried if one.error <= problem.tolerance]
            least = min(reached, default=np.inf)
            if solver in SPLITTINGS and problem.kind is None and _are_hopeless(tried, least):
                continue
            candidate = trial.candidate(solver, least)
            tried += [candidate] if candidate is not None else []
    # those that reach the tolerance by their cost, then the others by their error
    limit = problem.tolerance
    return sorted(tried, key=lambda c: (c.error > limit, c.seconds if c.error <= limit else c.error))


def _fastest_arc(problem: TorqueProblem, body: Bodies) -> tuple[Arc, np.ndarray]:
    """The arc that solvers are tried on, and the momentum (1, 3), inertial, that impulses add by its start.

    That in which the body turns fastest, of these that with the most torques, of these the longest.
    """
    starts = []
    for path in arcs_by_direction(problem.template, problem.torques, problem.impulses):
        sums, count = impulse_sums([impulse for arc in path for impulse in arc.impulses], body.attitude), 0
        for arc in path:
            count += len(arc.impulses)
            starts.append((arc, sums[count]))
    torques = max((arc.torques for arc, _ in starts), key=len)
    at_rest = replace(body, rate=np.zeros((1, 3)))
    slowest = float(max_angular_rates(problem.template, at_rest, torques)[0])
    speeds = [max(float(np.linalg.norm(rates_after(body, added))), slowest) for _, added in starts]
    ranks = [(speed, len(arc.torques), arc.length) for speed, (arc, _) in zip(speeds, starts, strict=True)]
    return starts[ranks.index(max(ranks))]


def _are_hopeless(tried: Sequence[Candidate], least: float) -> bool:
    """Whether two splittings, those with the smallest errors, cost far too much: others need no trial."""
    costs = [candidate.seconds for candidate in tried if candidate.solver in SPLITTINGS]
    return len(costs) > 1 and min(costs) > 3.0 * least


class TrialRun:
    """The first few turns of one body on an arc, and a fine solution of them."""

    def __init__(self, problem: TorqueProblem, body: Bodies, arc: Arc, rate: float, added: np.ndarray):
        self.problem, self.body, self.arc, self.rate = problem, body, arc, rate
        whole = problem.max_abs_seconds
        self.span = min(whole, arc.length or whole, RADIANS_OF_TRIAL / rate)
        self.growth = max(1.0, whole / self.span)
        self.aim = SHARE_OF_TOLERANCE * problem.tolerance / self.growth**ERROR_GROWTH_EXPONENT
        self.momentum = initial_momenta(problem.template, body, arc.torques) + added
        self._arguments: dict[object, SolverArguments] = {}
        paths = arcs_by_direction(problem.template, problem.torques, problem.impulses)
        self._arcs = {each.torques: each for path in paths for each in path}.values()
        self.reference = self._reference()

    def arguments(self, solver: Solver, arc: Arc | None = None) -> SolverArguments:
        """Return what a solver reads on an arc, without one on that of the trial; several share it."""
        torques = (self.arc if arc is None else arc).torques
        key = solver.prepare, *map(id, torques)
        if key not in self._arguments:
            self._arguments[key] = solver.prepare(self.problem.template, self.body, torques)
        return self._arguments[key]

    def _reference(self) -> np.ndarray:
        if self.arguments(COLLOCATION).is_smooth:
            rows, work = self.run(COLLOCATION, REFERENCE_STEP_RADIANS / self.rate)
            if not work.failed[0] and np.isfinite(rows).all():
                return rows
        rows, work = self.run(RUNGE_KUTTA, REFERENCE_TOLERANCE)
        if work.failed[0]:
            raise endless_steps(REFERENCE_TOLERANCE)
        return rows

    def run(self, solver: Solver, setting: float) -> tuple[np.ndarray, SolverWork]:
        """(OUTPUTS,) at the end of the trial, and the work."""
        arguments, arc = self.arguments(solver), self.arc
        stop = arc.start + float(np.copysign(self.span, arc.stop - arc.start))
        states = arguments.states(self.body.attitude, self.momentum)
        out = np.full((1, OUTPUTS, 1), np.nan)
        span = SolverSpan(arc.start, stop, np.array([[stop], [0.0]]), max_steps=MAX_STEPS_OF_TRIAL)
        task = SolverTask(arguments, np.array([0]), states, span, np.array([setting]), out)
        work = solver.integrate(task, arc.torques)
        return out[0, :, 0], work

    def error(self, rows: np.ndarray) -> float:
        """rad: of the attitude, or of the momentum relative to it, whichever is greater."""
        angle = float(rotations.angle_between(self.reference[:4], rows[:4]))
        size = float(np.linalg.norm(self.reference[7:]))
        relative = float(np.linalg.norm(self.reference[7:] - rows[7:])) / size if size else 0.0
        return max(angle, relative, 1e-17)

    def candidate(self, solver: Solver, least: float) -> Candidate | None:
        """What the solver would need, read off a ladder of settings; None where it cannot take the torques.

        The ladder is that of the coarser solution by which the error of the answer will be estimated.

        least : s, cost of the best before: from there on finer settings are not tried, but extrapolated
        """
        arguments = self.arguments(solver)
        if not self._can_take(solver):
            return None
        settings: list[float] = []
        errors: list[float] = []
        cost, aim = 0.0, 0.0
        for setting in self._ladder(solver, least):
            rows, work = self.run(solver, setting)
            if work.failed[0] and solver is RUNGE_KUTTA:
                break
            if work.failed[0] or not np.isfinite(rows).all():
                continue
            settings.append(setting)
            errors.append(self.error(rows))
            cost = _cost(solver, arguments, int(work.steps[0]), int(work.torques[0])) * self.growth
            stride = 0.0 if solver is RUNGE_KUTTA else setting * self.rate / solver.coarser
            aim = self.aim * float(solver.gain(arguments.is_smooth, self.problem.tolerance, stride))
            if errors[-1] <= aim or errors[-1] < ROUNDING or cost >= least:
                break
        if not settings:
            return None
        setting, error, order = _extrapolated(solver, settings, errors, aim)
        finer = solver.coarser * settings[-1] / setting
        cost *= finer ** (0.125 if solver is RUNGE_KUTTA else 1.0)
        error *= self.growth**ERROR_GROWTH_EXPONENT / solver.coarser**order
        return Candidate(solver, setting / solver.coarser, error, cost)

    def _can_take(self, solver: Solver) -> bool:
        """Whether it can on every arc."""
        if solver.kind != "splitting":
            return True
        return all(can_take(solver, self.arguments(solver, arc))[0] for arc in self._arcs)

    def _ladder(self, solver: Solver, least: float) -> tuple[float, ...]:
        """Settings from coarse to fine; where there is a best before, from what costs half as much on."""
        if solver is RUNGE_KUTTA:
            return TOLERANCES if least == np.inf else TOLERANCES[2:3]
        steps = tuple(s / self.rate for s in STEPS_RADIANS if s / self.rate <= self.span) or (self.span,)
        if least == np.inf:
            return steps
        cost = _cost(solver, self.arguments(solver), 1, solver.stages)
        equal = self.growth * self.span * cost / least  # the step that costs as much
        return tuple(step for step in steps if 0.5 * equal <= step <= 2.0 * equal) or steps[:1]


def _extrapolated(
    solver: Solver, settings: list[float], errors: list[float], aim: float
) -> tuple[float, float, float]:
    """The setting whose error is the one aimed at, its error, and the order seen last, or the one known."""
    setting, error = settings[-1], errors[-1]
    order = float(solver.order)
    if len(errors) > 1 and errors[-2] > errors[-1] > ROUNDING:
        seen = log(errors[-2] / errors[-1]) / log(settings[-2] / settings[-1])
        order = min(max(seen, 1.0), 16.0)
    least = 1e-14 if solver is RUNGE_KUTTA else 0.02 * setting
    coarsest = settings[-2] if len(settings) > 1 else setting
    needed = min(max(setting * (aim / error) ** (1.0 / order), least), coarsest)
    return needed, error * (needed / setting) ** order, order


def _cost(solver: Solver, arguments: SolverArguments, steps: int, torques: int) -> float:
    """s, by the table."""
    effects = EFFECT_NS * max(0, arguments.effects.shape[1] - 1)
    if solver is COLLOCATION:
        ns = steps * COLLOCATION_STEP_NS + torques / layout.NODES * (SWEEP_NS + effects)
    elif solver is RUNGE_KUTTA:
        ns = torques * (STAGE_NS + effects)
    else:
        drift = DRIFT_SYMMETRIC_NS if arguments.symmetric[0] else DRIFT_GENERAL_NS
        ns = torques * (drift + KICK_NS + effects) + steps * drift
    return 1e-9 * ns

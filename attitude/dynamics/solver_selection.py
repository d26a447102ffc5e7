"""Which solver, and how fine: measured on a short part of the motion, for the tolerance asked for.

Every candidate follows the first few turns at a ladder of steps; its errors there, against a much finer
solution, say what it would need over the whole span, and what that would cost by the table of measured costs
(docs/performance.md).  The same scene is always solved in the same way: no clock is read.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np

from ..errors import ToleranceError
from ..frames import rotations
from ..kernels import layout
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse, TorqueModel
from .arcs import Arc
from .momentum import gained, initial_momentum
from .solver_arguments import SolverArguments
from .solvers import COLLOCATION, OUTPUTS, RUNGE_KUTTA, SPLITTINGS, Part, Solver, Work, can_take

# Radians of the fastest motion: what the pilot follows, and the steps it tries.
PILOT = 40.0
STEPS = (5.6, 4.0, 2.8, 2.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.125)
TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12, 1e-14)
FINEST = 0.5
# Steps that solvers may choose to make of it: far more than any torque that can be followed over the span.
MOST_STEPS = 2e5
# Errors below this are rounding: no order is read off them.
ROUNDING = 3e-13
# Of the tolerance, what the estimate is to be: the rest is for what the pilot did not meet.
SHARE = 0.25
# The power of time that errors are taken to grow with: cautious, since the order is high.
# A rehearsal corrects it where spans are long.
GROWTH = 1.5

# Measured costs, ns (docs/design/torque-solvers.md).
DRIFT_SYMMETRIC, DRIFT_GENERAL, KICK = 60.0, 330.0, 110.0
SWEEP, COLLOCATION_STEP = 190.0, 400.0
STAGE = 85.0
SAMPLE = 4e-6  # s, each instant: a step of its own
ROW = 15.0  # each further effect, wherever the torque is computed


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
    error: float
    seconds: float


def pace(
    initial_state: InitialState, torques: Sequence[TorqueModel], kicks: Sequence[AppliedImpulse] = ()
) -> float:
    """rad/s of the fastest motion there is: the spin at the epoch and after the impulses, what the torques
    could make of it, and the orbit.
    """
    rates = initial_state.rate + _rates(initial_state, np.array(gained(kicks, initial_state.attitude)))
    fastest = rates[np.argmax(np.linalg.norm(rates, axis=1))]
    size = sum(torque.size(replace(initial_state, rate=fastest)) for torque in torques)
    orbit = 2.0 * np.pi / initial_state.course.period if initial_state.course is not None else 0.0
    own = float(np.linalg.norm(fastest))
    momentum = float(np.linalg.norm(rates @ initial_state.body.tensor, axis=1).max())
    with np.errstate(over="ignore"):  # infinite for a body that is thin enough
        swung = float(np.sqrt(size / initial_state.moments.min()))
    return max(own, momentum / float(initial_state.moments.max()), swung, orbit)


def _rates(initial_state: InitialState, momenta: np.ndarray) -> np.ndarray:
    """(k, 3) rad/s, body: of inertial momenta (k, 3) at the epoch's attitude."""
    back = rotations.rotate(rotations.conjugate(initial_state.attitude), momenta)
    rates: np.ndarray = np.linalg.solve(initial_state.body.tensor, back.T).T
    return rates


def tried_leg(initial_state: InitialState, directions: Sequence[Sequence[Arc]]) -> tuple[Arc, np.ndarray]:
    """The leg that solvers are tried on, and the momentum (3,), inertial, that impulses add by its start.

    That in which the body turns fastest, of these that with the most torques, of these the longest.
    """
    starts = []
    for legs in directions:
        met = [kick for leg in legs for kick in leg.kicks]
        sums, count = gained(met, initial_state.attitude), 0
        for leg in legs:
            count += len(leg.kicks)
            starts.append((leg, sums[count]))
    rates = initial_state.rate + _rates(initial_state, np.array([added for _, added in starts]))
    torques = max((leg.torques for leg, _ in starts), key=len)
    slow = pace(replace(initial_state, rate=np.zeros(3)), torques)
    speeds = np.maximum(np.linalg.norm(rates, axis=1), slow).tolist()
    places = range(len(starts))
    return starts[max(places, key=lambda i: (speeds[i], len(starts[i][0].torques), starts[i][0].length))]


def candidates(
    initial_state: InitialState,
    leg: Arc,
    span: float,
    tolerance: float,
    kind: str | None,
    added: np.ndarray | None = None,
) -> list[Candidate]:
    """All that can be used, cheapest first; `kind` names one sort of solver, None asks for any.

    Parameters
    ----------
    leg : whose torques are tried, from the state at the epoch
    span : s, of the whole; tolerance : rad at its end
    added : (3,), N m s, inertial: momentum that the body has besides, from impulses
    """
    added = np.zeros(3) if added is None else added
    rate = pace(
        replace(initial_state, rate=initial_state.rate + _rates(initial_state, added[None])[0]), leg.torques
    )
    if rate == 0.0 or span == 0.0:
        return [Candidate(COLLOCATION, max(span, 1.0), 0.0, 0.0)]
    if not PILOT / rate > 0.0:
        raise ToleranceError(
            f"effects: this body turns at {rate:.3g} rad/s, which no step through time follows"
        )
    pilot = _Pilot(initial_state, leg, rate, span, tolerance, added)
    found: list[Candidate] = []
    for solver in (COLLOCATION, *reversed(SPLITTINGS), RUNGE_KUTTA):
        if kind in (None, solver.kind):
            reached = [one.seconds for one in found if one.error <= tolerance]
            best = min(reached, default=np.inf)
            if solver in SPLITTINGS and kind is None and _are_hopeless(found, best):
                continue
            one = pilot.try_out(solver, best)
            found += [one] if one is not None else []
    return sorted(found, key=_merit(tolerance))


def _are_hopeless(found: Sequence[Candidate], best: float) -> bool:
    """Whether two splittings, those with the smallest errors, were far too dear: others need no trial."""
    tried = [one.seconds for one in found if one.solver in SPLITTINGS]
    return len(tried) > 1 and min(tried) > 3.0 * best


def _merit(tolerance: float) -> Callable[[Candidate], tuple[bool, float]]:
    """Those that reach the tolerance by their cost, then the others by their error."""
    return lambda one: (one.error > tolerance, one.seconds if one.error <= tolerance else one.error)


class _Pilot:
    """The first few turns, and a fine solution of them."""

    def __init__(
        self,
        initial_state: InitialState,
        leg: Arc,
        rate: float,
        span: float,
        tolerance: float,
        added: np.ndarray,
    ):
        self.initial_state, self.leg, self.rate = initial_state, leg, rate
        self.span = min(span, leg.length or span, PILOT / rate)
        self.growth = max(1.0, span / self.span)
        self.tolerance = tolerance
        self.wanted = SHARE * tolerance / self.growth**GROWTH
        self.momentum = initial_momentum(initial_state, leg.torques) + added
        self._prepared: dict[object, SolverArguments] = {}
        self.truth = self._truth()

    def prepared(self, solver: Solver) -> SolverArguments:
        """The arrays of a solver, which several share."""
        if solver.prepare not in self._prepared:
            self._prepared[solver.prepare] = solver.prepare(self.initial_state, self.leg.torques)
        return self._prepared[solver.prepare]

    def _truth(self) -> np.ndarray:
        stepped = self.prepared(COLLOCATION)
        if stepped.is_smooth:
            truth, work = self.march(COLLOCATION, stepped, FINEST / self.rate)
            if not work.failed and np.isfinite(truth).all():
                return truth
        return self.march(RUNGE_KUTTA, self.prepared(RUNGE_KUTTA), 1e-15)[0]

    def march(self, solver: Solver, stepped: SolverArguments, setting: float) -> tuple[np.ndarray, Work]:
        stop = self.leg.start + np.copysign(self.span, self.leg.stop - self.leg.start)
        state = stepped.state(self.initial_state.attitude, self.momentum)
        out = np.full((OUTPUTS, 1), np.nan)
        part = Part(self.leg.start, float(stop), np.array([stop]), np.zeros(1), most=MOST_STEPS)
        work = solver.follow(self.leg.torques, stepped, state, part, setting, out)
        return out[:, 0], work

    def error(self, answer: np.ndarray) -> float:
        """rad: of the attitude, or of the momentum relative to it, whichever is greater."""
        turned = float(rotations.angle_between(self.truth[:4], answer[:4]))
        size = float(np.linalg.norm(self.truth[7:]))
        return max(turned, float(np.linalg.norm(self.truth[7:] - answer[7:])) / size if size else 0.0, 1e-17)

    def try_out(self, solver: Solver, best: float) -> Candidate | None:
        """What the solver would need, read off a ladder of settings.

        The ladder is that of the coarser solution by which the error of the answer will be estimated.

        best : s, of the best found before: from there on finer settings are not tried, but reckoned
        """
        stepped = self.prepared(solver)
        if not can_take(solver, stepped):
            return None
        settings: list[float] = []
        errors: list[float] = []
        cost = 0.0
        for setting in self._ladder(solver, stepped, best):
            try:
                answer, work = self.march(solver, stepped, setting)
            except ToleranceError:
                break
            if work.failed or not np.isfinite(answer).all():
                continue
            settings.append(setting)
            errors.append(self.error(answer))
            cost = _cost(solver, stepped, work) * self.growth
            aim = self._aim(solver, stepped, setting)
            if errors[-1] <= aim or errors[-1] < ROUNDING or cost >= best:
                break
        if not settings:
            return None
        setting, error, order = _reckoned(solver, settings, errors, aim)
        finer = solver.coarser * settings[-1] / setting
        cost *= finer ** (0.125 if solver is RUNGE_KUTTA else 1.0)
        error *= self.growth**GROWTH / solver.coarser**order
        return Candidate(solver, setting / solver.coarser, error, cost)

    def _aim(self, solver: Solver, stepped: SolverArguments, setting: float) -> float:
        """rad: what the coarser solution may be off, for the estimate to be what is wanted at the end."""
        stride = 0.0 if solver is RUNGE_KUTTA else setting * self.rate / solver.coarser
        return self.wanted * solver.gain(stepped.is_smooth, self.tolerance, stride)

    def _ladder(self, solver: Solver, stepped: SolverArguments, best: float) -> tuple[float, ...]:
        """From coarse to fine; where there is a best before, from what costs half as much on."""
        if solver is RUNGE_KUTTA:
            return TOLERANCES if best == np.inf else TOLERANCES[2:3]
        steps = tuple(step / self.rate for step in STEPS if step / self.rate <= self.span) or (self.span,)
        if best == np.inf:
            return steps
        one = _cost(solver, stepped, Work(1, solver.stages, 0))
        equal = self.growth * self.span * one / best  # the step that costs as much
        return tuple(step for step in steps if step >= 0.5 * equal and step <= 2.0 * equal) or steps[:1]


def _reckoned(
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
    wanted = min(max(setting * (aim / error) ** (1.0 / order), least), coarsest)
    return wanted, error * (wanted / setting) ** order, order


def _cost(solver: Solver, stepped: SolverArguments, work: Work) -> float:
    """s, by the table."""
    rows = ROW * max(0, len(stepped.world[0]) - 1)
    if solver is COLLOCATION:
        ns = work.steps * COLLOCATION_STEP + work.torques / layout.NODES * (SWEEP + rows)
    elif solver is RUNGE_KUTTA:
        ns = work.torques * (STAGE + rows)
    else:
        drift = DRIFT_SYMMETRIC if stepped.symmetric else DRIFT_GENERAL
        ns = work.torques * (drift + KICK + rows) + work.steps * drift
    return 1e-9 * ns

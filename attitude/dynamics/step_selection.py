"""How long steps may be: tried on a short part of the motion, for the tolerance asked for.

The first radians are solved in pairs of journeys, the second in steps a little longer, as the whole span will
be (`error_estimate`), at ever shorter steps until the error that this foretells is small enough.  The same
scene is always solved in the same way: no clock is read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..errors import ToleranceError
from ..kernels.layout import NODES, EffectCode
from ..kernels.solvers.plate_layout import ARC_NODES
from ..problem.torque_model import CachedTorque
from . import plate_solver, solver, solver_cost
from .angular_rates import max_angular_rates, rates_after
from .arcs import Arc
from .batch_states import Bodies, TorqueProblem
from .error_estimate import MULTIPLE_OF_ROUNDING, angles, rounding_of, safety_factor
from .momentum import impulse_sums, initial_momenta
from .plate_arguments import edges_per_turn
from .solver import LEAST_DECAY, MIN_STEPS, OUTPUTS, SolverTask, SolverWork, StepSetting, take_steps
from .solver_arguments import SolverArguments, most_symmetric

MAX_RADIANS = {True: 12.0, False: 8.0}  # of the fastest motion, in a step of symmetric bodies and others
SHARE_OF_MIN_STEPS = 0.5  # of the steps that every arc has, those in a trial: the longest are tried too
# Steps that a trial may be cut into: far more than any torque that can be followed over the span.
MAX_STEPS_OF_TRIAL = 2e4
MAX_STEP_FACTOR = 0.9  # from one trial to the next: with more, the number of steps would hardly change
SHARE_OF_TOLERANCE = 0.25  # what the estimate is to be: the rest is for what the trial did not meet
# Differences below this are rounding of attitudes, which shorter steps would not make smaller.
ROUNDING = 3e-15


@dataclass(frozen=True)
class Candidate:
    """Steps that a body would need.

    Attributes
    ----------
    step : s
    decay : what a step may be off by, as `StepSetting` has it
    error : rad, predicted at the end of the span; rounding : the part of it that no steps make smaller
    seconds : predicted cost, but for samples; sample_seconds : of each
    dense_step : s, up to which the polynomial within a step is exact enough to be read; 0 if none is
    ends_at_edges : whether steps are arcs between the edges of plates; `step` is their longest then, rad
    min_steps : of every arc, however short
    """

    step: float
    decay: float = 0.0
    error: float = 0.0
    rounding: float = 0.0
    seconds: float = 0.0
    sample_seconds: float = solver_cost.SAMPLE
    dense_step: float = 0.0
    ends_at_edges: bool = False
    min_steps: float = MIN_STEPS

    @property
    def solver(self) -> str:
        """Name of the solver."""
        return plate_solver.NAME if self.ends_at_edges else solver.NAME

    @property
    def order(self) -> int:
        """Order of its error in the step."""
        return 2 * ARC_NODES if self.ends_at_edges else solver.ORDER

    @property
    def dense_coarsely(self) -> bool:
        """Whether the coarser solution may be read off its polynomials too: with room, as it has no trial."""
        return self.dense_step >= 1.15 * solver.STRIDE * self.step

    def settings(self, samples: int, span: float) -> tuple[Candidate, bool]:
        """The candidate for so many samples over a span (s), and whether they are read off polynomials.

        Steps are made shorter for it where the samples are so many that this costs less.
        """
        if self.dense_step <= 0.0:
            return self, False
        if self.dense_step >= self.step:
            return self, True
        more = span / self.dense_step - span / self.step
        if more > 0.8 * samples:
            return self, False
        return replace(self, step=self.dense_step), True

    def shortened(self, share: float) -> Candidate:
        """The candidate with steps of a share of the length, and as many more in arcs of few."""
        return replace(self, step=self.step * share, min_steps=self.min_steps / share)


def candidate_of(problem: TorqueProblem, body: Bodies, wants_dense: bool = True) -> Candidate:
    """The steps that one body needs.

    wants_dense : whether instants are so many that they may be read off polynomials
    """
    span = problem.max_abs_seconds
    arc, added = _fastest_arc(problem, body)
    spinning = replace(body, rate=rates_after(body, added)) if added.any() else body
    rate = float(max_angular_rates(problem.template, spinning, arc.torques)[0])
    if rate == 0.0 or span / MIN_STEPS == 0.0:  # of no length, or of one that no double divides
        return Candidate(max(span, 1.0), LEAST_DECAY)
    edges = edges_per_turn(problem.torques)
    if edges:
        return _between_edges(problem, rate, edges)
    return _Trial(problem, body, arc, rate, added).candidate(wants_dense)


def _between_edges(problem: TorqueProblem, rate: float, edges: int) -> Candidate:
    """Arcs between the edges of plates: no tolerance needs others, and none is cheaper with others."""
    angle, longest = rate * problem.max_abs_seconds, 0.5  # rad, of an arc
    arcs = angle * (edges / (2.0 * np.pi) + 0.6 / longest)  # the longest turn through 0.6 of the angle
    rounding = float(rounding_of(angle, arcs, carried=True))
    return Candidate(
        longest,
        np.inf,
        error=rounding,
        rounding=rounding,
        seconds=solver_cost.of_arcs(arcs, edges),
        sample_seconds=solver_cost.ARC_SAMPLE,
        ends_at_edges=True,
    )


def _fastest_arc(problem: TorqueProblem, body: Bodies) -> tuple[Arc, np.ndarray]:
    """The arc that steps are tried on, and the momentum (1, 3), inertial, that impulses add by its start.

    That in which the body turns fastest, of these that with the most torques, of these the longest.
    """
    starts = []
    for path in problem.arcs:
        sums, count = impulse_sums([impulse for arc in path for impulse in arc.impulses], body.attitude), 0
        for arc in path:
            count += len(arc.impulses)
            starts.append((arc, sums[count]))
    if len(starts) == 1:
        return starts[0]
    torques = max((arc.torques for arc, _ in starts), key=len)
    at_rest = replace(body, rate=np.zeros((1, 3)))
    slowest = float(max_angular_rates(problem.template, at_rest, torques)[0])
    speeds = [max(float(np.linalg.norm(rates_after(body, added))), slowest) for _, added in starts]
    ranks = [(speed, len(arc.torques), arc.length) for speed, (arc, _) in zip(speeds, starts, strict=True)]
    return starts[ranks.index(max(ranks))]


class _Pair(NamedTuple):
    """Journeys over the trial in a candidate's steps and in longer ones.

    Attributes
    ----------
    difference : rad, infinite where either failed; steps, sweeps : of the first
    """

    candidate: Candidate
    difference: float
    steps: int
    sweeps: int

    def is_rounding(self, shorter: float, most: float) -> bool:
        """Whether the difference is rounding that the motion multiplies, no more than `most`.

        It is where that of shorter steps is no less than half of it: by the order it would fall to a tenth.
        """
        return 0.5 * self.difference <= shorter <= most and self.difference <= most


class _Trial:
    """The first few turns of one body on an arc."""

    def __init__(self, problem: TorqueProblem, body: Bodies, arc: Arc, rate: float, added: np.ndarray):
        self.tolerance, self.rate = problem.tolerance, rate
        self.torques: tuple[CachedTorque, ...] = arc.torques
        one = most_symmetric(problem.template, body, arc.torques)
        self.arguments = one.repeated(2)
        self.whole = problem.max_abs_seconds
        self.span = min(self.whole, arc.length or self.whole, 40.0 / rate)  # of 40 rad
        self.start, self.stop = arc.start, arc.start + float(np.copysign(self.span, arc.stop - arc.start))
        self.compared = np.linspace(self.start, self.stop, 4)[1:]
        momentum = initial_momenta(problem.template, body, arc.torques) + added
        self.states = np.repeat(one.states(body.attitude, momentum), 2, axis=0)
        self.smooth = self.arguments.is_smooth
        self.safety = safety_factor(self.smooth)
        follows_orbit = self.arguments.codes & {EffectCode.GRAVITY_GRADIENT, EffectCode.MAGNETIC}
        self.orbit_path = problem.template.orbit_path if follows_orbit else None
        self.refined: SolverArguments | None = None
        if problem.refined is not problem:
            self.refined = most_symmetric(problem.refined.template, body, arc.torques)

    def run(
        self,
        candidate: Candidate,
        instants: np.ndarray,
        coarsely: Sequence[bool],
        dense: bool | np.ndarray = False,
        arguments: SolverArguments | None = None,
    ) -> tuple[np.ndarray, SolverWork]:
        """(k, OUTPUTS, m) at the instants, of one or two journeys at once, and their work.

        arguments : those of another orbit
        """
        k, at = len(coarsely), np.array([instants, np.zeros_like(instants)])
        out, each = np.full((k, OUTPUTS, instants.size), np.nan), np.ones(k)
        least = SHARE_OF_MIN_STEPS * candidate.min_steps
        setting = StepSetting(
            candidate.step * each, candidate.decay * each, dense, np.array(coarsely), min_steps=least
        )
        task = SolverTask(
            self.arguments if arguments is None else arguments,
            np.arange(k),
            self.states.copy(),
            self.start,
            self.stop,
            at,
            setting,
            out,
            MAX_STEPS_OF_TRIAL,
        )
        return out, take_steps(task, self.torques)

    def candidate(self, wants_dense: bool) -> Candidate:
        """Steps in which the difference of two journeys, and its growth, keep a share of the tolerance."""
        settled, growth = self._settled(), self.whole / self.span
        now, effects = settled.candidate, self.arguments.effects.shape[1]
        rounding = self._rounding(now, self.whole)
        dense_step = self._dense_step(now) if wants_dense else 0.0
        return replace(
            now,
            error=self.safety * settled.difference * growth + rounding,
            rounding=rounding,
            seconds=solver_cost.of_steps(growth * settled.steps, growth * settled.sweeps, effects),
            sample_seconds=solver_cost.DENSE_SAMPLE if dense_step >= now.step else solver_cost.SAMPLE,
            dense_step=dense_step,
        )

    def _settled(self) -> _Pair:
        """The first pair, in ever shorter steps, that differs by no more than it may."""
        growth = (self.whole / self.span) ** 1.5  # of errors: cautious, since the order is high
        aim = SHARE_OF_TOLERANCE * self.tolerance / growth / self.safety
        now = Candidate(self._longest_step(), aim if self.smooth else max(aim, LEAST_DECAY))
        aim = max(aim, SHARE_OF_TOLERANCE * self._difference_of_orbits(now) / self.safety)
        most = MULTIPLE_OF_ROUNDING * self._rounding(now, self.span)
        before: _Pair | None = None
        for _ in range(16):
            pair = self._pair(now)
            if pair.steps > MAX_STEPS_OF_TRIAL:
                if before is None:
                    raise ToleranceError(
                        "tolerance: the steps of the trial have no end: the torque is far too great for the "
                        "body, or not continuous anywhere"
                    )
                return before  # shorter ones are below rounding
            # pieces that steps have to be cut into, for their sweeps to settle, cost more than shorter steps
            is_cut = self.smooth and pair.steps > 1.2 * self.span / self._step_made(now) + 2.0
            is_least = not self.smooth and now.decay <= LEAST_DECAY
            if (pair.difference <= max(aim, ROUNDING) and not is_cut) or is_least:
                return pair
            if before is not None and self.smooth and before.is_rounding(pair.difference, most):
                return before
            before = pair if np.isfinite(pair.difference) and not is_cut else before
            now = self._finer(pair, aim)
        return pair._replace(candidate=now)

    def _finer(self, pair: _Pair, aim: float) -> Candidate:
        """Steps in which the difference falls to half the aim; where torques break, with the step itself."""
        order = 20.0 if self.smooth else 1.0
        ratio = (0.5 * aim / pair.difference) ** (1.0 / order) if pair.difference > aim else 1.0
        now = pair.candidate.shortened(min(MAX_STEP_FACTOR, max(0.4, ratio)))
        if self.smooth:
            return now
        return replace(now, decay=max(LEAST_DECAY, now.decay * min(0.3, max(1e-3, ratio))))

    def _rounding(self, candidate: Candidate, span: float) -> float:
        """rad, over so many seconds."""
        return float(rounding_of(self.rate * span, span / candidate.step, self.arguments.symmetric[0]))

    def _longest_step(self) -> float:
        """The longest steps, s, that are tried: a part of the span, of turns, and of the turn on an orbit.

        Under torques that depend on the place, 3.5 rad of the orbit where it is fastest: a longer step may
        pass a pericentre unseen, and so may the coarser solution's.
        """
        longest = MAX_RADIANS[bool(self.arguments.symmetric[0])]
        step = min(longest / self.rate, self.whole / MIN_STEPS)
        path = self.orbit_path
        return step if path is None else min(step, 3.5 / path.max_rate)

    def _step_made(self, candidate: Candidate) -> float:
        """The length of the trial's steps, s."""
        return min(candidate.step, self.span / (SHARE_OF_MIN_STEPS * candidate.min_steps))

    def _pair(self, candidate: Candidate) -> _Pair:
        """Two journeys, the second in longer steps.

        Compared at several instants: at one alone the two may agree by chance.
        """
        out, work = self.run(candidate, self.compared, (False, True))
        difference = np.inf if work.failed.any() else difference_of(*out)
        return _Pair(candidate, difference, int(work.steps[0]), int(work.sweeps[0]))

    def _difference_of_orbits(self, candidate: Candidate) -> float:
        """rad, at the end, by what the orbit's path is off: its jumps are not followed by shorter steps."""
        if self.refined is None:
            return 0.0
        end = np.array([self.stop])
        each = (self.run(candidate, end, (False,), arguments=a)[0][0] for a in (None, self.refined))
        off = difference_of(*each)
        return off if np.isfinite(off) else 0.0

    def _dense_step(self, candidate: Candidate) -> float:
        """The longest steps, s, within which polynomials keep a tenth of the tolerance."""
        at = np.linspace(self.start, self.stop, 25)[1:]
        off = difference_of(*self.run(candidate, at, (False, False), np.array([False, True]))[0])
        share = 0.1 * self.tolerance / (safety_factor(smooth=True) * max(off, ROUNDING))
        return self._step_made(candidate) * ((1.0 if share >= 1.0 else 0.5) * share) ** (1.0 / NODES)


def difference_of(one: np.ndarray, other: np.ndarray) -> float:
    """rad, the greatest: of attitudes, or of the momenta relative to them; infinite where one is no number.

    one, other : (OUTPUTS, m)
    """
    angle = float(angles(one[None, :4], other[None, :4]).max())
    change, size = one[7:] - other[7:], float((one[7:] * one[7:]).sum(axis=0).max())
    relative = float((change * change).sum(axis=0).max()) / size if size else 0.0
    return max(angle, float(np.sqrt(relative))) if np.isfinite(angle + relative) else np.inf

"""Motion under torques, of one body or many: steps for the tolerance, and the attitudes.

One body is a block of one.  For many how fine steps are is chosen once; every body's error is estimated by
itself, and one whose estimate stays above the tolerance is solved as a scene of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import ToleranceError, emit_warning
from ..times.instants import Instants
from .angular_rates import max_angular_rates
from .arc_integration import two_part
from .batch_states import Bodies, TorqueProblem, named
from .error_estimate import (
    Comparison,
    compare,
    compared_instants,
    estimate,
    kept_spans,
)
from .solver import OUTPUTS, StepSetting
from .step_selection import MAX_STEP_FACTOR, Candidate, candidate_of

REPORTED_TOLERANCE = 1e-9  # rad, up to which the best answer is said to be good until some instant
STATES = 7  # the first rows, which ensembles keep: attitude (4) and rate (3)
MAX_ATTEMPTS = 6
# Numbers of rows that a block of bodies may fill: it stays in a processor's cache, or not far from it.
MAX_NUMBERS_PER_BLOCK = 1 << 18
SHARE_OF_TOLERANCE = 0.5  # that the estimate is brought to in a rehearsal, and for many bodies


@dataclass(frozen=True)
class TorquedSolution:
    """Attitudes of one body under torques.

    Attributes
    ----------
    rows : (OUTPUTS, m): attitude wxyz (4), rate (3, body), momentum (3, inertial) at the instants
    error : rad, estimated greatest error of an attitude
    candidate : the steps that were used
    steps, sweeps : steps made, and sweeps in them
    kept : s, the part of the span in which the error stays within the tolerance, or that of the best answer
        within REPORTED_TOLERANCE, where it does not in all of it
    """

    rows: np.ndarray
    error: float
    candidate: Candidate
    steps: int
    sweeps: int
    kept: tuple[float, float] | None = None


def choose(problem: TorqueProblem, body: Bodies | None = None, samples: int | None = None) -> Candidate:
    """Steps for the problem's span.

    body : a block of one; without, the scene's own
    samples : instants that are asked for; without, many
    """
    wants_dense = samples is None or samples >= 16  # fewer are reached by steps
    return candidate_of(problem, problem.body if body is None else body, wants_dense)


def solve(
    problem: TorqueProblem, instants: Instants, candidate: Candidate, body: Bodies | None = None
) -> TorquedSolution:
    """Attitudes at the instants, off by less than the tolerance by comparison with a coarser solution.

    Where an error within the tolerance grows beyond it later, which steps however small cannot help, the
    solution says for how long it is within: the motion multiplies errors, or an orbit's table has its own.

    Parameters
    ----------
    candidate : by `choose`
    body : a block of one; without, the scene's own

    Raises
    ------
    ToleranceError : rounding alone is more than the tolerance, which is known before the span is integrated,
        or the tolerance holds at no instant; and the best answer there is is not wanted.
    """
    if candidate.rounding > problem.tolerance and not problem.best:
        raise _out_of_reach(problem, candidate.rounding)
    body, at = problem.body if body is None else body, two_part(instants)
    rows = np.empty((1, OUTPUTS, at.shape[1]))
    (refined,) = refine(problem, body, at, rehearse(problem, body, candidate), rows)
    error = refined.error
    if not np.isfinite(error):
        raise ToleranceError(
            "tolerance: no steps lead to the end of the span: the torque is not finite somewhere in it, or "
            "far too great for the body"
        )
    if not (refined.reached or refined.outgrown or problem.best or problem.refined is not problem):
        raise _out_of_reach(problem, error)
    kept = None if refined.reached or refined.is_kept_throughout(problem) else refined.kept
    return TorquedSolution(rows[0], error, refined.candidate, refined.steps, refined.sweeps, kept)


def _out_of_reach(problem: TorqueProblem, error: float) -> ToleranceError:
    strongest = max(problem.torques, key=lambda torque: torque.size(problem.template)).type
    return ToleranceError(
        f"tolerance: {problem.tolerance:.1e} rad cannot be reached over this span in double precision under "
        f"{strongest}: the least there is about {error:.1e} rad; ask for more than that, or for the best "
        'answer, "best"'
    )


def outgrown(problem: TorqueProblem, kept: tuple[float, float], error: float) -> str:
    """The warning of an error that grows beyond the tolerance: from when on, and why."""
    ends = [f"{end:.6g} s" for end in kept if end != 0.0]
    until = (
        f"kept up to {' and '.join(ends)} from the epoch; beyond, " if ends else "kept at the epoch only: "
    )
    reason = "rounding, and what the motion makes of it, is more"
    if problem.refined is not problem:
        reason = "errors of the interpolated orbit or density, and what the motion makes of them,"
        reason += " are more"
    return f"tolerance: {problem.tolerance:.1e} rad is {until}{reason} (estimated error {error:.1e} rad)"


# -- steps made finer, body by body -----------------------------------------------------------------------


@dataclass
class Refinement:
    """Attempts at one body.

    Attributes
    ----------
    candidate : with the steps of the last attempt where the tolerance is reached, else of the next
    error : rad, the least estimate of the attempts; where one in more steps is greater, that: the least was
        so small by chance
    steps, sweeps : of the last
    reached : whether its estimate is below the tolerance
    kept : s, the part of the span in which the least estimate is, or of the best answer below
        REPORTED_TOLERANCE
    stalled : attempts in more steps that hardly made the estimate smaller
    """

    candidate: Candidate
    error: float = np.inf
    steps: int = 0
    sweeps: int = 0
    reached: bool = False
    kept: tuple[float, float] = (0.0, 0.0)
    stalled: int = 0

    @property
    def outgrown(self) -> bool:
        """Whether the error is within the tolerance for some time, and outgrows it."""
        return not self.reached and self.kept != (0.0, 0.0)

    def is_kept_throughout(self, problem: TorqueProblem) -> bool:
        """Whether the part of the span is all of it."""
        return self.kept[0] <= problem.template.start and self.kept[1] >= problem.template.stop

    def add(
        self, problem: TorqueProblem, compared: Comparison, k: int, error: float, rounding: float
    ) -> bool:
        """Add the attempt of the k-th body compared; returns whether another, finer one is worth making."""
        fine, tolerance = compared.fine, problem.tolerance
        more = fine.steps[k] > self.steps
        if error > 0.5 * self.error and more:
            self.stalled += 1  # of few steps, a setting somewhat finer may make as many again
        self.steps, self.sweeps = int(fine.steps[k]), int(fine.sweeps[k])
        self.reached = error <= tolerance
        if not self.reached:
            self.candidate = finer(self.candidate, tolerance / error, self.steps)
        if error < self.error or (more and np.isfinite(error)):  # more steps are no less exact
            self.error = error
        stalls = 2 if problem.refined is problem else 1  # an orbit's own error is the same in any steps
        worth_making = not self.reached and self.stalled < stalls and rounding <= tolerance
        return worth_making and not (fine.plates and fine.smooth)  # arcs, which end at edges, are short


def refine(
    problem: TorqueProblem,
    bodies: Bodies,
    instants: np.ndarray,
    candidate: Candidate,
    out: np.ndarray,
    attempts: int = MAX_ATTEMPTS,
) -> list[Refinement]:
    """Finer and finer until each estimate is below the tolerance, twice has hardly fallen, or is rounding.

    out : (n, k, m), written where an estimate is the least of the attempts: the first k of `Solution.rows`
    """
    angles, momenta = _turned_and_momenta(problem, bodies)
    chosen, dense = candidate.settings(instants.shape[1], problem.max_abs_seconds)
    refinements = [Refinement(chosen) for _ in range(len(bodies))]
    left = np.arange(len(bodies))
    for _ in range(attempts):
        if not left.size:
            break
        now, part = [refinements[i] for i in left], bodies if left.size == len(bodies) else bodies[left]
        setting = _setting([one.candidate for one in now], momenta[left])
        setting = setting._replace(dense=dense, dense_coarsely=dense and chosen.dense_coarsely)
        compared = compare(problem, part, instants, setting)
        errors, rounding = estimate(compared, angles[left])
        better = errors < np.array([one.error for one in now])
        out[left[better]] = compared.fine.rows[better, : out.shape[1]]
        if (errors > problem.tolerance).any():  # nobody asks for how long one that is reached is kept
            kept = kept_spans(compared, rounding, REPORTED_TOLERANCE if problem.best else problem.tolerance)
            for one, is_better, (start, stop) in zip(now, better, kept.tolist(), strict=True):
                before = (-np.inf, np.inf) if is_better else one.kept
                one.kept = max(before[0], start), min(before[1], stop)
        again = [
            one.add(problem, compared, k, float(errors[k]), float(rounding[k])) for k, one in enumerate(now)
        ]
        left = left[again]
    return refinements


def _turned_and_momenta(problem: TorqueProblem, bodies: Bodies) -> tuple[np.ndarray, np.ndarray]:
    """(n,) rad and N m s: of bodies that turn as fast as they may, over the span and about any axis."""
    rates = max_angular_rates(problem.template, bodies, problem.torques, problem.impulses)
    return rates * problem.max_abs_seconds, rates * np.asarray(bodies.body.moments).max(axis=1)


def _setting(candidates: Sequence[Candidate], momenta: np.ndarray) -> StepSetting:
    """Steps of one candidate for each body, meant for momenta (n,), N m s."""
    steps, decays, least = np.array([(one.step, one.decay, one.min_steps) for one in candidates]).T
    return StepSetting(steps, decays, momentum=momenta, min_steps=least)


def finer(candidate: Candidate, ratio: float, steps: int) -> Candidate:
    """Steps whose error is smaller by a ratio, and a little more; of few steps, some that make others."""
    share = (0.5 * ratio) ** (1.0 / 14.0) if ratio > 0.0 else 0.5  # nothing known: it did not settle
    share = min(MAX_STEP_FACTOR, 1.0 - 1.0 / max(2, steps), max(0.3, share))
    decay = candidate.decay * min(0.3, max(1e-4, 0.5 * ratio))
    return replace(candidate.shortened(share), decay=decay)


def rehearse(problem: TorqueProblem, body: Bodies, candidate: Candidate) -> Candidate:
    """The candidate with steps that have kept their share of the tolerance over a twelfth of a long span.

    To find only at its end that steps were too long would cost all of it again.
    """
    angles, momenta = _turned_and_momenta(problem, body)
    if candidate.ends_at_edges or angles[0] < 1e4:  # rad
        return candidate
    parts = 12.0
    start, stop = problem.template.start / parts, problem.template.stop / parts
    part = problem.over(start, stop)
    instants = np.array([np.linspace(start, stop, 8), np.zeros(8)])
    # errors grow with the power 1.1 of time
    share, before = SHARE_OF_TOLERANCE * problem.tolerance / parts**1.1, np.inf
    for _ in range(MAX_ATTEMPTS):
        compared = compare(part, body, instants, _setting([candidate], momenta))
        (error,), (rounding,) = estimate(compared, angles / parts)
        if error <= share or rounding > share or error > 0.5 * before:  # not of steps, but of the orbit
            break
        before = error
        candidate = finer(candidate, share / error, int(compared.fine.steps[0]))
    return candidate


# -- many bodies ------------------------------------------------------------------------------------------


def choose_for_all(problem: TorqueProblem, instants: Instants, probes: Bodies | None = None) -> Candidate:
    """The steps for all bodies of an ensemble, by a few of them, or by the scene's own.

    The finest that any of them would choose; on that one its estimate over the whole span is brought to half
    of the tolerance.

    Raises
    ------
    InputError, ToleranceError : as `choose`.
    """
    bodies = problem.body if probes is None or not len(probes) else replace(probes, index=None)
    blocks = [bodies[i : i + 1] for i in range(len(bodies))]
    choices = [choose(problem, body) for body in blocks]
    finest = min(range(len(blocks)), key=lambda i: choices[i].step)
    if choices[finest].ends_at_edges:
        return choices[finest]
    at = two_part(instants)
    at = at[:, compared_instants(at.shape[1])]
    for tolerance in (SHARE_OF_TOLERANCE * problem.tolerance, problem.tolerance):
        aimed = replace(problem, tolerance=tolerance)
        candidate = rehearse(aimed, blocks[finest], choices[finest])
        out = np.empty((1, STATES, at.shape[1]))
        (refined,) = refine(aimed, blocks[finest], at, candidate, out)
        if refined.reached:
            return refined.candidate
    return choices[finest]


def solve_each(
    problem: TorqueProblem,
    bodies: Bodies,
    instants: Instants,
    candidate: Candidate,
    lost: list[int] | None = None,
) -> np.ndarray:
    """(n, STATES, m): attitude and rate of each body at the instants.

    No bit of a body's rows depends on the other bodies.  Bodies whose error grows beyond the tolerance later,
    since their motion multiplies it, are named in an AttitudeWarning.

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
        rows = out[first : first + size]
        # those that are left after two attempts together are solved as scenes of their own
        refined = refine(problem, block, at, candidate, rows, attempts=2)
        for i, one in enumerate(refined):
            if one.reached:
                continue
            with named(block, i, lost):
                error: float = one.error
                kept: tuple[float, float] | None = one.kept
                if not (one.outgrown and one.candidate.ends_at_edges):  # in steps that may be finer
                    out[first + i] = np.nan
                    alone = solve_alone(problem, block[i : i + 1], instants)
                    out[first + i], error, kept = alone.rows[:STATES], alone.error, alone.kept
                if kept is not None and not problem.best:
                    name = "" if block.index is None else f"bodies[{block.index[i]}]: "
                    text = name + outgrown(problem, kept, error)
                    emit_warning(text)
    return out


def solve_alone(problem: TorqueProblem, body: Bodies, instants: Instants) -> TorquedSolution:
    """One body of an ensemble, in steps of its own."""
    body = replace(body, index=None)
    return solve(problem, instants, choose(problem, body), body)

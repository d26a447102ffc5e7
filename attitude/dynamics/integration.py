"""Motion under torques: legs marched by the chosen solver, and how far the answer can be off."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple, TypeAlias

import numpy as np

from ..errors import InputError, ToleranceError
from ..frames import rotations
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse, TorqueModel
from ..runtime import threads
from ..times.instants import Instants
from .arcs import Arc, instants_within, legs
from .momentum import initial_momentum
from .solver_arguments import SolverArguments
from .solver_selection import Candidate, candidates, pace, tried_leg
from .solvers import COLLOCATION, OUTPUTS, RUNGE_KUTTA, SPLITTINGS, Part, Solver, Work

CHECKED = 64  # instants at which a coarser solution is compared
ATTEMPTS = 6
# Rehearsals: of spans longer than this, rad, the first of so many parts; errors grow with this power of time.
WORTH_REHEARSING, PARTS, REHEARSED, AIM, GROWTH = 1e4, 12.0, 8, 0.5, 1.1
# Of an attempt's setting, what the next takes at most: more would hardly change the number of steps.
NEXT = 0.9

# Of the first attempt's steps, what a later one takes at most: where torques break, more is of little use.
MOST = 30.0

# Instants, evenly over the span, at which the coarser solution tells how fast the body has come to turn.
SPREAD = 16

# Rounding, rad, by measurement against the closed form over 1e1 to 1e5 rad: a part of the angle turned,
# since the rates are doubles; and where the rate is read off the attitude or off a plain sum, which remember
# every rounding, that angle times the root of the number of stages (and ten times this on bad days).
OF_ANGLE = 3e-16
# Of the attitude, times the root of the number of steps.
OF_STEPS = 4e-16
OF_WANDERING = {"gauss": 7e-17, "dop853": 2e-16, "splitting": 7e-16}
# Motion near an unstable one makes rounding grow to this, or more: less than it is not divided by anything.
GROWN = 3e-11


class Marched(NamedTuple):
    """Rows at the instants (at some of them), the work, whether every torque was smooth, whether the body is
    symmetric for the solver; and, told by a coarser solution, the angle (rad) that rounding is a part of, and
    what impulses may multiply it by."""

    rows: np.ndarray
    work: Work
    smooth: bool
    symmetric: bool
    drift: float = 0.0
    growth: float = 0.0


class Estimate(NamedTuple):
    """A solution, and how far it may be off: rad, in all, and by rounding alone."""

    marched: Marched
    error: float
    rounding: float


Flags: TypeAlias = bool | np.ndarray
Numbers: TypeAlias = float | np.ndarray
March = Callable[[Candidate, bool, "np.ndarray | None"], Marched]


@dataclass(frozen=True)
class Answer:
    """Attitudes under torques.

    Attributes
    ----------
    rows : (OUTPUTS, n): attitude wxyz (4), rate (3, body), momentum (3, inertial) at the instants
    error : rad, estimated greatest error of an attitude
    candidate : the solver and setting that were used
    work : what it took
    """

    rows: np.ndarray
    error: float
    candidate: Candidate
    work: Work


def choose(
    initial_state: InitialState,
    torques: Sequence[TorqueModel],
    kicks: Sequence[AppliedImpulse],
    tolerance: float,
    kind: str | None = None,
) -> list[Candidate]:
    """Solvers and settings for the situation's span, cheapest first."""
    leg, added = tried_leg(initial_state, by_direction(initial_state, torques, kicks))
    span = max(abs(initial_state.start), abs(initial_state.stop))
    found = candidates(initial_state, leg, span, tolerance, kind, added)
    if not found:
        raise InputError("solver", kind, "a solver that takes these effects: automatic, gauss or dop853")
    return found


def solve(
    initial_state: InitialState,
    torques: Sequence[TorqueModel],
    kicks: Sequence[AppliedImpulse],
    instants: Instants,
    tolerance: float,
    found: Sequence[Candidate],
) -> Answer:
    """Attitudes at the instants, off by less than the tolerance (rad) by comparison with a coarser solution.

    found : what `choose` found

    Raises
    ------
    ToleranceError : steps however small do not bring the estimate below the tolerance.
    """
    seconds, rest = two_part(instants)
    march = partial(_march, initial_state, by_direction(initial_state, torques, kicks), seconds, rest)
    angle = pace(initial_state, torques, kicks) * max(abs(initial_state.start), abs(initial_state.stop))
    nearest, tried = np.inf, found[0].solver
    for candidate in _worth_trying(found, initial_state, torques):
        candidate = _rehearsed(initial_state, torques, kicks, candidate, tolerance, angle)
        one, candidate = _refined(march, candidate, tolerance, angle, seconds.size)
        if one.error <= tolerance:
            return Answer(one.marched.rows, one.error, candidate, one.marched.work)
        nearest, tried = min((nearest, tried), (one.error, candidate.solver), key=lambda pair: pair[0])
    if not np.isfinite(nearest):
        raise ToleranceError(
            f"tolerance: no steps of {tried.name} lead to the end of the span: the torque is not finite "
            "somewhere in it, or far too great for the body"
        )
    raise ToleranceError(
        f"tolerance: {tolerance:.1e} rad cannot be reached over this span in double precision by "
        f"{tried.name} (estimated error {nearest:.1e} rad); ask for more than that"
    )


def settled(
    initial_state: InitialState,
    torques: Sequence[TorqueModel],
    kicks: Sequence[AppliedImpulse],
    instants: Instants,
    tolerance: float,
    candidate: Candidate,
) -> Candidate:
    """The candidate with a setting that brings the estimate at the instants to half of the tolerance, or
    to the tolerance where half of it cannot be had; as it is where neither can.
    """
    seconds, rest = two_part(instants)
    march = partial(_march, initial_state, by_direction(initial_state, torques, kicks), seconds, rest)
    angle = pace(initial_state, torques, kicks) * max(abs(initial_state.start), abs(initial_state.stop))
    for aim in (AIM * tolerance, tolerance):
        begun = _rehearsed(initial_state, torques, kicks, candidate, aim, angle)
        one, found = _refined(march, begun, aim, angle, seconds.size)
        if one.error <= aim:
            return found
    return candidate


def two_part(instants: Instants) -> tuple[np.ndarray, np.ndarray]:
    """(n,) seconds and (n,) their rest, as kernels take them."""
    seconds = np.ascontiguousarray(instants.seconds).reshape(-1)
    if instants.seconds_low is None:
        return seconds, np.zeros_like(seconds)
    return seconds, np.ascontiguousarray(instants.seconds_low).reshape(-1)


def _worth_trying(
    found: Sequence[Candidate], initial_state: InitialState, torques: Sequence[TorqueModel]
) -> list[Candidate]:
    """The cheapest; where torques are not smooth, that which finds for itself where they break; and after a
    splitting collocation, for a pilot on which errors do not show: a body at rest spun up about one axis.
    """
    smooth = RUNGE_KUTTA.prepare(initial_state, torques).is_smooth
    other = COLLOCATION if found[0].solver in SPLITTINGS else found[0].solver
    other = other if smooth else RUNGE_KUTTA
    return [found[0], *(one for one in found[1:] if one.solver is other)]


def _rehearsed(
    initial_state: InitialState,
    torques: Sequence[TorqueModel],
    kicks: Sequence[AppliedImpulse],
    candidate: Candidate,
    tolerance: float,
    angle: float,
) -> Candidate:
    """A setting that has kept its share of the tolerance over the first part of a long span.

    To find only at the end of the whole that steps were too long would cost all of it again.
    """
    if angle < WORTH_REHEARSING:
        return candidate
    start, stop = initial_state.start / PARTS, initial_state.stop / PARTS
    seconds = np.linspace(start, stop, REHEARSED)
    march = partial(
        _march,
        initial_state,
        by_direction(replace(initial_state, start=start, stop=stop), torques, kicks),
        seconds,
        np.zeros(REHEARSED),
    )
    share = AIM * tolerance / PARTS**GROWTH
    for _ in range(ATTEMPTS):
        one = _estimated(march, candidate, angle / PARTS, REHEARSED)
        if one.error <= share or one.rounding > share:
            break
        candidate = finer(candidate, share / one.error, one.marched.smooth, one.marched.work.steps)
    return candidate


def _refined(
    march: March, candidate: Candidate, tolerance: float, angle: float, count: int
) -> tuple[Estimate, Candidate]:
    """Finer and finer until the estimate is below the tolerance, twice has hardly fallen, or is rounding."""
    best, vain, first, steps = None, 0, candidate, 0
    for _ in range(ATTEMPTS):
        one = _estimated(march, candidate, angle, count)
        if one.error <= tolerance:
            return one, candidate
        if best is not None and one.error > 0.5 * best.error and one.marched.work.steps > steps:
            vain += 1  # of few steps, a setting somewhat finer may make as many again
        steps = one.marched.work.steps
        best = one if best is None or one.error < best.error else best
        candidate = finer(candidate, tolerance / one.error, one.marched.smooth, steps)
        enough = not one.marched.smooth and candidate.setting * MOST < first.setting
        if vain == 2 or one.rounding > tolerance or (enough and candidate.solver is not RUNGE_KUTTA):
            break
    assert best is not None
    return best, candidate


def finer(candidate: Candidate, ratio: float, smooth: bool, steps: int) -> Candidate:
    """A setting whose error is smaller by a ratio, and a little more; of few steps, one that makes others."""
    order = min(candidate.solver.order, 14 if smooth else 2)
    share = (0.5 * ratio) ** (1.0 / order) if ratio > 0.0 else 0.5  # nothing known: it did not settle
    setting = candidate.setting * min(NEXT, 1.0 - 1.0 / max(2, steps), max(0.02, share))
    if candidate.solver is RUNGE_KUTTA:
        setting = max(setting, 1e-15)
    return replace(candidate, setting=setting)


def by_direction(
    initial_state: InitialState, torques: Sequence[TorqueModel], kicks: Sequence[AppliedImpulse]
) -> list[list[Arc]]:
    """Legs forwards, and backwards where instants lie before the epoch."""
    cut = []
    if initial_state.start < 0.0:
        cut.append(legs(initial_state, torques, kicks, initial_state.start))
    if initial_state.stop >= 0.0:
        cut.append(legs(initial_state, torques, kicks, initial_state.stop))
    return cut


def _estimated(march: March, candidate: Candidate, angle: float, count: int) -> Estimate:
    """The solution and a coarser one, side by side on two processors."""
    some = checked(count)
    answers: dict[bool, Marched] = {}

    def one(coarsely: bool) -> None:
        answers[coarsely] = march(candidate, coarsely, some if coarsely else None)

    threads.run(one, [False, True])
    fine, coarse = answers[False], answers[True]
    if any(answer.work.failed or not np.isfinite(answer.rows).all() for answer in (fine, coarse)):
        return Estimate(fine, np.inf, 0.0)
    apart = float(rotations.angle_between(fine.rows[:4, some].T, coarse.rows[:4].T).max())
    return estimate(candidate.solver, fine._replace(drift=coarse.drift, growth=coarse.growth), apart, angle)


def checked(count: int) -> np.ndarray:
    """Which of so many instants a coarser solution is compared at."""
    return np.unique(np.linspace(0, count - 1, min(count, CHECKED)).round().astype(int))


def estimate(solver: Solver, fine: Marched, apart: float, angle: float) -> Estimate:
    """How far a solution may be off that is `apart` (rad) from a coarser one, over an angle turned (rad)."""
    drift = max(angle, fine.drift)
    wandering = _wandering(solver, fine, drift)
    rounding = wandering + OF_ANGLE * drift + OF_STEPS * float(np.sqrt(fine.work.steps)) * (1.0 + fine.growth)
    better = solver.gain(fine.smooth, apart, angle / max(1, fine.work.steps))
    error = max(apart / better, min(apart, max(GROWN, 10.0 * wandering)))
    return Estimate(fine, error + rounding, rounding)


def spread(directions: Sequence[Sequence[Arc]]) -> np.ndarray:
    """(k,) s: the epoch, and SPREAD instants evenly over each direction."""
    ends = [cut[-1].stop for cut in directions if cut[-1].stop != 0.0]
    return np.concatenate([[0.0], *(np.linspace(0.0, end, SPREAD + 1)[1:] for end in ends)])


def inertial_kicks(kicks: Sequence[AppliedImpulse]) -> float:
    """N m s, of all impulses that are fixed in space: an error of the attitude tilts them in the body."""
    return sum(float(np.linalg.norm(kick.angular)) for kick in kicks if kick.inertial)


def drifts(rows: np.ndarray, symmetric: Flags, steps: Numbers, least: Numbers, kicked: float) -> np.ndarray:
    """(...), rad/s: what rounding makes of a rate is a part of this.

    A rate that is read off the momentum L is as good as L over the least moment, however slowly the body
    turns about that axis.  The momentum carried along an axis of symmetry is as good as the rate, but for
    what inertial impulses add, whose rounding stays, and torques, whose rounding is of either sign.

    Parameters
    ----------
    rows : (..., OUTPUTS, k), the first of them at the epoch
    symmetric : (...), whether that momentum is carried; steps : (...); least : (...), kg m2
    kicked : N m s, `inertial_kicks`
    """
    with np.errstate(over="ignore", invalid="ignore"):  # a solution that has run away, and is not taken
        turning, momentum = _length(rows[..., 4:7, :]), _length(rows[..., 7:10, :])
        change = _length(rows[..., 7:10, :] - rows[..., 7:10, :1])
        carried = turning + (kicked + change / np.sqrt(np.maximum(steps, 1))) / least
        found: np.ndarray = np.where(symmetric, carried, np.maximum(turning, momentum / least))
    return found


def _length(vectors: np.ndarray) -> np.ndarray:
    """(...): the greatest of (..., 3, k)."""
    x, y, z = np.moveaxis(vectors * vectors, -2, 0)
    greatest: np.ndarray = np.sqrt((x + y) + z).max(axis=-1)
    return greatest


def _wandering(solver: Solver, marched: Marched, angle: float) -> float:
    """rad, by which rounding alone may lead the attitude astray."""
    if marched.symmetric and solver is not RUNGE_KUTTA:
        return 0.0
    stages = marched.work.torques if solver.kind == "splitting" else marched.work.steps
    return OF_WANDERING[solver.kind] * float(np.sqrt(stages)) * angle


def _march(
    initial_state: InitialState,
    directions: list[list[Arc]],
    seconds: np.ndarray,
    rest: np.ndarray,
    candidate: Candidate,
    coarsely: bool,
    some: np.ndarray | None,
) -> Marched:
    """All directions, for the instants or some of them."""
    if some is not None:
        seconds, rest = seconds[some], rest[some]
    asked, others = seconds.size, spread(directions) if coarsely else np.zeros(0)
    seconds, rest = np.append(seconds, others), np.append(rest, np.zeros(others.size))
    rows, total = np.empty((OUTPUTS, seconds.size)), Work(0, 0, 0)
    smooth, symmetric = True, True
    before = seconds < 0.0
    for cut in directions:
        mine = np.flatnonzero(before if cut[-1].stop < 0.0 else ~before)
        if not mine.size:
            continue
        places = instants_within(cut, seconds[mine], rest[mine])
        places = [mine[place] for place in places]
        work, met = _march_legs(initial_state, cut, candidate, coarsely, (seconds, rest), places, rows)
        total = Work(*(a + b for a, b in zip(total, work, strict=True)))
        smooth = smooth and all(stepped.is_smooth for stepped in met)
        symmetric = symmetric and all(stepped.symmetric for stepped in met)
    drift, growth = 0.0, 0.0
    if coarsely:
        kicked = inertial_kicks([kick for cut in directions for leg in cut for kick in leg.kicks])
        carried = symmetric and candidate.solver is not RUNGE_KUTTA
        least = float(initial_state.moments.min())
        span = float(np.abs(others).max())
        drift = span * float(drifts(rows[:, asked:], carried, total.steps, least, kicked))
        growth = span * kicked / least
    return Marched(rows[:, :asked], total, smooth, symmetric, drift, growth)


def _march_legs(
    initial_state: InitialState,
    cut: list[Arc],
    candidate: Candidate,
    coarsely: bool,
    instants: tuple[np.ndarray, np.ndarray],
    places: list[np.ndarray],
    rows: np.ndarray,
) -> tuple[Work, list[SolverArguments]]:
    """Leg by leg from the epoch outwards; fills the rows at the places of each."""
    seconds, rest = instants
    sign = 1.0 if cut[-1].stop >= 0.0 else -1.0
    attitude = initial_state.attitude / np.linalg.norm(initial_state.attitude)
    momentum = initial_momentum(initial_state, cut[0].torques)
    total, state = Work(0, 0, 0), None
    prepared: dict[tuple[int, ...], SolverArguments] = {}
    for leg, place in zip(cut, places, strict=True):
        key = tuple(id(torque) for torque in leg.torques)
        if key not in prepared:
            prepared[key] = candidate.solver.prepare(initial_state, leg.torques)
        state = prepared[key].state(attitude, momentum, initial_state.rate) if state is None else state
        for kick in leg.kicks:
            prepared[key].push(state, attitude, kick, sign)
        # the last column is the end of the leg
        at = np.append(seconds[place], leg.stop), np.append(rest[place], 0.0)
        out = np.full((OUTPUTS, place.size + 1), np.nan)  # which a solver that stops leaves there
        part = Part(leg.start, leg.stop, *at, coarsely)
        work = candidate.solver.follow(leg.torques, prepared[key], state, part, candidate.setting, out)
        rows[:, place] = out[:, :-1]
        attitude = out[:4, -1]
        total = Work(*(a + b for a, b in zip(total, work, strict=True)))
    return total, list(prepared.values())

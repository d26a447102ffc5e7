"""Motion under torques: legs marched by the chosen solver, and how far the answer can be off."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from .. import orientation
from ..elapsed import Instants
from ..errors import InputError, ToleranceError
from ..runtime import threads
from .acting import Acting, Kick
from .choice import Candidate, candidates, pace
from .legs import Leg, instants_within, legs
from .momentum import inertial, initial_momentum
from .situation import Situation
from .solvers import OUTPUTS, RUNGE_KUTTA, Part, Solver, Work
from .stepped import Stepped

CHECKED = 64  # instants at which a coarser solution is compared
ATTEMPTS = 6
# Rehearsals: of spans longer than this, rad, the first of so many parts; errors grow with this power of time.
WORTH_REHEARSING, PARTS, REHEARSED, AIM, GROWTH = 1e4, 12.0, 8, 0.5, 1.1
# Of an attempt's setting, what the next takes at most: more would hardly change the number of steps.
NEXT = 0.9

# Of the first attempt's steps, what a later one takes at most: where torques break, more is of little use.
MOST = 30.0

# Rounding, rad, by measurement against the closed form over 1e1 to 1e5 rad: a part of the angle turned,
# since the rates are doubles; and where the rate is read off the attitude or off a plain sum, which remember
# every rounding, that angle times the root of the number of stages (and ten times this on bad days).
OF_ANGLE = 3e-16
OF_WANDERING = {"gauss": 7e-17, "dop853": 2e-16, "splitting": 7e-16}
# Motion near an unstable one makes rounding grow to this, or more: less than it is not divided by anything.
GROWN = 3e-11


class Marched(NamedTuple):
    """Rows at the instants (at some of them), the work, whether every torque was smooth, and whether the
    body is symmetric for the solver."""

    rows: np.ndarray
    work: Work
    smooth: bool
    symmetric: bool


class Estimate(NamedTuple):
    """A solution, and how far it may be off: rad, in all, and by rounding alone."""

    marched: Marched
    error: float
    rounding: float


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
    situation: Situation,
    torques: Sequence[Acting],
    kicks: Sequence[Kick],
    tolerance: float,
    kind: str | None = None,
) -> list[Candidate]:
    """Solvers and settings for the situation's span, cheapest first."""
    cut = _all_legs(situation, torques, kicks)
    busiest = max(cut, key=lambda leg: (len(leg.torques), leg.length))
    span = max(abs(situation.start), abs(situation.stop))
    found = candidates(situation, busiest, span, tolerance, kind)
    if not found:
        raise InputError("solver", kind, "a solver that takes these effects: automatic, gauss or dop853")
    return found


def solve(
    situation: Situation,
    torques: Sequence[Acting],
    kicks: Sequence[Kick],
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
    march = partial(_march, situation, by_direction(situation, torques, kicks), seconds, rest)
    angle = pace(situation, torques) * max(abs(situation.start), abs(situation.stop))
    nearest, tried = np.inf, found[0].solver
    for candidate in _worth_trying(found, situation, torques):
        candidate = _rehearsed(situation, torques, kicks, candidate, tolerance, angle)
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
    situation: Situation,
    torques: Sequence[Acting],
    kicks: Sequence[Kick],
    instants: Instants,
    tolerance: float,
    candidate: Candidate,
) -> Candidate:
    """The candidate with a setting that brings the estimate at the instants to half of the tolerance, or
    to the tolerance where half of it cannot be had; as it is where neither can.
    """
    seconds, rest = two_part(instants)
    march = partial(_march, situation, by_direction(situation, torques, kicks), seconds, rest)
    angle = pace(situation, torques) * max(abs(situation.start), abs(situation.stop))
    for aim in (AIM * tolerance, tolerance):
        begun = _rehearsed(situation, torques, kicks, candidate, aim, angle)
        one, found = _refined(march, begun, aim, angle, seconds.size)
        if one.error <= aim:
            return found
    return candidate


def two_part(instants: Instants) -> tuple[np.ndarray, np.ndarray]:
    """(n,) seconds and (n,) their rest, as kernels take them."""
    seconds = np.ascontiguousarray(instants.seconds).reshape(-1)
    if instants.rest is None:
        return seconds, np.zeros_like(seconds)
    return seconds, np.ascontiguousarray(instants.rest).reshape(-1)


def _worth_trying(
    found: Sequence[Candidate], situation: Situation, torques: Sequence[Acting]
) -> list[Candidate]:
    """The cheapest; and where torques are not smooth, that which finds for itself where they break."""
    if RUNGE_KUTTA.prepare(situation, torques).is_smooth:
        return [found[0]]
    return [found[0], *(one for one in found[1:] if one.solver is RUNGE_KUTTA)]


def _rehearsed(
    situation: Situation,
    torques: Sequence[Acting],
    kicks: Sequence[Kick],
    candidate: Candidate,
    tolerance: float,
    angle: float,
) -> Candidate:
    """A setting that has kept its share of the tolerance over the first part of a long span.

    To find only at the end of the whole that steps were too long would cost all of it again.
    """
    if angle < WORTH_REHEARSING:
        return candidate
    start, stop = situation.start / PARTS, situation.stop / PARTS
    seconds = np.linspace(start, stop, REHEARSED)
    march = partial(
        _march,
        situation,
        by_direction(replace(situation, start=start, stop=stop), torques, kicks),
        seconds,
        np.zeros(REHEARSED),
    )
    share = AIM * tolerance / PARTS**GROWTH
    for _ in range(ATTEMPTS):
        one = _estimated(march, candidate, angle / PARTS, REHEARSED)
        if one.error <= share or one.rounding > share:
            break
        candidate = finer(candidate, share / one.error, one.marched.smooth)
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
        candidate = finer(candidate, tolerance / one.error, one.marched.smooth)
        enough = not one.marched.smooth and candidate.setting * MOST < first.setting
        if vain == 2 or one.rounding > tolerance or (enough and candidate.solver is not RUNGE_KUTTA):
            break
    assert best is not None
    return best, candidate


def finer(candidate: Candidate, ratio: float, smooth: bool) -> Candidate:
    """A setting whose error is smaller by a ratio, and a little more."""
    order = min(candidate.solver.order, 14 if smooth else 2)
    share = (0.5 * ratio) ** (1.0 / order) if ratio > 0.0 else 0.5  # nothing known: it did not settle
    setting = candidate.setting * min(NEXT, max(0.02, share))
    if candidate.solver is RUNGE_KUTTA:
        setting = max(setting, 1e-15)
    return replace(candidate, setting=setting)


def _all_legs(situation: Situation, torques: Sequence[Acting], kicks: Sequence[Kick]) -> list[Leg]:
    return [leg for direction in by_direction(situation, torques, kicks) for leg in direction]


def by_direction(situation: Situation, torques: Sequence[Acting], kicks: Sequence[Kick]) -> list[list[Leg]]:
    """Legs forwards, and backwards where instants lie before the epoch."""
    cut = []
    if situation.start < 0.0:
        cut.append(legs(situation, torques, kicks, situation.start))
    if situation.stop >= 0.0:
        cut.append(legs(situation, torques, kicks, situation.stop))
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
    apart = float(orientation.angle_between(fine.rows[:4, some].T, coarse.rows[:4].T).max())
    return estimate(candidate.solver, fine, apart, angle)


def checked(count: int) -> np.ndarray:
    """Which of so many instants a coarser solution is compared at."""
    return np.unique(np.linspace(0, count - 1, min(count, CHECKED)).round().astype(int))


def estimate(solver: Solver, fine: Marched, apart: float, angle: float) -> Estimate:
    """How far a solution may be off that is `apart` (rad) from a coarser one, over an angle turned (rad)."""
    wandering = _wandering(solver, fine, angle)
    rounding = wandering + _rounding(fine.work, angle)
    better = solver.gain(fine.smooth, apart, angle / max(1, fine.work.steps))
    error = max(apart / better, min(apart, max(GROWN, 10.0 * wandering)))
    return Estimate(fine, error + rounding, rounding)


def _wandering(solver: Solver, marched: Marched, angle: float) -> float:
    """rad, by which rounding alone may lead the attitude astray."""
    if marched.symmetric and solver is not RUNGE_KUTTA:
        return 0.0
    stages = marched.work.torques if solver.kind == "splitting" else marched.work.steps
    return OF_WANDERING[solver.kind] * float(np.sqrt(stages)) * angle


def _rounding(work: Work, angle: float) -> float:
    return 4e-16 * float(np.sqrt(work.steps)) + OF_ANGLE * angle


def _march(
    situation: Situation,
    directions: list[list[Leg]],
    seconds: np.ndarray,
    rest: np.ndarray,
    candidate: Candidate,
    coarsely: bool,
    some: np.ndarray | None,
) -> Marched:
    """All directions, for the instants or some of them."""
    if some is not None:
        seconds, rest = seconds[some], rest[some]
    rows, total = np.empty((OUTPUTS, seconds.size)), Work(0, 0, 0)
    smooth, symmetric = True, True
    before = seconds < 0.0
    for cut in directions:
        mine = np.flatnonzero(before if cut[-1].stop < 0.0 else ~before)
        if not mine.size:
            continue
        places = instants_within(cut, seconds[mine], rest[mine])
        places = [mine[place] for place in places]
        work, met = _march_legs(situation, cut, candidate, coarsely, (seconds, rest), places, rows)
        total = Work(*(a + b for a, b in zip(total, work, strict=True)))
        smooth = smooth and all(stepped.is_smooth for stepped in met)
        symmetric = symmetric and all(stepped.symmetric for stepped in met)
    return Marched(rows, total, smooth, symmetric)


def _march_legs(
    situation: Situation,
    cut: list[Leg],
    candidate: Candidate,
    coarsely: bool,
    instants: tuple[np.ndarray, np.ndarray],
    places: list[np.ndarray],
    rows: np.ndarray,
) -> tuple[Work, list[Stepped]]:
    """Leg by leg from the epoch outwards; fills the rows at the places of each."""
    seconds, rest = instants
    sign = 1.0 if cut[-1].stop >= 0.0 else -1.0
    attitude = situation.attitude / np.linalg.norm(situation.attitude)
    momentum = initial_momentum(situation, cut[0].torques)
    total = Work(0, 0, 0)
    prepared: dict[tuple[int, ...], Stepped] = {}
    for leg, place in zip(cut, places, strict=True):
        key = tuple(id(torque) for torque in leg.torques)
        if key not in prepared:
            prepared[key] = candidate.solver.prepare(situation, leg.torques)
        for kick in leg.kicks:
            momentum = momentum + sign * inertial(kick, attitude)
        # the last column is the end of the leg
        at = np.append(seconds[place], leg.stop), np.append(rest[place], 0.0)
        out = np.full((OUTPUTS, place.size + 1), np.nan)  # which a solver that stops leaves there
        state = prepared[key].state(attitude, momentum)
        part = Part(leg.start, leg.stop, *at, coarsely)
        work = candidate.solver.follow(leg.torques, prepared[key], state, part, candidate.setting, out)
        rows[:, place] = out[:, :-1]
        attitude, momentum = out[:4, -1], out[7:, -1]
        total = Work(*(a + b for a, b in zip(total, work, strict=True)))
    return total, list(prepared.values())

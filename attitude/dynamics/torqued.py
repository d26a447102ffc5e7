"""Motion under torques: legs marched by the chosen solver, and how far the answer can be off."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from .. import orientation, threads
from ..elapsed import Instants
from ..errors import InputError, ToleranceError
from .acting import Acting, Kick
from .choice import Candidate, candidates
from .legs import Leg, instants_within, legs
from .momentum import inertial, initial_momentum
from .situation import Situation
from .solvers import OUTPUTS, RUNGE_KUTTA, Part, Work
from .stepped import Stepped

March = Callable[[Candidate, bool, "np.ndarray | None"], "tuple[np.ndarray, Work, Nature]"]
CHECKED = 64  # instants at which a coarser solution is compared
ATTEMPTS = 8


class Nature(NamedTuple):
    """Of all legs: whether every torque is smooth in time, and every body stepped as a symmetric one."""

    smooth: bool = True
    symmetric: bool = True


@dataclass(frozen=True)
class Answer:
    """Attitudes under torques.

    Attributes
    ----------
    rows : (OUTPUTS, n): attitude wxyz (4), rate (3, body), momentum (3, inertial) at the instants
    error : rad, estimated greatest error of an attitude
    candidate : the solver and setting that were used; others : what else was considered, cheapest first
    work : what it took
    """

    rows: np.ndarray
    error: float
    candidate: Candidate
    others: tuple[Candidate, ...]
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
    kind: str | None = None,
) -> Answer:
    """Attitudes at the instants, off by less than the tolerance (rad) by comparison with a coarser solution.

    Raises
    ------
    ToleranceError : steps however small do not bring the estimate below the tolerance.
    """
    found = choose(situation, torques, kicks, tolerance, kind)
    seconds = np.ascontiguousarray(instants.seconds).reshape(-1)
    rest = (
        np.zeros_like(seconds) if instants.rest is None else np.ascontiguousarray(instants.rest).reshape(-1)
    )
    march = partial(_march, situation, _by_direction(situation, torques, kicks), seconds, rest)
    turned = float(np.linalg.norm(situation.rate)) * max(abs(situation.start), abs(situation.stop))
    candidate, best, stuck = found[0], np.inf, 0
    for _ in range(ATTEMPTS):
        rows, work, error = _estimated(march, candidate, seconds.size, turned)
        if error <= tolerance:
            return Answer(rows, error, candidate, tuple(found), work)
        stuck = stuck + 1 if error > 0.5 * best else 0
        if stuck == 2:  # finer steps do not help: what is left is rounding, or the motion is chaotic
            break
        best = min(best, error)
        candidate = _finer(candidate, tolerance / error)
    raise ToleranceError(
        f"tolerance: {tolerance:.1e} rad cannot be reached over this span in double precision by "
        f"{candidate.solver.name} (estimated error {min(error, best):.1e} rad); ask for more than that"
    )


def _finer(candidate: Candidate, ratio: float) -> Candidate:
    """A setting whose error is smaller by a ratio, and a little more."""
    setting = candidate.setting * min(0.8, (0.3 * max(ratio, 1e-6)) ** (1.0 / candidate.solver.order))
    if candidate.solver is RUNGE_KUTTA:
        setting = max(setting, 1e-15)
    return replace(candidate, setting=setting)


def _all_legs(situation: Situation, torques: Sequence[Acting], kicks: Sequence[Kick]) -> list[Leg]:
    return [leg for direction in _by_direction(situation, torques, kicks) for leg in direction]


def _by_direction(situation: Situation, torques: Sequence[Acting], kicks: Sequence[Kick]) -> list[list[Leg]]:
    """Legs forwards, and backwards where instants lie before the epoch."""
    cut = []
    if situation.start < 0.0:
        cut.append(legs(situation, torques, kicks, situation.start))
    if situation.stop >= 0.0:
        cut.append(legs(situation, torques, kicks, situation.stop))
    return cut


def _estimated(
    march: March, candidate: Candidate, count: int, turned: float
) -> tuple[np.ndarray, Work, float]:
    """(rows, work, estimated error): the solution and a coarser one, side by side on two processors."""
    some = np.unique(np.linspace(0, count - 1, min(count, CHECKED)).round().astype(int))
    answers: dict[bool, tuple[np.ndarray, Work, Nature]] = {}

    def one(coarsely: bool) -> None:
        answers[coarsely] = march(candidate, coarsely, some if coarsely else None)

    threads.run(one, [False, True])
    (rows, work, nature), (coarse, _, _) = answers[False], answers[True]
    if work.failed or not np.isfinite(rows).all():
        return rows, work, np.inf
    apart = orientation.angle_between(rows[:4, some].T, coarse[:4].T)
    error = float(apart.max()) / candidate.solver.gain(nature.smooth)
    creeps = candidate.solver.kind == "splitting" and not nature.symmetric
    return rows, work, error + _rounding(work, turned if creeps else 0.0)


def _rounding(work: Work, turned: float) -> float:
    """rad: what both solutions may share of rounding, which their comparison does not show.

    A general drift rounds much the same from step to step: energy creeps, and the phase with its square
    (measured; docs/torques.md, section 5).
    """
    return 4e-16 * float(np.sqrt(work.steps)) + 5e-17 * work.torques * turned


def _march(
    situation: Situation,
    directions: list[list[Leg]],
    seconds: np.ndarray,
    rest: np.ndarray,
    candidate: Candidate,
    coarsely: bool,
    some: np.ndarray | None,
) -> tuple[np.ndarray, Work, Nature]:
    """Rows at the instants (at some of them), the work, and the nature of it."""
    if some is not None:
        seconds, rest = seconds[some], rest[some]
    rows, total, nature = np.empty((OUTPUTS, seconds.size)), Work(0, 0, 0), Nature()
    before = seconds < 0.0
    for cut in directions:
        mine = np.flatnonzero(before if cut[-1].stop < 0.0 else ~before)
        if not mine.size:
            continue
        places = instants_within(cut, seconds[mine], rest[mine])
        places = [mine[place] for place in places]
        work, met = _march_legs(situation, cut, candidate, coarsely, (seconds, rest), places, rows)
        total = Work(*(a + b for a, b in zip(total, work, strict=True)))
        nature = Nature(*map(min, nature, met))
    return rows, total, nature


def _march_legs(
    situation: Situation,
    cut: list[Leg],
    candidate: Candidate,
    coarsely: bool,
    instants: tuple[np.ndarray, np.ndarray],
    places: list[np.ndarray],
    rows: np.ndarray,
) -> tuple[Work, Nature]:
    """Leg by leg from the epoch outwards; fills the rows at the places of each."""
    seconds, rest = instants
    sign = 1.0 if cut[-1].stop >= 0.0 else -1.0
    attitude = situation.attitude / np.linalg.norm(situation.attitude)
    momentum = initial_momentum(situation, cut[0].torques)
    total, nature = Work(0, 0, 0), Nature()
    prepared: dict[tuple[int, ...], Stepped] = {}
    for leg, place in zip(cut, places, strict=True):
        key = tuple(id(torque) for torque in leg.torques)
        if key not in prepared:
            prepared[key] = candidate.solver.prepare(situation, leg.torques)
        for kick in leg.kicks:
            momentum = momentum + sign * inertial(kick, attitude)
        # the last column is the end of the leg
        at = np.append(seconds[place], leg.stop), np.append(rest[place], 0.0)
        out = np.empty((OUTPUTS, place.size + 1))
        state = prepared[key].state(attitude, momentum)
        part = Part(leg.start, leg.stop, *at, coarsely)
        work = candidate.solver.follow(leg.torques, prepared[key], state, part, candidate.setting, out)
        rows[:, place] = out[:, :-1]
        attitude, momentum = out[:4, -1], out[7:, -1]
        total = Work(*(a + b for a, b in zip(total, work, strict=True)))
        nature = Nature(*map(min, nature, (prepared[key].is_smooth, prepared[key].symmetric)))
    return total, nature

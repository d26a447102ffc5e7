"""Many bodies under the same torques: each marched as `torqued` marches one, a block of them in one call.

Which solver, and how fine, is chosen once.  Every body's error is estimated by itself; one whose estimate is
above the tolerance is marched again in finer steps of its own, and if that does not do, solved alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from .. import stopping
from ..frames import rotations
from ..kernels import layout
from ..problem.initial_state import InitialState
from ..problem.spin_bound import free_spin
from ..problem.torque_model import AppliedImpulse, CachedTorque
from ..runtime import compiled
from ..times.instants import Instants
from . import batch_states as arrays
from . import integration, schemes
from .arcs import Arc, instants_within
from .batch_states import Bodies, Prepared, named
from .integration import Marched
from .momentum import gained
from .solver_selection import Candidate
from .solvers import (
    COLLOCATION,
    OUTPUTS,
    RUNGE_KUTTA,
    SPLITTINGS,
    Part,
    Solver,
    Work,
    dormand_prince,
    steps_of,
)

SOLVERS = {solver.name: solver for solver in (COLLOCATION, RUNGE_KUTTA, *SPLITTINGS)}
TOLD = 7  # of the rows, which are told: attitude (4) and rate (3)
# Attempts of all bodies together; those that are left then are solved alone.
ROUNDS = 2
# Numbers of rows that a block of bodies may fill: it stays in a processor's cache, or not far from it.
ROOM = 1 << 18


@dataclass(frozen=True)
class Problem:
    """What all bodies have in common.

    Attributes
    ----------
    like : surroundings and span; the body in it is the scene's own
    torques, kicks : as `torqued.solve` has them
    tolerance : rad; kind : of solver that is asked for, or None
    """

    like: InitialState
    torques: tuple[CachedTorque, ...]
    kicks: tuple[AppliedImpulse, ...]
    tolerance: float
    kind: str | None = None

    def torques_on(self, initial_state: InitialState) -> list[CachedTorque]:
        return [torque.of(initial_state) for torque in self.torques]


class Marches(NamedTuple):
    """Of n bodies: rows (n, OUTPUTS, m), steps, torques and failures (n,), and whether each was symmetric;
    whether every torque was smooth; and drift and growth (n,), as `Marched` has them.
    """

    rows: np.ndarray
    steps: np.ndarray
    torques: np.ndarray
    failed: np.ndarray
    symmetric: np.ndarray
    smooth: bool
    drift: np.ndarray
    growth: np.ndarray

    def of(self, i: int) -> Marched:
        work = Work(int(self.steps[i]), int(self.torques[i]), int(self.failed[i]))
        told = bool(self.symmetric[i]), float(self.drift[i]), float(self.growth[i])
        return Marched(self.rows[i], work, self.smooth, *told)


def choose(problem: Problem, instants: Instants, probes: Bodies | None = None) -> Candidate:
    """The solver and setting for all bodies, by a few of them, or by the scene's own.

    The solver that most of them would choose, with the finest setting of those; on the first of them its
    estimate over the whole span is brought to half of the tolerance.

    Raises what `torqued.choose` does.
    """
    situations = [problem.like]
    if probes is not None and len(probes):
        situations = [probes.initial_state(problem.like, i) for i in range(len(probes))]
    best = [
        integration.choose(one, *_changes(problem, one), problem.tolerance, problem.kind)[0]
        for one in situations
    ]
    names = [candidate.solver.name for candidate in best]
    commonest = max(names, key=names.count)
    first = names.index(commonest)
    finest = min(
        (candidate for candidate in best if candidate.solver.name == commonest), key=lambda one: one.setting
    )
    changes = _changes(problem, situations[first])
    return integration.settled(situations[first], *changes, _checked(instants), problem.tolerance, finest)


def _changes(
    problem: Problem, initial_state: InitialState
) -> tuple[list[CachedTorque], tuple[AppliedImpulse, ...]]:
    return problem.torques_on(initial_state), problem.kicks


def _checked(instants: Instants) -> Instants:
    """Those that errors are estimated at."""
    seconds, rest = integration.two_part(instants)
    some = integration.checked(seconds.size)
    return Instants(seconds[some], rest[some], None)


def solve(
    problem: Problem,
    bodies: Bodies,
    instants: Instants,
    candidate: Candidate,
    lost: list[int] | None = None,
) -> np.ndarray:
    """(n, TOLD, m): attitude and rate of each body at the instants.

    No bit of a body's depends on the others.

    lost : takes the places of bodies that cannot be followed to the tolerance, whose rows are NaN then

    Raises
    ------
    ToleranceError, InputError : as `torqued.solve` and `torqued.choose`, of the body that is named.
    """
    seconds, rest = integration.two_part(instants)
    out = np.empty((len(bodies), TOLD, seconds.size))
    size = max(1, ROOM // (OUTPUTS * max(1, seconds.size)))
    for first in range(0, len(bodies), size):
        part = slice(first, first + size)
        for i in _solve_block(problem, bodies.some(part), (seconds, rest), candidate, out[part]):
            with named(bodies, first + i, lost):
                out[first + i] = np.nan
                out[first + i] = _alone(problem, bodies.initial_state(problem.like, first + i), instants)
    return out


def _alone(problem: Problem, initial_state: InitialState, instants: Instants) -> np.ndarray:
    changes = _changes(problem, initial_state)
    found = integration.choose(initial_state, *changes, problem.tolerance, problem.kind)
    return integration.solve(initial_state, *changes, instants, problem.tolerance, found).rows[:TOLD]


def _solve_block(
    problem: Problem,
    bodies: Bodies,
    instants: tuple[np.ndarray, np.ndarray],
    candidate: Candidate,
    out: np.ndarray,
) -> list[int]:
    """Fills the rows of those whose estimates are below the tolerance; returns the others."""
    angles = (paces(problem, bodies) * _span(problem.like)).tolist()
    settings = dict.fromkeys(range(len(bodies)), candidate.setting)
    for _ in range(ROUNDS):
        if not settings:
            break
        left = np.array(list(settings))
        fine, apart = _compared(problem, bodies, left, instants, candidate, np.array(list(settings.values())))
        for k, i in enumerate(left.tolist()):
            setting, error = settings.pop(i), np.inf
            if apart[k] < np.inf:
                error = integration.estimate(candidate.solver, fine.of(k), apart[k], angles[i]).error
            if error <= problem.tolerance:
                out[i] = fine.rows[k, :TOLD]
            else:
                mine = replace(candidate, setting=setting)
                settings[i] = integration.finer(
                    mine, problem.tolerance / error, fine.smooth, int(fine.steps[k])
                ).setting
    return sorted(settings)


def _compared(
    problem: Problem,
    bodies: Bodies,
    which: np.ndarray,
    instants: tuple[np.ndarray, np.ndarray],
    candidate: Candidate,
    settings: np.ndarray,
) -> tuple[Marches, list[float]]:
    """Solutions of some bodies, and how far (rad) each is from a coarser one: infinite where one failed."""
    part = bodies if len(which) == len(bodies) else bodies.some(which)
    seconds, rest = instants
    some = integration.checked(seconds.size)
    others = integration.spread(integration.by_direction(problem.like, problem.torques, problem.kicks))
    also = np.append(seconds[some], others), np.append(rest[some], np.zeros(others.size))
    fine = march(problem, part, (seconds, rest), candidate.solver, settings, False)
    coarse = march(problem, part, also, candidate.solver, settings, True)
    greatest = _farthest(fine.rows[:, :4, some], coarse.rows[:, :4, : some.size])
    well = (fine.failed == 0) & (coarse.failed == 0)
    well &= np.isfinite(fine.rows).all(axis=(1, 2)) & np.isfinite(coarse.rows).all(axis=(1, 2))
    pairs = zip(greatest.tolist(), well.tolist(), strict=True)
    apart = [2.0 * math.asin(min(1.0, math.sqrt(size))) if good else np.inf for size, good in pairs]
    carried, least = (
        coarse.symmetric & (candidate.solver is not RUNGE_KUTTA),
        np.asarray(part.body.moments).min(axis=1),
    )
    kicked = integration.inertial_kicks(problem.kicks)
    rates = integration.drifts(coarse.rows[:, :, some.size :], carried, coarse.steps, least, kicked)
    span = _span(problem.like)
    return fine._replace(drift=span * rates, growth=span * kicked / least), apart


def _farthest(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(n,), of attitudes (n, 4, m): the greatest square of vec(conj(p) q) of each body."""
    (a, x, y, z), (b, u, v, w) = p.transpose(1, 0, 2), q.transpose(1, 0, 2)
    first = a * u - b * x - (y * w - z * v)
    second = a * v - b * y - (z * u - x * w)
    third = a * w - b * z - (x * v - y * u)
    greatest: np.ndarray = (first * first + second * second + third * third).max(axis=1, initial=0.0)
    return greatest


def _span(initial_state: InitialState) -> float:
    return max(abs(initial_state.start), abs(initial_state.stop))


def paces(problem: Problem, bodies: Bodies) -> np.ndarray:
    """(n,), rad/s: `choice.pace` of each."""
    moments = np.asarray(bodies.body.moments)
    along = bodies.along_axes(bodies.rate)
    fastest, own, momentum = along, np.zeros(len(bodies)), np.zeros(len(bodies))
    for added in gained(problem.kicks, bodies.attitude):
        back = rotations.rotate(rotations.conjugate(bodies.attitude), added)
        rates = along + bodies.along_axes(back) / moments
        speed = _length(rates)
        fastest = np.where((speed > own)[:, None], rates, fastest)
        own, momentum = np.maximum(own, speed), np.maximum(momentum, _length(moments * rates))
    spin = free_spin(moments, fastest)
    size = sum((torque.sizes(moments, spin) for torque in problem.torques), np.zeros(len(bodies)))
    course = problem.like.orbit_path
    orbit = 2.0 * np.pi / course.period if course is not None else 0.0
    with np.errstate(over="ignore"):
        swung = np.sqrt(size / moments.min(axis=1))
    turning = np.maximum(own, momentum / moments.max(axis=1))
    greatest: np.ndarray = np.maximum(np.maximum(turning, swung), orbit)
    return greatest


def _length(vectors: np.ndarray) -> np.ndarray:
    x, y, z = (vectors * vectors).T
    length: np.ndarray = np.sqrt((x + y) + z)
    return length


# -- marching -----------------------------------------------------------------------------------------


def march(
    problem: Problem,
    bodies: Bodies,
    instants: tuple[np.ndarray, np.ndarray],
    solver: Solver,
    settings: np.ndarray,
    coarsely: bool,
) -> Marches:
    """All bodies to all instants, forwards and backwards from the epoch; settings (n,), one for each."""
    seconds, rest = instants
    n = len(bodies)
    counts = np.zeros((3, n), np.int64)
    rows, symmetric, smooth = np.full((n, OUTPUTS, seconds.size), np.nan), np.ones(n, np.bool_), True
    before = seconds < 0.0
    for cut in integration.by_direction(problem.like, problem.torques, problem.kicks):
        mine = np.flatnonzero(before if cut[-1].stop < 0.0 else ~before)
        if not mine.size:
            continue
        walk = _Walk(problem, bodies, solver, settings, coarsely, cut)
        for place in instants_within(cut, seconds[mine], rest[mine]):
            walk.on(seconds, rest, mine[place], rows)
        counts += walk.counts
        symmetric &= walk.symmetric
        smooth = smooth and walk.smooth
    return Marches(rows, counts[0], counts[1], counts[2], symmetric, smooth, np.zeros(n), np.zeros(n))


class _Walk:
    """All bodies on their way from the epoch outwards, leg by leg."""

    def __init__(
        self,
        problem: Problem,
        bodies: Bodies,
        solver: Solver,
        settings: np.ndarray,
        coarsely: bool,
        cut: list[Arc],
    ):
        self._problem, self._bodies, self._solver = problem, bodies, solver
        self._settings, self._coarsely, self._cut = settings, coarsely, iter(cut)
        self._sign = 1.0 if cut[-1].stop >= 0.0 else -1.0
        squares = (bodies.attitude * bodies.attitude).T
        length = np.sqrt((squares[0] + squares[1]) + (squares[2] + squares[3]))
        self._attitude = bodies.attitude / length[:, None]
        self._known = {id(torque): torque for torque in problem.torques}
        self.counts = np.zeros((3, len(bodies)), np.int64)  # steps, torques, failures
        self.symmetric, self.smooth = np.ones(len(bodies), np.bool_), True
        self._prepared: dict[tuple[int, ...], Prepared] = {}
        torques = self._torques(cut[0])
        momenta = arrays.initial_momenta(problem.like, bodies, torques)
        self._states = self._under(torques).states(self._attitude, momenta, bodies.rate)

    def on(self, seconds: np.ndarray, rest: np.ndarray, place: np.ndarray, rows: np.ndarray) -> None:
        """The next leg; fills the rows at those places of the instants."""
        leg = next(self._cut)
        torques = self._torques(leg)
        prepared = self._under(torques)
        for kick in leg.kicks:
            prepared.push(self._states, self._attitude, kick, self._sign)
        # the last column is the end of the leg
        at = np.append(seconds[place], leg.stop), np.append(rest[place], 0.0)
        out = np.full((len(self._bodies), OUTPUTS, place.size + 1), np.nan)
        well = (self.counts[2] == 0) & np.isfinite(self._states).all(axis=1)
        which = np.flatnonzero(well & prepared.can_be_taken_by(self._solver))
        part = Part(leg.start, leg.stop, *at, self._coarsely)
        task = _Task(self._solver, prepared, which, self._states, part, self._settings, out)
        self.counts[:, which] += _followed(task, torques)
        rows[:, :, place] = out[:, :, :-1]
        self._attitude = out[:, :4, -1]

    def _torques(self, leg: Arc) -> list[CachedTorque]:
        return [self._known[id(torque)] for torque in leg.torques]

    def _under(self, torques: Sequence[CachedTorque]) -> Prepared:
        key = tuple(id(torque) for torque in torques)
        if key not in self._prepared:
            prepare = arrays.most_symmetric if self._solver is COLLOCATION else arrays.ascending
            one = self._prepared[key] = prepare(self._problem.like, self._bodies, torques)
            self.symmetric &= one.symmetric == 1
            self.smooth = self.smooth and one.smooth
        return self._prepared[key]


class _Task(NamedTuple):
    """Bodies `which` of those prepared, to be marched over a part: it changes their states, and fills their
    rows of `out`.
    """

    solver: Solver
    prepared: Prepared
    which: np.ndarray
    states: np.ndarray
    part: Part
    settings: np.ndarray
    out: np.ndarray

    @property
    def begins(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Which bodies, from which states, when."""
        return self.which, self.states, np.array([self.part.start, 0.0])


def _followed(task: _Task, torques: Sequence[CachedTorque]) -> np.ndarray:
    """(3, k): steps, torques and failures of the bodies.

    What a function of the user's raised meanwhile is raised here, and Stopped.
    """
    try:
        work = MARCHES[task.solver.kind](task)
        stopping.current().check()
        return work
    finally:
        for torque in torques:
            torque.raise_failure()


def _collocate(task: _Task) -> np.ndarray:
    steps, counts = _steps(task), np.zeros((len(task.states), 2))
    compiled.collocate_each(
        *(*task.begins, task.part.stop, steps, task.prepared.body, task.prepared.symmetric),
        *_asked(task),
        *(schemes.gauss().copy(), counts, stopping.current().flag),
    )
    sweeps, failed = counts[task.which].astype(np.int64).T
    return np.stack([steps[task.which], sweeps * layout.NODES, failed])


def _split(task: _Task) -> np.ndarray:
    steps = _steps(task)
    composition = schemes.COMPOSITIONS[task.solver.name.partition(", ")[2]]
    compiled.split_each(
        *(*task.begins, task.part.stop, steps),
        *(composition.drifts, composition.kicks, task.prepared.body, task.prepared.symmetric),
        *_asked(task),
        *(np.empty((6, layout.NODES)), stopping.current().flag),
    )
    return np.stack([steps, steps * len(composition.kicks), np.zeros_like(steps)])[:, task.which]


def _runge_kutta(task: _Task) -> np.ndarray:
    counts, span = np.zeros((len(task.states), 3)), task.part.stop - task.part.start
    inverses = task.prepared.body[:, layout.INVERSES : layout.INVERSES + 3]
    rate = _length(inverses) * _length(task.states[:, layout.MOMENTUM : layout.MOMENTUM + 3])
    with np.errstate(divide="ignore"):
        first = np.copysign(np.minimum(abs(span), 0.1 / rate), span)
    compiled.runge_kutta_each(
        *(*task.begins, np.array([task.part.stop, 0.0]), first),
        task.settings * task.solver.coarser if task.part.coarsely else task.settings,
        *(dormand_prince(), task.prepared.body),
        *_asked(task, states=2),
        *(np.empty(13 * 7), counts, task.part.most, stopping.current().flag),
    )
    taken, refused, shrunk = counts[task.which].astype(np.int64).T
    return np.stack([taken, 12 * (taken + refused), shrunk])


def _steps(task: _Task) -> np.ndarray:
    """(n,): of each body, by its setting."""
    different, of = np.unique(task.settings, return_inverse=True)
    return np.array([steps_of(task.part, setting) for setting in different.tolist()])[of]


def _asked(task: _Task, states: int = 1) -> tuple[np.ndarray, ...]:
    """What every solver is told, and where it writes, as `solvers` hands it over."""
    spare = np.empty(states * layout.STATE)
    world = task.prepared.effects, *task.prepared.world
    return (*world, task.part.seconds, task.part.rest, task.out, spare)


MARCHES: dict[str, Callable[[_Task], np.ndarray]] = {
    "gauss": _collocate,
    "splitting": _split,
    "dop853": _runge_kutta,
}

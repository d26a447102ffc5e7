"""Where the search begins when no start is given: states from the observations, on a grid of inertia.

A motion is first fitted to a few observations about an anchor, then to more and more of them: over long
spans the sum of squares has a minimum for every number of turns that might have been missed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np

from .. import stopping
from ..errors import InputError, ToleranceError
from ..frames import rotations
from ..motion import TorqueFreeMotion
from ..rigid_body.body import RigidBody
from .least_squares import Loss, Problem, since
from .observations import Attitudes, BodyRates, Directions, ObservationSet
from .parameters import BodyState, exponential

# Moments over the least, of bodies that no two of the grid are like: from nearly a sphere to a needle.
RATIOS = ((1.0, 1.1, 1.2), (1.0, 1.3, 2.0), (1.0, 1.7, 2.0), (1.0, 2.2, 2.6), (1.0, 3.2, 3.5))
FIRST_WINDOW, GROWTH, MAX_IN_WINDOW = 8, 4, 400  # observations of each set
KEPT_AT_FIRST, KEPT = 24, 6  # candidates
PRIOR = 0.5  # natural units: what few observations do not see stays near the candidate's
LARGE_TURN = 2.0  # rad between neighbours, beyond which a whole turn may have been missed
RANDOM_STATES = 1000
INDISTINCT = 9.0  # difference of chi-square up to which minima cannot be told apart: three sigma
SAME = 1e-4  # relative difference of two candidates that are one


def search(
    sets: Sequence[ObservationSet], template: BodyState, groups: tuple[str, ...], grid: bool, loss: Loss
) -> list[BodyState]:
    """States at the epoch, the best first, from which the least squares may start.

    template : epoch, frame and inertia; grid : whether other inertia is tried too
    """
    seconds = [each.instants(template.epoch).seconds for each in sets]
    timed = max(range(len(sets)), key=lambda i: (isinstance(sets[i], Attitudes), len(sets[i])))
    anchor = float(seconds[timed][np.argmin(np.abs(seconds[timed]))])
    bodies = [template, *(_grid(template) if grid else ())]
    states = [replace(body, attitude=q, rate=w) for q, w in _states(sets, seconds, anchor) for body in bodies]
    if not states:
        raise InputError("start", None, "a motion to start from: these observations are too few to find one")
    most = max(map(len, sets))
    size, kept = FIRST_WINDOW, KEPT_AT_FIRST
    while True:
        window = [_window(each, times, anchor, size) for each, times in zip(sets, seconds, strict=True)]
        minima = _improved(_best(window, states, anchor, kept), window, groups, loss, anchor)
        states, lowest = [state for _, state in minima], minima[0][0]
        if size >= most:
            break
        size, kept = size * GROWTH, KEPT
    limit = lowest + INDISTINCT * max(1.0, lowest / sum(len(each) * each.DEGREES for each in window))
    return [_moved(state, -anchor) for cost, state in minima if cost <= limit]


def _window(each: ObservationSet, seconds: np.ndarray, anchor: float, size: int) -> ObservationSet:
    """The nearest so many observations to the anchor, thinned to MAX_IN_WINDOW."""
    nearest = np.argsort(np.abs(seconds - anchor), kind="stable")[:size]
    return each[nearest[:: -(-len(nearest) // MAX_IN_WINDOW)]]


def _grid(template: BodyState) -> Iterator[BodyState]:
    scale = template.moments.min()
    for ratios in RATIOS:
        for order in permutations(ratios):
            yield replace(template, moments=scale * np.array(order))


def _states(
    sets: Sequence[ObservationSet], seconds: Sequence[np.ndarray], anchor: float
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Attitudes and rates that there may be at the anchor."""
    rates = [
        each.rate[np.argmin(np.abs(times - anchor))]
        for each, times in zip(sets, seconds, strict=True)
        if isinstance(each, BodyRates)
    ]
    attitudes = [
        (each, times) for each, times in zip(sets, seconds, strict=True) if isinstance(each, Attitudes)
    ]
    for each, times in attitudes:
        nearest = np.argsort(np.abs(times - anchor), kind="stable")[:2]
        for q, t in zip(each.attitude[nearest], times[nearest], strict=True):  # one of which may be off
            for rate in rates or _differences(each.attitude, times, anchor):
                yield rotations.product(q, exponential(rate * (anchor - t))), rate
    if not attitudes and any(isinstance(each, Directions) for each in sets):
        yield from _random_states(seconds, rates)


def _differences(attitude: np.ndarray, seconds: np.ndarray, anchor: float) -> Iterator[np.ndarray]:
    """Mean rates between attitudes about the anchor; with whole turns more where these are far apart."""
    distinct, first = np.unique(seconds, return_index=True)
    middle = int(np.searchsorted(distinct, anchor))
    pairs = [
        i
        for i in (middle - 1, middle, middle - 2, middle + 1, middle - 3, middle + 2)
        if 0 <= i < len(distinct) - 1
    ]
    for i in pairs:
        turn = rotations.rotation_vectors(attitude[first[i]], attitude[first[i + 1]])
        interval, angle = distinct[i + 1] - distinct[i], float(np.sqrt(turn @ turn))
        yield turn / interval
        if angle > LARGE_TURN:
            for turns in (-1, 1):
                yield turn * (1.0 + turns * 2.0 * np.pi / angle) / interval


def _random_states(
    seconds: Sequence[np.ndarray], rates: Sequence[np.ndarray]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Attitudes at random, and rates up to half a turn between neighbours where none was observed."""
    random = np.random.default_rng(0)
    gaps = np.diff(np.unique(np.concatenate(seconds)))
    limit = np.pi / np.median(gaps) if gaps.size else 0.0
    for _ in range(RANDOM_STATES):
        q, w = random.normal(size=4), random.normal(size=3)
        size = limit * random.random() / np.sqrt(w @ w)
        yield q / np.sqrt(q @ q), rates[0] if rates else w * size


def _best(
    window: Sequence[ObservationSet], states: Sequence[BodyState], anchor: float, count: int
) -> list[BodyState]:
    """The candidates with the least sums of squares; all motions are computed in one batch."""
    if len(states) == 1:
        return list(states)
    tensors = np.array([state.tensor for state in states])
    attitudes, rates = (np.array([getattr(state, name) for state in states]) for name in ("attitude", "rate"))
    body = RigidBody(tensors, physical=False)
    motions = TorqueFreeMotion(body, attitudes, rates, None, "wxyz", states[0].frame)
    cost = np.zeros(len(states))
    for each in window:
        ephemeris = motions.ephemeris(since(each.instants(states[0].epoch), anchor), rate=True)
        for i in range(len(states)):
            stopping.check()
            residuals = each.residuals(
                ephemeris.attitude[i], ephemeris.computed_rate[i], np.zeros(each.biases)
            )
            cost[i] += np.log1p(((residuals * each.weights) ** 2).sum(axis=1)).sum()
    return [states[i] for i in np.argsort(cost, kind="stable")[:count]]


def _improved(
    states: Iterable[BodyState],
    window: Sequence[ObservationSet],
    groups: tuple[str, ...],
    loss: Loss,
    anchor: float,
) -> list[tuple[float, BodyState]]:
    """The minima near these states, the lowest first, each once; none that is far above the lowest."""
    minima: list[tuple[float, BodyState]] = []
    for state in states:
        problem = Problem(window, state, groups, loss, anchor, PRIOR)
        try:
            with np.errstate(over="raise"):
                x, _ = problem.minimize(np.zeros(len(problem.parameters.names)), None, 1e-6, 20)
        except (ToleranceError, FloatingPointError):
            continue  # it ran off, to rates or moments beyond any
        at_minimum = problem.parameters.state(x)
        if not any(_same(at_minimum, other) for _, other in minima):
            minima.append((problem.at(x).cost, at_minimum))
    if not minima:
        raise InputError("start", None, "a motion to start from: none was found that these observations fit")
    minima.sort(key=lambda each: each[0])
    count = sum(map(len, window))
    return [each for each in minima if each[0] <= 4.0 * minima[0][0] + 4.0 * count]


def _same(one: BodyState, other: BodyState) -> bool:
    """Whether two states are one motion, whatever the scale of inertia and the order of its axes."""
    size = np.sqrt(one.rate @ one.rate)
    return bool(
        rotations.angle_between(one.attitude, other.attitude) < SAME
        and np.abs(one.rate - other.rate).max() <= SAME * size
        and np.abs(one.tensor / np.trace(one.tensor) - other.tensor / np.trace(other.tensor)).max() < SAME
    )


def _moved(state: BodyState, seconds: float) -> BodyState:
    """The state so much later, of the same motion."""
    motion = replace(state, epoch=None).motion().at(seconds)
    return replace(state, attitude=motion.quaternion("wxyz"), rate=motion.angular_velocity)

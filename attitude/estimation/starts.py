"""Where the search begins when no start is given: states from the observations, on a grid of inertia.

A motion is first fitted to a few observations about an anchor, then to more and more of them: over long
spans the sum of squares has a minimum for every number of turns that might have been missed.  Any of the few
may be wrong, so that candidates are made of all of them, and judged by all.  Where most observations disagree
with what was found, there are other anchors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import permutations
from typing import NamedTuple

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
MAX_IN_WINDOW = 400  # observations of each set
INDISTINCT = 9.0  # difference of chi-square up to which minima cannot be told apart: three sigma


class StartCandidate(NamedTuple):
    """A minimum: the cost of the observations it was fitted to, the part of them that it meets, the state."""

    cost: float
    met: float
    state: BodyState


class StartStates(NamedTuple):
    """Attitudes (n, 4) and rates (n, 3) that there may be at an anchor; (n,) which of them are of a kind."""

    attitude: np.ndarray
    rate: np.ndarray
    kind: np.ndarray

    @classmethod
    def about(cls, window: Sequence[ObservationSet], anchor: float) -> StartStates:
        """Every attitude of the window with every rate observed in it, or that two attitudes make."""
        attitudes = [each for each in window if isinstance(each, Attitudes)]
        rates = [each.rate for each in window if isinstance(each, BodyRates)]
        if not attitudes:
            return cls.at_random(window, rates)
        kinds = [np.zeros(len(each), dtype=int) for each in rates]
        if not rates:
            rates, kinds = zip(*map(_differences, attitudes), strict=True)
        rate, kind = np.concatenate(rates), np.concatenate(kinds)
        q = np.concatenate([each.attitude for each in attitudes])
        earlier = anchor - np.concatenate([each.times.seconds for each in attitudes])
        moved = rotations.product(q[:, None], exponential(earlier[:, None, None] * rate))
        return cls(moved.reshape(-1, 4), np.tile(rate, (len(q), 1)), np.tile(kind, len(q)))

    @classmethod
    def at_random(cls, window: Sequence[ObservationSet], rates: Sequence[np.ndarray]) -> StartStates:
        """Attitudes at random, with rates up to half a turn between neighbours where none was observed."""
        if not any(isinstance(each, Directions) for each in window):
            expected = "a motion to start from, beside rates and ranges, which do not show the attitude alone"
            raise InputError("start", None, expected)
        random, count = np.random.default_rng(0), 1000
        gaps = np.diff(np.unique(np.concatenate([each.times.seconds for each in window])))
        limit = np.pi / np.median(gaps) if gaps.size else 0.0
        q, w = random.normal(size=(count, 4)), random.normal(size=(count, 3))
        w *= limit * random.random((count, 1)) / np.linalg.norm(w, axis=1, keepdims=True)
        if rates:
            observed = np.concatenate(rates)
            w = observed[np.arange(count) % len(observed)]
        return cls(q / np.linalg.norm(q, axis=1, keepdims=True), w, np.arange(count))


def search(
    sets: Sequence[ObservationSet],
    template: BodyState,
    groups: tuple[str, ...],
    grid: bool,
    loss: Loss,
    progress: Callable[[float], None],
) -> list[StartCandidate]:
    """States at the epoch, the best first, from which the least squares may start.

    sets : whose times are `Instants`
    template : epoch, frame and inertia; grid : whether other inertia is tried too
    progress : called with the fraction that is done
    """
    timed = max(sets, key=lambda each: (isinstance(each, Attitudes), len(each)))
    seconds = np.sort(timed.times.seconds)
    ratios = [order for each in RATIOS for order in permutations(each)] if grid else []
    least = template.moments.min()
    bodies = [template, *(replace(template, moments=least * np.array(each)) for each in ratios)]
    candidates: list[StartCandidate] = []
    indices = dict.fromkeys((int(np.argmin(np.abs(seconds))), len(seconds) // 2, len(seconds) - 1, 0))
    for done, index in enumerate(indices):
        progress(done / len(indices))
        anchor = float(seconds[index])
        for each in _search_about(anchor, sets, bodies, groups, loss):
            moved = each._replace(state=each.state.after(-anchor))
            if not any(moved.state.is_near(other.state) for other in candidates):
                candidates.append(moved)
        if any(each.met > 0.5 for each in candidates):
            break
    if not candidates:
        raise InputError("start", None, "a motion to start from: none was found that these observations fit")
    candidates.sort(key=lambda each: each.cost)
    lowest, count = candidates[0].cost, sum(min(len(each), MAX_IN_WINDOW) * each.DEGREES for each in sets)
    limit = lowest + INDISTINCT * max(1.0, lowest / count)
    return [each for each in candidates if each.cost <= limit]


def _search_about(
    anchor: float,
    sets: Sequence[ObservationSet],
    bodies: Sequence[BodyState],
    groups: tuple[str, ...],
    loss: Loss,
) -> list[StartCandidate]:
    """Minima near an anchor, the lowest first, with their states there.

    Of eight observations of each set about it, then of four times as many, and so on; six candidates go on.
    """
    size, window = 8, [_window(each, anchor, 8) for each in sets]
    states = _first_states(window, bodies, anchor)
    while True:
        minima = _improved(states, window, groups, loss, anchor)
        if size >= max(map(len, sets)) or not minima:
            return minima
        size *= 4
        window = [_window(each, anchor, size) for each in sets]
        found = [each.state for each in minima]
        attitudes, rates = (
            np.array([getattr(each, name) for each in found]) for name in ("attitude", "rate")
        )
        cost = _costs(window, np.array([each.tensor for each in found]), attitudes, rates, anchor)
        states = [found[i] for i in np.argsort(cost, kind="stable")[:6]]


def _window(each: ObservationSet, anchor: float, size: int) -> ObservationSet:
    """The nearest so many observations to the anchor, thinned to MAX_IN_WINDOW."""
    nearest = np.sort(np.argsort(np.abs(each.times.seconds - anchor), kind="stable")[:size])
    return each[nearest[:: -(-len(nearest) // MAX_IN_WINDOW)]]


def _first_states(
    window: Sequence[ObservationSet], bodies: Sequence[BodyState], anchor: float
) -> list[BodyState]:
    """The 24 best of the states that most observations agree with, of each body and kind the best."""
    states = StartStates.about(window, anchor)
    if not len(states.kind):
        raise InputError(
            "start", None, "a motion to start from: attitudes at two instants, or rates, at least"
        )
    tensors = np.array([body.tensor for body in bodies])
    cost = _costs(window, tensors[:, None], states.attitude, states.rate, anchor)
    order = np.argsort(cost, axis=None, kind="stable")
    body, state = np.unravel_index(order, cost.shape)
    _, first = np.unique(np.stack([body, states.kind[state]]), axis=1, return_index=True)
    return [
        replace(bodies[body[i]], attitude=states.attitude[state[i]], rate=states.rate[state[i]])
        for i in np.sort(first)[:24]
    ]


def _differences(each: Attitudes) -> tuple[np.ndarray, np.ndarray]:
    """Mean rates (n, 3) between any two attitudes, and the number of whole turns that each has more, (n,).

    Whole turns are tried between neighbours that are more than 2 rad apart, where one may have been missed.
    """
    seconds, first = np.unique(each.times.seconds, return_index=True)
    i, j = np.triu_indices(len(seconds), 1)
    interval = (seconds[j] - seconds[i])[:, None]
    turn = rotations.rotation_vectors(each.attitude[first[i]], each.attitude[first[j]])
    angle = np.linalg.norm(turn, axis=1, keepdims=True)
    far = (j == i + 1) & (angle[:, 0] > 2.0)
    whole = 2.0 * np.pi * turn[far] / angle[far]
    turns = np.concatenate(
        [turn / interval, (turn[far] - whole) / interval[far], (turn[far] + whole) / interval[far]]
    )
    return turns, np.repeat([0, -1, 1], [len(turn), len(whole), len(whole)])


def _costs(
    window: Sequence[ObservationSet],
    tensors: np.ndarray,
    attitude: np.ndarray,
    rate: np.ndarray,
    anchor: float,
) -> np.ndarray:
    """(...), logarithmic, of motions whose inertia (..., 3, 3), attitudes and rates broadcast."""
    motions = TorqueFreeMotion(RigidBody(tensors, physical=False), attitude, rate, order="wxyz")
    cost = np.zeros(motions.shape)
    for each in window:
        stopping.check()
        ephemeris = motions.ephemeris(since(each.times, anchor), rate=True)
        repeated = each[np.tile(np.arange(len(each)), cost.size)]
        residuals = repeated.residuals(
            ephemeris.attitude.reshape(-1, 4), ephemeris.computed_rate.reshape(-1, 3), np.zeros(each.biases)
        )
        square = ((residuals * repeated.weights) ** 2).sum(axis=1)
        cost += np.log1p(square).reshape(*cost.shape, len(each)).sum(axis=-1)
    return cost


def _improved(
    states: Sequence[BodyState],
    window: Sequence[ObservationSet],
    groups: tuple[str, ...],
    loss: Loss,
    anchor: float,
) -> list[StartCandidate]:
    """The minima near these states, the lowest first, each once; none that is far above the lowest."""
    from scipy.special import chdtri

    minima: list[StartCandidate] = []
    for state in states:
        # what few observations do not see stays near the candidate's
        problem = Problem(window, state, groups, loss, anchor, prior=0.5)
        try:
            with np.errstate(over="raise"):
                x, _ = problem.minimize(np.zeros(len(problem.parameters.names)), None, 1e-6, 20)
        except (ToleranceError, FloatingPointError):
            continue  # it ran off, to rates or moments beyond any
        at_minimum, linear = problem.parameters.state(x), problem.at(x)
        if not any(at_minimum.is_near(other.state) for other in minima):
            squares = zip(window, linear.squares, strict=True)
            # met: chance explains the residual, with a probability of 0.001
            is_met = np.concatenate([square <= chdtri(each.DEGREES, 0.001) for each, square in squares])
            minima.append(StartCandidate(linear.cost, float(is_met.mean()), at_minimum))
    minima.sort(key=lambda each: each.cost)
    count = sum(map(len, window))
    return [each for each in minima if each.cost <= 4.0 * minima[0].cost + 4.0 * count]

"""All sign changes of functions of time whose rate of change is bounded: none is missed.

Between instants a and b a function f with abs(f') <= R has no zero where abs(f(a)) + abs(f(b)) > R (b - a).
Other intervals are halved, all of one length together, until they are narrower than a stated width; those
that then have ends of opposite signs hold a crossing, which Chandrupatla's method refines.  What can be
missed are two crossings closer to each other than that width.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from .. import stopping
from ..errors import RegimeError
from ..samples.chunks import Progress
from ..times.two_part import two_sum

MAX_INTERVALS_PER_BLOCK = 1 << 18  # first intervals of a block
MAX_OPEN_INTERVALS = 1 << 20  # at one length, which a function that stays at zero passes
ROOT_TOLERANCE = 1e-10  # s
ROOT_RELATIVE_TOLERANCE = 4.5e-16  # of offsets from the base: two of their last places


class Sample(NamedTuple):
    """A function at instants.

    values : (n,)
    state : (n, k), whatever the bound on the rate of change in the time after them depends on
    """

    values: np.ndarray
    state: np.ndarray


class BoundedFunction(Protocol):
    """A function of time and a bound on how fast it changes."""

    def __call__(self, seconds: np.ndarray, seconds_low: np.ndarray) -> Sample:
        """The function at instants (n,), ascending, s since the epoch in two parts."""

    def max_rate(self, state: np.ndarray, duration: np.ndarray) -> np.ndarray:
        """(n,) per s: bounds over durations (n,), s, that begin with states (n, k)."""


class Crossings(NamedTuple):
    """Where a function changes its sign.

    starts_negative : whether it is below zero at the start of the span
    seconds, seconds_low : (n,) s since the epoch in two parts, ascending
    """

    starts_negative: bool
    seconds: np.ndarray
    seconds_low: np.ndarray


class Intervals(NamedTuple):
    """Intervals, and the function at their ends.

    base : (n,) s since the epoch; left, right : (n,) s from there
    left_values, right_values : (n,); state : (n, k), at the left ends
    """

    base: np.ndarray
    left: np.ndarray
    right: np.ndarray
    left_values: np.ndarray
    right_values: np.ndarray
    state: np.ndarray

    def part(self, key: np.ndarray) -> Intervals:
        """The intervals of a mask, or of indices."""
        return Intervals(*(array[key] for array in self))

    @property
    def duration(self) -> np.ndarray:
        """(n,) s."""
        return self.right - self.left

    @property
    def changes_sign(self) -> np.ndarray:
        """(n,): whether the ends lie on different sides of zero."""
        return (self.left_values < 0.0) != (self.right_values < 0.0)


def crossings(
    function: BoundedFunction,
    start: float,
    stop: float,
    width: float,
    cuts: Sequence[float] = (),
    progress: Progress | None = None,
) -> Crossings:
    """The sign changes of a function from start to stop, s since the epoch.

    Parameters
    ----------
    width : s; two crossings closer to each other than this may be missed
    cuts : s, instants where the rate of change, or the function, jumps: no bound holds across them
    progress : called with the fraction of the span that is searched

    Raises
    ------
    RegimeError : the function stays at zero, as far as doubles tell.
    """
    inner = np.array(sorted({cut for cut in cuts if start < cut < stop}))
    begins = np.append(start, inner)
    # the last instant of a piece is before what happens at the cut, which may change the function itself
    ends = np.append(np.nextafter(inner, -np.inf), np.nextafter(stop, start) if stop in cuts else stop)
    at_ends = np.stack([begins, ends], axis=1).reshape(-1)
    sample = function(at_ends, np.zeros_like(at_ends))
    is_negative = (sample.values < 0.0).reshape(-1, 2)
    jumps = inner[is_negative[:-1, 1] != is_negative[1:, 0]]
    found = [(jumps, np.zeros_like(jumps))]
    for i, (begin, end) in enumerate(zip(begins, ends, strict=True)):
        reached, state = begin, sample.state[2 * i]
        while reached < end:
            intervals, after, state = _first_intervals(function, reached, end, state)
            halvings = max(0.0, math.log2(intervals.duration.max() / width))
            brackets: list[Intervals] = []
            for k, narrow in enumerate(_brackets(function, intervals, width)):
                brackets.append(narrow)
                if progress is not None:
                    done = min(1.0, k / (halvings + 20))  # the refinement takes about 20 steps
                    progress((reached - start + done * (after - reached)) / (stop - start))
            merged = Intervals(*(np.concatenate(parts) for parts in zip(*brackets, strict=True)))
            found.append(_refined(function, merged.part(np.lexsort((merged.left, merged.base)))))
            reached = after
    seconds, low = (np.concatenate(parts) for parts in zip(*found, strict=True))
    order = np.lexsort((low, seconds))
    return Crossings(bool(is_negative[0, 0]), seconds[order], low[order])


def _first_intervals(
    function: BoundedFunction, start: float, stop: float, state: np.ndarray
) -> tuple[Intervals, float, np.ndarray]:
    """Equal intervals from the start, as many as a block holds; where they end, s, and the state there.

    state : (k,), at the start
    """
    rate = float(function.max_rate(state[None], np.zeros(1))[0])
    # in each a function changes by 1/2 at the most
    count = np.ceil(rate * (stop - start) / 0.5) if np.isfinite(rate) else 1.0
    end = stop  # not a sum, whose rounding could lead beyond it
    if count > MAX_INTERVALS_PER_BLOCK:
        block = (stop - start) * (MAX_INTERVALS_PER_BLOCK / count)
        end, count = min(stop, max(start + block, np.nextafter(start, stop))), MAX_INTERVALS_PER_BLOCK
    nodes = np.unique(np.linspace(start, end, int(max(count, 1.0)) + 1))
    sample = function(nodes, np.zeros_like(nodes))
    base, values = nodes[:-1], sample.values
    intervals = Intervals(
        base, np.zeros_like(base), np.diff(nodes), values[:-1], values[1:], sample.state[:-1]
    )
    return intervals, float(nodes[-1]), sample.state[-1]


def _brackets(function: BoundedFunction, intervals: Intervals, width: float) -> Iterator[Intervals]:
    """The intervals, none longer than `width`, in which the function changes its sign: after each halving."""
    while intervals.base.size:
        stopping.check()
        reach = function.max_rate(intervals.state, intervals.duration) * intervals.duration
        beyond = np.abs(intervals.left_values) + np.abs(intervals.right_values) > reach
        intervals = intervals.part(~beyond | intervals.changes_sign)
        rounding = ROOT_RELATIVE_TOLERANCE * intervals.right  # below it nothing can be halved
        narrow = intervals.duration <= np.maximum(width, rounding)
        yield intervals.part(narrow & intervals.changes_sign)
        intervals = intervals.part(~narrow)
        if intervals.base.size > MAX_OPEN_INTERVALS:
            raise RegimeError(
                f"windows: from {intervals.base[0]:.9g} s on the value stays so close to the threshold that "
                "no crossings can be found; another threshold, or a greater width, is needed"
            )
        intervals = _halved(function, intervals)


def _halved(function: BoundedFunction, intervals: Intervals) -> Intervals:
    if not intervals.base.size:
        return intervals
    middle = 0.5 * (intervals.left + intervals.right)
    sample = function(*two_sum(intervals.base, middle))

    def interleaved(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return np.stack([one, other], axis=1).reshape(-1, *one.shape[1:])

    return Intervals(
        np.repeat(intervals.base, 2),
        interleaved(intervals.left, middle),
        interleaved(middle, intervals.right),
        interleaved(intervals.left_values, sample.values),
        interleaved(sample.values, intervals.right_values),
        interleaved(intervals.state, sample.state),
    )


def _refined(function: BoundedFunction, brackets: Intervals) -> tuple[np.ndarray, np.ndarray]:
    """(n,), (n,) s since the epoch in two parts, of the crossings in brackets."""
    from scipy.optimize.elementwise import find_root

    if not brackets.base.size:
        return np.zeros(0), np.zeros(0)
    result = find_root(
        lambda offset, base: function(*two_sum(base, offset)).values,
        (brackets.left, brackets.right),
        args=(brackets.base,),
        tolerances={"xatol": ROOT_TOLERANCE, "xrtol": ROOT_RELATIVE_TOLERANCE, "fatol": 0.0, "frtol": 0.0},
    )
    # A value within rounding of zero may change its sign when it is computed again: it is the crossing.
    is_left = np.abs(brackets.left_values) < np.abs(brackets.right_values)
    nearest = np.where(is_left, brackets.left, brackets.right)
    is_invalid = result.status == -1  # as SciPy calls a bracket without a change of sign
    return two_sum(brackets.base, np.where(is_invalid, nearest, result.x))

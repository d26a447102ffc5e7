"""The instants that an interpolating reader is given, and how far off it will be between them."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .. import units
from ..elapsed import Grid, Instants
from ..errors import FormatError, InputError
from .interpolant import Interpolant as Interpolant
from .samples import Samples

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris

# Where the rate jumps, or a reader of somebody's file was told not to interpolate across.
CUTS = ("impulse", "contact", "segment")
LEAST_TOLERANCE, GREATEST_TOLERANCE = 1e-13, 1.0  # rad
MOST_NODES = 100_000_000  # in a file
PLACES = 64  # where a spacing is tried before it is checked everywhere
ROUNDS = 30
CHECKED = 1 << 16  # intervals at a time
CHECKED_AT_ONCE = 1 << 20
CONTACT_WITHIN = 1e-11  # s: how well the instant of a contact is known, on either side of which rates differ
LAST_SHORT = 1e-3  # of a step: where less would be left, the last one is so much longer


class Written(NamedTuple):
    """What became of an ephemeris on its way to a file.

    nodes : instants written
    interpolation_error : rad; the greatest found between them, where the format's readers interpolate and
        the motion is there to compare with; else None
    """

    nodes: int
    interpolation_error: float | None = None


class Nodes(NamedTuple):
    """One body's instants, in segments across which nobody may interpolate.

    segments : each at least one instant, in increasing order
    interpolant : what their readers do between them
    worst : rad, or None where it is not known
    """

    segments: tuple[Samples, ...]
    interpolant: Interpolant
    worst: float | None

    @property
    def written(self) -> Written:
        return Written(sum(segment.count for segment in self.segments), self.worst)

    @property
    def remark(self) -> str:
        """For people who read the file."""
        if self.worst is None:
            return "Error of interpolation between these attitudes is not known"
        return f"Error of interpolation ({self.interpolant}) at the midpoints is at most {self.worst:.1e} rad"


def chosen(
    samples: Samples, interpolant: Interpolant, tolerance: Any = None, most: int = MOST_NODES
) -> Nodes:
    """The given instants, or at `most` so many that interpolation errs by less than `tolerance`, rad."""
    if not samples.is_list:
        raise FormatError(f"one body at a list of instants is written, not shape {samples.shape}")
    if tolerance is None:
        segments = given(samples)
        known = samples.head.can_be_resampled
        return Nodes(tuple(segments), interpolant, _worst(segments, interpolant) if known else None)
    return _spaced(samples, interpolant, _check_tolerance(tolerance, samples.head), most)


def _check_tolerance(tolerance: Any, head: Ephemeris) -> float:
    angle = float(units.si_array(tolerance, units.ANGLE, "interpolation_error"))
    if not LEAST_TOLERANCE <= angle <= GREATEST_TOLERANCE:
        expected = f"an angle from {LEAST_TOLERANCE:g} to {GREATEST_TOLERANCE:g} rad"
        raise InputError("interpolation_error", tolerance, expected)
    if not head.can_be_resampled:
        expected = "none for an ephemeris read from a file: its motion is not known between the attitudes"
        raise InputError("interpolation_error", tolerance, expected)
    return angle


# -- the instants as they are given ---------------------------------------------------------------


def given(samples: Samples) -> list[Samples]:
    """Cut where the rate jumps; an instant at a cut is the first of what follows."""
    at = [event.seconds for event in samples.head.events if event.kind in CUTS]
    if not at:
        return [samples]
    seconds = np.concatenate([piece.elapsed for piece in samples.pieces()])
    edges = [0, *sorted({int(i) for i in np.searchsorted(seconds, at)} - {0, samples.count}), samples.count]
    return [_part(samples, first, last) for first, last in pairwise(edges)]


def _part(samples: Samples, first: int, last: int) -> Samples:
    return Samples(last - first, lambda a, b: samples.cut(first + a, first + b), samples.progress)


# -- instants chosen for a tolerance --------------------------------------------------------------


def _spaced(samples: Samples, interpolant: Interpolant, tolerance: float, most: int) -> Nodes:
    """Evenly, as far apart in each span between events as the tolerance lets them be."""
    segments: list[Samples] = []
    worst = 0.0
    for start, stop in _spans(samples):
        left = most - sum(segment.count for segment in segments)
        segment, found = _kept(samples, interpolant, tolerance, start, stop, left)
        segments.append(segment)
        worst = max(worst, found)
    return Nodes(tuple(segments), interpolant, worst)


def _kept(
    samples: Samples, interpolant: Interpolant, tolerance: float, start: float, stop: float, most: int
) -> tuple[Samples, float]:
    """Even nodes of a span that keep the tolerance everywhere, and what they err by."""
    step = _tried(samples.head, interpolant, tolerance, start, stop, most)
    for _ in range(ROUNDS):
        if (stop - start) / step > most - 1:
            expected = f"an angle that no more than {most} nodes can keep to"
            raise InputError("interpolation_error", tolerance, expected)
        segment = _even(samples, start, stop, step)
        found = _worst([segment], interpolant)
        if found <= tolerance:
            return segment, found
        step = _rounded(step * min(0.98, 0.97 * (tolerance / found) ** (1.0 / interpolant.order)))
    raise InputError("interpolation_error", tolerance, f"an angle above {found:.1e} rad")


def _spans(samples: Samples) -> list[tuple[float, float]]:
    """First and last instant of each span between events; one instant is its own first and last.

    A span ends just before its event, for what that changes comes after.
    """
    first, last = float(samples.head.elapsed[0]), float(samples.tail.elapsed[0])
    if last < first:
        raise FormatError("the last instant is before the first")
    between = {event.seconds: event.kind for event in samples.head.events if first < event.seconds < last}
    starts, stops = [first], []
    for at, kind in sorted(between.items()):
        room = CONTACT_WITHIN if kind == "contact" else 0.0
        stops.append(max(starts[-1], min(at - room, float(np.nextafter(at, -np.inf)))))
        starts.append(min(at + room, last))
    return list(zip(starts, [*stops, last], strict=True))


def _even(samples: Samples, start: float, stop: float, step: float) -> Samples:
    """Nodes at start, every step, and at stop.

    The last one is at stop itself: none is beyond an event, nor two of them closer than a reader can tell.
    """
    grid = Grid(start, stop, step=step) if step < stop - start else Grid(start, start, 1)
    behind = float(grid.part(grid.count - 1, grid.count).seconds[0])
    intervals = grid.count if behind < stop - LAST_SHORT * step else grid.count - 1
    head = samples.head

    def cut(first: int, until: int) -> Ephemeris:
        inside = grid.part(first, min(until, intervals)).seconds if first < intervals else np.empty(0)
        seconds = np.append(inside, stop) if until > intervals else inside
        return head.resampled(Instants(seconds, None, head.epoch, scale=head.instants.scale))

    if _is_run_as_a_whole(head):
        return Samples.of(cut(0, intervals + 1), samples.progress)
    return Samples(intervals + 1, cut, samples.progress)


def _is_run_as_a_whole(ephemeris: Ephemeris) -> bool:
    """A scene with effects is run from its beginning, however few instants are asked for."""
    return ephemeris.plan is not None and bool(ephemeris.plan.simulated)


def _tried(
    head: Ephemeris, interpolant: Interpolant, tolerance: float, start: float, stop: float, most: int
) -> float:
    """s: a spacing that keeps the tolerance at some places of the span, both ends among them."""
    span = stop - start
    if span == 0.0:
        return 1.0
    width = interpolant.degree
    longest = span / width
    step = longest
    at = np.random.default_rng(0).uniform(0.0, 1.0, PLACES)
    at[:2] = 0.0, 1.0
    for _ in range(ROUNDS):
        begins = start + at * max(0.0, span - width * step)
        errors = _error_at(head, interpolant, begins, step)
        found = float(errors.max())
        if found <= tolerance and (step == longest or found > 0.2 * tolerance):
            return _rounded(step)
        gain = np.clip((0.7 * tolerance / max(found, 1e-300)) ** (1.0 / interpolant.order), 0.02, 3.0)
        step = min(longest, step * float(gain))
        if step < 0.1 * span / max(most, 1):
            break
    return _rounded(step)


def _error_at(head: Ephemeris, interpolant: Interpolant, begins: np.ndarray, step: float) -> np.ndarray:
    """rad: in windows that begin there, at the midpoints of all their intervals that readers would use."""
    width = interpolant.degree
    offsets = step * np.arange(2 * width + 1) / 2.0
    t = (begins[:, None] + offsets).reshape(-1)
    order = np.argsort(t, kind="stable")
    q = np.empty((t.size, 4))
    q[order] = _at(head, t[order])
    windows = q.reshape(len(begins), 2 * width + 1, 4)
    nodes, between = windows[:, ::2], windows[:, 1::2]
    errors = [
        interpolant.errors(step * np.arange(width + 1.0), part, middle)
        for part, middle in zip(nodes, between, strict=True)
    ]
    middle = (width - 1) // 2  # elsewhere than at the ends a window is used in its middle alone
    return np.array([e.max() if i < 2 else e[middle] for i, e in enumerate(errors)])


def _rounded(step: float) -> float:
    """To three digits, downwards: a spacing that people can read, and that is whole in nanoseconds."""
    power = 10.0 ** (np.floor(np.log10(step)) - 2.0)
    return float(f"{np.floor(step / power * (1 + 1e-12)) * power:.2e}")


# -- what interpolation gives ---------------------------------------------------------------------


def _worst(segments: list[Samples], interpolant: Interpolant) -> float:
    """rad: the greatest error at the midpoints of all intervals, against the motion itself."""
    return max((_worst_of(segment, interpolant) for segment in segments), default=0.0)


def _worst_of(samples: Samples, interpolant: Interpolant) -> float:
    worst, around = 0.0, interpolant.degree
    size = CHECKED_AT_ONCE if _is_run_as_a_whole(samples.head) else CHECKED
    for first in range(0, samples.count - 1, size):
        last = min(first + size, samples.count - 1)  # intervals, from first to last
        low, high = max(0, first - around), min(samples.count, last + 1 + around)
        piece = samples.cut(low, high)
        _refuse_disorder(piece, low)
        q = piece.quaternion("wxyz")
        begin, end = first - low, last - low
        middle = _midpoints(piece.instants, begin, end)
        true = piece.resampled(middle).quaternion("wxyz")
        errors = interpolant.errors(piece.elapsed - piece.elapsed[0], q, true, begin)
        worst = max(worst, float(errors.max()))
    return worst


def _refuse_disorder(piece: Ephemeris, first: int) -> None:
    back = np.flatnonzero(~(np.diff(piece.elapsed) > 0.0))
    if back.size:
        i = int(back[0])
        raise FormatError(
            f"instants[{first + i + 1}] ({float(piece.elapsed[i + 1])!r} s) is not after the one before it: "
            "readers that interpolate need them in increasing order"
        )


def _midpoints(instants: Instants, first: int, last: int) -> Instants:
    """Between each from first to last and the next, in two parts."""
    seconds = instants.seconds[first : last + 1]
    half = 0.5 * np.diff(seconds)
    middle = seconds[:-1] + half
    rest = half - (middle - seconds[:-1])
    if instants.rest is not None:
        rest = rest + 0.5 * (instants.rest[first:last] + instants.rest[first + 1 : last + 1])
    return Instants(middle, rest, instants.epoch, scale=instants.scale)


def _at(head: Ephemeris, seconds: np.ndarray) -> np.ndarray:
    instants = Instants(seconds, None, head.epoch, scale=head.instants.scale)
    return head.resampled(instants).quaternion("wxyz")

"""The instants that an interpolating reader is given, and how far off it will be between them."""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import ROUND_CEILING, Context
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .. import units
from ..errors import FormatError, InputError
from ..samples.chunks import Samples
from ..times.instants import Grid, Instants
from .interpolant import Interpolant as Interpolant

if TYPE_CHECKING:
    from ..samples.ephemeris_data import EphemerisData

# Where the rate jumps, or a reader of somebody's file was told not to interpolate across.
CUTS = ("impulse", "contact", "segment")
LEAST_TOLERANCE, GREATEST_TOLERANCE = 1e-13, 1.0  # rad
MOST_NODES = 100_000_000  # in a file
TRIED = 64  # windows in which a spacing is tried before it is checked everywhere
ROUNDS = 30
CONTACT_WITHIN = 1e-11  # s: how well the instant of a contact is known, on either side of which rates differ
CHECKED = 1 << 13  # intervals at a time
CHECKED_AT_ONCE = 1 << 18

# Errors are looked for at these fractions of every interval.  They are zero at its ends and, between, the
# nodal polynomial times a smooth factor.  For factors linear in time, in every interval of the windows of
# degrees 1 to 15, the greatest error is at most 1.05 times the greatest at these six, which were placed to
# make that ratio least; tests/formats/test_nodes.py repeats this and compares with many motions.
PLACES = np.array([0.175, 0.285, 0.422, 0.578, 0.715, 0.825])
MARGIN = 1.07
# rad; chosen nodes are no further apart at the greatest rate.  Slerp takes the wrong way round beyond pi, and
# of polynomials, whose quaternions turn half as fast, none resolves a turn from node to node.
MOST_TURNED = 0.5 * np.pi
# Given instants further apart than that, or unevenly, are looked at in more places; in two turns and more
# from one to the next readers see another motion than this one, and are off by up to half a turn.
MANY_PLACES = (np.arange(128) + 0.5) / 128
LOST = 4.0 * np.pi


class Written(NamedTuple):
    """What became of an ephemeris on its way to a file.

    nodes : instants written
    interpolation_error : rad; what the format's readers are off by between them at most, where they
        interpolate and the motion is there to compare with; else None
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
        return f"Error of interpolation ({self.interpolant}) is at most {upwards(self.worst)} rad"


def upwards(angle: float) -> str:
    """To two digits, never below."""
    return f"{float(Context(prec=2, rounding=ROUND_CEILING).create_decimal_from_float(angle)):.1e}"


def chosen(
    samples: Samples, interpolant: Interpolant, tolerance: Any = None, most: int = MOST_NODES
) -> Nodes:
    """The given instants, or at `most` so many that interpolation errs by less than `tolerance`, rad."""
    if not samples.is_list:
        raise FormatError(f"one body at a list of instants is written, not shape {samples.shape}")
    if tolerance is None:
        segments = given(samples)
        known = samples.first.can_be_resampled
        read = [samples] if interpolant.crosses else segments
        return Nodes(tuple(segments), interpolant, _worst(read, interpolant) if known else None)
    return _spaced(samples, interpolant, _check_tolerance(tolerance, samples.first), most)


def _check_tolerance(tolerance: Any, head: EphemerisData) -> float:
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
    at = [event.seconds for event in samples.first.events if event.kind in CUTS]
    if not at:
        return [samples]
    seconds = np.concatenate([piece.elapsed for piece in samples.chunks()])
    edges = [0, *sorted({int(i) for i in np.searchsorted(seconds, at)} - {0, samples.count}), samples.count]
    return [_part(samples, first, last) for first, last in pairwise(edges)]


def _part(samples: Samples, first: int, last: int) -> Samples:
    return Samples(last - first, lambda a, b: samples.chunk(first + a, first + b), samples.progress)


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
    if start == stop:
        return _even(samples, start, stop, 1.0), 0.0
    head, least = samples.first, (stop - start) / max(most - 1, 0.5)
    longest = _longest(head, interpolant, start, stop)
    even = cache(lambda step: _even(samples, start, stop, step))
    step = longest
    for error in (
        lambda step: _worst_tried(head, interpolant, start, stop, step),
        lambda step: _worst([even(step)], interpolant),
    ):
        step, found = _searched(error, step, longest, least, tolerance, interpolant.order)
        if step < least:
            expected = f"an angle that no more than {most} nodes can keep to"
            raise InputError("interpolation_error", tolerance, expected)
        if found > tolerance:
            raise InputError("interpolation_error", tolerance, f"an angle above {upwards(found)} rad")
    return even(step), found


def _searched(
    error: Callable[[float], float], step: float, longest: float, least: float, tolerance: float, order: int
) -> tuple[float, float]:
    """A spacing, s, that keeps the tolerance, and its error: the longest, or one that errs by half the
    tolerance or more, or as near to that as there is one.  Where none was found, the last that was tried.
    """
    kept, kept_error, failed, found = 0.0, 0.0, np.inf, np.inf
    for _ in range(ROUNDS):
        if step < least:
            break
        found = error(step)
        if found > tolerance:
            failed = step
        else:
            kept, kept_error = step, found
            if step >= longest or found > 0.5 * tolerance:
                break
        gain = max(0.01, (0.8 * tolerance / max(found, 1e-300)) ** (1.0 / order))
        wanted = step * gain if kept < step * gain < failed else math.sqrt(kept * failed)
        step = min(longest, _rounded(wanted))
        if step in (kept, failed):
            break
    return (kept, kept_error) if kept else (step, found)


def _spans(samples: Samples) -> list[tuple[float, float]]:
    """First and last instant of each span between events; one instant is its own first and last.

    A span ends just before its event, for what that changes comes after.
    """
    first, last = float(samples.first.elapsed[0]), float(samples.last.elapsed[0])
    if last < first:
        raise FormatError("the last instant is before the first")
    between = {event.seconds: event.kind for event in samples.first.events if first < event.seconds < last}
    starts, stops = [first], []
    for at, kind in sorted(between.items()):
        room = CONTACT_WITHIN if kind == "contact" else 0.0
        stops.append(max(starts[-1], min(at - room, float(np.nextafter(at, -np.inf)))))
        starts.append(min(at + room, last))
    return list(zip(starts, [*stops, last], strict=True))


def _even(samples: Samples, start: float, stop: float, step: float) -> Samples:
    """Nodes at start, every step, and at stop; the last but one half-way where it would be close to that."""
    intervals = max(1, math.ceil((stop - start) / step - 1e-9)) if start < stop else 0
    grid = Grid(start, stop, step=step) if intervals > 2 else Grid(start, start, 1)
    ends = [stop] if intervals else []
    if intervals > 1:
        before, last = (start + k * step for k in (intervals - 2, intervals - 1))
        ends = [last if stop - last >= 0.5 * step else 0.5 * (before + stop), stop]
    count, head = intervals + 1, samples.first
    regular = count - len(ends)

    def cut(first: int, until: int) -> EphemerisData:
        inside = grid.part(first, min(until, regular)).seconds if first < regular else np.empty(0)
        after = ends[max(0, first - regular) : max(0, until - regular)]
        return head.resampled(Instants(np.append(inside, after), None, head.epoch, scale=head.instants.scale))

    if _is_run_as_a_whole(head):
        return Samples.of(cut(0, count), samples.progress)
    return Samples(count, cut, samples.progress)


def _is_run_as_a_whole(ephemeris: EphemerisData) -> bool:
    """A scene with effects is run from its beginning, however few instants are asked for."""
    return ephemeris.plan is not None and bool(ephemeris.plan.simulated)


def _longest(head: EphemerisData, interpolant: Interpolant, start: float, stop: float) -> float:
    """s: what makes one window of the span, and turns by no more than `MOST_TURNED` at the greatest rate."""
    at = Instants(start + _fractions() * (stop - start), None, head.epoch, scale=head.instants.scale)
    rate = math.sqrt(_squared_rates(head.resampled(at)).max())
    return _rounded(min((stop - start) / interpolant.degree, MOST_TURNED / max(rate, 1e-300)))


def _fractions() -> np.ndarray:
    """Of a span, in increasing order, both ends among them."""
    return np.sort(np.append([0.0, 1.0], np.random.default_rng(0).uniform(0.0, 1.0, TRIED - 2)))


def _worst_tried(
    head: EphemerisData, interpolant: Interpolant, start: float, stop: float, step: float
) -> float:
    """rad: the greatest error in windows of some nodes here and there, at both ends among them.

    Elsewhere than at the ends readers use the middle interval of a window alone.
    """
    width = interpolant.degree
    begins = start + _fractions() * max(0.0, stop - start - width * step)
    nodes = step * np.arange(width + 1.0)
    between = (nodes[:-1, None] + step * PLACES).reshape(-1)
    t = begins[:, None] + np.append(nodes, between)
    order = np.argsort(t, axis=None, kind="stable")
    q = np.empty((t.size, 4))
    q[order] = _at(head, t.reshape(-1)[order])
    windows = q.reshape(TRIED, -1, 4)
    errors = np.array(
        [interpolant.errors(nodes, w[: width + 1], np.arange(width), PLACES, w[width + 1 :]) for w in windows]
    )
    middle = (width - 1) // 2
    inside = errors[1:-1, middle]
    return _with_margin(max(float(inside.max()), float(errors[0].max()), float(errors[-1].max())))


def _rounded(step: float) -> float:
    """To three digits, downwards: a spacing that people can read, and that is whole in nanoseconds."""
    power = 10.0 ** (np.floor(np.log10(step)) - 2.0)
    return float(f"{np.floor(step / power * (1 + 1e-12)) * power:.2e}")


# -- what interpolation gives ---------------------------------------------------------------------


def _worst(segments: list[Samples], interpolant: Interpolant) -> float:
    """rad: what readers are off by at most, from the motion itself, in all intervals."""
    intervals = [segment for segment in segments if segment.count > 1]
    return max((_with_margin(_worst_of(segment, interpolant)) for segment in intervals), default=0.0)


def _with_margin(found: float) -> float:
    return min(MARGIN * found, np.pi)


def _worst_of(samples: Samples, interpolant: Interpolant) -> float:
    """rad: the greatest error found."""
    worst, around = 0.0, interpolant.degree
    size = CHECKED_AT_ONCE if _is_run_as_a_whole(samples.first) else CHECKED
    for first in range(0, samples.count - 1, size):
        last = min(first + size, samples.count - 1)  # intervals, from first to last
        low, high = max(0, first - around), min(samples.count, last + 1 + around)
        piece = samples.chunk(low, high)
        _refuse_disorder(piece, low)
        errors, turned = _errors(piece, interpolant, np.arange(first - low, last - low), PLACES)
        if turned.max() > LOST:
            return np.pi
        far = (
            first
            - low
            + np.flatnonzero(
                (turned > MOST_TURNED * (1.0 + 1e-9))
                | _is_uneven(piece.elapsed, interpolant)[first - low : last - low]
            )
        )
        some = size * PLACES.size // MANY_PLACES.size + 1
        for i in range(0, far.size, some):
            more, _ = _errors(piece, interpolant, far[i : i + some], MANY_PLACES)
            worst = max(worst, float(more.max()))
        worst = max(worst, float(errors.max()))
    return worst


def _errors(
    piece: EphemerisData, interpolant: Interpolant, intervals: np.ndarray, places: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Of intervals, by the node that each begins with: the greatest error at places of it, and how far the
    body turns in it at the greatest rate there; rad.
    """
    instants = piece.instants
    t = instants.seconds - instants.seconds[0]
    t = t if instants.seconds_low is None else t + (instants.seconds_low - instants.seconds_low[0])
    at = _between(instants, intervals, places)
    found = piece.resampled(at)
    errors = interpolant.errors(t, piece.quaternion("wxyz"), intervals, places, found.quaternion("wxyz"))
    rates = np.sqrt(_squared_rates(found).reshape(-1, places.size).max(axis=1))
    return errors, rates * (t[intervals + 1] - t[intervals])


def _is_uneven(t: np.ndarray, interpolant: Interpolant) -> np.ndarray:
    """(n - 1,): which intervals are in a window with others that differ by more than a factor of 2."""
    lengths, width = np.diff(t), interpolant.degree
    if width == 1 or lengths.max() <= 2.0 * lengths.min():
        return np.zeros(lengths.size, dtype=bool)
    around = np.lib.stride_tricks.sliding_window_view(np.pad(lengths, width, mode="edge"), 2 * width + 1)
    return np.asarray(around.max(axis=1) > 2.0 * around.min(axis=1))


def _squared_rates(ephemeris: EphemerisData) -> np.ndarray:
    """(n,) (rad/s)^2."""
    x, y, z = ephemeris.angular_velocity.T
    return np.asarray(x * x + y * y + z * z)


def _refuse_disorder(piece: EphemerisData, first: int) -> None:
    back = np.flatnonzero(~(np.diff(piece.elapsed) > 0.0))
    if back.size:
        i = int(back[0])
        raise FormatError(
            f"instants[{first + i + 1}] ({float(piece.elapsed[i + 1])!r} s) is not after the one before it: "
            "readers that interpolate need them in increasing order"
        )


def _between(instants: Instants, intervals: np.ndarray, places: np.ndarray) -> Instants:
    """At these fractions of intervals, by the node that each begins with, in two parts."""
    before, after = intervals[:, None], intervals[:, None] + 1
    seconds = instants.seconds[before]
    ahead = places * (instants.seconds[after] - seconds)
    at = seconds + ahead
    rest = ahead - (at - seconds)
    if instants.seconds_low is not None:
        rest = (
            rest
            + instants.seconds_low[before]
            + places * (instants.seconds_low[after] - instants.seconds_low[before])
        )
    return Instants(at.reshape(-1), rest.reshape(-1), instants.epoch, scale=instants.scale)


def _at(head: EphemerisData, seconds: np.ndarray) -> np.ndarray:
    instants = Instants(seconds, None, head.epoch, scale=head.instants.scale)
    return head.resampled(instants).quaternion("wxyz")

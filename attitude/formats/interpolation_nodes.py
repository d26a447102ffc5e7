"""Nodes for readers that interpolate, and the bound on the interpolation error between them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from decimal import ROUND_CEILING, Context
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from .. import stopping, units
from ..errors import FormatError, InputError
from ..samples.chunks import Samples
from ..samples.ephemeris_data import EphemerisData
from ..samples.resampling import SEGMENT_EVENTS
from ..times.instants import Grid, Instants
from .interpolant import FRACTIONS as FRACTIONS
from .interpolant import Interpolant as Interpolant

MOST_NODES = 100_000_000  # in a file
# Fractions of a span, increasing, with both ends, at which windows begin in which a spacing is tried before
# it is checked everywhere.
TRIAL_FRACTIONS = np.sort(np.append([0.0, 1.0], np.random.default_rng(0).uniform(0.0, 1.0, 62)))
INTERVALS_PER_CHECK = 1 << 13

ERROR_MARGIN = 1.07  # of the greatest error over that at the fractions where errors are evaluated
# rad; greatest rotation between chosen nodes at the greatest rate.  Beyond pi slerp takes the wrong
# direction, and no polynomial resolves a whole turn between nodes (its quaternions rotate half as fast).
MAX_ROTATION_PER_INTERVAL = 0.5 * np.pi
# Intervals of given instants that are longer than that, or uneven, are evaluated at more fractions.  Beyond
# two turns from node to node readers reconstruct another motion, with errors of up to half a turn.
DENSE_FRACTIONS = (np.arange(128) + 0.5) / 128
MAX_RESOLVED_ROTATION = 4.0 * np.pi


class Written(NamedTuple):
    """Summary of what was written to a file.

    nodes : number of instants written
    interpolation_error : rad, bound on the interpolation error of the format's readers between them; None if
        they do not interpolate, or the motion between the instants is unknown
    advice : which options of the format would keep the error that was asked for with fewer instants, and with
        about how many; None where none would
    """

    nodes: int
    interpolation_error: float | None = None
    advice: str | None = None


class Nodes(NamedTuple):
    """Instants of one body, in segments across which readers must not interpolate.

    segments : each at least one instant, in increasing order
    interpolant : how their readers interpolate
    max_error : rad, bound on the interpolation error, or None if it is unknown
    advice : as in `Written`
    """

    segments: tuple[Samples, ...]
    interpolant: Interpolant
    max_error: float | None
    advice: str | None = None

    @property
    def written(self) -> Written:
        """Summary of these nodes."""
        return Written(sum(segment.count for segment in self.segments), self.max_error, self.advice)

    @property
    def remark(self) -> str:
        """Comment in the file, on interpolation."""
        if self.max_error is None:
            return "Error of interpolation between these attitudes is not known"
        return f"Error of interpolation ({self.interpolant}) is at most {upwards(self.max_error)} rad"

    @property
    def notes(self) -> list[str]:
        """Comments in the file, on how input was taken: printable ASCII, of 200 characters at most."""
        texts = (ascii(note)[1:-1] for note in self.segments[0].first.notes)
        return [f"Input: {text}"[:200] for text in texts]


def upwards(angle: float) -> str:
    """Format an angle with two digits, rounded upwards."""
    return f"{float(Context(prec=2, rounding=ROUND_CEILING).create_decimal_from_float(angle)):.1e}"


def chosen(
    samples: Samples,
    interpolant: Interpolant,
    tolerance: Any = None,
    most: int = MOST_NODES,
    others: Mapping[str, Interpolant] | None = None,
) -> Nodes:
    """Choose nodes that keep a tolerance, rad; without one, the given instants.

    others : how readers interpolate with other options of the format, by these, for `Nodes.advice`

    Raises InputError if more than `most` nodes would be needed.
    """
    if not samples.is_list:
        raise FormatError(f"one body at a list of instants is written, not shape {samples.shape}")
    if tolerance is None:
        segments = split_at_jumps(samples)
        known = samples.first.has_known_motion
        read = [samples] if interpolant.crosses else segments
        return Nodes(tuple(segments), interpolant, error_bound(read, interpolant) if known else None)
    angle = float(units.si_array(tolerance, units.ANGLE, "interpolation_error"))
    if not 1e-13 <= angle <= 1.0:
        raise InputError("interpolation_error", tolerance, "an angle from 1e-13 to 1 rad")
    if not samples.first.has_known_motion:
        expected = "none for an ephemeris read from a file: its motion is not known between the attitudes"
        raise InputError("interpolation_error", tolerance, expected)
    nodes = evenly_spaced(samples, interpolant, angle, most)
    return nodes._replace(advice=advice(samples, others or {}, angle, nodes.written.nodes))


def advice(samples: Samples, others: Mapping[str, Interpolant], tolerance: float, count: int) -> str | None:
    """Which of the other interpolants would keep a tolerance with the fewest nodes, if with fewer than count.

    By trial windows alone, so that the number is approximate; not where effects are simulated, since each
    trial would run the scene.
    """
    if samples.first.is_simulated:
        return None
    spans = spans_between_events(samples)
    counts = {
        name: sum(_trial_count(samples, other, tolerance, span) for span in spans)
        for name, other in others.items()
        if len(spans) == 1 or not other.crosses  # whose polynomials no reader may lay across an event
    }
    best = min(counts, key=counts.__getitem__, default="")
    if not best or counts[best] >= 0.95 * count:
        return None
    return f"{best} would keep this error with about {counts[best]:.0f} attitudes instead of {count}"


def _trial_count(
    samples: Samples, interpolant: Interpolant, tolerance: float, span: tuple[float, float]
) -> float:
    """Number of even nodes of a span that keep a tolerance in trial windows; infinite if none do."""
    start, stop = span
    if start == stop:
        return 1
    longest = longest_spacing(samples.first, interpolant, start, stop)
    least = (stop - start) / MOST_NODES

    def error_of(step: float) -> float:
        return trial_error(samples.first, interpolant, start, stop, step)

    step, error = search_spacing(error_of, longest, (least, longest), tolerance, interpolant.order)
    return math.ceil((stop - start) / step - 1e-9) + 1 if error <= tolerance else math.inf


# -- the instants as they are given ---------------------------------------------------------------


def split_at_jumps(samples: Samples) -> list[Samples]:
    """Split the given instants where the rate jumps; an instant at a jump belongs to what follows."""
    cuts = [event.seconds for event in samples.first.events if event.kind in SEGMENT_EVENTS]
    if not cuts:
        return [samples]
    seconds = np.concatenate([piece.elapsed for piece in samples.chunks()])
    edges = [0, *sorted({int(i) for i in np.searchsorted(seconds, cuts)} - {0, samples.count}), samples.count]

    def part(first: int, last: int) -> Samples:
        return Samples(last - first, lambda a, b: samples.chunk(first + a, first + b), samples.progress)

    return [part(first, last) for first, last in pairwise(edges)]


# -- instants chosen for a tolerance --------------------------------------------------------------


def evenly_spaced(samples: Samples, interpolant: Interpolant, tolerance: float, most: int) -> Nodes:
    """Space nodes evenly in each span between events, as far apart as the tolerance allows."""
    segments: list[Samples] = []
    max_error = 0.0
    for start, stop in spans_between_events(samples):
        left = most - sum(segment.count for segment in segments)
        segment, error = nodes_of_span(samples, interpolant, tolerance, (start, stop), left)
        segments.append(segment)
        max_error = max(max_error, error)
    return Nodes(tuple(segments), interpolant, max_error)


def nodes_of_span(
    samples: Samples, interpolant: Interpolant, tolerance: float, span: tuple[float, float], most: int
) -> tuple[Samples, float]:
    """Even nodes of a span that keep the tolerance everywhere, and their interpolation error."""
    start, stop = span
    if start == stop:
        return even_nodes(samples, start, stop, 1.0), 0.0
    head, least = samples.first, (stop - start) / max(most - 1, 0.5)
    longest = longest_spacing(head, interpolant, start, stop)
    # of two spacings, the best and the last: simulated nodes are held in memory
    even = lru_cache(maxsize=2)(lambda step: even_nodes(samples, start, stop, step))
    step = longest
    for error_of in (
        lambda step: trial_error(head, interpolant, start, stop, step),
        lambda step: error_bound([even(step)], interpolant),
    ):
        step, error = search_spacing(error_of, step, (least, longest), tolerance, interpolant.order)
        if step < least:
            expected = f"an angle that no more than {most} nodes can keep to"
            raise InputError("interpolation_error", tolerance, expected)
        if error > tolerance:
            raise InputError("interpolation_error", tolerance, f"an angle above {upwards(error)} rad")
    return even(step), error


def search_spacing(
    error_of: Callable[[float], float],
    step: float,
    limits: tuple[float, float],
    tolerance: float,
    order: int,
) -> tuple[float, float]:
    """Spacing, s, between limits, and its error: more than half the tolerance, unless it is the longest.

    If no spacing with such an error is met, the longest that keeps the tolerance; if none keeps it, the last
    that was tried.
    """
    least, longest = limits
    best, best_error, failed, error = 0.0, 0.0, np.inf, np.inf
    for _ in range(30):
        if step < least:
            break
        error = error_of(step)
        if error > tolerance:
            failed = step
        else:
            best, best_error = step, error
            if step >= longest or error > 0.5 * tolerance:
                break
        gain = max(0.01, (0.8 * tolerance / max(error, 1e-300)) ** (1.0 / order))
        target = step * gain if best < step * gain < failed else math.sqrt(best * failed)
        step = min(longest, readable_spacing(target))
        if step in (best, failed):
            break
    return (best, best_error) if best else (step, error)


def spans_between_events(samples: Samples) -> list[tuple[float, float]]:
    """First and last instant of each span between events; for a single instant they are equal.

    A span ends just before its event, whose effect belongs to the next span; there is none after an event at
    the last instant.
    """
    first, last = float(samples.first.elapsed[0]), float(samples.last.elapsed[0])
    if last < first:
        raise FormatError("the last instant is before the first")
    between = {event.seconds: event.kind for event in samples.first.events if first < event.seconds <= last}
    starts, stops = [first], list[float]()
    for seconds, kind in sorted(between.items()):
        margin = 1e-11 if kind == "contact" else 0.0  # s: the error of its instant; rates differ beside it
        stops.append(max(starts[-1], min(seconds - margin, float(np.nextafter(seconds, -np.inf)))))
        starts.append(min(seconds + margin, last))
    spans = list(zip(starts, [*stops, last], strict=True))
    return spans[:-1] if last in between else spans


def even_nodes(samples: Samples, start: float, stop: float, step: float) -> Samples:
    """Nodes at start, every step, and at stop; one that would be close to stop is moved half-way back."""
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

    if head.is_simulated:
        return Samples.of(cut(0, count), samples.progress)
    return Samples(count, cut, samples.progress)


def longest_spacing(head: EphemerisData, interpolant: Interpolant, start: float, stop: float) -> float:
    """Longest spacing, s: one window in the span, and `MAX_ROTATION_PER_INTERVAL` at the greatest rate."""
    at = Instants(start + TRIAL_FRACTIONS * (stop - start), None, head.epoch, scale=head.instants.scale)
    rate = math.sqrt(_squared_rates(head.resampled(at)).max())
    return readable_spacing(
        min((stop - start) / interpolant.width, MAX_ROTATION_PER_INTERVAL / max(rate, 1e-300))
    )


def trial_error(
    head: EphemerisData, interpolant: Interpolant, start: float, stop: float, step: float
) -> float:
    """Greatest error, rad, in trial windows of a span; those at both ends are among them.

    Elsewhere readers use only the middle interval of a window.
    """
    width, fractions = interpolant.width, interpolant.fractions
    begins = start + TRIAL_FRACTIONS * max(0.0, stop - start - width * step)
    nodes = step * np.arange(width + 1.0)
    between = (nodes[:-1, None] + step * fractions).reshape(-1)
    t = begins[:, None] + np.append(nodes, between)
    order = np.argsort(t, axis=None, kind="stable")
    instants = Instants(t.reshape(-1)[order], None, head.epoch, scale=head.instants.scale)
    values = interpolant.node_values(head.resampled(instants))
    windows = np.empty_like(values)
    windows[order] = values
    windows = windows.reshape(len(begins), -1, values.shape[1])
    errors = np.array(
        [
            interpolant.errors(nodes, w[: width + 1], np.arange(width), fractions, w[width + 1 :, :4])
            for w in windows
        ]
    )
    middle = (width - 1) // 2
    inside = errors[1:-1, middle]
    error = max(float(inside.max()), float(errors[0].max()), float(errors[-1].max()))
    return min(ERROR_MARGIN * error, np.pi)


def readable_spacing(step: float) -> float:
    """Spacing rounded down to three digits: easy to read, and a whole number of nanoseconds."""
    power = 10.0 ** (np.floor(np.log10(step)) - 2.0)
    return float(f"{np.floor(step / power * (1 + 1e-12)) * power:.2e}")


# -- interpolation errors --------------------------------------------------------------------------


def error_bound(segments: list[Samples], interpolant: Interpolant) -> float:
    """Bound on the interpolation error, rad, in all intervals, compared with the motion itself."""
    intervals = [segment for segment in segments if segment.count > 1]
    error = max((greatest_error(segment, interpolant) for segment in intervals), default=0.0)
    return min(ERROR_MARGIN * error, np.pi)


def greatest_error(samples: Samples, interpolant: Interpolant) -> float:
    """Greatest interpolation error of a segment at the fractions of all intervals, rad."""
    max_error, around = 0.0, interpolant.width
    # each time, motion that is simulated begins anew
    size = 1 << 17 if samples.first.is_simulated else INTERVALS_PER_CHECK
    for first in range(0, samples.count - 1, size):
        stopping.check()
        last = min(first + size, samples.count - 1)  # intervals, from first to last
        low, high = max(0, first - around), min(samples.count, last + 1 + around)
        piece = samples.chunk(low, high)
        back = np.flatnonzero(~(np.diff(piece.elapsed) > 0.0))
        if back.size:
            i = int(back[0]) + 1
            text = f"instants[{low + i}] ({float(piece.elapsed[i])!r} s) is not after the one before it"
            raise FormatError(f"{text}: readers that interpolate need them in increasing order")
        intervals = np.arange(first - low, last - low)
        errors, rotation = interval_errors(piece, interpolant, intervals, interpolant.fractions)
        if rotation.max() > MAX_RESOLVED_ROTATION:
            return np.pi
        is_long = rotation > MAX_ROTATION_PER_INTERVAL * (1.0 + 1e-9)
        dense = intervals[is_long | _is_uneven(piece.elapsed, interpolant)[intervals]]
        group = size * interpolant.fractions.size // DENSE_FRACTIONS.size + 1
        for i in range(0, dense.size, group):
            stopping.check()
            dense_errors, _ = interval_errors(piece, interpolant, dense[i : i + group], DENSE_FRACTIONS)
            max_error = max(max_error, float(dense_errors.max()))
        max_error = max(max_error, float(errors.max()))
    return max_error


def interval_errors(
    piece: EphemerisData, interpolant: Interpolant, intervals: np.ndarray, fractions: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Greatest error of intervals at fractions of them, and rotation at the greatest rate there; rad.

    intervals : (m,), the node at which each begins
    """
    instants = piece.instants
    t = instants.seconds - instants.seconds[0]
    t = t if instants.seconds_low is None else t + (instants.seconds_low - instants.seconds_low[0])
    true = piece.resampled(_instants_between(instants, intervals, fractions))
    errors = interpolant.errors(
        t, interpolant.node_values(piece), intervals, fractions, true.quaternion("wxyz")
    )
    rates = np.sqrt(_squared_rates(true).reshape(-1, fractions.size).max(axis=1))
    return errors, rates * (t[intervals + 1] - t[intervals])


def _is_uneven(t: np.ndarray, interpolant: Interpolant) -> np.ndarray:
    """(n - 1,) bool: intervals in windows whose lengths differ by more than a factor of 2."""
    lengths, width = np.diff(t), interpolant.width
    if width == 1 or lengths.max() <= 2.0 * lengths.min():
        return np.zeros(lengths.size, dtype=bool)
    around = np.lib.stride_tricks.sliding_window_view(np.pad(lengths, width, mode="edge"), 2 * width + 1)
    return np.asarray(around.max(axis=1) > 2.0 * around.min(axis=1))


def _squared_rates(ephemeris: EphemerisData) -> np.ndarray:
    """(n,) (rad/s)^2."""
    x, y, z = ephemeris.angular_velocity.T
    return np.asarray(x * x + y * y + z * z)


def _instants_between(instants: Instants, intervals: np.ndarray, fractions: np.ndarray) -> Instants:
    """Instants at fractions of intervals, in two parts."""
    before, after = intervals[:, None], intervals[:, None] + 1
    seconds = instants.seconds[before]
    ahead = fractions * (instants.seconds[after] - seconds)
    at = seconds + ahead
    rest = ahead - (at - seconds)
    if instants.seconds_low is not None:
        rest = (
            rest
            + instants.seconds_low[before]
            + fractions * (instants.seconds_low[after] - instants.seconds_low[before])
        )
    return Instants(at.reshape(-1), rest.reshape(-1), instants.epoch, scale=instants.scale)

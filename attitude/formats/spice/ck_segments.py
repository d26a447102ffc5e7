"""Segments of a CK, types 1, 2, 3, 5 and 6, as records (layouts: NAIF, CK required reading)."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...errors import FormatError, note
from ...frames import rotations
from ...samples.interpolation import InterpolationMethod, lagrange_basis
from . import daf
from .ck_records import (
    MAX_ATTITUDE_MISMATCH,
    MAX_ID,
    CkRecords,
    concatenated,
    rotate_at_constant_rate,
)

# Numbers in a packet of types 5 and 6 by their subtypes, of which 0 and 2 hold derivatives too.
PACKET_SIZES = (8, 4, 14, 7)


class CkSegment(NamedTuple):
    """Records of a segment.

    begins : (n,) bool, records at which an interpolation interval begins
    steps : whether rates may jump from one record to the next (type 2)
    method : of interpolation between the records; None of type 1, which states none
    rank : index of the segment in the file: SPICE takes what the last one says
    """

    records: CkRecords
    begins: np.ndarray
    steps: bool
    method: InterpolationMethod | None
    rank: int

    def part(self, key: slice | np.ndarray) -> CkSegment:
        """Part of the records; an interval begins at the first."""
        begins = self.begins[key].copy()
        begins[:1] = True
        return self._replace(records=self.records.part(key), begins=begins)


def segments(array: daf.Array, rank: int, source: str) -> list[CkSegment]:
    """What an array of the file holds: one segment, of type 6 one for each mini-segment."""
    reader = SegmentReader(array, array.values, f"a segment of type {array.integers[2]}", source)
    return [segment._replace(rank=rank) for segment in reader.segments()]


class SegmentReader(NamedTuple):
    """The numbers of a segment, or of a mini-segment, as records; FormatError where they are none.

    array : of the file, with its descriptor
    values : the numbers
    noun : what they are, for errors
    """

    array: daf.Array
    values: np.ndarray
    noun: str
    source: str

    @property
    def has_rates(self) -> bool:
        """Whether the segment is said to have angular velocities."""
        return self.array.integers[3] == 1

    def segments(self) -> list[CkSegment]:
        """The segment, of type 6 its mini-segments, within the span that its descriptor states."""
        kind = self.array.integers[2]
        if kind not in (1, 2, 3, 5, 6):
            raise self.error(f"{self.noun}; types 1, 2, 3, 5 and 6 are read")
        if not (np.abs(self.values) < 1e100).all():  # ticks, or rad/s: the square is still finite
            raise self.error("a number that is not finite, or none of an attitude")
        if kind == 6:
            return self.mini_segments()
        segment = self.constant_rates() if kind == 2 else self.packets() if kind == 5 else self.records()
        ticks = segment.records.ticks
        inside = (ticks >= self.array.doubles[0]) & (ticks <= self.array.doubles[1])
        if not inside.any():
            raise self.error("a segment that covers none of its records")
        return [segment if inside.all() else segment.part(inside)]

    # -- numbers --------------------------------------------------------------------------------

    def error(self, reason: str) -> FormatError:
        """FormatError that names the file."""
        return FormatError(reason, self.source)

    def count(self, value: float) -> int:
        """A number that counts something."""
        if not (1 <= value <= MAX_ID and value == int(value)):
            raise self.error(f"a count of {float(value)!r}")
        return int(value)

    def parts(self, *sizes: int) -> list[np.ndarray]:
        """The numbers in parts of these sizes, which must be all of them."""
        if sum(sizes) != self.values.size:
            raise self.error(f"{self.noun} whose size does not match its counts")
        return np.split(self.values, np.cumsum(sizes[:-1]))

    def check_ticks(self, ticks: np.ndarray) -> None:
        """Refuse instants that do not increase."""
        if not (np.diff(ticks) > 0.0).all():
            raise self.error("instants of a segment that do not increase")

    def begins(self, ticks: np.ndarray, starts: np.ndarray) -> np.ndarray:
        """(n,) bool: the records at whose ticks interpolation intervals begin."""
        self.check_ticks(ticks)
        begins = np.isin(ticks, starts)
        if not begins[0] or begins.sum() != len(starts):
            raise self.error("intervals that begin between the records of their segment")
        return begins

    # -- types ----------------------------------------------------------------------------------

    def records(self) -> CkSegment:
        """Types 1 and 3: records, their ticks, each hundredth of these; of type 3 interval starts likewise.

        Then their counts.
        """
        is_type_1 = self.array.integers[2] == 1
        if is_type_1:
            counts = [self.count(self.values[-1])]
        elif self.values.size > 2:
            counts = [self.count(value) for value in self.values[-2:]][::-1]
        else:
            counts = [0, 0]
        sizes = [size for count in counts for size in (count, (count - 1) // 100)]
        width = 7 if self.has_rates else 4
        table, ticks, _, *intervals = self.parts(counts[0] * width, *sizes, len(counts))
        table = table.reshape(-1, width)
        begins = self.begins(ticks, ticks[:1] if is_type_1 else intervals[0])
        velocity = table[:, 4:] if self.has_rates else None
        records = CkRecords(ticks, rotations.conjugate(table[:, :4]), velocity)
        return CkSegment(records, begins, False, None if is_type_1 else InterpolationMethod(), 0)

    def packets(self) -> CkSegment:
        """Type 5: packets, their ticks and interval starts as of type 3, and five numbers of control.

        A mini-segment of type 6 is one interval, with neither starts nor their number.
        """
        is_mini = self.array.integers[2] == 6
        needed = 4 if is_mini else 5
        control = self.values[-needed:]
        if control.size < needed:
            raise self.error(f"{self.noun} without its numbers of control")
        rate, subtype, window, *intervals, count = control
        if subtype not in range(len(PACKET_SIZES)):
            raise self.error(f"a segment of subtype {float(subtype)!r}; 0 to 3 are read")
        window, *intervals, count = (self.count(value) for value in (window, *intervals, count))
        if window > 24 or sum(intervals) > count:
            of = f"{intervals[0] if intervals else 1} intervals of {count} records"
            raise self.error(f"a window of {window} records, {of}")
        size = PACKET_SIZES[int(subtype)]
        sizes = [size for each in (count, *intervals) for size in (each, (each - 1) // 100)]
        table, ticks, _, *starts = self.parts(count * size, *sizes, control.size)
        begins = self.begins(ticks, ticks[:1] if is_mini else starts[0])
        packets = Packets(table.reshape(count, size), ticks, begins, int(subtype), window, float(rate))
        return packets.segment(self.has_rates, self.source)

    def mini_segments(self) -> list[CkSegment]:
        """Type 6: mini-segments, the bounds of their intervals, each hundredth of these, where they are.

        Then two numbers: whether the instant of a bound belongs to the later of two, and their count.
        """
        count = self.count(self.values[-1])
        sizes = [count + 1, count // 100, count + 1, 2]
        base = self.values.size - sum(sizes)
        if base < 0:
            raise self.error(f"{self.noun} whose size does not match its counts")
        _, bounds, _, offsets, (takes_last, _) = self.parts(base, *sizes)
        pointers = [self.count(value) - 1 for value in offsets]
        if not (np.diff(bounds) > 0.0).all() or pointers[0] != 0 or pointers[-1] != base:
            raise self.error("mini-segments that do not follow each other")
        read = []
        for k in range(count):
            values = self.values[pointers[k] : pointers[k + 1]]
            mini = self._replace(values=values, noun="a mini-segment").packets()
            ticks = mini.records.ticks
            start, stop = max(bounds[k], self.array.doubles[0]), min(bounds[k + 1], self.array.doubles[1])
            inside = (ticks >= start) & (ticks <= stop)
            if takes_last != 1.0 and k > 0:
                inside &= ticks > bounds[k]
            elif takes_last == 1.0 and k + 1 < count:
                inside &= ticks < bounds[k + 1]
            if inside.any():
                read.append(mini.part(inside))
        return read

    def constant_rates(self) -> CkSegment:
        """Type 2: records, when they begin, when they end, every hundredth of the beginnings."""
        count = -(-(100 * self.values.size + 1) // 1001)
        if count < 1 or self.values.size != 10 * count + (count - 1) // 100:
            raise self.error("a segment of type 2 whose size matches no count of records")
        table, start, stop, _ = self.parts(8 * count, count, count, (count - 1) // 100)
        table = table.reshape(count, 8)
        if not ((stop >= start).all() and (start[1:] >= stop[:-1]).all() and (table[:, 7] > 0.0).all()):
            raise self.error("intervals of a segment that do not follow each other")
        if not self.array.doubles[0] <= start[0] <= stop[-1] <= self.array.doubles[1]:
            raise self.error("a segment that covers parts of its records")
        segment = _interval_ends(*_parts_of_turns(table, start, stop, self.source))
        self.check_ticks(segment.records.ticks)
        return segment


class Packets(NamedTuple):
    """Packets of types 5 and 6.

    table : (n, k) quaternions, derivatives and velocities, by the subtype
    window : nodes of one polynomial
    rate : s a tick
    """

    table: np.ndarray
    ticks: np.ndarray
    begins: np.ndarray
    subtype: int
    window: int
    rate: float

    def segment(self, has_rates: bool, source: str) -> CkSegment:
        """Their attitudes, and their angular velocities where the segment is said to have them."""
        is_hermite = self.subtype in (0, 2)
        degree = 2 * self.window - 1 if is_hermite else self.window - 1
        method = InterpolationMethod("hermite" if is_hermite else "lagrange", max(degree, 1), True)
        q = rotations.conjugate(self.table[:, :4])
        if not (np.abs(q) > 0.0).any(axis=1).all():
            raise FormatError("a quaternion of zeros", source)
        velocity = self._velocity(q) if has_rates else None
        return CkSegment(CkRecords(self.ticks, q, velocity), self.begins, False, method, 0)

    def _velocity(self, q: np.ndarray) -> np.ndarray:
        """(n, 3) rad/s, inertial: as stated, or twice the vector part of dq/dt conj(q)."""
        if self.subtype in (2, 3):
            return self.table[:, 8:11] if self.subtype == 2 else self.table[:, 4:7]
        derivative = rotations.conjugate(self.table[:, 4:8]) if self.subtype == 0 else self._derivative(q)
        twice = 2.0 * rotations.product(derivative, rotations.conjugate(q))[:, 1:]
        return twice / (q * q).sum(axis=1, keepdims=True)

    def _derivative(self, q: np.ndarray) -> np.ndarray:
        """(n, 4) 1/s: of the polynomials through the nearest records, as SPICE takes them at each record."""
        q, derivative, index = q.copy(), np.zeros_like(q), np.arange(len(q))
        starts = np.flatnonzero(self.begins)
        for start, stop in zip(starts, [*starts[1:], len(q)], strict=True):
            q[start:stop] = rotations.sign_continuous(q[start:stop])
        interval = np.cumsum(self.begins) - 1
        start, stop = starts[interval], np.append(starts[1:], len(q))[interval]
        half = self.window // 2
        first = np.maximum(index - half, start)
        last = np.minimum(index + np.where(index == 0, half, half - 1), stop - 1)
        for before, after in set(zip((index - first).tolist(), (last - index).tolist(), strict=True)):
            rows = index[(index - first == before) & (last - index == after)]
            nodes = rows[:, None] + np.arange(-before, after + 1)
            slopes = lagrange_basis(self.ticks[nodes] - self.ticks[rows, None], np.zeros(len(rows)))[1]
            derivative[rows] = np.einsum("mw,mwc->mc", slopes, q[nodes]) / self.rate
        is_flipped = (q * rotations.conjugate(self.table[:, :4])).sum(axis=1, keepdims=True) < 0.0
        return np.where(is_flipped, -derivative, derivative)


def _parts_of_turns(
    table: np.ndarray, start: np.ndarray, stop: np.ndarray, source: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Records of type 2 of which none turns by more than a right angle: attitudes tell no whole turns."""
    rotation = np.sqrt((table[:, 4:7] ** 2).sum(axis=1)) * (stop - start) * table[:, 7]
    counts = np.maximum(np.ceil(rotation / (0.5 * np.pi)), 1.0)
    if not counts.sum() <= 1e7:
        raise FormatError(f"records of type 2 that turn by {rotation.sum():.3g} rad", source)
    if (counts == 1.0).all():
        return table, start, stop
    owner = np.repeat(np.arange(len(counts)), counts.astype(np.int64))
    part = np.arange(len(owner)) - np.searchsorted(owner, owner)
    width = (stop - start) / counts
    begins = start[owner] + part * width[owner]
    ends = np.where(part + 1.0 == counts[owner], stop[owner], start[owner] + (part + 1.0) * width[owner])
    if not (np.diff(begins) > 0.0).all():
        raise FormatError("records of type 2 that turn several times a tick", source)
    q, velocity = rotations.conjugate(table[owner, :4]), table[owner, 4:7]
    omega = rotations.rotate(rotations.conjugate(q), velocity)
    turned = rotate_at_constant_rate(q, omega, (begins - start[owner]) * table[owner, 7])
    parts = table[owner].copy()
    parts[part > 0, :4] = rotations.conjugate(turned)[part > 0]
    return parts, begins, ends


def _interval_ends(table: np.ndarray, start: np.ndarray, stop: np.ndarray) -> CkSegment:
    """Attitudes at both ends of each interval, but once where one ends as the next begins."""
    q, velocity = rotations.conjugate(table[:, :4]), table[:, 4:7]
    omega = rotations.rotate(rotations.conjugate(q), velocity)
    at_end = rotate_at_constant_rate(q, omega, (stop - start) * table[:, 7])
    mismatch = rotations.angle_between(at_end[:-1], q[1:])
    is_adjacent = np.append(stop[:-1] == start[1:], False)
    begins = np.append(True, ~(is_adjacent[:-1] & (mismatch < MAX_ATTITUDE_MISMATCH)))
    both = CkRecords(
        np.stack([start, stop], axis=1).ravel(),
        np.stack([q, at_end], axis=1).reshape(-1, 4),
        np.repeat(velocity, 2, axis=0),
    )
    is_kept = np.stack([np.full(len(start), True), ~is_adjacent & (stop > start)], axis=1).ravel()
    begins = np.stack([begins, np.zeros_like(begins)], axis=1).ravel()
    return CkSegment(both.part(is_kept), begins[is_kept], True, InterpolationMethod(), 0)


def ranked(segments: list[CkSegment]) -> list[CkSegment]:
    """Segments without the records for which SPICE takes a later segment of the file; in order of time.

    An interval ends, and another begins, where the coverage of a later segment lies between.
    """
    segments = sorted(segments, key=lambda segment: float(segment.records.ticks[0]))
    ends = [(float(s.records.ticks[0]), float(s.records.ticks[-1])) for s in segments]
    if all(before[1] <= after[0] for before, after in pairwise(ends)):
        return segments
    note("where segments overlap, the later of the file counts, as in SPICE")
    kept: list[CkSegment] = []
    starts, stops = np.empty(0), np.empty(0)  # covered by the segments before, which rank higher
    for segment in sorted(segments, key=lambda segment: segment.rank, reverse=True):
        ticks = segment.records.ticks
        index = np.searchsorted(starts, ticks, side="right")
        is_covered = (index > 0) & (ticks <= np.append(stops, -np.inf)[index - 1])
        if not is_covered.all():
            rest, index = segment.part(~is_covered), index[~is_covered]
            removed = np.cumsum(is_covered)[~is_covered]
            is_break = (np.diff(index) != 0) | (np.diff(removed) != 0) | (segment.method is None)
            breaks = np.flatnonzero(is_break) + 1
            rest.begins[breaks] = True
            edges = [0, *breaks.tolist(), len(index)]
            kept += [rest.part(slice(first, last)) for first, last in pairwise(edges)]
        starts, stops = _united(segment, starts, stops)
    return sorted(kept, key=lambda segment: float(segment.records.ticks[0]))


def _united(segment: CkSegment, starts: np.ndarray, stops: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Covered intervals, together with those of a segment; of type 1 its records alone are covered."""
    ticks = segment.records.ticks
    first = np.arange(len(ticks)) if segment.method is None else np.flatnonzero(segment.begins)
    starts = np.concatenate([starts, ticks[first]])
    stops = np.concatenate([stops, ticks[np.append(first[1:], len(ticks)) - 1]])
    order = np.argsort(starts, kind="stable")
    starts, stops = starts[order], np.maximum.accumulate(stops[order])
    is_first = np.append(True, starts[1:] > stops[:-1])
    last = np.append(np.flatnonzero(is_first)[1:], len(starts)) - 1
    return starts[is_first], stops[last]


class CkSeries(NamedTuple):
    """Records of all segments, in order of time.

    begins : (n,) bool, records at which an interpolation interval begins
    methods : of the segments; owner : (n,), to which of them each record belongs
    """

    records: CkRecords
    begins: np.ndarray
    methods: list[InterpolationMethod | None]
    owner: np.ndarray


def joined(segments: list[CkSegment]) -> CkSeries:
    """Segments in order as one; a record that ends one and begins the next stands once.

    Where both differ, it is that of the later segment of the file.
    """
    series: list[CkSegment] = []
    for segment in segments:
        if series and segment.records.ticks[0] == series[-1].records.ticks[-1]:
            before, begins = series[-1], segment.begins.copy()
            begins[0] = not _is_continued(before, segment)
            if begins[0] and before.rank > segment.rank and len(begins) > 1:
                series.append(segment.part(slice(1, None)))
                continue
            last = slice(-1)
            series[-1] = before._replace(records=before.records.part(last), begins=before.begins[last])
            series.append(segment._replace(begins=begins))
        else:
            series.append(segment)
    return CkSeries(
        concatenated([segment.records for segment in series]),
        np.concatenate([segment.begins for segment in series]),
        [segment.method for segment in series],
        np.repeat(np.arange(len(series)), [len(segment.begins) for segment in series]),
    )


def _is_continued(before: CkSegment, after: CkSegment) -> bool:
    """Whether one segment begins with the record that the other ends with."""
    last, first = before.records.part(-1), after.records.part(0)
    if before.steps or after.steps:
        mismatch = rotations.angle_between(last.quaternion, first.quaternion)
        return bool(mismatch < MAX_ATTITUDE_MISMATCH)
    if not np.array_equal(last.quaternion, first.quaternion):
        return False
    return last.velocity is None or first.velocity is None or np.array_equal(last.velocity, first.velocity)

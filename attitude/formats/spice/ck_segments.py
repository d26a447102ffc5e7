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

MAX_NUMBER = 1e100  # ticks, or rad/s: its square is still finite
MAX_ROTATION_OF_PART, MAX_PARTS = 0.5 * np.pi, 10**7  # of records of type 2, rad, and their number
MAX_WINDOW = 24  # records that one polynomial goes through
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
    kind, width = array.integers[2], 7 if array.integers[3] == 1 else 4
    if kind not in (1, 2, 3, 5, 6):
        raise FormatError(f"a segment of type {kind}; types 1, 2, 3, 5 and 6 are read", source)
    if not (np.abs(array.values) < MAX_NUMBER).all():
        raise FormatError("a number that is not finite, or none of an attitude", source)
    if kind == 6:
        return [segment._replace(rank=rank) for segment in _type_6(array, source)]
    read = {1: _type_1, 2: _type_2, 3: _type_3, 5: _type_5}[kind]
    segment = read(array, width, source)._replace(rank=rank)
    _check_ticks(segment.records.ticks, source)
    return [segment]


def _check_ticks(ticks: np.ndarray, source: str) -> None:
    if not (np.diff(ticks) > 0.0).all():
        raise FormatError("instants of a segment that do not increase", source)


def _type_1(array: daf.Array, width: int, source: str) -> CkSegment:
    """Segment of records, their ticks, each hundredth of these, and their count."""
    count = _count(array.values[-1], source)
    ends = _layout(array, [count * width, count, (count - 1) // 100, 1], source)
    table, ticks = array.values[: ends[0]].reshape(count, width), array.values[ends[0] : ends[1]]
    begins = np.arange(count) == 0
    records = CkRecords(ticks, rotations.conjugate(table[:, :4]), _velocity(table, 4))
    return _covered(CkSegment(records, begins, False, None, 0), array, source)


def _velocity(table: np.ndarray, column: int) -> np.ndarray | None:
    return table[:, column : column + 3] if table.shape[1] >= column + 3 else None


def _layout(array: daf.Array, counts: list[int], source: str) -> np.ndarray:
    """Where each part of an array ends, of these sizes; FormatError unless they are all of it."""
    ends = np.cumsum(counts)
    if ends[-1] != array.values.size:
        kind = array.integers[2]
        raise FormatError(f"a segment of type {kind} whose size does not match its counts", source)
    return ends


def _type_3(array: daf.Array, width: int, source: str) -> CkSegment:
    """Segment of records, their ticks, each hundredth of these, interval starts likewise, and two counts."""
    values = array.values
    intervals, count = (_count(value, source) for value in values[-2:]) if values.size > 2 else (0, 0)
    sizes = [count * width, count, (count - 1) // 100, intervals, (intervals - 1) // 100, 2]
    ends = _layout(array, sizes, source)
    table = values[: ends[0]].reshape(count, width)
    ticks = values[ends[0] : ends[1]]
    begins = _interval_begins(ticks, values[ends[2] : ends[3]], source)
    records = CkRecords(ticks, rotations.conjugate(table[:, :4]), _velocity(table, 4))
    return _covered(CkSegment(records, begins, False, InterpolationMethod(), 0), array, source)


def _interval_begins(ticks: np.ndarray, starts: np.ndarray, source: str) -> np.ndarray:
    """(n,) bool: the records at whose ticks interpolation intervals begin."""
    _check_ticks(ticks, source)
    begins = np.isin(ticks, starts)
    if not begins[0] or begins.sum() != len(starts):
        raise FormatError("intervals that begin between the records of their segment", source)
    return begins


def _covered(segment: CkSegment, array: daf.Array, source: str) -> CkSegment:
    """The records within the span that the segment's descriptor states."""
    ticks = segment.records.ticks
    inside = (ticks >= array.doubles[0]) & (ticks <= array.doubles[1])
    if not inside.any():
        raise FormatError("a segment that covers none of its records", source)
    return segment if inside.all() else segment.part(inside)


def _type_5(array: daf.Array, width: int, source: str) -> CkSegment:
    """Segment of packets, their ticks and interval starts as of type 3, and five numbers of control."""
    values = array.values
    if values.size < 5:
        raise FormatError("a segment of type 5 whose size does not match its counts", source)
    rate, (subtype, window, intervals, count) = values[-5], _control(values[-4:], source)
    size = PACKET_SIZES[subtype]
    sizes = [count * size, count, (count - 1) // 100, intervals, (intervals - 1) // 100, 5]
    ends = _layout(array, sizes, source)
    ticks = values[ends[0] : ends[1]]
    begins = _interval_begins(ticks, values[ends[2] : ends[3]], source)
    packets = Packets(values[: ends[0]].reshape(count, size), ticks, begins, subtype, window, float(rate))
    return _covered(packets.segment(width == 7, source), array, source)


def _type_6(array: daf.Array, source: str) -> list[CkSegment]:
    """Mini-segments, the bounds of their intervals, each hundredth of these, where they are, two numbers."""
    values = array.values
    count = _count(values[-1], source)
    ends = np.cumsum([count + 1, count // 100, count + 1, 2])
    base = values.size - ends[-1]
    if base < 0:
        raise FormatError("a segment of type 6 whose size does not match its counts", source)
    bounds = values[base : base + ends[0]]
    pointers = [_count(value, source) - 1 for value in values[base + ends[1] : base + ends[2]]]
    if not (np.diff(bounds) > 0.0).all() or pointers[0] != 0 or pointers[-1] != base:
        raise FormatError("mini-segments that do not follow each other", source)
    takes_last = values[-2] == 1.0
    read = []
    for k in range(count):
        mini = _mini_segment(values[pointers[k] : pointers[k + 1]], array.integers[3] == 1, source)
        ticks = mini.records.ticks
        start, stop = max(bounds[k], array.doubles[0]), min(bounds[k + 1], array.doubles[1])
        inside = (ticks >= start) & (ticks <= stop)
        if not takes_last and k > 0:  # the instant of a bound belongs to the mini-segment before
            inside &= ticks > bounds[k]
        elif takes_last and k + 1 < count:
            inside &= ticks < bounds[k + 1]
        if inside.any():
            read.append(mini.part(inside))
    return read


def _mini_segment(values: np.ndarray, has_rates: bool, source: str) -> CkSegment:
    if values.size < 4:
        raise FormatError("a mini-segment without its numbers of control", source)
    rate, (subtype, window, _, count) = values[-4], _control(np.insert(values[-3:], 2, 1.0), source)
    size = PACKET_SIZES[subtype]
    ends = np.cumsum([count * size, count, (count - 1) // 100, 4])
    if ends[-1] != values.size:
        raise FormatError("a mini-segment whose size does not match its counts", source)
    ticks = values[ends[0] : ends[1]]
    begins = _interval_begins(ticks, ticks[:1], source)
    packets = Packets(values[: ends[0]].reshape(count, size), ticks, begins, subtype, window, float(rate))
    return packets.segment(has_rates, source)


def _control(values: np.ndarray, source: str) -> list[int]:
    """Subtype, window, number of intervals and number of packets."""
    subtype, *counts = values
    if subtype not in range(len(PACKET_SIZES)):
        raise FormatError(f"a segment of subtype {float(subtype)!r}; 0 to 3 are read", source)
    window, intervals, count = (_count(value, source) for value in counts)
    if window > MAX_WINDOW or intervals > count:
        raise FormatError(f"a window of {window} records, {intervals} intervals of {count} records", source)
    return [int(subtype), window, intervals, count]


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


def _count(value: float, source: str) -> int:
    if not (1 <= value <= MAX_ID and value == int(value)):
        raise FormatError(f"a count of {float(value)!r}", source)
    return int(value)


def _type_2(array: daf.Array, _: int, source: str) -> CkSegment:
    """Segment of records, when they begin, when they end, every hundredth of the beginnings."""
    values = array.values
    count = -(-(100 * values.size + 1) // 1001)
    if count < 1 or values.size != 10 * count + (count - 1) // 100:
        raise FormatError("a segment of type 2 whose size matches no count of records", source)
    table = values[: 8 * count].reshape(count, 8)
    start, stop = values[8 * count : 9 * count], values[9 * count : 10 * count]
    if not ((stop >= start).all() and (start[1:] >= stop[:-1]).all() and (table[:, 7] > 0.0).all()):
        raise FormatError("intervals of a segment that do not follow each other", source)
    if not array.doubles[0] <= start[0] <= stop[-1] <= array.doubles[1]:
        raise FormatError("a segment that covers parts of its records", source)
    return _interval_ends(*_parts_of_turns(table, start, stop, source))


def _parts_of_turns(
    table: np.ndarray, start: np.ndarray, stop: np.ndarray, source: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Records of type 2 of which none turns by more than a right angle: attitudes tell no whole turns."""
    rotation = np.sqrt((table[:, 4:7] ** 2).sum(axis=1)) * (stop - start) * table[:, 7]
    counts = np.maximum(np.ceil(rotation / MAX_ROTATION_OF_PART), 1.0)
    if not counts.sum() <= MAX_PARTS:
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

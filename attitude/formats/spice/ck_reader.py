"""Reading a CK of types 2 and 3, from its bytes: without CSPICE, its state and its lock."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np

from ...errors import FormatError, InputError
from ...frames import rotations
from ...samples.ephemeris_data import EphemerisData
from ...samples.event import Event
from ...samples.interpolation import InterpolationMethod
from ...samples.resampling import with_method
from ...times.instants import Instants
from .. import schema, time_origin
from . import daf, sclk, text_kernels
from .ck_records import (
    MAX_ATTITUDE_MISMATCH,
    MAX_ID,
    CkRecords,
    check_id,
    concatenated,
    rotate_at_constant_rate,
)

FRAMES = {1: "ICRF", 17: "ECLIPJ2000"}  # by SPICE's numbers
MAX_NUMBER = 1e100  # ticks, or rad/s: its square is still finite


class CkSegment(NamedTuple):
    """Records of a segment.

    begins : (n,) bool, records at which an interpolation interval begins
    steps : whether rates may jump from one record to the next (type 2)
    """

    records: CkRecords
    begins: np.ndarray
    steps: bool


def parse(
    stream: BinaryIO,
    source: str,
    *,
    sclk: str | Path | None = None,
    structure_id: int | None = None,
    clock_id: int | None = None,
) -> EphemerisData:
    """Attitudes of one structure, dated in TT.

    Of type 2, the attitudes at the ends of its intervals.  Of two records at one instant, one ending an
    interval and the other beginning the next, the latter stays.  Angular velocities only where all segments
    have them.  Where a record begins an interval, an event "segment" says so.

    sclk : SCLK kernel of the clock that counted the ticks; else that of the same name, ending in .tsc
    structure_id : which, where the file has several
    clock_id : number of the spacecraft whose clock it is (-82), where the structure's number does not tell
    """
    if clock_id is not None:
        check_id(clock_id, "clock_id")
    arrays = daf.arrays(daf.content(stream, b"DAF/CK", source), 2, 6, source)
    structure = _structure(arrays, structure_id, source)
    arrays = [array for array in arrays if array.integers[0] == structure]
    segment = _joined([_segment(array, source) for array in arrays], source)
    frame, clock = _frame(arrays, source), _clock(sclk, structure, clock_id, source)
    anchor, seconds, rest = clock.tt(segment.records.ticks, source)
    instants = Instants(seconds, rest if rest.any() else None, time_origin.tt_time(anchor))
    return _ephemeris(segment, instants, frame, arrays[0].name, source)


def _structure(arrays: list[daf.Array], requested: int | None, source: str) -> int:
    structures = sorted({array.integers[0] for array in arrays})
    if requested is None and len(structures) == 1:
        return structures[0]
    if requested not in structures or requested is None:
        names = ", ".join(map(str, structures[:20])) or "none"
        raise FormatError(f"structure_id is one of {names}; got {requested}", source)
    return requested


def _frame(arrays: list[daf.Array], source: str) -> str:
    numbers = {array.integers[1] for array in arrays}
    if len(numbers) > 1 or not numbers <= FRAMES.keys():
        text = ", ".join(str(number) for number in sorted(numbers)[:20])
        raise FormatError(
            f"relative to SPICE's frame {text}; 1 (J2000) or 17 (ECLIPJ2000) is read, one a file", source
        )
    return FRAMES[numbers.pop()]


def _clock(kernel: str | Path | None, structure: int, clock_id: int | None, source: str) -> sclk.Clock:
    path = Path(source).with_suffix(".tsc") if kernel is None else Path(kernel)
    try:
        text = path.read_bytes().decode("latin-1")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", error)
        raise FormatError(
            f"a CK counts the ticks of a clock, and its SCLK kernel {path} cannot be read ({reason}); "
            "sclk= names another",
            source,
        ) from None
    return sclk.clock_from(text, structure, str(path), clock_id)


# -- segments -----------------------------------------------------------------------------------


def _segment(array: daf.Array, source: str) -> CkSegment:
    kind = array.integers[2]
    if kind not in (2, 3):
        raise FormatError(f"a segment of type {kind}; types 2 and 3 are read", source)
    if not (np.abs(array.values) < MAX_NUMBER).all():
        raise FormatError("a number that is not finite, or none of an attitude", source)
    segment = _type_2(array, source) if kind == 2 else _type_3(array, source)
    _check_ticks(segment.records.ticks, source)
    return segment


def _check_ticks(ticks: np.ndarray, source: str) -> None:
    if not (np.diff(ticks) > 0.0).all():
        raise FormatError("instants of a segment that do not increase", source)


def _type_3(array: daf.Array, source: str) -> CkSegment:
    """Segment of records, their ticks, each hundredth of these, interval starts likewise, and two counts."""
    values, width = array.values, 7 if array.integers[3] == 1 else 4
    intervals, count = (_count(value, source) for value in values[-2:]) if values.size > 2 else (0, 0)
    ends = np.cumsum([count * width, count, (count - 1) // 100, intervals, (intervals - 1) // 100, 2])
    if ends[-1] != values.size or not 1 <= intervals <= count:
        raise FormatError("a segment of type 3 whose size does not match its counts", source)
    table = values[: ends[0]].reshape(count, width)
    ticks, starts = values[ends[0] : ends[1]], values[ends[2] : ends[3]]
    _check_ticks(ticks, source)
    begins = np.isin(ticks, starts)
    if not begins[0] or begins.sum() != intervals:
        raise FormatError("intervals that begin between the records of their segment", source)
    records = CkRecords(ticks, rotations.conjugate(table[:, :4]), table[:, 4:] if width == 7 else None)
    inside = (ticks >= array.doubles[0]) & (ticks <= array.doubles[1])
    if not inside.any():
        raise FormatError("a segment that covers none of its records", source)
    begins[int(np.argmax(inside))] = True
    return CkSegment(records.part(inside), begins[inside], False)


def _count(value: float, source: str) -> int:
    if not (1 <= value <= MAX_ID and value == int(value)):
        raise FormatError(f"a count of {float(value)!r}", source)
    return int(value)


def _type_2(array: daf.Array, source: str) -> CkSegment:
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
    return _interval_ends(table, start, stop)


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
    return CkSegment(both.part(is_kept), begins[is_kept], True)


def _joined(segments: list[CkSegment], source: str) -> CkSegment:
    """Segments in order; a record that ends one and begins the next stands once."""
    segments = sorted(segments, key=lambda segment: float(segment.records.ticks[0]))
    joined: list[CkSegment] = []
    for segment in segments:
        if joined and segment.records.ticks[0] <= joined[-1].records.ticks[-1]:
            before = joined[-1]
            if segment.records.ticks[0] < before.records.ticks[-1]:
                raise FormatError("segments that overlap: which counts depends on who reads them", source)
            segment.begins[0] = not _is_continued(before, segment)
            joined[-1] = CkSegment(before.records.part(slice(-1)), before.begins[:-1], before.steps)
        joined.append(segment)
    begins = np.concatenate([segment.begins for segment in joined])
    records = concatenated([segment.records for segment in joined])
    return CkSegment(records, begins, any(segment.steps for segment in joined))


def _is_continued(before: CkSegment, after: CkSegment) -> bool:
    """Whether one segment begins with the record that the other ends with."""
    last, first = before.records.part(-1), after.records.part(0)
    if before.steps or after.steps:
        mismatch = rotations.angle_between(last.quaternion, first.quaternion)
        return bool(mismatch < MAX_ATTITUDE_MISMATCH)
    if not np.array_equal(last.quaternion, first.quaternion):
        return False
    return last.velocity is None or first.velocity is None or np.array_equal(last.velocity, first.velocity)


def _ephemeris(segment: CkSegment, instants: Instants, frame: str, name: str, source: str) -> EphemerisData:
    q, velocity = segment.records.quaternion, segment.records.velocity
    try:
        q = schema.unit_rows(q, source)
        schema.check_dates(instants.finite("instants"))
    except InputError as error:
        raise FormatError(str(error), source) from None
    rate = None if velocity is None else rotations.rotate(rotations.conjugate(q), velocity)
    text = "a new interval begins: not to be interpolated into from before"
    starts = instants.seconds[1:][segment.begins[1:]]
    events = tuple(Event(float(seconds), "segment", text) for seconds in starts)
    q = rotations.sign_continuous(q)
    ephemeris = EphemerisData(q, instants, frame, None, rate, name, events=events)
    # Instants remain distinct, and within the clock's range, when they are counted as a CK of theirs would.
    seconds, _ = time_origin.tt_origin(ephemeris[:1]).seconds(instants)
    if not (np.diff(seconds) > 0.0).all() or not seconds[-1] < text_kernels.SECONDS:
        raise FormatError("instants that coincide, or span too many years, for one clock", source)
    return with_method(ephemeris, InterpolationMethod())

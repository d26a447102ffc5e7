"""The content of an AEM as it is read, in either syntax: segments of rows, joined to one ephemeris."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from ...errors import AttitudeError, InputError, note
from ...frames import rotations
from ...samples.ephemeris_data import EphemerisData
from ...samples.event import Event
from ...samples.interpolation import Interpolation, InterpolationMethod, InterpolationSegment
from ...times.instants import Instants
from .. import schema
from ..text_reader import TextReader
from .epochs import Timestamps, seconds_at, to_instants
from .keywords import HEADER, METADATA, KeywordBlock
from .segment import Rows, Segment


class MessageReader(TextReader):
    """What both syntaxes fill: version, keyword blocks and segments, read in order."""

    def __init__(self, source: str, segment: int | None):
        super().__init__(source)
        self.requested = segment
        self.version = ""
        self.segment_count = 0
        self.segments: list[Segment] = []

    def begin(self, version: str, line: int) -> None:
        """Set the version; FormatError if it is not supported."""
        if version not in ("1.0", "2.0"):
            raise self.error(f"AEM version {version[:20]!r}, not 1.0 or 2.0", line)
        self.version = version

    def header(self) -> KeywordBlock:
        """Empty header."""
        return KeywordBlock(HEADER, self.version, "header", self.source)

    def metadata(self) -> KeywordBlock:
        """Empty metadata of a segment."""
        return KeywordBlock(METADATA, self.version, "metadata", self.source)

    def begin_segment(self, fields: KeywordBlock, line: int) -> Segment | None:
        """Segment to be filled, whose metadata end at this line; None if it was not requested."""
        fields.close(line)
        self.segment_count += 1
        if self.requested not in (None, self.segment_count):
            return None
        self.segments.append(Segment(fields))
        return self.segments[-1]

    def ephemeris(self) -> EphemerisData:
        """Segments, joined; FormatError if they do not belong to one ephemeris."""
        if not self.segments:
            raise self.error(f"no segment {self.requested or 1}, of {self.segment_count}")
        for before, after in pairwise(self.segments):
            after.check_after(before)
        try:
            return _joined(self.segments)
        except AttitudeError as error:
            raise self.error(str(error)) from None


def _joined(segments: list[Segment]) -> EphemerisData:
    """One ephemeris of all segments.

    Rows that the useable spans of two overlapping segments exclude are no instants of it: they only serve
    interpolation.  An instant at which two segments meet stands twice where the attitudes differ or no
    useable span says which counts; the first of them gets the double before the second's.
    """
    rows = [segment.rows() for segment in segments]
    stamps = Timestamps.joined(part.stamps for part in rows)
    attitude = np.concatenate([part.attitude for part in rows], axis=1).T
    sign_changes = sum(rotations.sign_changes(part.attitude.T) for part in rows)
    attitude = rotations.sign_continuous(schema.unit_rows(attitude, segments[0].source))
    rates = [part.rate for part in rows if part.rate is not None]
    rate = np.concatenate(rates, axis=1).T if len(rates) == len(rows) else None
    times = schema.check_dates(to_instants(stamps, segments[0].system))
    nodes = EphemerisData(attitude, times, segments[0].convention.frame, rate=rate)
    edges = [0, *np.cumsum([part.attitude.shape[1] for part in rows]).tolist()]
    useable = _useable(segments, rows)
    data, starts = _instants_of(nodes, stamps, useable, edges)
    excluded = sum(int((~mask).sum()) for mask in useable)
    if excluded:
        text = f"{excluded} attitudes outside useable spans only serve interpolation"
        note(f"{segments[0].source}: {text}")
    events = tuple(
        Event(float(data.elapsed[start]), "segment", f"segment {k} of the file begins")
        for k, start in enumerate(starts, start=2)
    )
    data = replace(data, name=segments[0].fields.values["OBJECT_NAME"], events=events)
    interpolation = _interpolation(segments, nodes, stamps, edges)
    return replace(data, interpolation=replace(interpolation, sign_changes=sign_changes))


def _useable(segments: list[Segment], rows: list[Rows]) -> list[np.ndarray]:
    """Masks of the rows of each segment that are instants of the ephemeris."""
    masks = [np.ones(part.attitude.shape[1], dtype=bool) for part in rows]
    for k, (before, after) in enumerate(pairwise(segments)):
        earlier, later = rows[k].stamps, rows[k + 1].stamps
        stop, start = before.useable[1], after.useable[0]
        if later.first >= earlier.last:
            continue
        if stop is not None:
            masks[k] &= ~earlier.is_after(stop)
        if start is not None:
            masks[k + 1] &= ~later.is_before(start)
        for segment, mask in ((before, masks[k]), (after, masks[k + 1])):
            if not mask.any():
                raise segment.fields.error("START_TIME", "no attitudes in the useable span of this segment")
        last, first = int(np.flatnonzero(masks[k])[-1]), int(np.argmax(masks[k + 1]))
        same = np.array_equal(rows[k].attitude[:, last], rows[k + 1].attitude[:, first])
        masks[k][last] &= not (same and earlier.at(last) == later.at(first))
    return masks


def _instants_of(
    nodes: EphemerisData, stamps: Timestamps, masks: list[np.ndarray], edges: list[int]
) -> tuple[EphemerisData, list[int]]:
    """The nodes that are instants of the ephemeris, and where segments begin among them."""
    kept = np.concatenate(masks)
    starts = [int(kept[:edge].sum()) for edge in edges[1:-1]]
    data = nodes if kept.all() else nodes[kept]
    stamps = Timestamps(stamps.second[kept], stamps.atto[kept])
    shared = [start for start in starts if stamps.at(start) == stamps.at(start - 1)]
    _check_steps(data.instants, stamps, shared)
    if not shared:
        return data, starts
    seconds = data.elapsed
    note(f"{len(shared)} epochs that two segments share are read twice, the first a double earlier")
    for start in reversed(shared):
        seconds[start - 1] = np.nextafter(seconds[start], -np.inf)
    low, epoch = data.instants.seconds_low, data.epoch
    return replace(data, instants=Instants(seconds, low, epoch, scale=data.instants.scale)), starts


def _interpolation(
    segments: list[Segment], nodes: EphemerisData, stamps: Timestamps, edges: list[int]
) -> Interpolation:
    """What the metadata state of each segment; slerp where one states nothing."""
    parts = []
    for segment, (first, last) in zip(segments, pairwise(edges), strict=True):
        part = nodes[first:last]
        ends = [part.elapsed[0], part.elapsed[-1]]
        for i, time in enumerate(segment.useable):
            if time is not None:
                ends[i] = min(max(seconds_at(time, stamps, segment.system), ends[0]), ends[1])
        rate = part.angular_velocity if part.has_rate else None
        method = segment.method or InterpolationMethod()
        parts.append(InterpolationSegment(ends[0], ends[1], part.instants, part.attitude, rate, method))
    return Interpolation(tuple(parts), any(segment.method is not None for segment in segments))


def _check_steps(times: Instants, stamps: Timestamps, shared: list[int]) -> None:
    """Refuse epochs that coincide when written again to the nanosecond, other than `shared` ones."""
    steps = np.diff(times.seconds)
    if times.seconds_low is not None:
        steps += np.diff(times.seconds_low)
    steps[np.array(shared, dtype=int) - 1] = np.inf
    if not steps.size or steps.min() > 2.1e-9:
        return
    least = 2e-9 if (stamps.atto % 10**9).any() else 1e-9
    close = np.flatnonzero(steps < least * (1.0 - 1e-3))
    if close.size:
        i = int(close[0])
        expected = f"epochs at least {least:g} s apart, which remain distinct when rounded to nanoseconds"
        raise InputError(f"attitudes[{i + 1}]", f"{float(steps[i]):.3g} s after the one before", expected)

"""The content of an AEM as it is read, in either syntax: segments of rows, joined to one ephemeris."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ...errors import AttitudeError, FormatError, InputError
from ...frames import rotations
from ...samples.ephemeris_data import EphemerisData
from ...samples.event import Event
from ...times.instants import Instants
from .. import schema, text_rows
from .conventions import row_convention
from .epochs import TIME_SYSTEMS, RowError, Timestamps, parse_epoch, parse_epochs, to_instants
from .keywords import HEADER, INTERPOLATION_METHODS, METADATA, SHARED_KEYWORDS, VERSIONS, KeywordBlock
from .rows import parse_rows

MAX_REMARKS = 100_000  # comments and empty lines, in which a file without an end may go on
ATTOSECONDS_PER_NANOSECOND = 10**9  # writers round epochs to whole nanoseconds


class Segment:
    """Metadata and the attitudes that follow them."""

    def __init__(self, fields: KeywordBlock):
        self.fields = fields
        self.source = fields.source
        self.system = fields.get("TIME_SYSTEM") or ""
        if self.system not in TIME_SYSTEMS:
            raise fields.error("TIME_SYSTEM", f"this version reads {', '.join(TIME_SYSTEMS)}")
        self.convention = row_convention(fields)
        self.columns = self.convention.columns
        self._column_kinds = "t" + "n" * len(self.columns)  # an epoch and numbers
        self._check_interpolation()
        self._span = self._read_span()
        self.stamps: list[Timestamps] = []
        self.attitudes: list[np.ndarray] = []  # (4, n) wxyz
        self.rates: list[np.ndarray] = []  # (3, n) rad/s

    # -- metadata -------------------------------------------------------------------------------

    def _check_interpolation(self) -> None:
        method, degree = self.fields.get("INTERPOLATION_METHOD"), self.fields.get("INTERPOLATION_DEGREE")
        if method is not None and method not in INTERPOLATION_METHODS:
            raise self.fields.error("INTERPOLATION_METHOD", f"not one of {', '.join(INTERPOLATION_METHODS)}")
        if method is not None and degree is None:
            raise self.fields.error("INTERPOLATION_METHOD", "no INTERPOLATION_DEGREE beside it")
        if degree is not None and not (degree.isascii() and degree.isdigit() and int(degree[:10]) > 0):
            raise self.fields.error("INTERPOLATION_DEGREE", "not a whole number greater than 0")

    def _read_span(self) -> dict[str, tuple[int, int]]:
        span: dict[str, tuple[int, int]] = {}
        for name in ("START_TIME", "USEABLE_START_TIME", "USEABLE_STOP_TIME", "STOP_TIME"):
            if name in self.fields.values:
                try:
                    span[name] = parse_epoch(self.fields.values[name].encode("ascii", "replace"), self.system)
                except RowError as error:
                    raise self.fields.error(name, error.reason) from None
        for (name, before), (other, after) in pairwise(span.items()):
            if before > after:
                raise self.fields.error(other, f"before {name}")
        return span

    # -- attitudes ------------------------------------------------------------------------------

    def add_lines(self, text: bytes, number: int) -> int:
        """Add whole lines, the first of which has this number; return how many of them are empty."""
        table, numbers = text_rows.read_spaced(text, number, self._column_kinds)
        if numbers:
            self._add(table, numbers)
        return text.count(b"\n") - len(numbers)

    def add_rows(self, rows: list[bytes], numbers: Sequence[int]) -> None:
        """Add rows with one blank between their words, and the numbers of their lines."""
        if rows:
            table = text_rows.read(b"\n".join(rows) + b"\n", self._column_kinds)
            self._add(rows if table is None else table, numbers)

    def _add(self, table: text_rows.ParsedRows | list[bytes], numbers: Sequence[int]) -> None:
        """FormatError for the first row that is wrong, with the number of its line."""
        try:
            if isinstance(table, list):
                stamps, values = parse_rows(table, self.columns, self.system)
            else:
                stamps, values = parse_epochs(table.texts[0], self.system), table.columns
            self._check_order(stamps)
            attitude, rate = self.convention.convert(values)
        except RowError as error:
            raise FormatError(error.reason, self.source, numbers[error.index]) from None
        self.stamps.append(stamps)
        self.attitudes.append(attitude)
        if rate is not None:
            self.rates.append(rate)

    def _check_order(self, stamps: Timestamps) -> None:
        """Refuse epochs that do not increase, or are outside START_TIME and STOP_TIME."""
        second, atto = stamps
        later = (second[1:] > second[:-1]) | ((second[1:] == second[:-1]) & (atto[1:] > atto[:-1]))
        if self.stamps and stamps.first <= self.stamps[-1].last:
            raise RowError(0, "an epoch that is not after the one before")
        if not later.all():
            raise RowError(int(np.argmin(later)) + 1, "an epoch that is not after the one before")
        if stamps.first < self._span["START_TIME"]:
            raise RowError(0, "an epoch before START_TIME")
        stop = self._span["STOP_TIME"]
        if stamps.last > stop:
            beyond = (second > stop[0]) | ((second == stop[0]) & (atto > stop[1]))
            raise RowError(int(np.argmax(beyond)), "an epoch after STOP_TIME")

    def close(self, line: int) -> None:
        """End the segment; FormatError if it has no attitudes."""
        if not self.stamps:
            raise FormatError("no attitudes between DATA_START and DATA_STOP", self.source, line)

    @property
    def count(self) -> int:
        """Number of attitudes read."""
        return sum(len(stamps.second) for stamps in self.stamps)

    def check_after(self, other: Segment) -> None:
        """FormatError if this segment cannot follow another one in one ephemeris."""
        for name in SHARED_KEYWORDS:
            if self.fields.get(name) != other.fields.get(name):
                shown = f"the segment before has {other.fields.values.get(name)}"
                raise self.fields.error(name, f"{shown}; segment=k reads one of them")
        stop, start = other._span.get("USEABLE_STOP_TIME"), self._span.get("USEABLE_START_TIME")
        if stop is not None and start is not None and start < stop:
            raise self.fields.error("USEABLE_START_TIME", "before USEABLE_STOP_TIME of the segment before")
        if self._span["START_TIME"] < other._span["STOP_TIME"]:
            raise self.fields.error("START_TIME", "before STOP_TIME of the segment before")
        if self.stamps[0].first < other.stamps[-1].last:
            raise self.fields.error("START_TIME", "its first epoch is before the last of the segment before")


class MessageReader:
    """What both syntaxes fill: version, keyword blocks and segments, read in order."""

    def __init__(self, source: str, segment: Any):
        if segment is not None and (isinstance(segment, bool) or not isinstance(segment, int) or segment < 1):
            raise InputError("segment", segment, "a whole number, 1 for the first, or None for all")
        self.source, self.requested = source, segment
        self.version = ""
        self.segment_count = self.remark_count = 0
        self.segments: list[Segment] = []

    def begin(self, version: str, line: int) -> None:
        """Set the version; FormatError if it is not supported."""
        if version not in VERSIONS:
            raise FormatError(f"AEM version {version[:20]!r}, not 1.0 or 2.0", self.source, line)
        self.version = version

    def add_remarks(self, line: int, count: int = 1) -> None:
        """Count comments and empty lines; FormatError if there are too many."""
        self.remark_count += count
        if self.remark_count > MAX_REMARKS:
            reason = f"more than {MAX_REMARKS} comments and empty lines"
            raise FormatError(reason, self.source, line)

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
            raise FormatError(f"no segment {self.requested or 1}, of {self.segment_count}", self.source)
        for before, after in pairwise(self.segments):
            after.check_after(before)
        try:
            return _joined(self.segments)
        except AttitudeError as error:
            raise FormatError(str(error), self.source) from None


def _joined(segments: list[Segment]) -> EphemerisData:
    first = segments[0]
    columns = zip(*(stamps for segment in segments for stamps in segment.stamps), strict=True)
    stamps = Timestamps(*map(np.concatenate, columns))
    starts = np.cumsum([segment.count for segment in segments])[:-1].tolist()
    shared = [
        start
        for start, (before, after) in zip(starts, pairwise(segments), strict=True)
        if after.stamps[0].first == before.stamps[-1].last
    ]
    for segment in segments:
        segment.stamps.clear()
    times = schema.check_dates(to_instants(stamps, first.system))
    _check_steps(times, stamps, shared)
    for start in reversed(shared):  # an instant of two segments: the first one gets the double before
        times.seconds[start - 1] = np.nextafter(times.seconds[start], -np.inf)
    events = tuple(
        Event(float(times.seconds[start]), "segment", f"segment {k} of the file begins")
        for k, start in enumerate(starts, start=2)
    )
    q = schema.unit_rows(_concatenated([segment.attitudes for segment in segments]), first.source)
    q = rotations.sign_continuous(q)
    rate = _concatenated([segment.rates for segment in segments]) if first.rates else None
    name = first.fields.values["OBJECT_NAME"]
    return EphemerisData(q, times, first.convention.frame, None, rate, name, events=events)


def _check_steps(times: Instants, stamps: Timestamps, shared: list[int]) -> None:
    """Refuse epochs that coincide when written again to the nanosecond, other than `shared` ones."""
    steps = np.diff(times.seconds)
    if times.seconds_low is not None:
        steps += np.diff(times.seconds_low)
    steps[np.array(shared, dtype=int) - 1] = np.inf
    if not steps.size or steps.min() > 2.1e-9:
        return
    least = 2e-9 if (stamps.atto % ATTOSECONDS_PER_NANOSECOND).any() else 1e-9
    close = np.flatnonzero(steps < least * (1.0 - 1e-3))
    if close.size:
        i = int(close[0])
        expected = f"epochs at least {least:g} s apart, which remain distinct when rounded to nanoseconds"
        raise InputError(f"attitudes[{i + 1}]", f"{float(steps[i]):.3g} s after the one before", expected)


def _concatenated(lists: list[list[np.ndarray]]) -> np.ndarray:
    """(n, components), stored by component; the blocks are released."""
    whole = np.concatenate([block for blocks in lists for block in blocks], axis=1).T
    for blocks in lists:
        blocks.clear()
    return whole

"""A segment of an AEM as it is read: metadata, and the rows that follow them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ... import stopping
from ...errors import FormatError, note
from ...samples.interpolation import InterpolationMethod
from .. import text_rows
from .conventions import row_convention
from .epochs import RowError, Timestamps, moved, parse_epochs, unit_of
from .keywords import ATTITUDE_TYPES, KeywordBlock
from .rows import parse_rows

TIMES = ("START_TIME", "USEABLE_START_TIME", "USEABLE_STOP_TIME", "STOP_TIME")


class Rows(NamedTuple):
    """Rows of a segment: Timestamps, (4, n) wxyz and (3, n) rad/s, or None for the rates."""

    stamps: Timestamps
    attitude: np.ndarray
    rate: np.ndarray | None

    def part(self, rows: np.ndarray | slice) -> Rows:
        """Some of the rows: a mask or a slice."""
        rate = None if self.rate is None else self.rate[:, rows]
        return Rows(Timestamps(*(part[rows] for part in self.stamps)), self.attitude[:, rows], rate)


class Segment:
    """Metadata and the attitudes that follow them."""

    def __init__(self, fields: KeywordBlock):
        self.fields = fields
        self.source = fields.source
        self.system = fields.time_system()
        if "OBJECT_ID" not in fields.values:
            note(f"{self.source}: no OBJECT_ID, which is mandatory")
        self.convention = row_convention(fields)
        self.columns = self.convention.columns
        self.kind = ATTITUDE_TYPES[fields.get("ATTITUDE_TYPE") or ""]
        stated = fields.interpolation("INTERPOLATION_METHOD")
        self.method = None if stated is None else InterpolationMethod(*stated)
        times = {name: fields.time(name) for name in TIMES}
        self.span = {name: time for name, time in times.items() if time is not None}
        for name, other in pairwise(self.span):
            if self.span[name] > self.span[other]:
                raise fields.error(other, f"before {name}")
        self.blocks: list[Rows] = []
        self._column_kinds = "t" + "n" * len(self.columns)  # an epoch and numbers

    @property
    def useable(self) -> tuple[tuple[int, int] | None, tuple[int, int] | None]:
        """The useable span, where the metadata state one."""
        return self.span.get("USEABLE_START_TIME"), self.span.get("USEABLE_STOP_TIME")

    # -- attitudes ------------------------------------------------------------------------------

    def add_lines(self, text: bytes, number: int) -> int:
        """Add whole lines, the first of which has this number; return how many are empty or comments."""
        if b"COMMENT" in text:
            text = re.sub(rb"(?m)^[ \t]*COMMENT\b.*$", b"", text)
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
        self.blocks.append(Rows(stamps, attitude, rate))

    def _check_order(self, stamps: Timestamps) -> None:
        """Refuse epochs that do not increase, or are outside START_TIME and STOP_TIME.

        A writer may have rounded these two, or the rows, to fewer digits than the others: less than a unit of
        the last digit beyond them is inside.
        """
        if self.blocks and stamps.first <= self.blocks[-1].stamps.last:
            raise RowError(0, "an epoch that is not after the one before")
        stamps.check_ascending()
        start, stop = (
            moved(self.span[name], way * max(unit_of(self.fields.values[name]), stamps.unit))
            for name, way in (("START_TIME", -1), ("STOP_TIME", 1))
        )
        if stamps.first <= start:
            raise RowError(0, "an epoch before START_TIME")
        if stamps.last >= stop:
            raise RowError(int(np.argmin(stamps.is_before(stop))), "an epoch after STOP_TIME")
        if stamps.first < self.span["START_TIME"] or stamps.last > self.span["STOP_TIME"]:
            note(f"{self.source}: epochs pass START_TIME or STOP_TIME by less than a unit of its last digit")

    def close(self, line: int) -> None:
        """End the segment; FormatError if it has no attitudes."""
        stopping.check()
        if not self.blocks:
            raise FormatError("no attitudes between DATA_START and DATA_STOP", self.source, line)

    def rows(self) -> Rows:
        """All rows; the blocks are released."""
        blocks, self.blocks = self.blocks, []
        stamps = Timestamps.joined(block.stamps for block in blocks)
        attitude = np.concatenate([block.attitude for block in blocks], axis=1)
        rates = [block.rate for block in blocks if block.rate is not None]
        return Rows(stamps, attitude, np.concatenate(rates, axis=1) if rates else None)

    def check_after(self, other: Segment) -> None:
        """FormatError if this segment cannot follow another one in one ephemeris."""
        shared = ("OBJECT_NAME", "OBJECT_ID", "CENTER_NAME", "REF_FRAME_A", "REF_FRAME_B", "ATTITUDE_DIR")
        for name in (*shared, "TIME_SYSTEM"):
            if self.fields.get(name) != other.fields.get(name):
                shown = f"the segment before has {other.fields.values.get(name)}"
                raise self.fields.error(name, f"{shown}; segment=k reads one of them")
        stop, start = other.useable[1] or other.span["STOP_TIME"], self.useable[0] or self.span["START_TIME"]
        if start < stop:
            name, before = (
                next(name for name in names if name in segment.span)
                for segment, names in ((self, TIMES[1::-1]), (other, TIMES[2:]))
            )
            raise self.fields.error(
                name, f"before {before} of the segment before; segment=k reads one of them"
            )

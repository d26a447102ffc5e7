"""CSV: metadata in comment lines, a header, a line per instant; written in blocks."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import orjson

from ...errors import FormatError
from ...samples.chunks import Samples
from .. import line_blocks, schema, text_rows

if TYPE_CHECKING:
    from ...samples.ephemeris_data import EphemerisData

METADATA_PREFIX = b"# metadata: "


def blocks(samples: Samples) -> Iterator[bytes]:
    """The file of these samples, block by block, in the memory of one chunk."""
    schema.refuse_unless_list(samples, "CSV")
    meta, names = schema.metadata(samples), schema.names(samples)
    header = ",".join(names).encode()
    yield b"# %s\n%s%s\n%s\n" % (meta["convention"].encode(), METADATA_PREFIX, orjson.dumps(meta), header)
    separators = [b"", *[b","] * (len(names) - 1), b"\n"]
    for chunk in samples.chunks():
        yield schema.rows(schema.columns(chunk, names), names, separators)


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """The ephemeris in a stream of this format; FormatError, with its place, for anything else."""
    reader = _CsvReader(source)
    for block in line_blocks.blocks(stream, source):
        reader.read(block)
    return reader.ephemeris()


class _CsvReader:
    """Reads comments, then the column names, then rows."""

    def __init__(self, source: str):
        self.source = source
        self.comments: list[str] = []
        self.names: list[str] = []
        self.first_line = 0
        self.numbers: list[np.ndarray] = []
        self.stated_count = self.count = 0

    def read(self, block: line_blocks.LineBlock) -> None:
        offset, number = 0, block.number
        while offset < block.size and not self.names:
            line, offset = block.line(offset)
            self._read_header_line(line.decode("utf-8", errors="replace"), number)
            number += 1
        if offset < block.size:
            self._read_rows(block, offset)

    def _read_rows(self, block: line_blocks.LineBlock, offset: int) -> None:
        """The rows from this offset; numpy reads those that Arrow does not, or reports what is wrong."""
        kinds = "".join("-" if name == schema.TIME else "n" for name in self.names)
        table = text_rows.read(block.text[offset:], kinds, b",")
        if table is None:
            rows = block.text[offset:-1].decode("utf-8", errors="replace").split("\n")
            columns = self._slow_path(rows, block.number_at(offset))
        else:
            columns = table.columns
        self.numbers.append(columns)
        self.count += columns.shape[1]
        schema.refuse_more(self.count, self.stated_count, self.source, self.first_line + self.stated_count)

    def _slow_path(self, rows: list[str], first_line: int) -> np.ndarray:
        """(columns, n) doubles; FormatError with the line of the first row that is none."""
        for number, row in enumerate(rows, first_line):
            count = row.count(",") + 1
            if count != len(self.names):
                raise FormatError(f"{count} values where {len(self.names)} belong", self.source, number)
        indices = [i for i, name in enumerate(self.names) if name != schema.TIME]
        try:
            return np.loadtxt(rows, delimiter=",", usecols=indices, ndmin=2, comments=None).T
        except ValueError as error:
            row_number = re.search(r"row (\d+)", str(error))
            line = first_line + int(row_number[1]) if row_number else None
            raise FormatError(str(error), self.source, line) from None

    def _read_header_line(self, row: str, number: int) -> None:
        if row.startswith("#") and len(self.comments) < 64:  # a file of comments alone is not read to its end
            self.comments.append(row)
            return
        self.stated_count = schema.stated_count(_metadata(self.comments, self.source), self.source)
        names = row.split(",")
        if len(set(names)) < len(names):
            raise FormatError("a column name twice", self.source, number)
        self.names, self.first_line = names, number + 1

    def ephemeris(self) -> EphemerisData:
        meta = _metadata(self.comments, self.source)
        if not self.names:
            raise FormatError("ends before the column names", self.source, len(self.comments))
        if not self.numbers:
            raise FormatError("no instants", self.source, self.first_line)
        matrix = np.concatenate(self.numbers, axis=1)
        names = [name for name in self.names if name != schema.TIME]
        table = dict(zip(names, matrix, strict=True))
        return schema.ephemeris_from(meta, table, self.source, self.first_line)


def _metadata(comments: list[str], source: str) -> dict[str, Any]:
    for number, comment in enumerate(comments, start=1):
        if comment.startswith(METADATA_PREFIX.decode()):
            try:
                meta: dict[str, Any] = orjson.loads(comment[len(METADATA_PREFIX) :])
            except orjson.JSONDecodeError:
                raise FormatError("metadata that are not JSON", source, number) from None
            if not isinstance(meta, dict):
                raise FormatError("metadata that are not an object", source, number)
            return meta
    raise FormatError("not an ephemeris of this library: no metadata comment", source, 1)

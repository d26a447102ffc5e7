"""CSV: metadata in comment lines, a header, a line per instant; written in blocks."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np
import orjson

from ...errors import FormatError
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from .. import schema, text_rows
from .row_reader import RowReader

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
    return CsvReader(source).read(stream)


def metadata_of(lines: list[str], source: str) -> dict[str, Any] | None:
    """The metadata in the comments at the beginning of a file; None of a file without them."""
    for number, line in enumerate(lines, start=1):
        if line.startswith(METADATA_PREFIX.decode()):
            try:
                meta: dict[str, Any] = orjson.loads(line[len(METADATA_PREFIX) :])
            except orjson.JSONDecodeError:
                raise FormatError("metadata that are not JSON", source, number) from None
            if not isinstance(meta, dict):
                raise FormatError("metadata that are not an object", source, number)
            return meta
    return None


class CsvReader(RowReader):
    """Comments, then the column names, then rows."""

    def __init__(self, source: str):
        super().__init__(source)
        self.comments: list[str] = []

    def is_header(self, line: bytes, number: int) -> bool:
        """Comments, and the names of the columns."""
        if self.names:
            return False
        row = line.decode("utf-8", errors="replace")
        if row.startswith("#") and len(self.comments) < 64:  # a file of comments alone is not read to its end
            self.comments.append(row)
            return True
        self.end_of_metadata(self._metadata(), number + 1)
        self.names = row.split(",")
        if len(set(self.names)) < len(self.names):
            raise self.error("a column name twice", number)
        return True

    def _metadata(self) -> dict[str, Any]:
        meta = metadata_of(self.comments, self.source)
        if meta is None:
            raise self.error("not an ephemeris of this library: no metadata comment", 1)
        return meta

    def no_rows(self) -> FormatError:
        """The error of a file without metadata, without names, or without rows."""
        self._metadata()
        if not self.names:
            return self.error("ends before the column names", len(self.comments))
        return super().no_rows()

    def columns(self, text: bytes, number: int) -> np.ndarray:
        """Numbers by Arrow; numpy reads rows that Arrow does not, or reports what is wrong."""
        kinds = "".join("-" if name == schema.TIME else "n" for name in self.names)
        table = text_rows.read(text, kinds, b",")
        if table is not None:
            return table.columns
        rows = text[:-1].decode("utf-8", errors="replace").split("\n")
        for line, row in enumerate(rows, number):
            count = row.count(",") + 1
            if count != len(self.names):
                raise self.error(f"{count} values where {len(self.names)} belong", line)
        indices = [i for i, name in enumerate(self.names) if name != schema.TIME]
        try:
            return np.loadtxt(rows, delimiter=",", usecols=indices, ndmin=2, comments=None).T
        except ValueError as error:
            match = re.search(r"row (\d+)", str(error))
            raise self.error(str(error), number + int(match[1]) if match else None) from None

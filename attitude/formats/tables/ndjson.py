"""NDJSON: a line of metadata, then a line per instant, each a JSON object."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import orjson

from ...errors import FormatError
from ...samples.chunks import Samples
from .. import line_blocks, schema, text_rows

if TYPE_CHECKING:
    from ...samples.ephemeris_data import EphemerisData

NOT_PUNCTUATION = bytes(set(range(256)) - set(b'{}:,"\n'))
PUNCTUATION_TO_BLANKS = bytes.maketrans(b"{}:,", b"    ")


def blocks(samples: Samples) -> Iterator[bytes]:
    """The file of these samples, block by block, in the memory of one chunk."""
    schema.refuse_unless_list(samples, "NDJSON")
    yield orjson.dumps(schema.metadata(samples)) + b"\n"
    names = schema.names(samples)
    quote = b'"' if names[0] == schema.TIME else b""
    keys = [b'"%s":' % name.encode() for name in names]
    pieces = [b"{" + keys[0] + quote, quote + b"," + keys[1], *(b"," + key for key in keys[2:]), b"}\n"]
    for chunk in samples.chunks():
        yield schema.rows(schema.columns(chunk, names), names, pieces)


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """The ephemeris in a stream of this format; FormatError, with its place, for anything else."""
    reader = _NdjsonReader(source)
    for block in line_blocks.blocks(stream, source):
        reader.read(block)
    return reader.ephemeris()


class _NdjsonReader:
    """Reads a line of metadata, then rows, each block into columns of numbers."""

    def __init__(self, source: str):
        self.source = source
        self.meta: Any = None
        self.names: list[str] | None = None  # of the first row
        self.punctuation = b""  # of the first row
        self.numbers: list[np.ndarray] = []
        self.stated_count = self.count = 0

    def read(self, block: line_blocks.LineBlock) -> None:
        offset, number = 0, block.number
        if self.meta is None:
            line, offset = block.line(0)
            self.meta, number = _object(line, self.source, number), number + 1
            self.stated_count = schema.stated_count(self.meta, self.source, 1)
        if offset == block.size:
            return
        if self.names is None:
            line, _ = block.line(offset)
            self.names = list(_object(line, self.source, number))
            self.punctuation = line.translate(None, NOT_PUNCTUATION) + b"\n"
        text = block.text[offset:]
        columns = self._fast_path(text, self.names)
        self.numbers.append(self._slow_path(text, self.names, number) if columns is None else columns)
        self.count += self.numbers[-1].shape[1]
        schema.refuse_more(self.count, self.stated_count, self.source, self.stated_count + 2)

    def _fast_path(self, text: bytes, names: list[str]) -> np.ndarray | None:
        """(c, n) numbers of rows with names and punctuation in the order of the first row; else None."""
        from pyarrow import compute

        if text.translate(None, NOT_PUNCTUATION) != self.punctuation * text.count(b"\n"):
            return None
        # Between quotes: the opening brace, then each name and its number, or its colon, date and comma.
        kinds = "-" + "".join("t---" if name == schema.TIME else "tn" for name in names)
        table = text_rows.read(text.translate(PUNCTUATION_TO_BLANKS), kinds, b'"')
        if table is None:
            return None
        pairs = zip(table.texts, names, strict=True)
        same = all(compute.all(compute.equal(texts, name.encode())).as_py() for texts, name in pairs)
        return table.columns if same else None

    def _slow_path(self, text: bytes, names: list[str], first_line: int) -> np.ndarray:
        """(c, n) numbers of any rows; FormatError with the line of the first that is none."""
        rows = []
        for number, line in enumerate(text[:-1].split(b"\n"), first_line):
            row = _object(line, self.source, number)
            if row.keys() != set(names):
                raise FormatError("other names than in the line before", self.source, number)
            rows.append({name: self._number(row, name, number) for name in names if name != schema.TIME})
        columns = [[row[name] for row in rows] for name in names if name != schema.TIME]
        return np.array(columns).reshape(-1, len(rows))

    def _number(self, row: dict[str, Any], name: str, line: int) -> float:
        value = row[name]
        if type(value) not in (float, int) or abs(value) > sys.float_info.max:
            raise FormatError(f"{name}: a number; got {value!r:.40}", self.source, line)
        return float(value)

    def ephemeris(self) -> EphemerisData:
        if self.names is None:
            raise FormatError("no instants", self.source)
        names = [name for name in self.names if name != schema.TIME]
        table = dict(zip(names, np.concatenate(self.numbers, axis=1), strict=True))
        return schema.ephemeris_from(self.meta, table, self.source, 2)


def _object(line: bytes, source: str, number: int) -> dict[str, Any]:
    try:
        document = orjson.loads(line)
    except orjson.JSONDecodeError as error:
        raise FormatError(f"not JSON: {error.msg}", source, number) from None
    if not isinstance(document, dict):
        raise FormatError("not a JSON object", source, number)
    return document

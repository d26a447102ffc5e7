"""A line of metadata, then a line an instant, each a JSON object."""

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


MARKS = b'{}:,"\n'
NO_MARKS = bytes(set(range(256)) - set(MARKS))
BLANKS = bytes.maketrans(b"{}:,", b"    ")


def blocks(samples: Samples) -> Iterator[bytes]:
    if not samples.is_list:
        raise FormatError(
            f"NDJSON holds one body at a list of instants, not shape {samples.shape}; ecsv, json and npz do"
        )
    yield orjson.dumps(schema.metadata(samples)) + b"\n"
    names = schema.names(samples)
    pieces = _pieces(names)
    for piece in samples.pieces():
        yield schema.rows(schema.columns(piece, names), names, pieces)


def _pieces(names: list[str]) -> list[bytes]:
    """What stands around the values of an object."""
    quote = b'"' if names[0] == schema.TIME else b""
    keys = [b'"%s":' % name.encode() for name in names]
    return [b"{" + keys[0] + quote, quote + b"," + keys[1], *(b"," + key for key in keys[2:]), b"}\n"]


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    read = Reader(source)
    for block in line_blocks.blocks(stream, source):
        read.take(block)
    return read.ephemeris()


class Reader:
    """A line of metadata, then rows, of which each block is kept as numbers."""

    def __init__(self, source: str):
        self.source = source
        self.meta: Any = None
        self.names: list[str] | None = None  # of the first row
        self.marks = b""
        self.numbers: list[np.ndarray] = []
        self.count = self.found = 0

    def take(self, block: line_blocks.Block) -> None:
        at, number = 0, block.number
        if self.meta is None:
            line, at = block.line(0)
            self.meta, number = _object(line, self.source, number), number + 1
            self.count = schema.stated_count(self.meta, self.source, 1)
        if at < block.size:
            self._begin(block.line(at)[0], number)
            columns = self._plain(block.text[at:])
            self.numbers.append(self._careful(block.text[at:], number) if columns is None else columns)
            self.found += self.numbers[-1].shape[1]
            schema.refuse_more(self.found, self.count, self.source, self.count + 2)

    def _begin(self, line: bytes, number: int) -> None:
        """The names and the marks between them that a row has: those of the first."""
        if self.names is None:
            self.names = list(_object(line, self.source, number))
            self.marks = line.translate(None, NO_MARKS) + b"\n"

    def _plain(self, text: bytes) -> np.ndarray | None:
        """(c, n) numbers of rows with the names in the same order and the same marks between; else None."""
        from pyarrow import compute

        if text.translate(None, NO_MARKS) != self.marks * text.count(b"\n"):
            return None
        # Between quotes: what is in front, then each name and its number, or its colon, date and comma.
        names = self.names or []
        kinds = "-" + "".join("t---" if name == schema.TIME else "tn" for name in names)
        table = text_rows.read(text.translate(BLANKS), kinds, b'"')
        if table is None:
            return None
        pairs = zip(table.texts, names, strict=True)
        same = all(compute.all(compute.equal(found, name.encode())).as_py() for found, name in pairs)
        return table.columns if same else None

    def _careful(self, text: bytes, number: int) -> np.ndarray:
        """(c, n) numbers of any rows; FormatError for the first that is none."""
        texts = text[:-1].split(b"\n")
        found = [_object(line, self.source, place) for place, line in enumerate(texts, number)]
        names = self._names(found, number)
        self._refuse_what_is_no_number(found, number)
        return np.array([[float(row[name]) for row in found] for name in names]).reshape(-1, len(found))

    def _names(self, rows: list[dict[str, Any]], number: int) -> list[str]:
        """Of the numbers; the same in every row."""
        keys = dict.fromkeys(self.names or []).keys()
        for place, row in enumerate(rows, number):
            if row.keys() != keys:
                raise FormatError("other names than in the line before", self.source, place)
        return [name for name in keys if name != schema.TIME]

    def _refuse_what_is_no_number(self, rows: list[dict[str, Any]], number: int) -> None:
        for place, row in enumerate(rows, number):
            for name, value in row.items():
                is_number = type(value) in (float, int) and abs(value) <= sys.float_info.max
                if name != schema.TIME and not is_number:
                    raise FormatError(f"{name}: a number; got {value!r:.40}", self.source, place)

    def ephemeris(self) -> EphemerisData:
        if self.names is None:
            raise FormatError("no instants", self.source)
        names = [name for name in self.names if name != schema.TIME]
        table = dict(zip(names, np.concatenate(self.numbers, axis=1), strict=True))
        return schema.ephemeris_from(self.meta, table, self.source, 2)


def _object(line: bytes, source: str, number: int) -> dict[str, Any]:
    try:
        found = orjson.loads(line)
    except orjson.JSONDecodeError as error:
        raise FormatError(f"not JSON: {error.msg}", source, number) from None
    if not isinstance(found, dict):
        raise FormatError("not a JSON object", source, number)
    return found

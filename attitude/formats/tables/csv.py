"""Comma-separated text: metadata in comment lines, a header, one line an instant; written in blocks."""

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

MARK = b"# metadata: "
MOST_COMMENTS = 64


def blocks(samples: Samples) -> Iterator[bytes]:
    if not samples.is_list:
        raise FormatError(
            f"CSV holds one body at a list of instants, not shape {samples.shape}; ecsv, json and npz do"
        )
    meta, names = schema.metadata(samples), schema.names(samples)
    header = ",".join(names).encode()
    yield b"# %s\n%s%s\n%s\n" % (meta["convention"].encode(), MARK, orjson.dumps(meta), header)
    pieces = [b"", *[b","] * (len(names) - 1), b"\n"]
    for piece in samples.pieces():
        yield schema.rows(schema.columns(piece, names), names, pieces)


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    read = Reader(source)
    for block in line_blocks.blocks(stream, source):
        read.take(block)
    return read.ephemeris()


class Reader:
    """Comments, then the column names, then rows."""

    def __init__(self, source: str):
        self.source = source
        self.comments: list[str] = []
        self.names: list[str] = []
        self.first_line = 0
        self.numbers: list[np.ndarray] = []
        self.count = self.found = 0

    def take(self, block: line_blocks.Block) -> None:
        at, number = 0, block.number
        while at < block.size and not self.names:
            line, at = block.line(at)
            self._head(line.decode("utf-8", errors="replace"), number)
            number += 1
        if at < block.size:
            self._rows(block, at)

    def _rows(self, block: line_blocks.Block, at: int) -> None:
        """From there on; what is no plain row is left to numpy, which reads it or tells what is wrong."""
        wanted = [i for i, name in enumerate(self.names) if name != schema.TIME]
        kinds = "".join("-" if name == schema.TIME else "n" for name in self.names)
        table = text_rows.read(block.text[at:], kinds, b",")
        if table is None:
            texts = block.text[at:-1].decode("utf-8", errors="replace").split("\n")
            self._keep(_numbers(texts, wanted, len(self.names), self.source, block.number_at(at)).T)
        else:
            self._keep(table.columns)

    def _keep(self, columns: np.ndarray) -> None:
        self.numbers.append(columns)
        self.found += columns.shape[1]
        schema.refuse_more(self.found, self.count, self.source, self.first_line + self.count)

    def _head(self, row: str, number: int) -> None:
        if row.startswith("#") and len(self.comments) < MOST_COMMENTS:
            self.comments.append(row)
            return
        self.count = schema.stated_count(_metadata(self.comments, self.source), self.source)
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
        wanted = [name for name in self.names if name != schema.TIME]
        table = dict(zip(wanted, matrix, strict=True))
        return schema.ephemeris_from(meta, table, self.source, self.first_line)


def _metadata(comments: list[str], source: str) -> dict[str, Any]:
    for number, comment in enumerate(comments, start=1):
        if comment.startswith(MARK.decode()):
            try:
                meta: dict[str, Any] = orjson.loads(comment[len(MARK) :])
            except orjson.JSONDecodeError:
                raise FormatError("metadata that are not JSON", source, number) from None
            if not isinstance(meta, dict):
                raise FormatError("metadata that are not an object", source, number)
            return meta
    raise FormatError("not an ephemeris of this library: no metadata comment", source, 1)


def _numbers(texts: list[str], wanted: list[int], width: int, source: str, first_line: int) -> np.ndarray:
    """(n, columns) doubles, with the line of the first that is none."""
    for number, row in enumerate(texts):
        if row.count(",") != width - 1:
            raise FormatError(
                f"{row.count(',') + 1} values where {width} belong", source, first_line + number
            )
    try:
        return np.loadtxt(texts, delimiter=",", usecols=wanted, ndmin=2, comments=None)
    except ValueError as error:
        place = re.search(r"row (\d+)", str(error))
        raise FormatError(str(error), source, first_line + int(place[1]) if place else None) from None

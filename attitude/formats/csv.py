"""Comma-separated text: metadata in comment lines, a header, one line an instant; written in blocks."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import orjson

from ..errors import FormatError
from . import lines, parts
from .samples import Samples

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris

MARK = b"# metadata: "
MOST_COMMENTS = 64


def blocks(samples: Samples) -> Iterator[bytes]:
    if not samples.is_list:
        raise FormatError(
            f"CSV holds one body at a list of instants, not shape {samples.shape}; ecsv, json and npz do"
        )
    meta, names = parts.metadata(samples), parts.names(samples)
    header = ",".join(names).encode()
    yield b"# %s\n%s%s\n%s\n" % (meta["convention"].encode(), MARK, orjson.dumps(meta), header)
    for piece in samples.pieces():
        for table in parts.tables(piece, names):
            yield _rows(table, names)


def _rows(table: dict[str, np.ndarray], names: list[str]) -> bytes:
    lines = parts.digits(table, names, b",")
    if parts.TIME in names:
        lines = [time + b"," + line for time, line in zip(table[parts.TIME].tolist(), lines, strict=True)]
    return b"\n".join(lines) + b"\n"


def parse(stream: BinaryIO, source: str) -> Ephemeris:
    read = Reader(source)
    for block in lines.blocks(stream, source):
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

    def take(self, block: lines.Block) -> None:
        rows = [line.decode("utf-8", errors="replace") for line in block.lines]
        number = block.number
        while rows and not self.names:
            self._head(rows.pop(0), number)
            number += 1
        if rows:
            wanted = [i for i, name in enumerate(self.names) if name != parts.TIME]
            self.numbers.append(_numbers(rows, wanted, len(self.names), self.source, number))

    def _head(self, row: str, number: int) -> None:
        if row.startswith("#") and len(self.comments) < MOST_COMMENTS:
            self.comments.append(row)
            return
        _metadata(self.comments, self.source)
        names = row.split(",")
        if len(set(names)) < len(names):
            raise FormatError("a column name twice", self.source, number)
        self.names, self.first_line = names, number + 1

    def ephemeris(self) -> Ephemeris:
        meta = _metadata(self.comments, self.source)
        if not self.names:
            raise FormatError("ends before the column names", self.source, len(self.comments))
        if not self.numbers:
            raise FormatError("no instants", self.source, self.first_line)
        matrix = np.concatenate(self.numbers)
        wanted = [name for name in self.names if name != parts.TIME]
        table = {name: matrix[:, i] for i, name in enumerate(wanted)}
        return parts.ephemeris_from(meta, table, self.source, self.first_line)


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


def _numbers(rows: list[str], wanted: list[int], width: int, source: str, first_line: int) -> np.ndarray:
    """(n, columns) doubles, with the line of the first that is none."""
    for number, row in enumerate(rows):
        if row.count(",") != width - 1:
            raise FormatError(
                f"{row.count(',') + 1} values where {width} belong", source, first_line + number
            )
    try:
        return np.loadtxt(rows, delimiter=",", usecols=wanted, ndmin=2, comments=None)
    except ValueError as error:
        place = re.search(r"row (\d+)", str(error))
        raise FormatError(str(error), source, first_line + int(place[1]) if place else None) from None

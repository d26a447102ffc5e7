"""A line of metadata, then a line an instant, each a JSON object."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import orjson

from ..errors import FormatError
from . import lines, parts
from .samples import Samples

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris


def blocks(samples: Samples) -> Iterator[bytes]:
    if not samples.is_list:
        raise FormatError(
            f"NDJSON holds one body at a list of instants, not shape {samples.shape}; ecsv, json and npz do"
        )
    yield orjson.dumps(parts.metadata(samples)) + b"\n"
    names = parts.names(samples)
    for piece in samples.pieces():
        for table in parts.tables(piece, names):
            yield _rows(table, names)


def _rows(table: dict[str, np.ndarray], names: list[str]) -> bytes:
    dated = parts.TIME in names
    numbers = names[1:] if dated else names
    row = (
        b"{"
        + (b'"time":"%s",' if dated else b"")
        + b",".join(b'"%s":%%s' % n.encode() for n in numbers)
        + b"}\n"
    )
    digits = parts.digits(table, names, b",")
    values = [digit for line in digits for digit in line.split(b",")]
    if dated:
        width = len(numbers)
        times = table[parts.TIME].tolist()
        values = [v for i, time in enumerate(times) for v in (time, *values[i * width : (i + 1) * width])]
    return row * len(digits) % tuple(values)


def parse(stream: BinaryIO, source: str) -> Ephemeris:
    read = Reader(source)
    for block in lines.blocks(stream, source):
        read.take(block)
    return read.ephemeris()


class Reader:
    """A line of metadata, then rows, of which each block is kept as numbers."""

    def __init__(self, source: str):
        self.source = source
        self.meta: Any = None
        self.names: list[str] | None = None
        self.numbers: list[np.ndarray] = []

    def take(self, block: lines.Block) -> None:
        rows, number = block.lines, block.number
        if self.meta is None:
            self.meta, rows, number = _object(rows[0], self.source, number), rows[1:], number + 1
        if rows:
            self._add(_objects(rows, self.source, number), number)

    def _add(self, rows: list[dict[str, Any]], number: int) -> None:
        names = self._names(rows, number)
        values = [row[name] for name in names for row in rows]
        if set(map(type, values)) <= {float, int}:
            try:
                self.numbers.append(np.array(values, dtype=float).reshape(len(names), len(rows)))
                return
            except OverflowError:
                pass
        self._refuse_what_is_no_number(rows, number)

    def _names(self, rows: list[dict[str, Any]], number: int) -> list[str]:
        """Of the numbers; the same in every row."""
        self.names = list(rows[0]) if self.names is None else self.names
        keys = dict.fromkeys(self.names).keys()
        for place, row in enumerate(rows, number):
            if row.keys() != keys:
                raise FormatError("other names than in the line before", self.source, place)
        return [name for name in self.names if name != parts.TIME]

    def _refuse_what_is_no_number(self, rows: list[dict[str, Any]], number: int) -> None:
        for place, row in enumerate(rows, number):
            for name, value in row.items():
                is_number = type(value) in (float, int) and abs(value) <= sys.float_info.max
                if name != parts.TIME and not is_number:
                    raise FormatError(f"{name}: a number; got {value!r:.40}", self.source, place)

    def ephemeris(self) -> Ephemeris:
        if self.names is None:
            raise FormatError("no instants", self.source)
        names = [name for name in self.names if name != parts.TIME]
        table = dict(zip(names, np.concatenate(self.numbers, axis=1), strict=True))
        return parts.ephemeris_from(self.meta, table, self.source, 2)


def _objects(rows: list[bytes], source: str, number: int) -> list[dict[str, Any]]:
    """One a line: all at once where each is plainly one object, with its braces around it and none inside."""
    text = b",\n".join(rows)
    braces = text.count(b"{") == text.count(b"}") == len(rows) == text.count(b"},\n{") + 1
    if braces and text.startswith(b"{") and text.endswith(b"}"):
        try:
            return orjson.loads(b"[" + text + b"]")
        except orjson.JSONDecodeError:
            pass  # it is told below in which line
    return [_object(line, source, place) for place, line in enumerate(rows, number)]


def _object(line: bytes, source: str, number: int) -> dict[str, Any]:
    try:
        found = orjson.loads(line)
    except orjson.JSONDecodeError as error:
        raise FormatError(f"not JSON: {error.msg}", source, number) from None
    if not isinstance(found, dict):
        raise FormatError("not a JSON object", source, number)
    return found

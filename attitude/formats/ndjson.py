"""A line of metadata, then a line an instant, each a JSON object."""

from __future__ import annotations

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
        yield _rows(parts.columns(piece, names), names)


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
    meta: Any = None
    columns: dict[str, list[Any]] = {}
    for block in lines.blocks(stream, source):
        for number, line in enumerate(block.lines, block.number):
            found = _object(line, source, number)
            if meta is None:
                meta = found
                continue
            if columns.keys() != found.keys() and columns:
                raise FormatError("other names than in the line before", source, number)
            for name, value in found.items():
                columns.setdefault(name, []).append(value)
    if not columns:
        raise FormatError("no instants", source)
    columns.pop(parts.TIME, None)
    return parts.ephemeris_from(meta, columns, source, 2)


def _object(line: bytes, source: str, number: int) -> dict[str, Any]:
    try:
        found = orjson.loads(line)
    except orjson.JSONDecodeError as error:
        raise FormatError(f"not JSON: {error.msg}", source, number) from None
    if not isinstance(found, dict):
        raise FormatError("not a JSON object", source, number)
    return found

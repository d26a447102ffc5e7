"""Comma-separated text: metadata in comment lines, a header, one line an instant; written in blocks."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import orjson

from ..errors import FormatError
from . import parts

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris

BLOCK = 1 << 16
MARK = b"# metadata: "


def blocks(ephemeris: Ephemeris, progress: Callable[[float], None]) -> Iterator[bytes]:
    if len(ephemeris.shape) != 1:
        raise FormatError(
            f"CSV holds one body at a list of instants, not shape {ephemeris.shape}; ecsv and json do"
        )
    meta = parts.metadata(ephemeris)
    names = ",".join(_header(ephemeris))
    yield b"# %s\n%s%s\n%s\n" % (meta["convention"].encode(), MARK, orjson.dumps(meta), names.encode())
    for start in range(0, len(ephemeris), BLOCK):
        stop = min(start + BLOCK, len(ephemeris))
        yield _rows(parts.columns(ephemeris[start:stop]), _header(ephemeris))
        progress(stop / len(ephemeris))


def _header(ephemeris: Ephemeris) -> list[str]:
    """Column names, the same for every block: the rest of two-part seconds stands in all or in none."""
    names = list(parts.columns(ephemeris[:1]))
    rest = ephemeris.instants.rest
    if rest is not None and rest.any() and parts.REST not in names:
        names.insert(names.index(parts.ELAPSED) + 1, parts.REST)
    return names


def _rows(table: dict[str, np.ndarray], names: list[str]) -> bytes:
    """The digits are orjson's: shortest form that reads back to the same bits, at 20 ns a number."""
    numbers = [name for name in names if name != parts.TIME]
    zero = np.zeros_like(table[parts.ELAPSED])
    matrix = np.stack([table.get(name, zero) for name in numbers], axis=1)
    lines = orjson.dumps(matrix, option=orjson.OPT_SERIALIZE_NUMPY)[2:-2].split(b"],[")
    if parts.TIME in names:
        lines = [time + b"," + line for time, line in zip(table[parts.TIME].tolist(), lines, strict=True)]
    return b"\n".join(lines) + b"\n"


def parse(text: bytes, source: str) -> Ephemeris:
    lines = text.decode("utf-8", errors="replace").split("\n")
    if lines.pop():
        raise FormatError("ends in the middle of a line", source, len(lines) + 1)
    lines = [line.removesuffix("\r") for line in lines]
    comments = [line for line in lines[:64] if line.startswith("#")]
    meta = _metadata(comments, source)
    body = lines[len(comments) :]
    if not body:
        raise FormatError("ends before the column names", source, len(lines))
    names = body[0].split(",")
    if len(set(names)) < len(names):
        raise FormatError("a column name twice", source, len(comments) + 1)
    wanted = [i for i, name in enumerate(names) if name != parts.TIME]
    first_line = len(comments) + 2
    matrix = _numbers(body[1:], wanted, len(names), source, first_line)
    table = {names[i]: matrix[:, k] for k, i in enumerate(wanted)}
    return parts.ephemeris_from(meta, table, source, first_line)


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
    if not rows:
        raise FormatError("no instants", source, first_line)
    try:
        return np.loadtxt(rows, delimiter=",", usecols=wanted, ndmin=2, comments=None)
    except ValueError as error:
        place = re.search(r"row (\d+)", str(error))
        raise FormatError(str(error), source, first_line + int(place[1]) if place else None) from None

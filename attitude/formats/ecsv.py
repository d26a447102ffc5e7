"""ECSV: the header is astropy's, the rows below it are written in blocks; astropy reads both."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import TYPE_CHECKING, BinaryIO

import numpy as np
import orjson
from astropy.table import QTable

from ..errors import FormatError
from . import whole
from .samples import Samples
from .table import from_table, refuse_unfolding, to_table

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris

MOST_BYTES = 1 << 30  # astropy reads the whole text at once


def blocks(samples: Samples) -> Iterator[bytes]:
    yield _header(samples)
    for piece in samples.pieces():
        yield _rows(to_table(piece, has_rest=samples.has_rest))


def _header(samples: Samples) -> bytes:
    """What astropy writes above the rows of such a table."""
    text = io.StringIO()
    first = to_table(samples.head, samples.shape, samples.has_rest)
    first.write(text, format="ascii.ecsv")
    return text.getvalue().encode()[: -len(_last_line(text.getvalue()))]


def _last_line(text: str) -> bytes:
    return text[text.rindex("\n", 0, -1) + 1 :].encode()


def _rows(table: QTable) -> bytes:
    """A cell of several numbers is JSON; digits are the shortest that read back to the same bits."""
    cells = []
    for name in table.colnames:
        if name == "time":
            cells += [_numbers(table[name].jd1), _numbers(table[name].jd2)]
            continue
        column = np.asarray(table[name].value if hasattr(table[name], "unit") else table[name])
        cells.append(_numbers(column) if column.ndim == 1 else _vectors(column))
    return b"\n".join(map(b" ".join, zip(*cells, strict=True))) + b"\n"


def _numbers(values: np.ndarray) -> list[bytes]:
    text = orjson.dumps(np.ascontiguousarray(values), option=orjson.OPT_SERIALIZE_NUMPY)
    return text[1:-1].split(b",")


def _vectors(values: np.ndarray) -> list[bytes]:
    """Of shape (n, ...), n texts without a blank."""
    depth = values.ndim - 1
    text = orjson.dumps(np.ascontiguousarray(values), option=orjson.OPT_SERIALIZE_NUMPY)
    between = b"]" * depth + b"," + b"[" * depth
    opening, closing = b"[" * depth, b"]" * depth
    return [opening + row + closing for row in text[depth + 1 : -depth - 1].split(between)]


def parse(stream: BinaryIO, source: str) -> Ephemeris:
    text = whole.text(stream, source, MOST_BYTES)
    _refuse_gaps(text, source)
    try:
        refuse_unfolding("\n".join(line[2:] for line in text.decode().split("\n") if line.startswith("# ")))
        table = QTable.read(text.decode(), format="ascii.ecsv")
    except Exception as error:  # astropy's reader raises a dozen kinds; none may leave as it is
        raise FormatError(
            f"not ECSV that astropy reads: {' '.join(str(error).split())[:200]}", source
        ) from None
    return from_table(table, source)


def _refuse_gaps(text: bytes, source: str) -> None:
    """A missing number stands as "" in a row, or null in a cell; astropy's reader makes it zero."""
    for number, line in enumerate(text.split(b"\n"), start=1):
        if (b'""' in line or b"null" in line) and not line.startswith(b"#"):
            raise FormatError("elapsed, quaternion or rate without a value", source, number)

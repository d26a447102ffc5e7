"""ECSV: the header is astropy's, the rows below it are written in blocks; astropy reads both."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import orjson
from astropy.table import QTable

from ...errors import FormatError
from ...samples.chunks import Samples
from .. import bounded_read, text_rows
from ..text_rows import texts
from .qtable import from_table, refuse_unfolding, to_table

if TYPE_CHECKING:
    from ...samples.ephemeris_data import EphemerisData

HEADER = re.compile(rb"(?:#[^\n]*\n)*(?:[^#\n]+\n)?")  # comments, and the names
MOST_BYTES = 1 << 30  # astropy reads the whole text at once


def blocks(samples: Samples) -> Iterator[bytes]:
    yield _header(samples)
    for piece in samples.chunks():
        yield _rows(to_table(piece, has_seconds_low=samples.has_seconds_low))


def _header(samples: Samples) -> bytes:
    """What astropy writes above the rows of such a table."""
    text = io.StringIO()
    first = to_table(samples.first, samples.shape, samples.has_seconds_low)
    first.write(text, format="ascii.ecsv")
    return text.getvalue().encode()[: -len(_last_line(text.getvalue()))]


def _last_line(text: str) -> bytes:
    return text[text.rindex("\n", 0, -1) + 1 :].encode()


def _rows(table: QTable) -> bytes:
    """A cell of several numbers is JSON."""
    cells: list[np.ndarray] = []
    for name in table.colnames:
        if name == "time":
            cells += [table[name].jd1, table[name].jd2]
        else:
            cells.append(np.asarray(table[name].value if hasattr(table[name], "unit") else table[name]))
    row = b" ".join(orjson.dumps(np.zeros(cell.shape[1:]).tolist()) for cell in cells) + b"\n"
    columns = np.concatenate([cell.reshape(len(cell), -1).T for cell in cells])
    return texts(columns, row.split(b"0.0"))


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    text = bounded_read.text(stream, source, MOST_BYTES)
    _refuse_gaps(text, source)
    try:
        begin = HEADER.match(text).end()  # type: ignore[union-attr]  # it may be empty
        header = text[:begin].decode().split("\n")
        refuse_unfolding("\n".join(line[2:] for line in header if line.startswith("# ")))
        table = _plain(text, begin)
        table = QTable.read(text.decode(), format="ascii.ecsv") if table is None else table
    except Exception as error:  # astropy's reader raises a dozen kinds; none may leave as it is
        raise FormatError(
            f"not ECSV that astropy reads: {' '.join(str(error).split())[:200]}", source
        ) from None
    return from_table(table, source)


def _plain(text: bytes, begin: int) -> QTable | None:
    """The columns of numbers, where names and rows are as they are written here; else None.

    What they are, astropy reads off the header and the first row, which begins here.
    """
    one = QTable.read(text[: text.find(b"\n", begin) + 1].decode(), format="ascii.ecsv")
    numbers = [name for name in one.colnames if name != "time"]
    names = text[text.rindex(b"\n", 0, begin - 1) + 1 : begin - 1].decode().split(" ")
    known = [name for name in names if name not in ("time.jd1", "time.jd2")]
    if known != numbers or any(one[name].dtype != float or one[name].ndim > 2 for name in numbers):
        return None
    kinds = ["t" if name in numbers and one[name].ndim == 2 else "n" for name in names]
    found = text_rows.read(text[begin:], "".join(kinds))
    if found is None:
        return None
    cells, columns = iter(found.texts), iter(found.columns)
    table = QTable(meta=one.meta)
    for name, kind in zip(names, kinds, strict=True):
        values = next(columns) if kind == "n" else _vectors(next(cells), one[name].shape[1])
        if values is None:
            return None
        if name in numbers:
            unit = getattr(one[name], "unit", None)
            table[name] = values if unit is None else values * unit
    return table


def _vectors(cells: Any, width: int) -> np.ndarray | None:
    """(n, width) of n texts such as [0.5,0.5,0.5,0.5]; None where one of them is not."""
    text = text_rows.contents(cells).tobytes()
    found = text_rows.read(text[1:-1].replace(b"][", b"\n") + b"\n", "n" * width, b",")
    if found is None or found.columns.shape[1] != len(cells) or text[:1] + text[-1:] != b"[]":
        return None
    return found.columns.T


def _refuse_gaps(text: bytes, source: str) -> None:
    """A missing number stands as "" in a row, or null in a cell; astropy's reader makes it zero."""
    if b'""' not in text and b"null" not in text:
        return
    for number, line in enumerate(text.split(b"\n"), start=1):
        if (b'""' in line or b"null" in line) and not line.startswith(b"#"):
            raise FormatError("elapsed, quaternion or rate without a value", source, number)

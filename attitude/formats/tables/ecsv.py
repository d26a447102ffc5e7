"""ECSV: a header written by astropy, and rows written in blocks; astropy reads both."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np
import orjson
from astropy.table import QTable

from ...errors import FormatError, library_errors
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from .. import bounded_read, text_rows
from .qtable import cells, from_table, refuse_unfolding, to_table


def blocks(samples: Samples) -> Iterator[bytes]:
    """The file of these samples, block by block, in the memory of one chunk."""
    first = io.StringIO()
    to_table(samples.first, samples.shape).write(first, format="ascii.ecsv")
    text = first.getvalue()
    yield text[: text.rindex("\n", 0, -1) + 1].encode()  # without the row of the first instant
    yield from rows(samples)


def rows(samples: Samples) -> Iterator[bytes]:
    """The file without its header; a cell of several numbers is JSON."""
    for chunk in samples.chunks():
        columns: list[np.ndarray] = []
        for name, column in cells(to_table(chunk)).items():
            columns += list(column.T) if name == "time" else [column]
        row = b" ".join(orjson.dumps(np.zeros(column.shape[1:]).tolist()) for column in columns) + b"\n"
        numbers = np.concatenate([column.reshape(len(column), -1).T for column in columns])
        yield text_rows.texts(numbers, row.split(b"0.0"))


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """The ephemeris in a stream of this format; FormatError, with its place, for anything else."""
    text = bounded_read.text(stream, source)
    if b"\n" not in text:  # astropy would take it for the name of a file
        raise FormatError("not ECSV that astropy reads: one line without an end", source)
    if b'""' in text or b"null" in text:  # which astropy would read as zero
        for number, line in enumerate(text.split(b"\n"), start=1):
            if (b'""' in line or b"null" in line) and not line.startswith(b"#"):
                raise FormatError("elapsed, quaternion or rate without a value", source, number)
    with library_errors("not ECSV that astropy reads", source):
        comments_and_names = re.match(rb"(?:#[^\n]*\n)*(?:[^#\n]+\n)?", text)
        begin = comments_and_names.end() if comments_and_names else 0
        header = text[:begin].decode().split("\n")
        refuse_unfolding("\n".join(line[2:] for line in header if line.startswith("# ")))
        table = _fast_path(text, begin)
        table = QTable.read(text.decode(), format="ascii.ecsv") if table is None else table
    return from_table(table, source)


def _fast_path(text: bytes, begin: int) -> QTable | None:
    """The table, where names and rows are as `blocks` writes them; else None.

    astropy reads the header and the first row, which begins at `begin`; Arrow reads all rows.
    """
    one = QTable.read(text[: text.find(b"\n", begin) + 1].decode(), format="ascii.ecsv")
    numbers = [name for name in one.colnames if name != "time"]
    names = text[text.rindex(b"\n", 0, begin - 1) + 1 : begin - 1].decode().split(" ")
    without_dates = [name for name in names if name not in ("time.jd1", "time.jd2")]
    if without_dates != numbers or any(one[name].dtype != float or one[name].ndim > 2 for name in numbers):
        return None
    kinds = ["t" if name in numbers and one[name].ndim == 2 else "n" for name in names]
    rows = text_rows.read(text[begin:], "".join(kinds))
    if rows is None:
        return None
    cells, columns = iter(rows.texts), iter(rows.columns)
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
    """(n, width) numbers of n texts such as [0.5,0.5,0.5,0.5]; None where any is different."""
    text = text_rows.contents(cells).tobytes()
    rows = text_rows.read(text[1:-1].replace(b"][", b"\n") + b"\n", "n" * width, b",")
    if rows is None or rows.columns.shape[1] != len(cells) or text[:1] + text[-1:] != b"[]":
        return None
    return rows.columns.T

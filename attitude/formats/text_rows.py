"""Rows of numbers as text, and back, by Arrow: every double comes back to the same bits."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from ..errors import FormatError

__all__ = ["Table", "contents", "read", "read_spaced", "texts"]

WIDEST_NUMBER = 26  # bytes: -1.2345678901234567e-308, and a point that is put in
MOST_BYTES = 1 << 30  # of a text; Arrow counts them in 32 bits


def texts(columns: np.ndarray, pieces: list[bytes], leads: np.ndarray | None = None) -> bytes:
    """The rows, in order: piece, lead, piece, number, piece, number, ..., piece.

    columns : (c, n) finite doubles, written with the fewest digits that read back to the same bits, with a
        decimal point and a digit on either side of it; FormatError for one that is not finite
    pieces : c + 2, what stands around and between the lead and the numbers; c + 1 without a lead
    leads : (n,) bytes, or None for no lead
    """
    import pyarrow as pa
    from pyarrow import compute

    finite = np.isfinite(columns).all(axis=0)
    if not finite.all():
        raise FormatError(f"a number that is not finite, in row {int(np.argmin(finite))}, is not written")
    widest = len(columns) * WIDEST_NUMBER + sum(map(len, pieces)) + (0 if leads is None else leads.itemsize)
    if len(finite) * widest > MOST_BYTES and len(finite) > 1:
        halves = [slice(len(finite) // 2), slice(len(finite) // 2, None)]
        return b"".join(texts(columns[:, h], pieces, leads if leads is None else leads[h]) for h in halves)
    cells = [] if leads is None else [_words(leads.tolist())]
    cells += [_decimals(array(column, pa.float64())) for column in columns]
    first, *others, nothing = _words([*pieces, b""])
    row = chain([first], *zip(cells, others, strict=True), [nothing])
    return contents(compute.binary_join_element_wise(*row)).tobytes()


def contents(words: Any) -> memoryview:
    """The texts of an Arrow array, one after another."""
    _, offsets, data = words.buffers()
    ends = np.frombuffer(offsets, np.int32, len(words) + 1, 4 * words.offset)
    return memoryview(data)[ends[0] : ends[-1]]


def array(values: np.ndarray, kind: Any) -> Any:
    """Arrow's, on the memory of the numbers: `pyarrow.array` looks for missing ones, and imports pandas."""
    import pyarrow as pa

    numbers = np.ascontiguousarray(values).view(np.uint8)
    return pa.Array.from_buffers(kind, len(values), [None, pa.py_buffer(numbers)])


def _words(words: list[bytes]) -> Any:
    """Arrow's of texts."""
    import pyarrow as pa

    ends = np.cumsum([0, *map(len, words)]).astype(np.int32)
    buffers = [None, pa.py_buffer(ends), pa.py_buffer(b"".join(words))]
    return pa.Array.from_buffers(pa.string(), len(words), buffers)


def _decimals(numbers: Any) -> Any:
    """Arrow writes 1 and 5e-8 for what CCSDS wants as 1.0 and 5.0e-8, and JSON needs as -0.0."""
    import pyarrow as pa
    from pyarrow import compute

    text = numbers.cast(pa.string())
    whole = compute.invert(compute.match_substring(text, "."))
    with_point = compute.replace_substring_regex(text.filter(whole), r"^(-?\d+)", r"\1.0", max_replacements=1)
    return compute.replace_with_mask(text, whole, with_point)


class Table(NamedTuple):
    """What was read of n rows.

    texts : Arrow arrays, of the columns of text
    columns : (c, n) finite doubles, of the columns of numbers
    """

    texts: list[Any]
    columns: np.ndarray


def read(text: bytes, kinds: str, separator: bytes = b" ") -> Table | None:
    """Each line as a row, or None where any line is not plainly one: who calls finds out which, and why.

    text : whole lines
    kinds : a letter for each column: t of text, n of numbers, - for one that is passed over
    separator : one byte, which stands once between two values
    """
    import pyarrow as pa
    from pyarrow import csv

    names = [str(i) for i in range(len(kinds))]
    types = {"t": pa.binary(), "n": pa.float64()}
    wanted = {name: types[kind] for name, kind in zip(names, kinds, strict=True) if kind in types}
    try:
        table = csv.read_csv(
            pa.BufferReader(text),
            csv.ReadOptions(use_threads=False, column_names=names, block_size=len(text) + 1),
            csv.ParseOptions(delimiter=separator.decode(), quote_char=False, ignore_empty_lines=False),
            csv.ConvertOptions(column_types=wanted, include_columns=list(wanted), null_values=[]),
        )
    except pa.ArrowInvalid:
        return None
    found = [column.combine_chunks() for column in table.columns]
    numbers = [each for each in found if each.type == types["n"]]
    columns = np.empty((len(numbers), table.num_rows))
    for column, each in zip(columns, numbers, strict=True):
        column[:] = np.frombuffer(each.buffers()[1], np.float64, len(each), 8 * each.offset)
    if table.num_rows != text.count(b"\n") or not np.isfinite(columns).all():
        return None
    return Table([each for each in found if each.type == types["t"]], columns)


def read_spaced(text: bytes, number: int, kinds: str) -> tuple[Table | list[bytes], Sequence[int]]:
    """Rows with any blanks and tabs between their values, and the numbers of the lines that they stand in.

    text : whole lines, of which the first has this number; empty ones are passed over
    Returns a list of the lines, with one blank between words, where any of them is no row.
    """
    table = read(text, kinds)
    if table is not None:
        return table, range(number, number + table.columns.shape[1])
    lines = [b" ".join(line.split()) for line in text.split(b"\n")[:-1]]
    numbers = [i for i, line in enumerate(lines, number) if line]
    lines = [line for line in lines if line]
    table = read(b"".join(line + b"\n" for line in lines), kinds)
    return lines if table is None else table, numbers

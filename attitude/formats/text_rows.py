"""Rows of numbers to text and back, by Arrow; doubles are read back to the same bits."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from ..errors import FormatError

MAX_TEXT_BYTES = 1 << 30  # Arrow counts them in 32 bits


def texts(columns: np.ndarray, pieces: list[bytes], leads: np.ndarray | None = None) -> bytes:
    """Text of the rows, each: piece, lead, piece, number, piece, number, ..., piece.

    columns : (c, n) finite doubles, written with the fewest digits that read back to the same bits, with a
        decimal point and a digit on either side of it; FormatError for one that is not finite
    pieces : c + 2 texts around and between the lead and the numbers; c + 1 without a lead
    leads : (n,) bytes, or None for no lead
    """
    import pyarrow as pa
    from pyarrow import compute

    finite = np.isfinite(columns).all(axis=0)
    if not finite.all():
        raise FormatError(f"a number that is not finite, in row {int(np.argmin(finite))}, is not written")
    row_bytes = sum(map(len, pieces)) + (0 if leads is None else leads.itemsize)
    row_bytes += len(columns) * len("-1.2345678901234567e-308" + ".0")  # the longest number
    if len(finite) * row_bytes > MAX_TEXT_BYTES and len(finite) > 1:
        halves = [slice(len(finite) // 2), slice(len(finite) // 2, None)]
        return b"".join(texts(columns[:, h], pieces, leads if leads is None else leads[h]) for h in halves)
    cells = [] if leads is None else [_string_array(leads.tolist())]
    cells += [_decimals(array(column, pa.float64())) for column in columns]
    first, *others, separator = _string_array([*pieces, b""])
    row = chain([first], *zip(cells, others, strict=True), [separator])
    return contents(compute.binary_join_element_wise(*row)).tobytes()


def contents(strings: Any) -> memoryview:
    """The concatenated texts of an Arrow string array."""
    _, offsets, data = strings.buffers()
    ends = np.frombuffer(offsets, np.int32, len(strings) + 1, 4 * strings.offset)
    return memoryview(data)[ends[0] : ends[-1]]


def array(values: np.ndarray, kind: Any) -> Any:
    """An Arrow array on the memory of the numbers; `pyarrow.array` searches for nulls and imports pandas."""
    import pyarrow as pa

    numbers = np.ascontiguousarray(values).view(np.uint8)
    return pa.Array.from_buffers(kind, len(values), [None, pa.py_buffer(numbers)])


def _string_array(strings: list[bytes]) -> Any:
    import pyarrow as pa

    ends = np.cumsum([0, *map(len, strings)]).astype(np.int32)
    buffers = [None, pa.py_buffer(ends), pa.py_buffer(b"".join(strings))]
    return pa.Array.from_buffers(pa.string(), len(strings), buffers)


def _decimals(numbers: Any) -> Any:
    """Numbers as text with a decimal point: Arrow writes 1 and 5e-8, CCSDS requires 1.0 and 5.0e-8."""
    import pyarrow as pa
    from pyarrow import compute

    text = numbers.cast(pa.string())
    whole = compute.invert(compute.match_substring(text, "."))
    with_point = compute.replace_substring_regex(text.filter(whole), r"^(-?\d+)", r"\1.0", max_replacements=1)
    return compute.replace_with_mask(text, whole, with_point)


class ParsedRows(NamedTuple):
    """The columns of n rows of text.

    texts : Arrow arrays, of the columns of text
    columns : (c, n) finite doubles, of the columns of numbers
    """

    texts: list[Any]
    columns: np.ndarray


def read(text: bytes, kinds: str, separator: bytes = b" ") -> ParsedRows | None:
    """The rows of a text, a line each; None where any line is not a row: the caller's slow path reports why.

    text : whole lines
    kinds : a letter for each column: t of text, n of numbers, - for a column that is skipped
    separator : one byte, exactly once between two values
    """
    import pyarrow as pa
    from pyarrow import csv

    names = [str(i) for i in range(len(kinds))]
    types = {"t": pa.binary(), "n": pa.float64()}
    column_types = {name: types[kind] for name, kind in zip(names, kinds, strict=True) if kind in types}
    try:
        table = csv.read_csv(
            pa.BufferReader(text),
            csv.ReadOptions(use_threads=False, column_names=names, block_size=len(text) + 1),
            csv.ParseOptions(delimiter=separator.decode(), quote_char=False, ignore_empty_lines=False),
            csv.ConvertOptions(column_types=column_types, include_columns=list(column_types), null_values=[]),
        )
    except pa.ArrowInvalid:
        return None
    arrays = [column.combine_chunks() for column in table.columns]
    numbers = [each for each in arrays if each.type == types["n"]]
    columns = np.empty((len(numbers), table.num_rows))
    for column, each in zip(columns, numbers, strict=True):
        column[:] = np.frombuffer(each.buffers()[1], np.float64, len(each), 8 * each.offset)
    if table.num_rows != text.count(b"\n") or not np.isfinite(columns).all():
        return None
    return ParsedRows([each for each in arrays if each.type == types["t"]], columns)


def read_spaced(text: bytes, number: int, kinds: str) -> tuple[ParsedRows | list[bytes], Sequence[int]]:
    """The rows of a text with any blanks and tabs between values, and their line numbers.

    text : whole lines, the first with this number; empty lines are skipped
    Returns the lines as a list, with one blank between words, where any of them is not a row.
    """
    table = read(text, kinds)
    if table is not None:
        return table, range(number, number + table.columns.shape[1])
    lines = [b" ".join(line.split()) for line in text.split(b"\n")[:-1]]
    numbers = [i for i, line in enumerate(lines, number) if line]
    lines = [line for line in lines if line]
    table = read(b"".join(line + b"\n" for line in lines), kinds)
    return lines if table is None else table, numbers

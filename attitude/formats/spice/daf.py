"""Double precision array files, the container of SPICE's binary kernels (NAIF, DAF required reading).

Read here from the bytes: no library's state is touched, no kernel is loaded, and nothing that a damaged file
says is believed before it was compared with the file's length.
"""

from __future__ import annotations

from typing import BinaryIO, NamedTuple

import numpy as np

from ...errors import FormatError
from .. import bounded_read

RECORD = 1024  # bytes
ORDERS = {b"LTL-IEEE": "<", b"BIG-IEEE": ">"}
# Ends of lines and high bits, between FTPSTR and ENDFTP: changed by a transfer as text.
TRANSFER = b"FTPSTR:\r:\n:\r\n:\r\x00:\x81:\x10\xce:ENDFTP"


class Array(NamedTuple):
    """One of a file's arrays.

    name : what its maker called it
    doubles, integers : its descriptor
    values : (n,) float64
    """

    name: str
    doubles: tuple[float, ...]
    integers: tuple[int, ...]
    values: np.ndarray


def content(stream: BinaryIO, kind: bytes, source: str) -> bytes:
    """A file of this kind, up to the end of the record in which its own count says that it ends.

    Raises FormatError for any other file, before more than the first record of it is read.
    """
    data = stream.read(RECORD)
    if data[:8] != kind.ljust(8):
        raise FormatError(f"does not begin with {kind.decode()}", source)
    free = int(np.frombuffer(data, f"{_order(data, source)}i4", 1, 84)[0])  # the first word that is not used
    left = max(0, -(-8 * (free - 1) // RECORD) - 1) * RECORD
    if not stream.seekable():
        return data + bounded_read.from_pipe(stream, source)
    data += stream.read(left)
    if any(stream.read(RECORD)):  # zeros may fill it up
        raise FormatError("something after its end", source)
    return data


def _order(data: bytes, source: str) -> str:
    order = ORDERS.get(data[88:96])
    if order is None or len(data) < RECORD:
        raise FormatError("no DAF file record in IEEE numbers", source)
    return order


def arrays(data: bytes, nd: int, ni: int, source: str) -> list[Array]:
    """All arrays of a file, whose descriptors have nd doubles and ni integers.

    Raises FormatError for others, and for a file that is damaged or shorter than it says.
    """
    order = _order(data, source)
    if b"FTPSTR" in data[600:RECORD] and TRANSFER not in data[600:RECORD]:
        raise FormatError("damaged by a transfer as text", source)
    found_nd, found_ni = np.frombuffer(data, f"{order}i4", 2, 8).tolist()
    if (found_nd, found_ni) != (nd, ni):
        raise FormatError(f"descriptors of {found_nd} doubles and {found_ni} integers", source)
    words = np.frombuffer(data, f"{order}f8", len(data) // 8)
    first = int(np.frombuffer(data, f"{order}i4", 1, 76)[0])
    return [
        _array(data, words, order, record, place, nd, ni, source)
        for record, count in _summaries(words, first, nd + (ni + 1) // 2, source)
        for place in range(count)
    ]


def _summaries(words: np.ndarray, first: int, size: int, source: str) -> list[tuple[int, int]]:
    """(number of a record, how many summaries are in it), in the file's order."""
    found: list[tuple[int, int]] = []
    record: float = first
    while record:
        last = words.size * 8 // RECORD
        if not 2 <= record < last or record != int(record) or int(record) in (number for number, _ in found):
            raise FormatError("a chain of summary records that leads nowhere", source)
        start = (int(record) - 1) * RECORD // 8
        following, _, count = words[start : start + 3].tolist()
        if not (0 <= count <= (RECORD // 8 - 3) // size and count == int(count)):
            raise FormatError(f"{count!r} summaries in a record", source)
        found.append((int(record), int(count)))
        record = following
    return found


def _array(
    data: bytes, words: np.ndarray, order: str, record: int, place: int, nd: int, ni: int, source: str
) -> Array:
    """The summary is doubles, then integers in pairs; its name stands at the same place a record later."""
    size = (nd + (ni + 1) // 2) * 8
    at = (record - 1) * RECORD + 24 + place * size
    doubles = np.frombuffer(data, f"{order}f8", nd, at)
    integers = np.frombuffer(data, f"{order}i4", ni, at + 8 * nd)
    begin, end = integers[-2:].tolist()
    if not 1 <= begin <= end <= words.size:
        raise FormatError(f"an array from {begin} to {end} in a file of {words.size} numbers", source)
    name = data[record * RECORD + place * size : record * RECORD + (place + 1) * size]
    values = words[begin - 1 : end].astype(np.float64)
    text = name.decode("ascii", errors="replace").strip(" \0")
    return Array(text, tuple(doubles.tolist()), tuple(integers.tolist()), values)

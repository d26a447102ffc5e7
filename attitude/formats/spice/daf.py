"""Double precision array files (DAF), the container of SPICE's binary kernels (NAIF, DAF required reading).

They are read from their bytes: no library's state is changed, no kernel is loaded, and sizes and offsets are
checked against the length of the file, which may be damaged.
"""

from __future__ import annotations

from typing import BinaryIO, NamedTuple

import numpy as np

from ...errors import FormatError
from .. import bounded_read

RECORD_BYTES = 1024
# Line ends and high bits between FTPSTR and ENDFTP, which a transfer as text changes.
TRANSFER_TEST = b"FTPSTR:\r:\n:\r\n:\r\x00:\x81:\x10\xce:ENDFTP"


class Array(NamedTuple):
    """One array of a file.

    name : of the array, or in SPICE's terms the segment
    doubles, integers : its descriptor
    values : (n,) float64
    """

    name: str
    doubles: tuple[float, ...]
    integers: tuple[int, ...]
    values: np.ndarray


def content(stream: BinaryIO, kind: bytes, source: str) -> tuple[bytes, str]:
    """Bytes of a file of this kind, to the end of its last record by its own count, and their order.

    Raises FormatError for any other file after reading only its first record.
    """
    data = stream.read(RECORD_BYTES)
    if data[:8] != kind.ljust(8):
        raise FormatError(f"does not begin with {kind.decode()}", source)
    order = {b"LTL-IEEE": "<", b"BIG-IEEE": ">"}.get(data[88:96])
    if order is None or len(data) < RECORD_BYTES:
        raise FormatError("no DAF file record in IEEE numbers", source)
    free = int(np.frombuffer(data, f"{order}i4", 1, 84)[0])  # first unused word
    left = max(0, -(-8 * (free - 1) // RECORD_BYTES) - 1) * RECORD_BYTES
    if not stream.seekable():
        return data + bounded_read.from_pipe(stream, source), order
    data += stream.read(left)
    if any(stream.read(RECORD_BYTES)):  # padding with zeros is allowed
        raise FormatError("something after its end", source)
    return data, order


def arrays(stream: BinaryIO, kind: bytes, nd: int, ni: int, source: str) -> list[Array]:
    """All arrays of a file of this kind, whose descriptors have nd doubles and ni integers.

    Raises FormatError for any other file, and for a damaged or truncated one.
    """
    data, order = content(stream, kind, source)
    if b"FTPSTR" in data[600:RECORD_BYTES] and TRANSFER_TEST not in data[600:RECORD_BYTES]:
        raise FormatError("damaged by a transfer as text", source)
    doubles, integers = np.frombuffer(data, f"{order}i4", 2, 8).tolist()
    if (doubles, integers) != (nd, ni):
        raise FormatError(f"descriptors of {doubles} doubles and {integers} integers", source)
    words = np.frombuffer(data, f"{order}f8", len(data) // 8)
    first = int(np.frombuffer(data, f"{order}i4", 1, 76)[0])
    size = nd + (ni + 1) // 2  # words of a summary: doubles, then integers in pairs
    records = _summary_records(words, first, size, source)
    offsets = [(n - 1) * RECORD_BYTES + 24 + i * size * 8 for n, count in records for i in range(count)]
    arrays_read = []
    for offset in offsets:
        doubles = np.frombuffer(data, f"{order}f8", nd, offset)
        integers = np.frombuffer(data, f"{order}i4", ni, offset + 8 * nd)
        begin, end = integers[-2:].tolist()
        if not 1 <= begin <= end <= words.size:
            raise FormatError(f"an array from {begin} to {end} in a file of {words.size} numbers", source)
        name = data[offset + RECORD_BYTES - 24 :][: size * 8].decode("ascii", errors="replace").strip(" \0")
        values = words[begin - 1 : end].astype(np.float64)
        arrays_read.append(Array(name, tuple(doubles.tolist()), tuple(integers.tolist()), values))
    return arrays_read


def _summary_records(words: np.ndarray, first: int, size: int, source: str) -> list[tuple[int, int]]:
    """Pairs (number, count of summaries) of each summary record, in the file's order."""
    counts: dict[int, int] = {}
    last = words.size * 8 // RECORD_BYTES
    record: float = first
    while record:
        if not 2 <= record < last or record != int(record) or record in counts:
            raise FormatError("summary record list is corrupt (cycle, or offset outside the file)", source)
        start = (int(record) - 1) * RECORD_BYTES // 8
        following, _, count = words[start : start + 3].tolist()
        if not (0 <= count <= (RECORD_BYTES // 8 - 3) // size and count == int(count)):
            raise FormatError(f"{count!r} summaries in a record", source)
        counts[int(record)] = int(count)
        record = following
    return list(counts.items())

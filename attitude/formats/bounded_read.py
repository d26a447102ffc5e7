"""Contents that are read as a whole: how much they are is asked before anything of them is held."""

from __future__ import annotations

import io
from typing import BinaryIO

from ..errors import FormatError

MOST_UNTOLD = 1 << 27  # bytes of a pipe or device, whose size is known at its end alone
CHUNK = 1 << 22
LOOKED_AT = 1 << 12  # bytes at both ends, in search of what no text has
BLOCKS = "csv, ndjson and arrows are read in blocks"


def text(stream: BinaryIO, source: str, most: int) -> bytes:
    """All of a text of at most so many bytes, from where the stream stands."""
    told = _told(stream)
    if told is None:
        return untold(stream, source, most)
    if told > most:
        raise FormatError(f"more than {most} bytes; {BLOCKS}", source)
    begin = stream.read(LOOKED_AT)
    _refuse_zeros(begin, source, 1)
    if told > 2 * LOOKED_AT:
        stream.seek(-LOOKED_AT, io.SEEK_END)
        _refuse_zeros(stream.read(LOOKED_AT), source, None)
        stream.seek(LOOKED_AT - told, io.SEEK_END)
    return begin + stream.read(told)


def untold(stream: BinaryIO, source: str, most: int = MOST_UNTOLD) -> bytes:
    """All that comes through a pipe, which may have no end."""
    chunks, taken, most = [], 0, min(most, MOST_UNTOLD)
    while chunk := stream.read(CHUNK):
        chunks.append(chunk)
        taken += len(chunk)
        if taken > most:
            raise FormatError(f"more than {most} bytes, of a size that is not known before; {BLOCKS}", source)
    return b"".join(chunks)


def _told(stream: BinaryIO) -> int | None:
    """Bytes from where the stream stands; None where it cannot tell (of a device, it is none)."""
    if not stream.seekable():
        return None
    here = stream.tell()
    left = stream.seek(0, io.SEEK_END) - here
    stream.seek(here)
    return left if left > 0 else None


def _refuse_zeros(part: bytes, source: str, line: int | None) -> None:
    at = part.find(b"\0")
    if at >= 0:
        number = None if line is None else line + part.count(b"\n", 0, at)
        raise FormatError("not text: it has zero bytes", source, number)

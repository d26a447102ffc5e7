"""Sinks and checks of binary formats: written without seeking, read without trust in stated sizes."""

from __future__ import annotations

import io
from itertools import groupby
from typing import Any, BinaryIO

from ..errors import FormatError
from . import bounded_read

MAX_INFLATED_BYTES = 1 << 30  # that any file may unpack to; a larger file, to 100 times its size


class Sink:
    """A file object for libraries to write to; `take` returns what they wrote and drops it."""

    closed = False

    def __init__(self) -> None:
        self._written: list[Any] = []
        self._count = 0

    def write(self, data: Any) -> int:
        """Write bytes to the blocks that are taken next."""
        size = memoryview(data).nbytes
        self._written.append(data)
        self._count += size
        return size

    def tell(self) -> int:
        """Bytes written so far."""
        return self._count

    def flush(self) -> None:
        """Nothing: blocks are taken by the writer."""

    def close(self) -> None:
        """Nothing: the blocks are the file."""
        self.closed = True

    def take(self) -> list[Any]:
        """What was written since the last call: joined bytes, and views of long pieces."""
        written, self._written = self._written, []
        pieces: list[Any] = []
        for is_long, group in groupby(written, lambda data: memoryview(data).nbytes >= 1 << 16):
            if is_long:
                pieces.extend(map(memoryview, group))
            else:
                pieces.append(b"".join(group))
        return pieces


def seekable(stream: BinaryIO, source: str) -> BinaryIO:
    """The stream itself, or the contents of a pipe in memory."""
    return stream if stream.seekable() else io.BytesIO(bounded_read.from_pipe(stream, source))


def refuse_inflated(stated: int, stream: BinaryIO, source: str) -> None:
    """Raises FormatError where the stated unpacked size is out of proportion to the file's.

    The stream is at its beginning afterwards.
    """
    size = stream.seek(0, io.SEEK_END)
    stream.seek(0)
    limit = max(MAX_INFLATED_BYTES, 100 * size)
    if stated > limit:
        raise FormatError(f"states {stated} bytes of data, and a file of its size may have {limit}", source)


def refuse_trailing(stream: BinaryIO, source: str) -> None:
    """Raises FormatError where bytes follow the end of the data (unless in a pipe, which may block)."""
    if stream.seekable() and stream.read(1):
        raise FormatError("data after its end", source)

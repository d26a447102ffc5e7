"""What formats of bytes have in common: written without seeking, read without trust in the sizes told."""

from __future__ import annotations

import io
from itertools import groupby
from typing import Any, BinaryIO

from ..errors import FormatError
from . import bounded_read

# A file may tell of more bytes than it has (packed ones): of so many more, or of so many in all.
MOST_TIMES = 100
ALWAYS = 1 << 30
LONG = 1 << 16  # bytes; shorter pieces are handed out together


class Sink:
    """A file for libraries to write to, that hands out what they wrote and keeps none of it."""

    closed = False

    def __init__(self) -> None:
        self._written: list[Any] = []
        self._count = 0

    def write(self, data: Any) -> int:
        size = memoryview(data).nbytes
        self._written.append(data)
        self._count += size
        return size

    def tell(self) -> int:
        return self._count

    def flush(self) -> None:
        pass

    def close(self) -> None:
        self.closed = True

    def take(self) -> list[Any]:
        """What was written since it was last asked: bytes, or where it is long a view of the library's."""
        written, self._written = self._written, []
        pieces: list[Any] = []
        for is_long, some in groupby(written, lambda data: memoryview(data).nbytes >= LONG):
            if is_long:
                pieces.extend(map(memoryview, some))
            else:
                pieces.append(b"".join(some))
        return pieces


def seekable(stream: BinaryIO, source: str) -> BinaryIO:
    """The same bytes, in memory if they come through a pipe."""
    return stream if stream.seekable() else io.BytesIO(bounded_read.untold(stream, source))


def size(stream: BinaryIO) -> int:
    """Bytes in all; the stream is at its beginning afterwards."""
    end = stream.seek(0, io.SEEK_END)
    stream.seek(0)
    return end


def refuse_inflated(told: int, stream: BinaryIO, source: str) -> None:
    """Refuses to unpack so many bytes from so small a file: no attitudes repeat themselves like that."""
    most = max(ALWAYS, MOST_TIMES * size(stream))
    if told > most:
        raise FormatError(f"tells of {told} bytes, more than the {most} that a file of its size may", source)


def refuse_rest(stream: BinaryIO, source: str) -> None:
    """Refuses a file that goes on where it should end; of a pipe nobody knows whether more will come."""
    if stream.seekable() and stream.read(1):
        raise FormatError("something after its end", source)


def told_by(error: Exception) -> str:
    """What a library says of a file it cannot read, in one line."""
    return " ".join(str(error).split())[:200] or type(error).__name__

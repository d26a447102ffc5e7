"""Text of any size read in blocks of whole lines, with line numbers.

Lines end with a line feed, a carriage return, or both in either order (CCSDS 504.0-B-2, 6.6.6); a byte order
mark of UTF-8 is skipped.
"""

from __future__ import annotations

import re
from codecs import BOM_UTF8
from collections.abc import Iterator
from functools import cached_property
from typing import BinaryIO

from ..errors import FormatError
from .bounded_read import with_line_feeds

BLOCK_BYTES = 1 << 22
MAX_LINE_BYTES = 1 << 20  # no format has longer lines, and a file of zeros is one line


class LineBlock:
    """Consecutive whole lines of a text.

    Attributes
    ----------
    number : int, of the first line
    text : bytes, the lines with their line ends
    size : int, of the text
    """

    def __init__(self, number: int, text: bytes):
        self.number = number
        self.text = text
        self.size = len(text)
        self._counted = 0, number  # an offset, and the number of the line that begins there

    @property
    def count(self) -> int:
        """The number of lines."""
        return self.number_at(self.size) - self.number

    @cached_property
    def lines(self) -> list[bytes]:
        """The lines without their line ends."""
        lines = self.text[:-1].split(b"\n")
        return [line.removesuffix(b"\r") for line in lines] if b"\r" in self.text else lines

    def line(self, offset: int) -> tuple[bytes, int]:
        """The line that begins at this offset, without its line end, and the offset of the next one."""
        end = self.text.index(b"\n", offset)
        return self.text[offset:end].removesuffix(b"\r"), end + 1

    def find(self, word: bytes, offset: int) -> int:
        """Offset of the first line from an offset on that is this word alone; the size if there is none."""
        while (match := self.text.find(word, offset)) >= 0:
            begin = self.text.rfind(b"\n", offset, match) + 1 or offset
            line, offset = self.line(begin)
            if line.split() == [word]:
                return begin
        return self.size

    def number_at(self, offset: int) -> int:
        """The number of the line that begins at this offset; counting continues from the last call."""
        start, number = self._counted
        if offset < start:
            start, number = 0, self.number
        number += self.text.count(b"\n", start, offset)
        self._counted = offset, number
        return number


def blocks(stream: BinaryIO, source: str, last_line: bytes | None = None) -> Iterator[LineBlock]:
    """Blocks of whole lines.

    last_line : form of what ends a file, so that it is complete without a line end after it

    Raises FormatError for another last line without a line end (the file may be truncated), a line of more
    than 1 MiB, and a block of nearly empty lines.
    """
    number, rest, mark = 1, b"", BOM_UTF8
    while chunk := stream.read(BLOCK_BYTES):
        chunk, mark = chunk.removeprefix(mark), b""
        if chunk.count(b"\r") != chunk.count(b"\r\n"):  # a line end may go on in the next chunk
            while chunk.endswith((b"\r", b"\n")) and (more := stream.read(1)):
                chunk += more
            chunk = with_line_feeds(chunk)
        end = chunk.rfind(b"\n") + 1
        block = LineBlock(number, b"".join([rest, memoryview(chunk)[:end]]) if end else b"")
        rest = chunk[end:] if end else rest + chunk
        if len(rest) > MAX_LINE_BYTES:
            raise FormatError(f"a line of more than {MAX_LINE_BYTES} bytes", source, number + block.count)
        if end:
            if block.count > max(1 << 16, len(chunk) // 8):  # a row of five numbers takes ten bytes
                raise FormatError("nearly empty lines, one after another", source, number)
            yield block
            number = block.number_at(block.size)
    if rest and last_line is not None and re.fullmatch(last_line, rest):
        yield LineBlock(number, rest + b"\n")
    elif rest:
        raise FormatError("ends in the middle of a line", source, number)

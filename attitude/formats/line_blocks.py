"""Text read line by line in blocks, however large the file; every line knows its number."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import BinaryIO

from ..errors import FormatError

BLOCK = 1 << 22  # bytes
LONGEST = 1 << 20  # bytes of a line: no format has longer ones, and a file of zeros is one line
FEW = 1 << 16  # lines
SHORTEST = 8  # bytes of a line on average in a full block: five numbers and what is between them take ten


class Block:
    """Whole lines.

    Attributes
    ----------
    number : int, of the first line
    text : bytes, the lines with their ends
    size : int, of the text
    """

    def __init__(self, number: int, text: bytes):
        self.number = number
        self.text = text
        self.size = len(text)
        self._known = 0, number  # a place, and the number of the line that begins there

    @property
    def count(self) -> int:
        return self.number_at(self.size) - self.number

    @cached_property
    def lines(self) -> list[bytes]:
        """Without their ends."""
        lines = self.text[:-1].split(b"\n")
        return [line.removesuffix(b"\r") for line in lines] if b"\r" in self.text else lines

    def line(self, place: int) -> tuple[bytes, int]:
        """The one that begins there, without its end, and where the next one does."""
        end = self.text.index(b"\n", place)
        return self.text[place:end].removesuffix(b"\r"), end + 1

    def number_at(self, place: int) -> int:
        """Of the line that begins there; counted on from where it was last asked."""
        known, number = self._known
        if place < known:
            known, number = 0, self.number
        number += self.text.count(b"\n", known, place)
        self._known = place, number
        return number


def blocks(stream: BinaryIO, source: str) -> Iterator[Block]:
    """Refuses a line without an end, at the end of the file too: what was cut off there nobody knows."""
    number, rest = 1, b""
    while chunk := stream.read(BLOCK):
        cut = chunk.rfind(b"\n") + 1
        block = Block(number, b"".join([rest, memoryview(chunk)[:cut]]) if cut else b"")
        rest = chunk[cut:] if cut else rest + chunk
        if len(rest) > LONGEST:
            raise FormatError(f"a line of more than {LONGEST} bytes", source, number + block.count)
        if cut:
            if block.count > max(FEW, len(chunk) // SHORTEST):
                raise FormatError("lines with hardly anything in them, one after another", source, number)
            yield block
            number = block.number_at(block.size)
    if rest:
        raise FormatError("ends in the middle of a line", source, number)

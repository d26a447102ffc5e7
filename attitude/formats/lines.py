"""Text read line by line in blocks, however large the file; every line knows its number."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import BinaryIO

import numpy as np

from ..errors import FormatError
from .rows import MARGIN, line_ends

BLOCK = 1 << 22  # bytes
LONGEST = 1 << 20  # bytes of a line: no format has longer ones, and a file of zeros is one line


class Block:
    """Whole lines.

    Attributes
    ----------
    number : int, of the first line
    text : bytes, the lines with their ends, then MARGIN zeros
    size : int, of the text without these
    """

    def __init__(self, number: int, pieces: list[bytes | memoryview]):
        self.number = number
        self.text = b"".join([*pieces, bytes(MARGIN)])
        self.size = len(self.text) - MARGIN

    @cached_property
    def count(self) -> int:
        return line_ends(self.text, 0, self.size)

    @cached_property
    def lines(self) -> list[bytes]:
        """Without their ends."""
        lines = self.text[: self.size - 1].split(b"\n")
        return [line.removesuffix(b"\r") for line in lines] if b"\r" in self.text else lines

    def line(self, place: int) -> tuple[bytes, int]:
        """The one that begins there, without its end, and where the next one does."""
        end = self.text.index(b"\n", place)
        return self.text[place:end].removesuffix(b"\r"), end + 1

    def number_at(self, place: int) -> int:
        """Of the line that begins there."""
        return self.number + (self.count if place == self.size else line_ends(self.text, 0, place))

    def numbers(self, first: int, end: int) -> np.ndarray:
        """(n,): of the lines from one place to another that are not empty."""
        number, count = self.number_at(first), line_ends(self.text, first, end)
        found = number + np.arange(count)
        lines = self.text[first : end - 1].split(b"\n") if count else []
        return found[[bool(line.strip()) for line in lines]] if count else found


def blocks(stream: BinaryIO, source: str) -> Iterator[Block]:
    """Refuses a line without an end, at the end of the file too: what was cut off there nobody knows."""
    number, rest = 1, b""
    while chunk := stream.read(BLOCK):
        cut = chunk.rfind(b"\n") + 1
        if cut:
            block = Block(number, [rest, memoryview(chunk)[:cut]])
            rest = chunk[cut:]
        else:
            rest += chunk
        count = block.count if cut else 0
        if len(rest) > LONGEST:
            raise FormatError(f"a line of more than {LONGEST} bytes", source, number + count)
        if cut:
            yield block
            number += count
    if rest:
        raise FormatError("ends in the middle of a line", source, number)

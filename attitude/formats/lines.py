"""Text read line by line in blocks, however large the file; every line knows its number."""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO, NamedTuple

from ..errors import FormatError

BLOCK = 1 << 22  # bytes
LONGEST = 1 << 20  # bytes of a line: no format has longer ones, and a file of zeros is one line
FEW = 1 << 16  # lines
SHORTEST = 8  # bytes of a line on average in a full block: five numbers and what is between them take ten


class Block(NamedTuple):
    """Whole lines, without their ends; the first has this number."""

    number: int
    lines: list[bytes]


def blocks(stream: BinaryIO, source: str) -> Iterator[Block]:
    """Refuses a line without an end, at the end of the file too: what was cut off there nobody knows."""
    number, rest = 1, b""
    while chunk := stream.read(BLOCK):
        *lines, rest = (rest + chunk).split(b"\n")
        if len(rest) > LONGEST:
            raise FormatError(f"a line of more than {LONGEST} bytes", source, number + len(lines))
        if len(lines) > max(FEW, len(chunk) // SHORTEST):
            raise FormatError("lines with hardly anything in them, one after another", source, number)
        if lines:
            yield Block(number, [line.removesuffix(b"\r") for line in lines] if b"\r" in chunk else lines)
            number += len(lines)
    if rest:
        raise FormatError("ends in the middle of a line", source, number)

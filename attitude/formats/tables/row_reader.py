"""Text of metadata and rows, a line each, read in blocks of lines into columns of numbers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, BinaryIO

import numpy as np

from ...errors import FormatError
from ...samples.ephemeris_data import EphemerisData
from .. import line_blocks, schema
from ..text_reader import TextReader


class RowReader(TextReader, ABC):
    """Reads the lines before the first row, then rows; a format says what its lines are.

    Attributes
    ----------
    meta : metadata, once they were read
    names : of the columns; empty before they are known
    first_line : of the rows
    """

    def __init__(self, source: str):
        super().__init__(source)
        self.meta: Any = None
        self.names: list[str] = []
        self.first_line = self.stated_count = self.count = 0
        self.numbers: list[np.ndarray] = []

    @abstractmethod
    def is_header(self, line: bytes, number: int) -> bool:
        """Read a line before the first row; False for the first row itself, which must know `names`."""

    @abstractmethod
    def columns(self, text: bytes, number: int) -> np.ndarray:
        """(c, n) numbers of rows, the first at this line; FormatError for one that is none."""

    def end_of_metadata(self, meta: Any, first_line: int, line: int | None = None) -> None:
        """Take the metadata; FormatError, of their line, unless they state a list of instants."""
        self.meta, self.first_line = meta, first_line
        self.stated_count = schema.stated_count(meta, self.source, line)

    def no_rows(self) -> FormatError:
        """The error of a file that ends before its first row."""
        return self.error("no instants", self.first_line or None)

    def read(self, stream: BinaryIO) -> EphemerisData:
        """The ephemeris in a stream; FormatError, with its place, for anything else."""
        for block in line_blocks.blocks(stream, self.source):
            offset, number = 0, block.number
            while offset < block.size and not self.numbers:
                line, following = block.line(offset)
                if not self.is_header(line, number):
                    break
                offset, number = following, number + 1
            if offset < block.size:
                self.numbers.append(self.columns(block.text[offset:], number))
                self.count += self.numbers[-1].shape[1]
                last_line = self.first_line + self.stated_count
                schema.refuse_more(self.count, self.stated_count, self.source, last_line)
        if not self.numbers:
            raise self.no_rows()
        names = [name for name in self.names if name != schema.TIME]
        table = dict(zip(names, np.concatenate(self.numbers, axis=1), strict=True))
        return schema.ephemeris_from(self.meta, table, self.source, self.first_line)

"""A table in CSV whose columns are found by their names; lines that begin with # are comments."""

from __future__ import annotations

import csv
from typing import BinaryIO, Self

import numpy as np

from .. import bounded_read
from ..text_reader import TextReader, finite_number


class TextTable(TextReader):
    """Columns of text by their names.

    Attributes
    ----------
    names : of the columns, in lower case; rows : their text; numbers : of the rows' lines, from 1
    lines : all of the file
    """

    def __init__(self, lines: list[str], source: str):
        super().__init__(source)
        self.lines = lines
        numbered = [(i, line) for i, line in enumerate(lines, start=1) if line.strip() and line[0] != "#"]
        if len(numbered) < 2:
            raise self.error("no rows")
        self.names = [name.strip().lower() for name in next(csv.reader([numbered[0][1]]))]
        self.rows = list(csv.reader([line for _, line in numbered[1:]]))
        self.numbers = [i for i, _ in numbered[1:]]
        if len(self.rows) != len(self.numbers):
            raise self.error("quoted text that goes on over a line")
        for row, number in zip(self.rows, self.numbers, strict=True):
            if len(row) != len(self.names):
                raise self.error(f"{len(row)} values where {len(self.names)} belong", number)
        if len(set(self.names)) < len(self.names):
            raise self.error("a column name twice")

    @classmethod
    def read(cls, stream: BinaryIO, source: str) -> Self:
        """The table in a stream; FormatError with the line of what is wrong."""
        content = bounded_read.text(stream, source, bounded_read.MAX_MESSAGE_BYTES)
        return cls(content.decode("utf-8", errors="replace").splitlines(), source)

    def column(self, index: int) -> np.ndarray:
        """(n,) finite numbers."""
        values = np.empty(len(self.rows))
        for k, row in enumerate(self.rows):
            values[k] = finite_number(row[index].strip())
            if np.isnan(values[k]):
                reason = f"{self.names[index]} is {row[index][:40]!r}, not a finite number"
                raise self.error(reason, self.numbers[k])
        return values

"""What readers of text share: errors that name the file and the line, and numbers of words."""

from __future__ import annotations

import re
from math import inf, isfinite, isnan, nan
from typing import Any

from ..errors import FormatError, InputError

MAX_REMARKS = 100_000  # comments and empty lines, in which a file without an end may go on


class TextReader:
    """A reader of one file.

    source : the file's name in errors
    """

    def __init__(self, source: str):
        self.source = source
        self.remark_count = 0

    def add_remarks(self, line: int, count: int = 1, rows: int = 0) -> None:
        """Count comments and empty lines; FormatError for more than MAX_REMARKS, or than the rows so far."""
        self.remark_count += count
        if self.remark_count > max(MAX_REMARKS, rows):
            raise self.error(f"more than {MAX_REMARKS} comments and empty lines", line)

    def finite(self, word: str, line: int) -> float:
        """The number that a word is; FormatError for any other word."""
        value = finite_number(word)
        if isnan(value):
            raise self.error(f"{word[:40]!r} is no finite number", line)
        return value

    def error(self, reason: str, line: int | None = None) -> FormatError:
        """FormatError that names the file, and the line if one is given."""
        return FormatError(reason, self.source, line)


def finite_number(word: str) -> float:
    """The decimal number that a word is; NaN for any other word, and for a number beyond a double."""
    is_number = re.fullmatch(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", word, re.ASCII)
    value = float(word) if is_number else inf
    return value if isfinite(value) else nan


def check_number(value: Any, name: str, default: str) -> None:
    """InputError unless this option of a reader is None or a whole number from 1."""
    if value is not None and (isinstance(value, bool) or not isinstance(value, int) or value < 1):
        raise InputError(name, value, f"a whole number, 1 for the first, or None for {default}")

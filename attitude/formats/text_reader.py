"""What readers of text share: errors that name the file and the line, and numbers of words."""

from __future__ import annotations

import re
from math import inf, isfinite, nan

from ..errors import FormatError

NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)


class TextReader:
    """A reader of one file.

    source : the file's name in errors
    """

    def __init__(self, source: str):
        self.source = source

    def error(self, reason: str, line: int | None = None) -> FormatError:
        """FormatError that names the file, and the line if one is given."""
        return FormatError(reason, self.source, line)


def finite_number(word: str) -> float:
    """The decimal number that a word is; NaN for any other word, and for a number beyond a double."""
    value = float(word) if NUMBER.fullmatch(word) else inf
    return value if isfinite(value) else nan

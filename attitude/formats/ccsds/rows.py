"""Lines of attitudes, EPOCH and numbers between blanks: to integers and doubles, in blocks."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np

from .epochs import EPOCH, EpochError, Stamps, each

NUMBER = re.compile(rb"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")


class RowError(ValueError):
    """What is wrong with the row at `index`."""

    def __init__(self, index: int, reason: str):
        self.index = index
        self.reason = reason
        super().__init__(reason)


class Rows(NamedTuple):
    """stamps of the epochs, and (columns, n) doubles."""

    stamps: Stamps
    numbers: np.ndarray


def careful(rows: list[bytes], columns: tuple[str, ...], system: str) -> Rows:
    """Any rows; RowError for the first that is none."""
    texts, numbers = [], np.empty((len(columns), len(rows)))
    for i, row in enumerate(rows):
        epoch, *words = row.split()
        texts.append(epoch)
        if len(words) != len(columns):
            _refuse_count(i, epoch, len(words), columns)
        numbers[:, i] = [_number(word, name, i) for word, name in zip(words, columns, strict=True)]
    return Rows(stamps(texts, system), numbers)


def stamps(texts: Any, system: str) -> Stamps:
    """Of a list of texts, or an Arrow array of them; RowError for the first that is no epoch."""
    try:
        return each(texts, system)
    except EpochError as error:
        raise RowError(error.index, error.reason) from None


def _refuse_count(index: int, epoch: bytes, count: int, columns: tuple[str, ...]) -> None:
    if EPOCH.fullmatch(epoch) is None:
        raise RowError(
            index, f"{epoch[:40].decode('ascii', 'replace')!r} where an epoch or DATA_STOP belongs"
        )
    missing = f", no {columns[count]}" if count < len(columns) else ""
    raise RowError(index, f"{count} numbers where {' '.join(columns)} belong{missing}")


def _number(word: bytes, name: str, index: int) -> float:
    value = float(word) if NUMBER.fullmatch(word) else np.nan
    if not np.isfinite(value):
        raise RowError(index, f"{name} is {word[:40].decode('ascii', 'replace')!r}, not a finite number")
    return value

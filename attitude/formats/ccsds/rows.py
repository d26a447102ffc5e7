"""Rows of an AEM, epoch and numbers between blanks, parsed one by one to name what is wrong with a row."""

from __future__ import annotations

import re

import numpy as np

from .epochs import EPOCH, RowError, Timestamps, parse_epochs

NUMBER = re.compile(rb"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")


def parse_rows(rows: list[bytes], columns: tuple[str, ...], system: str) -> tuple[Timestamps, np.ndarray]:
    """Timestamps and (columns, n) doubles; RowError for the first row that is invalid."""
    texts, numbers = [], np.empty((len(columns), len(rows)))
    for i, row in enumerate(rows):
        epoch, *words = row.split()
        texts.append(epoch)
        if len(words) != len(columns):
            _refuse_count(i, epoch, len(words), columns)
        for j, (word, name) in enumerate(zip(words, columns, strict=True)):
            value = float(word) if NUMBER.fullmatch(word) else np.nan
            if not np.isfinite(value):
                raise RowError(i, f"{name} is {_shown(word)}, not a finite number")
            numbers[j, i] = value
    return parse_epochs(texts, system), numbers


def _refuse_count(index: int, epoch: bytes, count: int, columns: tuple[str, ...]) -> None:
    if EPOCH.fullmatch(epoch) is None:
        raise RowError(index, f"{_shown(epoch)} where an epoch or DATA_STOP belongs")
    missing = f", no {columns[count]}" if count < len(columns) else ""
    raise RowError(index, f"{count} numbers where {' '.join(columns)} belong{missing}")


def _shown(word: bytes) -> str:
    return repr(word[:40].decode("ascii", "replace"))

"""Lines of attitudes, EPOCH and numbers between blanks: to integers and doubles, in blocks."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
import orjson

from . import aem_epochs
from .aem_epochs import EpochError, Stamps

NUMBER = re.compile(rb"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
PLAIN = b"0123456789+-.eE \n"


class RowError(ValueError):
    """What is wrong with the row at `index`."""

    def __init__(self, index: int, reason: str):
        self.index = index
        self.reason = reason
        super().__init__(reason)


class Rows(NamedTuple):
    """stamps of the epochs, and (n, columns) doubles."""

    stamps: Stamps
    numbers: np.ndarray


def plain(rows: list[bytes], columns: tuple[str, ...], system: str) -> Rows | None:
    """Rows with one blank between the values, and numbers as JSON has them; None for any other."""
    try:
        stamps, texts = _plain_epochs(rows, system)
    except EpochError:
        return None
    if stamps is None:
        return None
    numbers = _plain_numbers(texts, len(columns))
    return None if numbers is None else Rows(stamps, numbers)


def _plain_epochs(rows: list[bytes], system: str) -> tuple[Stamps | None, list[bytes]]:
    """The epochs, and the rest of each row."""
    width = rows[0].find(b" ") + 1
    heads = np.frombuffer(b"".join([row[:width] for row in rows]), dtype=np.uint8)
    if width > 0 and len(heads) == width * len(rows):
        heads = heads.reshape(-1, width)
        if (heads[:, -1] == ord(" ")).all():
            stamps = aem_epochs.alike(heads[:, :-1], system)
            if stamps is not None:
                return stamps, [row[width:] for row in rows]
    parts = [row.partition(b" ") for row in rows]
    if not all(blank for _, blank, _ in parts):
        return None, []
    return aem_epochs.each([epoch for epoch, _, _ in parts], system), [text for _, _, text in parts]


def _plain_numbers(texts: list[bytes], width: int) -> np.ndarray | None:
    """(n, width); one list of all numbers is read in half of the time of a list of rows."""
    text = b"\n".join(texts)
    if text.translate(None, PLAIN) or {row.count(b" ") for row in texts} != {width - 1}:
        return None
    try:
        values = orjson.loads(b"[" + text.replace(b"\n", b",").replace(b" ", b",") + b"]")
    except orjson.JSONDecodeError:
        return None
    if len(values) != len(texts) * width:  # a line break within a row
        return None
    return np.fromiter(values, np.float64, len(values)).reshape(-1, width)


def careful(rows: list[bytes], columns: tuple[str, ...], system: str) -> Rows:
    """Any rows; RowError for the first that is none."""
    epochs, numbers = [], np.empty((len(rows), len(columns)))
    for i, row in enumerate(rows):
        epoch, *words = row.split()
        epochs.append(epoch)
        if len(words) != len(columns):
            _refuse_count(i, epoch, len(words), columns)
        numbers[i] = [_number(word, name, i) for word, name in zip(words, columns, strict=True)]
    try:
        return Rows(aem_epochs.each(epochs, system), numbers)
    except EpochError as error:
        raise RowError(error.index, error.reason) from None


def _refuse_count(index: int, epoch: bytes, count: int, columns: tuple[str, ...]) -> None:
    if aem_epochs.EPOCH.fullmatch(epoch) is None:
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

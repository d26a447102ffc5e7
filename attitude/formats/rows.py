"""Rows of numbers as text, and back: the kernels that do it, shared among threads."""

from __future__ import annotations

import os
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .. import memory
from ..errors import FormatError
from ..kernels.layout import LEAD_DATE as DATE
from ..kernels.layout import LEAD_NOTHING as NOTHING
from ..kernels.layout import LEAD_WORD as WORD
from ..kernels.layout import TEXT_MARGIN as MARGIN
from ..kernels.layout import WIDEST_NUMBER
from ..runtime import compiled, threads

__all__ = ["DATE", "MARGIN", "NOTHING", "WORD", "Form", "Part", "line_ends", "read", "texts"]

WORTH_SHARING = 4096  # rows to a thread; with fewer it begins too late
WORTH_BYTES = 1 << 18
MOST_THREADS = 4
MOST_ODD = 1024  # lines at a time
FIRST_SPAN = 1 << 12  # bytes


def cores() -> int:
    available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(available, MOST_THREADS)


def texts(columns: np.ndarray, pieces: list[bytes], leads: np.ndarray | None = None) -> list[bytes]:
    """The rows, in order, as a text or several.

    columns : (c, n) finite doubles, written with the fewest digits that read back to the same bits, with a
        decimal point and a digit on either side of it; FormatError for one that is not finite
    pieces : c + 2, what stands around and between the lead and the numbers
    leads : (n,) bytes of one width, or None for no lead
    """
    count = columns.shape[1]
    shares = threads.cut(count, min(cores(), max(1, count // WORTH_SHARING)))
    found: dict[int, bytes] = {}
    width = 0 if leads is None else leads.dtype.itemsize
    lead = np.zeros(0, dtype=np.uint8) if leads is None else np.ascontiguousarray(leads).view(np.uint8)
    between = np.frombuffer(b"".join(pieces), dtype=np.uint8)
    ends = np.cumsum([len(piece) for piece in pieces])
    most = width + len(columns) * WIDEST_NUMBER + len(between)
    numbers = np.ascontiguousarray(columns)

    def write(share: tuple[int, int]) -> None:
        first, last = share
        room = ((last - first) * most + MARGIN) // 8 + 1
        text, size = memory.empty((room,)).view(np.uint8), np.zeros(1, dtype=np.int64)
        compiled.put_rows(lead.reshape(-1), width, numbers, first, last, between, ends, text, size)
        if size[0] < 0:
            raise FormatError(f"a number that is not finite, in row {-1 - int(size[0])}, is not written")
        found[first] = text[: size[0]].tobytes()

    threads.run(write, shares)
    return [found[first] for first, _ in shares]


class Part(NamedTuple):
    """Rows read from a text.

    first, stop : where in the text they were looked for
    end : where the first line begins that is not a plain row; `stop` where all are
    second, atto : (n,) integers of dates, as aem_epochs.Stamps
    columns : (c, n)
    """

    first: int
    stop: int
    end: int
    second: np.ndarray
    atto: np.ndarray
    columns: np.ndarray


class Form(NamedTuple):
    """Of rows to be read.

    width : numbers in a row
    lead : NOTHING, a DATE (with a Z where `zulu`), or a WORD that is passed over
    separator : between values; a blank stands for any blanks and tabs, which are then passed over in front
        of rows and behind them, as empty lines are
    """

    width: int
    lead: int = NOTHING
    separator: bytes = b" "
    zulu: bool = False


# Of lines that are not plain rows: from a place on, before another, so many at most; where it stopped, and
# whether rows may follow.
Odd = Callable[[int, int, int], tuple[int, bool]]


def read(text: bytes, first: int, stop: int, form: Form, take: Callable[[Part], None], odd: Odd) -> int:
    """Rows in whole lines from `first` on; where they end, at `stop` at the latest.

    text : with MARGIN bytes more
    take : is given the rows in order, part by part
    odd : is given what is not a plain row of this form
    """
    for part in _plain(text, _shares(text, first, stop), form):
        at, goes_on = _past_odd(text, _taken(part, take), part.stop, form, take, odd)
        if not goes_on:
            return at
    return stop


def _past_odd(
    text: bytes, at: int, stop: int, form: Form, take: Callable[[Part], None], odd: Odd
) -> tuple[int, bool]:
    """Past lines that are not plain, the more at once the more there are, and the rows that follow."""
    most = 1
    while at < stop:
        at, goes_on = odd(at, stop, most)
        if not goes_on or at == stop:
            return at, goes_on
        before, at = at, _plain_from(text, at, stop, form, take)
        most = 1 if at > before else min(2 * most, MOST_ODD)
    return at, True


def _plain_from(text: bytes, at: int, stop: int, form: Form, take: Callable[[Part], None]) -> int:
    """Past the plain rows from there on: looked for in spans that grow, for there may be few."""
    span = FIRST_SPAN
    while at < stop:
        until = text.find(b"\n", at + span, stop) + 1 or stop
        (part,) = _plain(text, [(at, until)], form)
        at, span = _taken(part, take), 4 * span
        if at < until:
            break
    return at


def _taken(part: Part, take: Callable[[Part], None]) -> int:
    if part.columns.shape[1]:
        take(part)
    return part.end


def _plain(text: bytes, shares: list[tuple[int, int]], form: Form) -> list[Part]:
    """As many rows of each share as are plain."""
    characters = np.frombuffer(text, dtype=np.uint8)
    parts: dict[int, Part] = {}

    def take(share: tuple[int, int]) -> None:
        begin, until = share
        room = line_ends(text, begin, until)
        second, atto = np.empty(room, dtype=np.int64), np.empty(room, dtype=np.int64)
        columns, found = np.empty((form.width, room)), np.zeros(2, dtype=np.int64)
        how = form.lead, int(form.zulu), form.separator[0]
        compiled.take_rows(characters, begin, until, *how, second, atto, columns, found)
        count, end = found.tolist()
        parts[begin] = Part(begin, until, end, second[:count], atto[:count], columns[:, :count])

    threads.run(take, shares)
    return [parts[begin] for begin, _ in shares]


def line_ends(text: bytes, first: int, stop: int) -> int:
    """How many there are from one place to another; in a tenth of the time that bytes.count takes."""
    found = np.zeros(1, dtype=np.int64)
    compiled.count_lines(np.frombuffer(text, dtype=np.uint8), first, stop, found)
    return int(found[0])


def _shares(text: bytes, first: int, stop: int) -> list[tuple[int, int]]:
    """Cut at the ends of lines."""
    edges = [first]
    for _, last in threads.cut(stop - first, min(cores(), max(1, (stop - first) // WORTH_BYTES))):
        edge = text.find(b"\n", first + last - 1, stop) + 1
        if edge > edges[-1]:
            edges.append(edge)
    return list(pairwise(edges))

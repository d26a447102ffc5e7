"""Arrays for answers, in memory that earlier answers were in.

Memory fresh from the system is cleared page by page, which takes longer than computing what goes into
it (docs/performance.md).  So what a dropped answer was in is kept, up to a limit, for the next one.

An answer may be dropped anywhere: by another thread, or by the garbage collector while this very code
runs.  So nobody waits for the lock: who finds it taken does without what is kept.
"""

from __future__ import annotations

from contextlib import suppress
from math import prod
from threading import Lock
from typing import Any

import numpy as np

SMALLEST = 2**15  # doubles; for less the system's own allocator keeps memory
LIMIT = 2**25  # doubles kept in all, 256 MiB: attitudes and rates of four million instants
SPARE = 1.25  # memory up to this much larger than asked for is taken

_kept: list[np.ndarray] = []  # oldest first; touched by who holds the lock
_lock = Lock()


class _Block:
    """What an array and all views of it stand on; when the last of them is gone, its memory is kept."""

    def __init__(self, memory: np.ndarray):
        self.memory = memory
        self.__array_interface__ = memory.__array_interface__

    def __del__(self) -> None:
        with suppress(Exception):  # the interpreter may be ending
            _keep(self.memory)


def empty(shape: tuple[int, ...]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """As numpy's: doubles of any value."""
    count = prod(shape)
    if count < SMALLEST:
        return np.empty(shape)
    memory = _taken(count)
    block = _Block(np.empty(count) if memory is None else memory)
    return np.asarray(block)[:count].reshape(shape)


def _taken(count: int) -> np.ndarray | None:
    if not _lock.acquire(blocking=False):
        return None
    try:
        for place in reversed(range(len(_kept))):  # the last to be dropped is the likeliest in a cache
            if count <= _kept[place].size <= SPARE * count:
                return _kept.pop(place)
        return None
    finally:
        _lock.release()


def _keep(memory: np.ndarray) -> None:
    if memory.size > LIMIT or not _lock.acquire(blocking=False):
        return
    try:
        _kept.append(memory)
        while sum(each.size for each in _kept) > LIMIT:
            del _kept[0]
    finally:
        _lock.release()

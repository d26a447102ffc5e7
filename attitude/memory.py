"""Arrays for answers, in memory that earlier answers were in.

Memory fresh from the system is cleared page by page, which takes longer than computing what goes into
it (docs/performance.md).  So what a dropped answer was in is kept, up to a limit, for the next one.
"""

from __future__ import annotations

from contextlib import suppress
from math import prod
from typing import Any

import numpy as np

SMALLEST = 2**15  # doubles; for less the system's own allocator keeps memory
LIMIT = 2**25  # doubles kept in all, 256 MiB: attitudes and rates of four million instants
SPARE = 1.25  # memory up to this much larger than asked for is taken

_kept: dict[int, np.ndarray] = {}  # by id, oldest first; each operation on a dict is atomic


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
    for key, memory in reversed(list(_kept.items())):  # the last to be dropped is the likeliest in a cache
        if count <= memory.size <= SPARE * count and _kept.pop(key, None) is not None:
            return memory
    return None


def _keep(memory: np.ndarray) -> None:
    if memory.size > LIMIT:
        return
    _kept[id(memory)] = memory
    while sum(each.size for each in list(_kept.values())) > LIMIT:
        _kept.pop(next(iter(_kept)), None)

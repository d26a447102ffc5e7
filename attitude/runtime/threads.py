"""Work in threads, for computations that release the interpreter's lock."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextvars import copy_context
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar

from ..errors import whole_number

Share = TypeVar("Share")

# The processor limit of a container: "quota period", or "max period".
CPU_SHARE = Path("/sys/fs/cgroup/cpu.max")


def check(threads: Any) -> int:
    """The number of threads; InputError unless it is a whole number, at least 1."""
    return whole_number(threads, "threads")


def processors() -> int:
    """The number of processors this process may use, by its affinity and its container's limit."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    try:
        quota, period = CPU_SHARE.read_text().split()
        return max(1, min(count, -(-int(quota) // int(period))))
    except (OSError, ValueError):  # no such file, or no such limit
        return count


def ranges(length: int, parts: int) -> list[tuple[int, int]]:
    """`parts` ranges (first, last), last excluded, of equal length; fewer where the length is less."""
    edges = [length * i // parts for i in range(parts + 1)]
    return [(a, b) for a, b in pairwise(edges) if a < b]


def run(work: Callable[[Share], None], shares: Sequence[Share]) -> None:
    """Runs `work` on each share, in a thread each, the first in this one; raises what any of them raises."""
    if len(shares) < 2:
        for share in shares:
            work(share)
        return
    pool = _pool(len(shares) - 1)
    others = [pool.submit(copy_context().run, work, share) for share in shares[1:]]
    try:
        work(shares[0])
    finally:
        wait(others)
    for other in others:
        other.result()


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    """A pool that stays: to start and end a thread takes as long as a hundred thousand samples."""
    return ThreadPoolExecutor(threads, "attitude")


if hasattr(os, "register_at_fork"):  # a forked child has none of its parent's threads
    os.register_at_fork(after_in_child=_pool.cache_clear)

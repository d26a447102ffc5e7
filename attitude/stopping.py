"""Cancellation of computations from another thread.

    stop = Stop()
    with stoppable(stop):     # in the thread that computes
        scene.run()           # raises Stopped soon after stop.set() is called in any other

Compiled loops whose length depends on input read the flag at every step; loops in Python call `check()`.
The service stops a request at its deadline so (`Job.check_deadline` of service/compute.py).
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

import numpy as np


class Stopped(BaseException):
    """The computation was cancelled.  A BaseException, so that handlers of errors do not catch it."""


class Stop:
    """A request to stop.

    Attributes
    ----------
    flag : (1,) float64, nonzero once it is set; compiled loops read it
    """

    __slots__ = ("flag",)

    def __init__(self) -> None:
        self.flag = np.zeros(1)

    def set(self) -> None:
        """Requests the stop."""
        self.flag[0] = 1.0

    def check(self) -> None:
        """Raises Stopped if it is set."""
        if self.flag[0]:
            raise Stopped


_never = Stop()
_current: ContextVar[Stop] = ContextVar("stop", default=_never)


def current() -> Stop:
    """The Stop of the current computation, or one that is never set."""
    return _current.get()


def check() -> None:
    """Raises Stopped where the current computation is to stop: for loops whose length depends on input."""
    if _current.get().flag[0]:
        raise Stopped


@contextmanager
def checked_calls() -> Iterator[None]:
    """Every call of a Python function in this context does `check`: for code that knows nothing of stops."""
    before, stop = sys.getprofile(), _current.get()
    sys.setprofile(lambda *_: stop.check())
    try:
        yield
    finally:
        sys.setprofile(before)


@contextmanager
def stoppable(stop: Stop) -> Iterator[None]:
    """Computations in this context stop when `stop` is set."""
    token = _current.set(stop)
    try:
        yield
    finally:
        _current.reset(token)

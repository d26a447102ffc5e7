"""Computations that can be stopped, by whoever set them going and from another thread.

    stop = Stop()
    with stoppable(stop):     # in the thread that computes
        scene.run()           # raises Stopped soon after stop.set() is called in any other

Compiled loops that may go on for minutes look at the flag at every step; what computes in pieces calls
`check` between them.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

import numpy as np


class Stopped(BaseException):
    """Not an error: nobody wants the answer any more.  Nothing that handles errors should catch it."""


class Stop:
    """Whether to stop.

    Attributes
    ----------
    flag : (1,) float64, nonzero once it is set: what compiled loops read
    """

    __slots__ = ("flag",)

    def __init__(self) -> None:
        self.flag = np.zeros(1)

    def set(self) -> None:
        self.flag[0] = 1.0

    def check(self) -> None:
        """Raises Stopped where it is set."""
        if self.flag[0]:
            raise Stopped


_never = Stop()
_current: ContextVar[Stop] = ContextVar("stop", default=_never)


def current() -> Stop:
    """That of the computation this is called in; one that is never set where there is none."""
    return _current.get()


@contextmanager
def stoppable(stop: Stop) -> Iterator[None]:
    """What is computed within stops when `stop` is set."""
    token = _current.set(stop)
    try:
        yield
    finally:
        _current.reset(token)

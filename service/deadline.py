"""The deadline of a request: what stops its computation, and what ends a process whose computation goes on.

A request may compute for ATTITUDE_MAX_SECONDS; waiting for a thread does not count.  When they are used up,
`Compute` sets the request's `Stop`, which every loop of the library looks at (attitude/stopping.py).  A
computation that does not stop nevertheless is stuck STUCK_AFTER_S later: /healthz fails then, and a process
that has a supervisor ends and is replaced.
"""

from __future__ import annotations

import asyncio
import faulthandler
import logging
import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter, thread_time

from attitude.errors import InputError
from attitude.stopping import Stop, stoppable

from .settings import variable

log = logging.getLogger(__name__)

# Beyond its deadline: the processor's time that a computation may take to stop; and when it is stuck.
OVERTIME_S, STUCK_AFTER_S = 1, 5
# After SIGTERM: for requests, beside their seconds of computing; then for a computation to stop.
GRACE_S, STOP_WITHIN_S = 1, 0.5
LOOK_EVERY_S = 1.0
STDERR = 2


class Deadline:
    """The seconds of computing of one request, in one piece of work or in many.

    Attributes
    ----------
    max_seconds : of all pieces together
    stop : set where the piece under way is to end now
    """

    def __init__(self, max_seconds: float):
        self.max_seconds = max_seconds
        self.stop = Stop()
        self._before = 0.0
        self._begun: float | None = None  # the piece of work under way

    @contextmanager
    def computing(self) -> Iterator[None]:
        """A piece of work, whose seconds count, and which the stop ends."""
        self._begun, processor_begun = perf_counter(), thread_time()
        allowed = self.max_seconds - self._before + OVERTIME_S
        try:
            with stoppable(self.stop):
                yield
        finally:
            self._before, self._begun = self.spent(), None
            if (seconds := thread_time() - processor_begun) > allowed:
                log.warning("a computation took %.1f s, %.1f s were left to it", seconds, allowed)

    def spent(self) -> float:
        """Seconds of computing, those of the piece under way included."""
        begun = self._begun
        return self._before + (perf_counter() - begun if begun is not None else 0.0)

    def check(self) -> None:
        """Raises InputError where the seconds are used up."""
        if (spent := self.spent()) > self.max_seconds:
            limit = f"a scene that takes at most {self.max_seconds} s to compute ({variable('max_seconds')})"
            raise InputError("times", f"{spent:.3g} s so far", limit)

    def is_stuck(self) -> bool:
        """Whether a computation goes on that should have stopped long ago."""
        return self._begun is not None and self.spent() > self.max_seconds + STUCK_AFTER_S


async def end_stuck_process(is_stuck: Callable[[], bool], max_seconds: float) -> None:
    """End this process where a computation is stuck, if it is one of several: its supervisor starts another.

    What else it has accepted is answered first.  A call that holds the interpreter's lock would hold this
    loop too: against that the timer of `faulthandler`, which needs no lock, ends any process.
    """
    try:
        while not (is_stuck() and multiprocessing.parent_process() is not None):
            faulthandler.dump_traceback_later(max_seconds + STUCK_AFTER_S, exit=True, file=STDERR)
            await asyncio.sleep(LOOK_EVERY_S)
    finally:
        faulthandler.cancel_dump_traceback_later()
    log.critical("a computation does not stop: this process ends, to be replaced")
    signal.raise_signal(signal.SIGTERM)
    await asyncio.sleep(max_seconds + GRACE_S + STOP_WITHIN_S)
    os._exit(1)


async def end_computations(is_computing: Callable[[], bool]) -> None:
    """Wait for computations that are to stop; end the process where one does not.

    The interpreter would wait for its thread for ever.
    """
    for _ in range(10):
        if not is_computing():
            return
        await asyncio.sleep(STOP_WITHIN_S / 10)
    log.critical("a computation does not stop: this process ends without it")
    os._exit(1)

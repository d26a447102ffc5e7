"""What ends a process whose computation goes on beyond its deadline.

A request may compute for ATTITUDE_MAX_SECONDS; waiting for a thread does not count.  When they are used up,
`Compute` sets the request's `Stop`, which every loop of the library looks at (attitude/stopping.py).  A
computation that does not stop nevertheless is stuck STUCK_AFTER_S later: /healthz fails then, and a process
that has a supervisor ends and is replaced.
"""

import asyncio
import faulthandler
import logging
import multiprocessing
import os
import signal
from collections.abc import Callable

log = logging.getLogger(__name__)

# Beyond its deadline: the processor's time that a computation may take to stop; and when it is stuck.
OVERTIME_S, STUCK_AFTER_S = 1, 5
# After SIGTERM: for requests, beside their seconds of computing; then for a computation to stop.
GRACE_S, STOP_WITHIN_S = 1, 0.5


async def end_stuck_process(is_stuck: Callable[[], bool], max_seconds: float) -> None:
    """End this process where a computation is stuck, if it is one of several: its supervisor starts another.

    What else it has accepted is answered first.  A call that holds the interpreter's lock would hold this
    loop too: against that the timer of `faulthandler`, which needs no lock, ends any process.
    """
    try:
        while not (is_stuck() and multiprocessing.parent_process() is not None):
            faulthandler.dump_traceback_later(max_seconds + STUCK_AFTER_S, exit=True, file=2)
            await asyncio.sleep(1.0)
    finally:
        faulthandler.cancel_dump_traceback_later()
    log.critical("a computation does not stop: this process ends, to be replaced")
    signal.raise_signal(signal.SIGTERM)
    await asyncio.sleep(max_seconds + GRACE_S + STOP_WITHIN_S)
    os._exit(1)


async def end_computations(is_computing: Callable[[], bool]) -> None:
    """Wait for computations that are to stop; end the process, whose interpreter would wait for ever."""
    for _ in range(10):
        if not is_computing():
            return
        await asyncio.sleep(STOP_WITHIN_S / 10)
    log.critical("a computation does not stop: this process ends without it")
    os._exit(1)

"""Where requests compute: threads beside the event loop, which itself only listens and answers.

There are about as many threads as processors.  Requests wait for one in the order in which they came, block
by block where the answer is sent in blocks, so that a long answer does not keep short ones waiting; and
more requests than are meant to wait are refused at once, with the time after which to try again.
"""

from __future__ import annotations

import asyncio
import os
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from contextvars import copy_context
from functools import partial
from http import HTTPStatus
from typing import Any, ParamSpec, TypeVar

from starlette.exceptions import HTTPException

from . import jobs
from .settings import Settings, variable

T = TypeVar("T")
P = ParamSpec("P")

RETRY_AFTER_S = 1
# Of threads that compute, below the event loop's: a processor that both want is the event loop's.
NICENESS = 0


class Compute:
    """Runs what blocks; one an application, in `app.state.compute`.

    Attributes
    ----------
    in_flight : requests that compute, or wait for a thread, or whose answer is being sent
    busy : threads that compute
    on_change : called when either has changed
    """

    def __init__(self, settings: Settings):
        self.settings = settings
        self.in_flight = self.busy = 0
        self.on_change: Callable[[], None] = _nothing
        self._pool = ThreadPoolExecutor(settings.computing_threads, "compute", initializer=_step_back)
        self._counting = threading.Lock()

    async def run(self, work: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """The result of a call that computes.

        Raises HTTPException 503 where too many requests are in flight already, InputError where the request
        has used up its seconds, ClientDisconnect where its client has gone away; and what the call raises.
        """
        job = jobs.current()
        if job is None:  # called by no request: nobody to watch, nothing to add up
            job = jobs.Job()
        self._admit(job)
        job.check(self.settings.max_seconds)
        task = partial(self._piece, job, partial(work, *args, **kwargs))
        future = asyncio.get_running_loop().run_in_executor(self._pool, copy_context().run, task)
        try:
            await self._until_done(future, job)
        except BaseException:
            job.abandoned = True  # for the thread, which may be amid it
            future.add_done_callback(_forget)
            future.cancel()
            raise
        finally:
            if jobs.current() is None:
                job.end()
        return future.result()

    async def blocks(self, blocks: Iterator[bytes]) -> AsyncIterator[bytes]:
        """The blocks of an answer, each computed when the one before has been sent."""
        while (block := await self.run(next, blocks, None)) is not None:
            yield block

    def close(self) -> None:
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _admit(self, job: jobs.Job) -> None:
        """Once a request; it counts until it is over."""
        if self._leave in job.at_end:
            return
        most = self.settings.requests_in_flight
        if self.in_flight >= most:
            detail = f"at most {most} requests at once ({variable('max_requests')}); try again later"
            retry = {"retry-after": str(RETRY_AFTER_S)}
            raise HTTPException(HTTPStatus.SERVICE_UNAVAILABLE, detail, headers=retry)
        self.in_flight += 1
        job.at_end.append(self._leave)
        self.on_change()

    def _leave(self) -> None:
        self.in_flight -= 1
        self.on_change()

    def _piece(self, job: jobs.Job, work: Callable[[], T]) -> T:
        """In a thread: some of a request's work."""
        job.begin_piece()
        self._count(1)
        try:
            job.check(self.settings.max_seconds)
            return work()
        finally:
            self._count(-1)
            job.end_piece()

    def _count(self, change: int) -> None:
        with self._counting:
            self.busy += change
            self.on_change()

    async def _until_done(self, future: asyncio.Future[Any], job: jobs.Job) -> None:
        gone = job.watch()
        while not future.done():
            left = max(0.01, self.settings.max_seconds - job.spent())
            await asyncio.wait((future, gone), timeout=left, return_when=asyncio.FIRST_COMPLETED)
            if not future.done():
                job.check(self.settings.max_seconds)


def _forget(future: asyncio.Future[Any]) -> None:
    """Of work that nobody waits for: what it raised is nobody's concern."""
    if not future.cancelled():
        future.exception()


def _nothing() -> None:
    pass


def _step_back() -> None:
    with suppress(AttributeError, OSError):  # where threads have no priorities of their own
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)

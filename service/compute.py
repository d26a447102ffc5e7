"""Where requests compute: threads beside the event loop, which itself only listens and answers.

There are about as many threads as processors.  Requests wait for one in the order in which they came, block
by block where the answer is sent in blocks, so that a long answer does not keep short ones waiting; and
more requests than are meant to wait are refused at once, with the time after which to try again.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from functools import partial
from http import HTTPStatus
from typing import Any, ParamSpec, TypeVar

from starlette.exceptions import HTTPException

from attitude.stopping import stoppable

from . import jobs
from .settings import Settings, variable

T = TypeVar("T")
P = ParamSpec("P")

RETRY_AFTER_S = 1
# After which a piece of work is looked after: most are done before.
LOOK_AFTER_S, LOOK_EVERY_S = 0.05, 1.0


class Compute:
    """Runs what blocks; one an application, in `app.state.compute`.

    Attributes
    ----------
    in_flight : requests that compute, or wait for a thread, or whose answer is being sent
    busy : threads that compute
    on_change : called when either may have changed
    """

    def __init__(self, settings: Settings):
        self.settings = settings
        self.in_flight = self.busy = 0
        self.on_change: Callable[[], None] = _nothing
        self._pool = ThreadPoolExecutor(settings.computing_threads, "compute")
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
        loop = asyncio.get_running_loop()
        task = partial(self._piece, job, partial(work, *args, **kwargs))
        future = loop.run_in_executor(self._pool, copy_context().run, task)
        looking = _Looking(self, job, future)
        try:
            return await future
        except asyncio.CancelledError:
            if looking.reason is not None:
                raise looking.reason from None
            job.give_up()
            raise
        finally:
            looking.end()
            if jobs.current() is None:
                job.end()

    async def blocks(self, blocks: Iterator[bytes]) -> AsyncIterator[bytes]:
        """The blocks of an answer, each computed while the one before is on its way, and none beyond that."""
        ahead = asyncio.ensure_future(self.run(next, blocks, None))
        try:
            while (block := await ahead) is not None:
                ahead = asyncio.ensure_future(self.run(next, blocks, None))
                await asyncio.sleep(0)  # it begins before this one is copied into the socket
                yield block
        finally:
            ahead.add_done_callback(_forget)
            ahead.cancel()

    def close(self) -> None:
        """For who makes many of them; a process that ends needs it not."""
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
            with stoppable(job.stop):
                return work()
        finally:
            self._count(-1)
            job.end_piece()

    def _count(self, change: int) -> None:
        with self._counting:
            self.busy += change


def _forget(task: asyncio.Future[Any]) -> None:
    """Of work that nobody waits for: what it raised is nobody's concern."""
    if not task.cancelled():
        task.exception()


class _Looking:
    """From time to time, whether a piece of work is still wanted; what is done by then costs no look."""

    def __init__(self, compute: Compute, job: jobs.Job, future: asyncio.Future[Any]):
        self.compute, self.job, self.future = compute, job, future
        self.reason: Exception | None = None  # for which it was given up
        self._timer = future.get_loop().call_later(LOOK_AFTER_S, self._begin)

    def _begin(self) -> None:
        self.job.on_gone = self._look
        self.job.watch()
        self._look()

    def _look(self) -> None:
        self.compute.on_change()
        self._timer.cancel()
        try:
            self.job.check(self.compute.settings.max_seconds)
        except Exception as error:
            self.reason = error
            self.job.give_up()
            self.future.cancel()
        else:
            left = self.compute.settings.max_seconds - self.job.spent()
            self._timer = self.future.get_loop().call_later(min(LOOK_EVERY_S, left + 0.01), self._look)

    def end(self) -> None:
        self._timer.cancel()
        self.job.on_gone = None


def _nothing() -> None:
    pass

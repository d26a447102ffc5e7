"""Where requests compute: threads beside the event loop, which itself only listens and answers.

There are about as many threads as processors.  Requests wait for one in the order in which they came, block
by block where the answer is sent in blocks, so that a long answer does not keep short ones waiting; and
more requests than are meant to wait are refused at once, with the time after which to try again.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar, copy_context
from functools import partial
from http import HTTPStatus
from typing import Any, ParamSpec, TypeVar

from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.types import Message, Receive

from .deadline import Deadline, end_computations
from .metrics import Metrics
from .settings import Settings, variable

T = TypeVar("T")
P = ParamSpec("P")

RETRY_AFTER_S = 1
# When a computation is looked at: first, which is after most are done; and then.
FIRST_LOOK_S, LOOK_EVERY_S = 0.05, 0.5


class Job:
    """One request: what it takes, and whether anybody still waits for its answer.

    Attributes
    ----------
    identity : goes through the logs, and back to the client
    deadline : seconds of computing, and the stop that ends them
    samples : instants that the answer holds
    is_admitted : counts among those in flight
    is_abandoned : no client waits for the answer any more
    """

    def __init__(self, identity: str, receive: Receive, max_seconds: float):
        self.identity = identity
        self.deadline = Deadline(max_seconds)
        self.samples = 0
        self.is_admitted = self.is_abandoned = False
        self._receive = receive
        self._disconnect: asyncio.Task[None] | None = None

    async def receive(self) -> Message:
        """What the application receives; while the client is watched, its disconnection only."""
        if self._disconnect is not None:
            await asyncio.shield(self._disconnect)
            return {"type": "http.disconnect"}
        return await self._receive()

    def disconnect(self) -> asyncio.Task[None]:
        """Watch for the client to go away; nothing further of its request is read."""
        if self._disconnect is None:
            self._disconnect = asyncio.create_task(self._wait_for_disconnect())
        return self._disconnect

    async def _wait_for_disconnect(self) -> None:
        while (await self._receive())["type"] != "http.disconnect":
            pass
        self.is_abandoned = True

    def give_up(self) -> None:
        """Stop the thread that computes, if any."""
        self.is_abandoned = True
        self.deadline.stop.set()

    def end(self) -> None:
        """Watch no longer."""
        if self._disconnect is not None:
            self._disconnect.cancel()

    def check(self) -> None:
        """Raises ClientDisconnect where no client waits any more, InputError where its time is used up."""
        if self.is_abandoned:
            raise ClientDisconnect
        self.deadline.check()

    def run(self, work: Callable[[], T]) -> T:
        """One piece of its work, in the thread that calls this."""
        self.check()
        with self.deadline.computing():
            return work()


current: ContextVar[Job | None] = ContextVar("job", default=None)


class Compute:
    """Runs what blocks; one an application, in `app.state.compute`.

    Attributes
    ----------
    in_flight : requests that compute, or wait for a thread, or whose answer is being sent
    running : requests that a thread computes
    """

    def __init__(self, settings: Settings, metrics: Metrics | None = None):
        self.settings = settings
        self.metrics = metrics or Metrics()
        self.in_flight = 0
        self.max_in_flight = settings.requests_in_flight
        self.running: set[Job] = set()
        self._pool = ThreadPoolExecutor(settings.computing_threads, "compute")

    async def run(self, work: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """The result of a call that computes, for the current request.

        Raises HTTPException 503 where too many requests are in flight already, InputError where the request
        has used up its seconds, ClientDisconnect where its client has gone away; and what the call raises.
        """
        job = current.get()
        assert job is not None  # noqa: S101 (for the type checker)
        self._admit(job)
        job.check()
        piece = partial(self._piece, job, partial(work, *args, **kwargs))
        future = asyncio.get_running_loop().run_in_executor(self._pool, copy_context().run, piece)
        try:
            await self._finished(job, future)
        except BaseException:
            job.give_up()
            future.cancel()
            raise
        return await future

    async def _finished(self, job: Job, future: asyncio.Future[Any]) -> None:
        """Wait for a result as long as it is wanted."""
        awaited: set[asyncio.Future[Any]] = {future}
        seconds = FIRST_LOOK_S
        while True:
            await asyncio.wait(awaited, timeout=seconds, return_when=asyncio.FIRST_COMPLETED)
            if future.done():
                return
            job.check()
            awaited = {future, job.disconnect()}
            left = job.deadline.max_seconds - job.deadline.spent()
            seconds = min(LOOK_EVERY_S, left + 0.01)

    async def blocks(self, blocks: Iterator[bytes]) -> AsyncIterator[bytes]:
        """The blocks of an answer, each computed while the one before is on its way, and none beyond that."""
        ahead = asyncio.ensure_future(self.run(next, blocks, None))
        try:
            while (block := await ahead) is not None:
                ahead = asyncio.ensure_future(self.run(next, blocks, None))
                await asyncio.sleep(0)  # it begins before this one is copied into the socket
                yield block
        finally:
            ahead.add_done_callback(lambda task: task.cancelled() or task.exception())
            ahead.cancel()

    def leave(self, job: Job) -> None:
        """A request is over, whatever became of it."""
        job.end()
        if job.is_admitted:
            job.is_admitted = False
            self.in_flight -= 1
            self.metrics.in_flight.set(self.in_flight)

    def is_stuck(self) -> bool:
        """Whether a computation goes on that should have stopped long ago."""
        return any(job.deadline.is_stuck() for job in tuple(self.running))

    async def stop(self) -> None:
        """Stop what is computed: the process is to end."""
        for job in tuple(self.running):
            job.give_up()
        await end_computations(lambda: bool(self.running))

    def close(self) -> None:
        """End the threads, for who makes many of them; a process that ends needs it not."""
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _admit(self, job: Job) -> None:
        """Once a request; it counts until it is over."""
        if job.is_admitted:
            return
        if self.in_flight >= self.max_in_flight:
            limit = f"at most {self.max_in_flight} requests at once ({variable('max_requests')})"
            retry = {"retry-after": str(RETRY_AFTER_S)}
            raise HTTPException(HTTPStatus.SERVICE_UNAVAILABLE, f"{limit}; try again later", retry)
        job.is_admitted = True
        self.in_flight += 1
        self.metrics.in_flight.set(self.in_flight)

    def _piece(self, job: Job, work: Callable[[], T]) -> T:
        """In a thread: some of a request's work."""
        self.running.add(job)
        self.metrics.busy.inc()
        try:
            return job.run(work)
        finally:
            self.running.discard(job)
            self.metrics.busy.dec()


def count_samples(samples: int) -> None:
    """Instants that an answer holds, for the log and the metrics."""
    job = current.get()
    if job is not None:
        job.samples += samples

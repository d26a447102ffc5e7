"""Where requests compute: threads beside the event loop, which itself only listens and answers.

There are about as many threads as processors.  Requests wait for one in the order in which they came, block
by block where the answer is sent in blocks, so that a long answer does not keep short ones waiting; and
more requests than are meant to wait are refused at once, with the time after which to try again.
"""

import asyncio
import logging
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar, copy_context
from functools import partial
from http import HTTPStatus
from threading import Lock
from time import perf_counter, thread_time
from typing import ParamSpec, TypeVar

from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request

from attitude.errors import AttitudeError, InputError, collected_warnings
from attitude.stopping import Stop, stoppable

from . import deadline, metrics
from .settings import Settings, variable

log = logging.getLogger(__name__)

T = TypeVar("T")
P = ParamSpec("P")

LOOK_EVERY_S = 0.1  # at a computation: is its client there still, are its seconds used up


class NoRoomError(Exception):
    """Answers that are held in memory leave no room for one of so many samples now."""

    def __init__(self, samples: int):
        self.samples = samples


class CutError(Exception):
    """What computes the rest of an answer that has begun was refused, or ran out of time."""


class Job:
    """One request: what it takes, and whether anybody still waits for its answer.

    Attributes
    ----------
    identity : goes through the logs, and back to the client
    samples : instants of the answer; held : those of them that are in memory until it is sent
    predicted : s, computing that its scenes are predicted to need together
    warnings : of the library, which the answer has in a header
    is_admitted : counts among those in flight
    is_abandoned : the answer is not wanted any more: its client has gone, or its seconds are used up
    """

    def __init__(self, identity: str, request: Request, compute: "Compute"):
        self.identity, self.request, self.compute = identity, request, compute
        self.max_seconds: float = compute.settings.max_seconds
        self.samples = self.held = 0
        self.predicted = 0.0
        self.warnings: list[str] = []
        self.is_admitted = self.is_abandoned = False
        self._stop = Stop()
        self._before = 0.0  # seconds of the pieces of work that are done
        self._begun: float | None = None  # the piece under way

    def spent(self) -> float:
        """Seconds of computing, those of the piece under way included."""
        begun = self._begun
        return self._before + (perf_counter() - begun if begun is not None else 0.0)

    def check_deadline(self) -> None:
        """Raises ClientDisconnect where no client waits any more, InputError where its time is used up."""
        if self.is_abandoned:
            raise ClientDisconnect
        if (spent := self.spent()) > self.max_seconds:
            limit = f"a scene that takes at most {self.max_seconds} s to compute ({variable('max_seconds')})"
            raise InputError("times", f"{spent:.3g} s so far", limit)

    def predict(self, seconds: float) -> None:
        """Add what one scene is predicted to need; InputError where all need more than they may."""
        predicted = self.predicted + seconds
        if not predicted <= self.max_seconds:
            limit = f"a scene predicted to take at most {self.max_seconds} s ({variable('max_seconds')})"
            raise InputError("times", f"{predicted:.3g} s", limit)
        self.predicted = predicted

    def run(self, work: Callable[[], T]) -> T:
        """One piece of its work, in the thread that calls this."""
        self.check_deadline()
        allowed = self.max_seconds - self._before + deadline.OVERTIME_S
        self._begun, processor_begun = perf_counter(), thread_time()
        try:
            with stoppable(self._stop), collected_warnings(self.warnings):
                return work()
        finally:
            self._before, self._begun = self.spent(), None
            if (seconds := thread_time() - processor_begun) > allowed:
                log.warning("a computation took %.1f s, %.1f s were left to it", seconds, allowed)

    def give_up(self) -> None:
        """Stop the thread that computes, if any."""
        self.is_abandoned = True
        self._stop.set()

    def is_stuck(self) -> bool:
        """Whether a computation goes on that should have stopped long ago."""
        return self._begun is not None and self.spent() > self.max_seconds + deadline.STUCK_AFTER_S


current: ContextVar[Job | None] = ContextVar("job", default=None)


def check_wanted(_done: float = 0.0) -> None:
    """What the library calls between pieces of its work, as its `progress`; see `Job.check_deadline`."""
    if (job := current.get()) is not None:
        job.check_deadline()


def check_predicted(seconds: float) -> None:
    """What the library calls with the seconds that a scene is predicted to need; see `Job.predict`."""
    if (job := current.get()) is not None:
        job.predict(seconds)


def hold(samples: int) -> None:
    """Take room for an answer whose samples are all in memory until it is sent.

    Raises NoRoomError, where there is none: `Compute.run` does the work again when there is.
    """
    if (job := current.get()) is not None and not job.compute.hold(job, samples):
        raise NoRoomError(samples)


class Compute:
    """Runs what blocks; one an application, in `app.state.compute`.

    Attributes
    ----------
    in_flight : requests that compute, or wait for a thread, or whose answer is being sent
    running : requests that a thread computes
    held : samples that answers hold in memory, from their computation until they are sent
    """

    def __init__(self, settings: Settings):
        self.settings = settings
        self.max_requests, self.in_flight = settings.requests_in_flight, 0
        self.running: set[Job] = set()
        self.held, self._lock = 0, Lock()
        self._pool = ThreadPoolExecutor(settings.computing_threads, "compute")

    async def run(self, work: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """The result of a call that computes, for the current request.

        Raises HTTPException 503 where too many requests are in flight already, InputError where the request
        has used up its seconds, ClientDisconnect where its client has gone away; and what the call raises.
        """
        job = current.get()
        assert job is not None  # noqa: S101 (for the type checker)
        self._admit(job)
        while True:
            try:
                return await self._run_once(job, partial(work, *args, **kwargs))
            except NoRoomError as error:
                await self._wait_for_room(job, error.samples)

    async def _run_once(self, job: Job, work: Callable[[], T]) -> T:
        job.check_deadline()
        piece = partial(copy_context().run, self._run_piece, job, work)
        future = asyncio.get_running_loop().run_in_executor(self._pool, piece)
        try:
            while not (await asyncio.wait([future], timeout=LOOK_EVERY_S))[0]:
                job.is_abandoned = await job.request.is_disconnected()
                job.check_deadline()
        except BaseException:
            job.give_up()
            future.cancel()
            raise
        return await future

    def hold(self, job: Job, samples: int) -> bool:
        """Take room for so many samples, unless a request has taken it before; whether there is any.

        One answer may hold them all.
        """
        with self._lock:
            if not job.held and not (self.held and self.held + samples > self.settings.max_samples):
                self.held += samples
                job.held = samples
        return job.held > 0 or samples == 0

    async def _wait_for_room(self, job: Job, samples: int) -> None:
        """HTTPException 503 where others hold what room there is for as long as a request may compute."""
        seconds = self.settings.max_seconds
        for _ in range(round(seconds / LOOK_EVERY_S)):
            if self.hold(job, samples):
                return
            await asyncio.sleep(LOOK_EVERY_S)
            job.is_abandoned = await job.request.is_disconnected()
            job.check_deadline()
        detail = (
            f"answers to others hold all of {self.settings.max_samples} samples in memory; try again later"
        )
        raise HTTPException(HTTPStatus.SERVICE_UNAVAILABLE, detail, {"retry-after": str(seconds)})

    def _run_piece(self, job: Job, work: Callable[[], T]) -> T:
        self.running.add(job)
        try:
            with metrics.busy.track_inprogress():
                return job.run(work)
        finally:
            self.running.discard(job)

    async def blocks(self, blocks: Iterator[bytes]) -> AsyncIterator[bytes]:
        """The blocks of an answer, each computed while the one before is on its way, and none beyond that.

        The first is there already: an answer that has begun has sent it, whatever becomes of the others.
        """
        block, ahead = next(blocks, None), None
        try:
            while block is not None:
                ahead = asyncio.ensure_future(self.run(next, blocks, None))
                await asyncio.sleep(0)  # it begins before this one is copied into the socket
                yield block
                block = await ahead
        except AttitudeError as error:
            raise CutError(str(error)) from error
        finally:
            if ahead is not None:
                ahead.add_done_callback(lambda task: task.cancelled() or task.exception())
                ahead.cancel()

    def _admit(self, job: Job) -> None:
        """Once a request, which counts until it has left; HTTPException 503 where there are too many."""
        if job.is_admitted:
            return
        if self.in_flight >= self.max_requests:
            limit = f"at most {self.max_requests} requests at once ({variable('max_requests')})"
            detail = f"{limit}; try again later"
            raise HTTPException(HTTPStatus.SERVICE_UNAVAILABLE, detail, {"retry-after": "1"})
        job.is_admitted = True
        self.in_flight += 1
        metrics.in_flight.inc()

    def leave(self, job: Job) -> None:
        """A request is over, whatever became of it."""
        with self._lock:
            self.held -= job.held
            job.held = 0
        if job.is_admitted:
            job.is_admitted = False
            self.in_flight -= 1
            metrics.in_flight.dec()

    def is_stuck(self) -> bool:
        return any(job.is_stuck() for job in tuple(self.running))

    async def stop(self) -> None:
        """Stop what is computed: the process is to end."""
        for job in tuple(self.running):
            job.give_up()
        await deadline.end_computations(lambda: bool(self.running))

    def close(self) -> None:
        """End the threads, for who makes many of them; a process that ends needs it not."""
        self._pool.shutdown(wait=False, cancel_futures=True)

"""What becomes of one request while it is served: who it is, what it took, whether anybody still waits."""

from __future__ import annotations

import asyncio
import random
from collections.abc import Callable
from contextvars import ContextVar
from time import perf_counter

from starlette.requests import ClientDisconnect
from starlette.types import Message, Receive

from attitude.errors import InputError
from attitude.stopping import Stop

from .settings import variable

DISCONNECT: Message = {"type": "http.disconnect"}


class Job:
    """One request.

    Attributes
    ----------
    identity : goes through the logs, and back to the client
    samples : instants that the answer holds, counted by whoever makes it
    compute_seconds : that threads have spent on it so far
    abandoned : nobody waits for the answer any more
    stop : set where what computes is to end now
    on_gone : called when the client has gone, while it is watched
    at_end : called when the request is over, whatever became of it
    """

    def __init__(self, identity: str = "", receive: Receive | None = None):
        self.identity = identity
        self.samples = 0
        self.compute_seconds = 0.0
        self.at_end: list[Callable[[], None]] = []
        self.abandoned = False
        self.stop = Stop()
        self.on_gone: Callable[[], None] | None = None
        self._receive = receive
        self._watcher: asyncio.Task[None] | None = None
        self._piece_begun: float | None = None

    # -- whether anybody still waits --------------------------------------------------------------

    async def receive(self) -> Message:
        """What the application receives; from `watch` on the watcher alone listens to the client."""
        if self._watcher is not None:
            await asyncio.shield(self._watcher)
            return DISCONNECT
        assert self._receive is not None
        return await self._receive()

    def watch(self) -> None:
        """Notice when the client goes away; nothing further of its request is read."""
        if self._receive is not None and self._watcher is None:
            self._watcher = asyncio.create_task(self._listen(self._receive))

    async def _listen(self, receive: Receive) -> None:
        while (await receive())["type"] != "http.disconnect":
            pass
        self.abandoned = True
        if self.on_gone is not None:
            self.on_gone()

    def give_up(self) -> None:
        """For the thread, which may be amid it."""
        self.abandoned = True
        self.stop.set()

    def end(self) -> None:
        if self._watcher is not None:
            self._watcher.cancel()
        for callback in self.at_end:
            callback()

    # -- what it takes ----------------------------------------------------------------------------

    def begin_piece(self) -> None:
        self._piece_begun = perf_counter()

    def end_piece(self) -> None:
        self.compute_seconds, self._piece_begun = self.spent(), None

    def spent(self) -> float:
        """Seconds of computing, those of the piece under way included."""
        begun = self._piece_begun
        return self.compute_seconds + (perf_counter() - begun if begun is not None else 0.0)

    def check(self, most_seconds: float) -> None:
        """Raises ClientDisconnect where nobody waits any more, InputError where its time is used up."""
        if self.abandoned:
            raise ClientDisconnect
        if (spent := self.spent()) > most_seconds:
            limit = f"a scene that takes at most {most_seconds} s to compute ({variable('max_seconds')})"
            raise InputError("times", f"{spent:.3g} s so far", limit)


def new_identity() -> str:
    """Not to be mixed up with another request's; no secret."""
    return f"{random.getrandbits(64):016x}"


_current: ContextVar[Job | None] = ContextVar("job", default=None)


def begin(job: Job) -> None:
    """From here on this task, and what it starts, works on `job`."""
    _current.set(job)


def current() -> Job | None:
    return _current.get()


def count_samples(samples: int) -> None:
    """Instants that an answer holds, for the log and the metrics."""
    job = current()
    if job is not None:
        job.samples += samples

"""Where requests compute: threads beside the event loop, which itself only listens and answers."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterator
from typing import ParamSpec, TypeVar

from starlette.concurrency import run_in_threadpool

from .settings import Settings

T = TypeVar("T")
P = ParamSpec("P")
_END = b""


class Compute:
    """Runs what blocks; one an application, in `app.state.compute`."""

    def __init__(self, settings: Settings):
        self.settings = settings

    async def run(self, work: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """The result of a call that computes."""
        return await run_in_threadpool(work, *args, **kwargs)

    async def blocks(self, blocks: Iterator[bytes]) -> AsyncIterator[bytes]:
        """The blocks of an answer, each computed when the one before has been sent."""
        while block := await self.run(next, blocks, _END):
            yield block

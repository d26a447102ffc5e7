"""How what is written to a connection goes out: small things together, large ones without being copied.

The head of a small answer and its content leave in one packet: each call of the system takes longer than to
make the head, and the client is woken once instead of twice.  A large block waits here and is handed to the
transport in slices, the next when the one before is gone: asyncio's own would copy all of it that does not
fit into the socket at once, and move what is left for every piece that does.
"""

from __future__ import annotations

import asyncio
from collections import deque
from typing import Any

MOST_BYTES = 1 << 16  # more are not held for others to come
SLICE = 1 << 20


class Gathering:
    """A transport around another; all but what is said here is that one's.

    The protocol is told to pause as long as anything is left here or there, and calls `push` where it would
    resume.
    """

    def __init__(self, transport: asyncio.Transport, loop: asyncio.AbstractEventLoop):
        self._transport, self._loop = transport, loop
        self._held: list[memoryview] = []
        self._size = 0  # of what is held
        self._waiting: deque[memoryview] = deque()
        self._is_ending = False
        transport.set_write_buffer_limits(high=0)

    def write(self, data: Any) -> None:
        """Bytes, or a list of them."""
        for part in data if isinstance(data, list) else [data]:
            self._write(memoryview(part).cast("B"))

    def _write(self, part: memoryview) -> None:
        if self._size + len(part) > MOST_BYTES:
            self.flush()
            self._send(part)
            return
        if not self._held:
            self._loop.call_soon(self.flush)
        self._held.append(part)
        self._size += len(part)

    def flush(self) -> None:
        held, self._held, self._size = self._held, [], 0
        if held:
            self._send(memoryview(b"".join(held)))

    def _send(self, part: memoryview) -> None:
        self._waiting.append(part)
        self.push()

    def push(self) -> None:
        """As much as the transport passes on at once, and a slice more."""
        while self._waiting and not self._transport.get_write_buffer_size():
            view = self._waiting.popleft()
            if len(view) > SLICE:
                self._waiting.appendleft(view[SLICE:])
            self._transport.write(view[:SLICE])
        if self._is_ending and not self._waiting:
            self._transport.close()

    @property
    def is_holding(self) -> bool:
        """Whether something waits for the transport."""
        return bool(self._waiting)

    def drop(self) -> None:
        """Nobody is there to take what is left."""
        self._held, self._size = [], 0
        self._waiting.clear()

    def write_eof(self) -> None:
        self.flush()
        while self._waiting:
            self._transport.write(self._waiting.popleft())
        self._transport.write_eof()

    def close(self) -> None:
        """When everything is on its way."""
        self.flush()
        self._is_ending = True
        self.push()

    def is_closing(self) -> bool:
        return self._is_ending or self._transport.is_closing()

    def abort(self) -> None:
        self.drop()
        self._transport.abort()

    def get_write_buffer_size(self) -> int:
        waiting = sum(len(view) for view in self._waiting)
        return self._transport.get_write_buffer_size() + self._size + waiting

    def __getattr__(self, name: str) -> Any:
        return getattr(self._transport, name)

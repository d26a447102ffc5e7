"""What is written to a connection in one turn of the event loop goes out together.

The head of a small answer and its content in one packet: each call of the system takes longer than to make
the head, and the client is woken once instead of twice.
"""

from __future__ import annotations

import asyncio
from typing import Any

MOST_BYTES = 1 << 16  # more are not held, and not copied


class Gathering:
    """A transport around another; all but what is said here is that one's."""

    def __init__(self, transport: asyncio.Transport, loop: asyncio.AbstractEventLoop):
        self._transport, self._loop = transport, loop
        self._held: list[bytes] = []
        self._size = 0

    def write(self, data: Any) -> None:
        if self._size + len(data) > MOST_BYTES:
            self.flush()
            self._transport.write(data)
            return
        if not self._held:
            self._loop.call_soon(self.flush)
        self._held.append(data)
        self._size += len(data)

    def flush(self) -> None:
        held, self._held, self._size = self._held, [], 0
        if held:
            self._transport.write(b"".join(held))

    def write_eof(self) -> None:
        self.flush()
        self._transport.write_eof()

    def close(self) -> None:
        self.flush()
        self._transport.close()

    def get_write_buffer_size(self) -> int:
        return self._transport.get_write_buffer_size() + self._size

    def __getattr__(self, name: str) -> Any:
        return getattr(self._transport, name)

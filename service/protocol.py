"""HTTP as the server speaks it, where no application is asked yet: uvicorn's, with three things changed.

What is no HTTP, or has headers without end, is refused with a problem like everything else; no client is
waited for forever, neither for its headers nor for taking what it asked for; and answers go out in the pieces
that they are made of (service/gathering.py).
"""

from __future__ import annotations

import asyncio
import logging
import sys
from collections.abc import Callable
from http import HTTPStatus
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from . import headers, jobs
from .errors import problem
from .gathering import Gathering
from .settings import Settings, variable

log = logging.getLogger(__name__)

MOST_HEADER_BYTES = 2**16
LINGER_S = 2.0  # for a client that is still sending to see that it is refused
NOT_HTTP = "the request is not HTTP/1.1 as this service reads it"
TOO_LONG = f"request line and headers: at most {MOST_HEADER_BYTES} bytes; got more"
REFUSALS = {HTTPStatus.BAD_REQUEST: NOT_HTTP, HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE: TOO_LONG}


class Connection(h11.Connection):
    """What is to be sent, in pieces: to join them would copy every block of an answer."""

    def send(self, event: Any) -> Any:
        return self.send_with_data_passthrough(event)


class Protocol(H11Protocol):
    """One connection."""

    client_seconds = 20
    count_refusal: Callable[[int], None] = staticmethod(lambda status: None)

    def __init__(self, *arguments: Any, **named: Any):
        super().__init__(*arguments, **named)
        self.conn = Connection(h11.SERVER, MOST_HEADER_BYTES)
        self._is_waiting = True  # for a request, or for what is left of one that is answered already
        self._patience: asyncio.TimerHandle | None = None
        self._stuck: asyncio.TimerHandle | None = None
        self._is_refused = False

    # -- clients that send slowly -----------------------------------------------------------------

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        self._gathering = Gathering(transport, self.loop)
        super().connection_made(self._gathering)  # type: ignore[arg-type]
        self._wait()

    def data_received(self, data: bytes) -> None:
        if self._is_refused:  # and not read, but taken: else the system would take the refusal back
            return
        if self._is_waiting and self._patience is None:
            self._wait()
        super().data_received(data)

    def handle_events(self) -> None:
        before = self.cycle
        super().handle_events()
        if self.cycle is not before:
            self._is_waiting = False
            self._wait_no_more()

    def on_response_complete(self) -> None:
        self._is_waiting = True
        super().on_response_complete()

    def connection_lost(self, exc: Exception | None) -> None:
        self._wait_no_more()
        self._gathering.drop()
        self.resume_writing()
        super().connection_lost(exc)

    def _wait(self) -> None:
        self._patience = self.loop.call_later(self.client_seconds, self._give_up)

    def _wait_no_more(self) -> None:
        if self._patience is not None:
            self._patience.cancel()
            self._patience = None

    def _give_up(self) -> None:
        self._patience = None
        seconds = f"{self.client_seconds} s ({variable('client_seconds')})"
        self._refuse(HTTPStatus.REQUEST_TIMEOUT, f"request: whole within {seconds}")

    # -- clients that take slowly -----------------------------------------------------------------

    def pause_writing(self) -> None:
        super().pause_writing()
        self._look_again()

    def resume_writing(self) -> None:
        if self._stuck is not None:
            self._stuck.cancel()
            self._stuck = None
        self._gathering.push()
        if not self._gathering.is_holding:
            super().resume_writing()

    def _look_again(self) -> None:
        untaken = self.transport.get_write_buffer_size()
        self._stuck = self.loop.call_later(self.client_seconds, self._end_if_stuck, untaken)

    def _end_if_stuck(self, untaken: int) -> None:
        """Nothing was taken meanwhile: the answer's memory is not kept for a client that does not read."""
        if self.transport.get_write_buffer_size() < untaken:
            self._look_again()
            return
        log.info("a client took nothing for %s s; its connection is ended", self.client_seconds)
        self.transport.abort()

    # -- refusals ---------------------------------------------------------------------------------

    def send_400_response(self, msg: str) -> None:
        """Called by uvicorn while it handles the error, which says what is wrong."""
        error = sys.exc_info()[1]
        status = HTTPStatus(getattr(error, "error_status_hint", HTTPStatus.BAD_REQUEST))
        self._refuse(status, REFUSALS.get(status, NOT_HTTP))

    def _refuse(self, status: HTTPStatus, detail: str) -> None:
        """Answer, where an answer is still possible, and end the connection."""
        if self.transport.is_closing() or self._is_refused:
            return
        self._is_refused, is_answered = True, self.conn.our_state not in (h11.IDLE, h11.SEND_RESPONSE)
        if not is_answered:
            self.count_refusal(status)
            identity = jobs.new_identity()
            log.info("refused %d: %s", status, detail, extra={"fields": {"request_id": identity}})
            self.transport.write(self._answer(status, detail, identity))
        if self.cycle is not None:  # whose application is not to answer a second time
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        if is_answered:
            self.transport.close()
        else:
            self.transport.write_eof()
            self.loop.call_later(LINGER_S, self.transport.close)

    def _answer(self, status: HTTPStatus, detail: str, identity: str) -> bytes:
        answer = problem(status, detail, headers={"connection": "close", "x-request-id": identity})
        raw = [*self.server_state.default_headers, *headers.secured(answer.raw_headers, status)]
        events = (
            h11.Response(status_code=status, headers=raw, reason=status.phrase.encode()),
            h11.Data(data=bytes(answer.body)),
            h11.EndOfMessage(),
        )
        sent: list[list[bytes]] = [self.conn.send(event) for event in events]  # type: ignore[misc]
        return b"".join(part for parts in sent for part in parts)


def protocol(settings: Settings, count_refusal: Callable[[int], None]) -> type[Protocol]:
    """With the settings of one application; the server makes one for each connection."""
    changed = {"client_seconds": settings.client_seconds, "count_refusal": staticmethod(count_refusal)}
    return type("Protocol", (Protocol,), changed)

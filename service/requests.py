"""Around every request: its id, its line in the log, its figures, and the headers that all answers have."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable
from time import perf_counter
from typing import Any

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from . import headers, jobs
from .jobs import Job
from .logs import FIELDS, plain
from .metrics import Metrics
from .readiness import Readiness

log = logging.getLogger(__name__)

ID = b"x-request-id"
SANE_ID = re.compile(rb"[A-Za-z0-9._:/+=-]{1,100}")
LONGEST_PATH = 200  # of what the log repeats
NO_ROUTE = "none"
GONE = "gone"  # for a status: the client did not wait for one
CUT = "cut"  # for a status: an answer that was begun and not ended


class Requests:
    """The outermost of the application."""

    def __init__(self, app: ASGIApp, metrics: Metrics, readiness: Readiness):
        self.app = app
        self.metrics = metrics
        self.readiness = readiness

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        job = Job(_identity(scope), receive)
        jobs.begin(job)
        answer = _Sent(send, job.identity, self.readiness)
        begun = perf_counter()
        try:
            await self.app(scope, job.receive, answer.send)
        finally:
            job.end()
            self._tell(scope, job, answer, perf_counter() - begun)

    def _tell(self, scope: Scope, job: Job, answer: _Sent, seconds: float) -> None:
        route = getattr(scope.get("route"), "path", NO_ROUTE)
        status = answer.outcome(job)
        self.metrics.observe(scope["method"], route, status, seconds, job)
        fields: dict[str, Any] = {
            "method": scope["method"][:LONGEST_PATH],
            "path": plain(scope["path"][:LONGEST_PATH]),
            "route": route,
            "status": int(status) if status.isdigit() else status,
            "seconds": round(seconds, 6),
            "bytes": answer.bytes,
        }
        if spent := job.spent():
            fields["compute_seconds"] = round(spent, 6)
        log.info("request", extra={FIELDS: fields})


class _Sent:
    """An answer on its way: what it has been so far."""

    def __init__(self, send: Send, identity: str, readiness: Readiness):
        self._send = send
        self._identity = identity
        self._readiness = readiness
        self.status: int | None = None
        self.bytes = 0
        self.whole = False

    async def send(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self.status = status = message["status"]
            message["headers"] = self._with_ours(message.get("headers", []), status)
        elif message["type"] == "http.response.body":
            self.bytes += len(message.get("body", b""))
        await self._send(message)
        self.whole = message["type"] == "http.response.body" and not message.get("more_body", False)

    def _with_ours(self, given: Iterable[tuple[bytes, bytes]], status: int) -> headers.RawHeaders:
        all_of_them = headers.secured(list(given), status)
        all_of_them.append((ID, self._identity.encode()))
        if self._readiness.stopping:  # the client is to ask elsewhere next
            all_of_them.append((b"connection", b"close"))
        return all_of_them

    def outcome(self, job: Job) -> str:
        if self.whole:
            return str(self.status)
        return GONE if job.abandoned or self.status is None else CUT


def _identity(scope: Scope) -> str:
    """The client's own, where it is one that a log may hold; else a new one."""
    for name, value in scope["headers"]:
        if name == ID and SANE_ID.fullmatch(value):
            return str(value, "ascii")
    return jobs.new_identity()

"""Around every request: its id, log line, figures and headers; gzip, and pages of other origins."""

from __future__ import annotations

import asyncio
import logging
import random
import re
from http import HTTPStatus
from time import perf_counter

from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware.cors import CORSMiddleware
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from . import metrics
from .compute import Compute, Job, current
from .errors import problem
from .logs import FIELDS, plain
from .negotiation import qualities
from .settings import variable

log = logging.getLogger(__name__)

MAX_HEADER_BYTES = 8192
EVERY_ANSWER = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
}
# Pages load everything from here; scripts are files, never text in a page.  Drawings may be made in place.
PAGE = {
    "content-security-policy": "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "cross-origin-opener-policy": "same-origin",
    "x-frame-options": "DENY",
}
# What is no page is shown as none, even where a browser is led to open it as one.
NO_PAGE = {"content-security-policy": "default-src 'none'; frame-ancestors 'none'; sandbox"}


class Requests:
    """Gives every request its id, its line in the log and its figures, and every answer its headers.

    HEAD is answered as GET is; the server sends no body after it.
    """

    def __init__(self, app: ASGIApp, compute: Compute):
        self.app, self.compute = app, compute

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        method, scope = scope["method"], dict(scope)
        scope["method"] = "GET" if method == "HEAD" else method
        request = Request(scope, receive)
        job = Job(identity_of(request), request, self.compute.settings.max_seconds)
        current.set(job)
        answer = Answer(send, job.identity, self.compute.settings.client_seconds)
        begun = perf_counter()
        try:
            await (refused_header(scope) or self.app)(scope, receive, answer.send)
        finally:
            self.compute.leave(job)
            taken, route = perf_counter() - begun, getattr(scope.get("route"), "path", "none")
            gone = job.is_abandoned or not answer.status
            outcome = answer.status if answer.is_whole else "gone" if gone else "cut"
            metrics.observe(method, route, outcome, taken)
            metrics.samples.inc(job.samples)
            metrics.computing.inc(job.deadline.spent())
            fields = {
                "method": method[:200],
                "path": plain(scope["path"][:200]),
                "route": route,
                "status": outcome,
                "seconds": round(taken, 6),
                "bytes": answer.bytes,
                "compute_seconds": round(job.deadline.spent(), 6),
            }
            log.info("request", extra={FIELDS: fields})


class Answer:
    """An answer on its way: its status, how much of it was sent, and whether that is all."""

    def __init__(self, send: Send, identity: str, max_seconds: int):
        self._send, self._identity, self._max_seconds = send, identity, max_seconds
        self.status = self.bytes = 0
        self.is_whole = False

    async def send(self, message: Message) -> None:
        """With the headers that all answers have; ClientDisconnect where the client does not take it."""
        if message["type"] == "http.response.start":
            self.status = message["status"]
            headers = MutableHeaders(raw=message.setdefault("headers", []))
            is_page = headers.get("content-type", "").startswith("text/html")
            # what a 304 does not repeat stays as the browser has kept it (RFC 9111, 3.2)
            policy = {} if self.status == HTTPStatus.NOT_MODIFIED else PAGE if is_page else NO_PAGE
            for name, value in (EVERY_ANSWER | policy | {"x-request-id": self._identity}).items():
                headers.setdefault(name, value)
        elif message["type"] == "http.response.body":
            self.bytes += len(message.get("body", b""))
        try:
            async with asyncio.timeout(self._max_seconds):
                await self._send(message)
        except TimeoutError:  # its memory and its place are not kept for a client that does not read
            log.info("a client took nothing for %s s (%s)", self._max_seconds, variable("client_seconds"))
            raise ClientDisconnect from None
        self.is_whole = message["type"] == "http.response.body" and not message.get("more_body", False)


def identity_of(request: Request) -> str:
    """The client's own, where it is one that a log may hold; else a new one, which is no secret."""
    own = request.headers.get("x-request-id", "")
    return own if re.fullmatch(r"[A-Za-z0-9._:/+=-]{1,100}", own) else f"{random.getrandbits(64):016x}"


def refused_header(scope: Scope) -> Response | None:
    """The refusal of a request with a header that is too long to be looked at."""
    for name, value in scope["headers"]:
        if len(name) + len(value) > MAX_HEADER_BYTES:
            detail = f"{name[:50].decode('latin-1')}: at most {MAX_HEADER_BYTES} bytes a header; got more"
            return problem(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, detail)
    return None


class Compression(GZipMiddleware):
    """Starlette's, which would take `gzip;q=0` for a wish to have gzip."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            accepted = qualities(Headers(scope=scope).get("accept-encoding", ""))
            if not accepted.get("gzip", 0.0):
                scope["headers"] = [pair for pair in scope["headers"] if pair[0] != b"accept-encoding"]
        await super().__call__(scope, receive, send)


class CrossOrigin(CORSMiddleware):
    """Starlette's, whose refusals are problems like all others."""

    def preflight_response(self, request_headers: Headers) -> Response:
        answer = super().preflight_response(request_headers)
        if answer.status_code < HTTPStatus.BAD_REQUEST:
            return answer
        return problem(answer.status_code, bytes(answer.body).decode(), headers={"vary": "Origin"})

"""Around every request: its id, log line, figures and headers; gzip, HEAD, and pages of other origins."""

from __future__ import annotations

import asyncio
import logging
import random
import re
from http import HTTPStatus
from time import perf_counter

from starlette.datastructures import Headers
from starlette.middleware.cors import CORSMiddleware
from starlette.middleware.gzip import DEFAULT_EXCLUDED_CONTENT_TYPES, GZipMiddleware
from starlette.requests import ClientDisconnect
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from attitude.formats.registry import FORMATS

from .compute import Compute, Job, current
from .errors import problem
from .logs import FIELDS, plain
from .metrics import Metrics
from .query import accepts_gzip
from .settings import variable

log = logging.getLogger(__name__)

ID = b"x-request-id"
SANE_ID = re.compile(rb"[A-Za-z0-9._:/+=-]{1,100}")
LONGEST_LOGGED_PATH = 200
LONGEST_HEADER_BYTES = 8192

RawHeaders = list[tuple[bytes, bytes]]


# -- headers that every answer has -------------------------------------------------------------------

EVERYWHERE = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
}
# Pages load everything from here; scripts are files, never text in a page.  Drawings may be made in place.
PAGES = {
    "content-security-policy": "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "cross-origin-opener-policy": "same-origin",
    "x-frame-options": "DENY",
}
# What is no page is shown as none, even where a browser is led to open it as one.
OTHERS = {"content-security-policy": "default-src 'none'; frame-ancestors 'none'; sandbox"}


def policy(media: str) -> dict[str, str]:
    """Of an answer of this media type, and of a 304 in its place, whose headers replace those kept."""
    return PAGES if media.startswith("text/html") else OTHERS


def secured(headers: RawHeaders, status: int) -> RawHeaders:
    """With what a handler has not set itself; a 304 is of no media type, and is given no policy here."""
    names = dict(headers)
    ours = dict(EVERYWHERE)
    if status != HTTPStatus.NOT_MODIFIED:
        ours |= policy(names.get(b"content-type", b"").decode("latin-1"))
    pairs = ((name.encode(), value.encode()) for name, value in ours.items())
    return headers + [pair for pair in pairs if pair[0] not in names]


# -- the outermost layer -------------------------------------------------------------------------------


class Requests:
    """Gives every request its id, its line in the log and its figures, and every answer its headers."""

    def __init__(self, app: ASGIApp, metrics: Metrics, compute: Compute):
        self.app, self.metrics, self.compute = app, metrics, compute

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        job = Job(_identity(scope), receive, self.compute.settings.max_seconds)
        current.set(job)
        answer = _Answer(send, job, self.compute.settings.client_seconds)
        begun = perf_counter()
        try:
            await (_checked(scope) or self.app)(scope, job.receive, answer.send)
        finally:
            self.compute.leave(job)
            seconds, route = perf_counter() - begun, getattr(scope.get("route"), "path", "none")
            self.metrics.observe(
                scope["method"], route, answer.outcome(), seconds, job.samples, job.deadline.spent()
            )
            fields = {
                "method": scope["method"][:LONGEST_LOGGED_PATH],
                "path": plain(scope["path"][:LONGEST_LOGGED_PATH]),
                "route": route,
                "status": answer.outcome(),
                "seconds": round(seconds, 6),
                "bytes": answer.bytes,
                "compute_seconds": round(job.deadline.spent(), 6),
            }
            log.info("request", extra={FIELDS: fields})


class _Answer:
    """An answer on its way: what it has been so far."""

    def __init__(self, send: Send, job: Job, client_seconds: int):
        self._send, self._job, self._seconds = send, job, client_seconds
        self.status = 0
        self.bytes = 0
        self.is_whole = False

    async def send(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self.status = message["status"]
            headers = secured(list(message.get("headers", [])), self.status)
            message["headers"] = [*headers, (ID, self._job.identity.encode())]
        elif message["type"] == "http.response.body":
            self.bytes += len(message.get("body", b""))
        try:
            async with asyncio.timeout(self._seconds):
                await self._send(message)
        except TimeoutError:  # its memory and its place are not kept for a client that does not read
            log.info("a client took nothing for %s s (%s)", self._seconds, variable("client_seconds"))
            raise ClientDisconnect from None
        self.is_whole = message["type"] == "http.response.body" and not message.get("more_body", False)

    def outcome(self) -> int | str:
        """The status; "gone" where the client did not wait for one, "cut" for an answer that did not end."""
        if self.is_whole:
            return self.status
        return "gone" if self._job.is_abandoned or not self.status else "cut"


def _identity(scope: Scope) -> str:
    """The client's own, where it is one that a log may hold; else a new one, which is no secret."""
    for name, value in scope["headers"]:
        if name == ID and SANE_ID.fullmatch(value):
            return str(value, "ascii")
    return f"{random.getrandbits(64):016x}"


def _checked(scope: Scope) -> Response | None:
    """The refusal of a request with a header that is too long to be looked at."""
    for name, value in scope["headers"]:
        if len(name) + len(value) > LONGEST_HEADER_BYTES:
            detail = f"{name[:50].decode('latin-1')}: at most {LONGEST_HEADER_BYTES} bytes a header; got more"
            return problem(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, detail)
    return None


# -- inner layers --------------------------------------------------------------------------------------


class Compression(GZipMiddleware):
    """Starlette's, for text; it would take `gzip;q=0` for a wish to have gzip, and know nothing of `*`."""

    def __init__(self, app: ASGIApp):
        binary = {each.media for each in FORMATS.values() if not each.media.startswith("text/")} - {
            "application/json",
            "application/x-ndjson",
            "application/xml",
            "application/vnd.czml+json",
        }
        excluded = (*DEFAULT_EXCLUDED_CONTENT_TYPES, *binary)
        # Packed, digits take half their room; the first level takes a quarter of the sixth's time.
        super().__init__(app, minimum_size=1024, compresslevel=1, exclude_content_types=excluded)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        accepted = accepts_gzip(Headers(scope=scope).get("accept-encoding", ""))
        others = [pair for pair in scope["headers"] if pair[0] != b"accept-encoding"]
        scope["headers"] = [*others, (b"accept-encoding", b"gzip")] if accepted else others
        await super().__call__(scope, receive, send)


class HeadAsGet:
    """Answers HEAD wherever GET is answered, with the same headers and nothing after them."""

    def __init__(self, app: ASGIApp):
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self.app(scope, receive, send)
            return

        async def without_body(message: Message) -> None:
            if message["type"] == "http.response.body":
                message = {**message, "body": b""}
            await send(message)

        as_get = {**scope, "method": "GET"}
        await self.app(as_get, receive, without_body)
        scope["route"] = as_get.get("route")  # for the log


class CrossOrigin(CORSMiddleware):
    """Starlette's, whose refusals are problems like all others."""

    def __init__(self, app: ASGIApp, origins: tuple[str, ...]):
        sent = ("Accept", "Authorization", "Content-Type", "If-None-Match", "X-Request-ID")
        shown = "Attitude-Cost Attitude-Plan Attitude-Version Content-Disposition ETag Retry-After"
        exposed = [*shown.split(), "WWW-Authenticate", "X-Request-ID"]
        super().__init__(app, origins, ("GET", "HEAD", "POST"), sent, expose_headers=exposed)

    def preflight_response(self, request_headers: Headers) -> Response:
        answer = super().preflight_response(request_headers)
        if answer.status_code < HTTPStatus.BAD_REQUEST:
            return answer
        return problem(answer.status_code, bytes(answer.body).decode(), headers={"vary": "Origin"})

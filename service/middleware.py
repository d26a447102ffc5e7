"""Around every request: its id, log line, figures and headers; and the answer to unexpected errors."""

from __future__ import annotations

import asyncio
import json
import logging
import random
import re
from http import HTTPStatus
from time import perf_counter

from starlette.datastructures import MutableHeaders
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

import attitude

from . import metrics
from .compute import Compute, CutError, Job, current
from .dependencies import qualities
from .errors import problem, unexpected
from .settings import variable

log = logging.getLogger(__name__)

MAX_HEADER_BYTES = 8192
EVERY_ANSWER = {
    "attitude-version": attitude.__version__,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "x-frame-options": "DENY",
}
# Pages load everything from here; scripts are files, never text in a page.  Drawings may be made in place.
# What is no page is shown as none, even where a browser is led to open it as one.
POLICIES = {
    "text/html": "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'",
    "": "default-src 'none'; frame-ancestors 'none'; sandbox",
}


class Requests:
    """Gives every request its id, its line in the log and its figures, and every answer its headers.

    HEAD is answered as GET is; the server sends no body after it.  An answer that cannot go on is left as it
    is: the server closes its connection without the last chunk, by which a client knows.
    """

    def __init__(self, app: ASGIApp, compute: Compute):
        self.app, self.compute = app, compute

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        method = scope["method"]
        request = Request({**scope, "method": "GET" if method == "HEAD" else method}, receive)
        own = request.headers.get("x-request-id", "")  # a new one is no secret
        is_sane = re.fullmatch(r"[A-Za-z0-9._:/+=-]{1,100}", own)
        settings, identity = self.compute.settings, own if is_sane else f"{random.getrandbits(64):016x}"
        job = Job(identity, request, self.compute)
        current.set(job)
        answer = Answer(send, job, settings.client_seconds)
        begun = perf_counter()
        try:
            await self.answer(request, answer)
        finally:
            self.compute.leave(job)
            record(request.scope, method, answer, perf_counter() - begun)

    async def answer(self, request: Request, answer: Answer) -> None:
        """Send the application's answer, or what is answered where it fails before its first byte."""
        refusal = None
        try:
            await (refused_header(request) or self.app)(request.scope, request.receive, answer.send)
        except ClientDisconnect:
            log.info("the client went away before its answer was whole")
            if answer.status and not answer.job.is_abandoned:
                answer.unfinished = "cut"
        except asyncio.CancelledError:  # by the server, whose grace is over
            log.warning("the service stops before the answer is whole")
            detail, answer.unfinished = "the service stops before this is computed; try again", "cut"
            refusal = problem(HTTPStatus.SERVICE_UNAVAILABLE, detail, headers={"retry-after": "1"})
        except CutError as error:
            log.warning("the answer is cut: %s", error)
            answer.unfinished = "cut"
        except Exception:
            refusal, answer.unfinished = unexpected(request), "cut"
        if refusal is not None and not answer.status:
            await refusal(request.scope, request.receive, answer.send)


def record(scope: Scope, method: str, answer: Answer, seconds: float) -> None:
    """Put a request that is over into the log and into the figures."""
    job, route = answer.job, getattr(scope.get("route"), "path", "none")
    for text in job.warnings:
        log.warning("%s", text)
    metrics.observe(method, route, answer.outcome, seconds)
    metrics.samples.inc(job.samples)
    metrics.computing.inc(job.spent())
    fields = {
        "method": method[:200],
        "path": scope["path"][:200],
        "route": route,
        "status": answer.outcome,
        "seconds": round(seconds, 6),
        "bytes": answer.bytes,
        "compute_seconds": round(job.spent(), 6),
    }
    log.info("request", extra={"fields": fields})


class Answer:
    """An answer on its way: its status, how much of it was sent, and whether that is all.

    unfinished : why it is not whole, "gone" where its client is, "cut" where it cannot go on
    """

    def __init__(self, send: Send, job: Job, max_seconds: int):
        self._send, self.job, self.max_seconds = send, job, max_seconds
        self.status = self.bytes = 0
        self.is_whole, self.unfinished = False, "gone"

    @property
    def outcome(self) -> int | str:
        """Its status, or why it is not whole."""
        return self.status if self.is_whole else self.unfinished

    async def send(self, message: Message) -> None:
        """Send with the headers that all answers have; ClientDisconnect where the client does not take it."""
        if message["type"] == "http.response.start":
            self.status = message["status"]
            headers = MutableHeaders(raw=message.setdefault("headers", []))
            for name, value in {**EVERY_ANSWER, "x-request-id": self.job.identity}.items():
                headers.setdefault(name, value)
            if self.job.warnings:
                headers["attitude-warnings"] = listed(self.job.warnings)
            if self.status != HTTPStatus.NOT_MODIFIED:  # which leaves it as the browser has kept it
                media = headers.get("content-type", "").partition(";")[0]
                headers.setdefault("content-security-policy", POLICIES.get(media, POLICIES[""]))
        elif message["type"] == "http.response.body":
            self.bytes += len(message.get("body", b""))
        try:
            async with asyncio.timeout(self.max_seconds):
                await self._send(message)
        except TimeoutError:  # its memory and its place are not kept for a client that does not read
            log.info("a client took nothing for %s s (%s)", self.max_seconds, variable("client_seconds"))
            raise ClientDisconnect from None
        self.is_whole = message["type"] == "http.response.body" and not message.get("more_body", False)


def listed(warnings: list[str]) -> str:
    """A list in JSON of as many as a header may hold.

    That is 3000 bytes; JSON escapes a character by six of them at most.
    """
    texts = [warning[:480] for warning in warnings]
    while len(text := json.dumps(texts)) > 3000:
        texts.pop()
    return text


def refused_header(request: Request) -> Response | None:
    """The refusal of a request with a header that is too long to be looked at; gzip;q=0 is no wish for it."""
    for name, value in request.headers.raw:
        if len(name) + len(value) > MAX_HEADER_BYTES:
            detail = f"{name[:50].decode('latin-1')}: at most {MAX_HEADER_BYTES} bytes a header; got more"
            return problem(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, detail)
    if not qualities(request.headers.get("accept-encoding", "")).get("gzip"):
        request.scope["headers"] = [pair for pair in request.headers.raw if pair[0] != b"accept-encoding"]
    return None

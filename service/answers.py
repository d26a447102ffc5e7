"""Answers on their way out: blocks as they are computed, tags, names, and gzip where it is asked for."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator
from functools import lru_cache
from hashlib import blake2b
from http import HTTPStatus
from typing import Any, NamedTuple

import orjson
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

import attitude

from .compute import Compute
from .headers import policy
from .negotiation import accepts_gzip

JSON = "application/json"
VERSION, PLAN, COST = "attitude-version", "attitude-plan", "attitude-cost"
VERSIONED = {VERSION: attitude.__version__}
# Packed, digits take half their room; the first level takes a quarter of the time that the usual sixth does.
LEVEL = 1
GZIP = 31  # zlib's word for a gzip wrapper around the greatest window
WORTH_PACKING = 1024  # bytes
TEXT = (
    "text/",
    JSON,
    "application/x-ndjson",
    "application/xml",
    "application/vnd.czml+json",
    "image/svg+xml",
)


class Computed(NamedTuple):
    """An answer whose first block is there: whatever could be refused has been."""

    blocks: Iterator[Any]
    is_whole: bool
    media: str
    headers: dict[str, str]


def tag_of(*parts: str | bytes) -> str:
    """A weak one: what computing took is in the answer too, and is never the same twice."""
    digest = blake2b(digest_size=16)
    for part in (attitude.__version__, *parts):
        data = part.encode("utf-8", "backslashreplace") if isinstance(part, str) else part
        digest.update(b"%d:" % len(data) + data)
    return f'W/"{digest.hexdigest()}"'


def is_seen(tag: str, seen: str) -> bool:
    """Whether If-None-Match names the tag, weakly compared (RFC 9110, 13.1.2)."""
    return bool(seen) and tag.removeprefix("W/") in (
        each.strip().removeprefix("W/") for each in seen.split(",")
    )


# -- what was computed ----------------------------------------------------------------------------


def packed(computed: Computed, gzip: bool) -> Computed:
    """The same, with gzip around it where that was asked for and makes it smaller."""
    if not computed.media.startswith(TEXT):
        return computed
    headers = computed.headers | {"vary": "accept, accept-encoding"}
    if not gzip:
        return computed._replace(headers=headers)
    if computed.is_whole:
        content = next(computed.blocks)
        if len(content) < WORTH_PACKING:
            return computed._replace(headers=headers, blocks=iter([content]))
        computed = computed._replace(blocks=iter([content]))
    blocks = _compressed(computed.blocks)
    blocks = iter([b"".join(blocks)]) if computed.is_whole else blocks
    return computed._replace(headers=headers | {"content-encoding": "gzip"}, blocks=blocks)


def _compressed(blocks: Iterable[Any], level: int = LEVEL) -> Iterator[bytes]:
    compressor = zlib.compressobj(level, zlib.DEFLATED, GZIP)
    for block in blocks:
        if data := compressor.compress(block):
            yield data
    yield compressor.flush()


def sent(computed: Computed, compute: Compute) -> Response:
    """In one piece, with its length, or in blocks, each computed when the one before is on its way."""
    headers = computed.headers | {"content-type": computed.media}
    if computed.is_whole:
        return Response(next(computed.blocks, b""), HTTPStatus.OK, headers)
    return StreamingResponse(compute.blocks(computed.blocks), HTTPStatus.OK, headers)


def unchanged(tag: str, media: str = JSON, vary: str = "accept, accept-encoding") -> Response:
    """In place of an answer of this media type, whose policy it repeats."""
    return Response(b"", HTTPStatus.NOT_MODIFIED, {"etag": tag, "vary": vary, **policy(media)})


def json_answer(document: bytes | dict[str, Any]) -> Response:
    content = document if isinstance(document, bytes) else orjson.dumps(document)
    return Response(content, HTTPStatus.OK, VERSIONED, JSON)


# -- what never changes while the service runs ------------------------------------------------------


def fixed(request: Request, content: bytes | str, media: str = JSON) -> Response:
    """With a tag, packed once, and not sent again to who has it."""
    data = content.encode() if isinstance(content, str) else content
    tag, small = _ready(data)
    if is_seen(tag, request.headers.get("if-none-match", "")):
        return unchanged(tag, media, "accept-encoding")
    headers = {"etag": tag, "vary": "accept-encoding", **VERSIONED}
    if small and media.startswith(TEXT) and accepts_gzip(request.headers.get("accept-encoding", "")):
        return Response(small, HTTPStatus.OK, headers | {"content-encoding": "gzip"}, media)
    return Response(data, HTTPStatus.OK, headers, media)


@lru_cache(maxsize=64)
def _ready(content: bytes) -> tuple[str, bytes]:
    """The tag, and the content packed as small as it gets; nothing where that is not worth it."""
    small = b"" if len(content) < WORTH_PACKING else b"".join(_compressed([content], 9))
    return tag_of(content), small


# -- HEAD -------------------------------------------------------------------------------------------


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

        asked = {**scope, "method": "GET"}
        await self.app(asked, receive, without_body)
        scope["route"] = asked.get("route")  # for the log

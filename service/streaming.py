"""Responses: in blocks as they are computed, or whole; tags, and 304 for who has the answer already."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from hashlib import blake2b
from http import HTTPStatus
from typing import Any, NamedTuple

from starlette.requests import Request
from starlette.responses import Response, StreamingResponse

import attitude

from .compute import Compute
from .middleware import policy

JSON = "application/json"
VERSION, PLAN, COST = "attitude-version", "attitude-plan", "attitude-cost"
VERSIONED = {VERSION: attitude.__version__}


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


def has_tag(tag: str, if_none_match: str) -> bool:
    """Whether If-None-Match names the tag, weakly compared (RFC 9110, 13.1.2)."""
    tags = (each.strip().removeprefix("W/") for each in if_none_match.split(","))
    return bool(if_none_match) and tag.removeprefix("W/") in tags


def response(computed: Computed, compute: Compute) -> Response:
    """In one piece, with its length, or in blocks, each computed when the one before is on its way."""
    headers = {"vary": "accept, accept-encoding"} | computed.headers | {"content-type": computed.media}
    if computed.is_whole:
        return Response(next(computed.blocks, b""), HTTPStatus.OK, headers)
    return StreamingResponse(compute.blocks(computed.blocks), HTTPStatus.OK, headers)


def unchanged(tag: str, media: str = JSON, vary: str = "accept, accept-encoding", **headers: str) -> Response:
    """In place of an answer of this media type, whose policy it repeats."""
    ours = {"etag": tag, "vary": vary, **policy(media), **headers}
    return Response(b"", HTTPStatus.NOT_MODIFIED, ours)


def json_response(content: bytes) -> Response:
    return Response(content, HTTPStatus.OK, VERSIONED, JSON)


@lru_cache(maxsize=64)
def _tag_of_fixed(content: bytes) -> str:
    return tag_of(content)


def fixed(request: Request, content: bytes, media: str = JSON, **headers: str) -> Response:
    """What never changes while the service runs: with a tag, and not sent again to who has it."""
    tag = _tag_of_fixed(content)
    if has_tag(tag, request.headers.get("if-none-match", "")):
        return unchanged(tag, media, "accept-encoding", **headers)
    ours = {"etag": tag, "vary": "accept-encoding", **VERSIONED, **headers}
    return Response(content, HTTPStatus.OK, ours, media)

"""Responses: in blocks as they are computed, or whole; tags, and 304 for who has the answer already."""

from collections.abc import Callable, Iterator
from hashlib import blake2b
from http import HTTPStatus
from typing import Any, NamedTuple

from starlette.requests import Request
from starlette.responses import Response, StreamingResponse

import attitude

from .compute import Compute

JSON = "application/json"


class Computed(NamedTuple):
    """An answer whose first block is there: whatever could be refused has been."""

    blocks: Iterator[Any]
    is_whole: bool
    media: str
    headers: dict[str, str]
    status: int = HTTPStatus.OK


def tag_of(*parts: str | bytes) -> str:
    """A weak one: what computing took is in the answer too, and is never the same twice."""
    digest = blake2b(digest_size=16)
    for part in (attitude.__version__, *parts):
        data = part.encode("utf-8", "backslashreplace") if isinstance(part, str) else part
        digest.update(b"%d:" % len(data) + data)
    return f'W/"{digest.hexdigest()}"'


def is_known(tag: str, request: Request) -> bool:
    """Whether If-None-Match names the tag, weakly compared (RFC 9110, 13.1.2)."""
    tags = request.headers.get("if-none-match", "").split(",")
    return tag.removeprefix("W/") in {each.strip().removeprefix("W/") for each in tags}


async def answered(
    work: Callable[[Request, Any, Any], Computed | bytes], request: Request, source: Any, query: Any
) -> Response:
    """What a call answers that computes, beside the event loop and within the settings' limits.

    In one piece, with its length, or in blocks, each computed when the one before is on its way.
    """
    compute: Compute = request.app.state.compute
    computed = await compute.run(work, request, source, query)
    if isinstance(computed, bytes):
        return json_response(computed)
    headers = {"vary": "accept, accept-encoding", "attitude-version": attitude.__version__}
    headers |= {"content-type": computed.media, **computed.headers}
    if computed.is_whole:
        return Response(next(computed.blocks, b""), computed.status, headers)
    return StreamingResponse(compute.blocks(computed.blocks), computed.status, headers)


def json_response(content: bytes) -> Response:
    return Response(content, HTTPStatus.OK, {"attitude-version": attitude.__version__}, JSON)


def fixed(request: Request, content: bytes, media: str = JSON, **headers: str) -> Response:
    """What never changes while the service runs: with a tag, and not sent again to who has it."""
    tag = tag_of(content)
    headers |= {"etag": tag, "vary": "accept-encoding", "attitude-version": attitude.__version__}
    if is_known(tag, request):
        return Response(b"", HTTPStatus.NOT_MODIFIED, headers)
    return Response(content, HTTPStatus.OK, headers, media)

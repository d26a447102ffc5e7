"""Responses: in blocks as they are computed, or whole; tags, and 304 for who has the answer already."""

from hashlib import blake2b
from http import HTTPStatus
from typing import Any

import orjson
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse

import attitude
from attitude.formats.encoding import EncodedFile

JSON = "application/json"


class Whole(Response):
    """A response in one piece: plain data as JSON, bytes as they are."""

    media_type = JSON

    def render(self, content: Any) -> bytes:
        return content if isinstance(content, bytes) else orjson.dumps(content)


def file_response(request: Request, file: EncodedFile, **headers: str) -> Response:
    """A file in one piece, or in blocks, each computed when the one before is on its way.

    The first block is there: whatever could be refused has been.
    """
    disposition = f'{"inline" if file.media == JSON else "attachment"}; filename="{file.name}"'
    headers |= {"vary": "accept, accept-encoding", "content-disposition": disposition}
    headers["content-type"] = file.media
    if file.is_whole:
        return Response(next(file.blocks, b""), headers=headers)
    return StreamingResponse(request.app.state.compute.blocks(file.blocks), headers=headers)


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


def fixed(request: Request, content: bytes, media: str = JSON, **headers: str) -> Response:
    """What never changes while the service runs: with a tag, and not sent again to who has it."""
    headers |= {"etag": (tag := tag_of(content)), "vary": "accept-encoding"}
    if is_known(tag, request):
        return unchanged(**headers)
    return Response(content, headers=headers, media_type=media)  # text with its charset


def unchanged(**headers: str) -> Response:
    """The client has the answer of this tag already."""
    return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=headers)

"""Responses: in blocks as they are computed, or whole; tags, and 304 for who has the answer already."""

from hashlib import blake2b
from http import HTTPStatus

from starlette.requests import Request
from starlette.responses import Response, StreamingResponse

import attitude
from attitude.formats.encoding import EncodedFile

from .compute import Compute

JSON = "application/json"


def whole(content: bytes, media: str = JSON, **headers: str) -> Response:
    """A response in one piece, with its length."""
    return Response(content, headers={**common(media), **headers})


def common(media: str) -> dict[str, str]:
    """Headers of all responses of this type."""
    return {"content-type": media, "attitude-version": attitude.__version__}


def file_response(compute: Compute, file: EncodedFile, **headers: str) -> Response:
    """A file in one piece, or in blocks, each computed when the one before is on its way.

    The first block is there: whatever could be refused has been.
    """
    disposition = f'{"inline" if file.media == JSON else "attachment"}; filename="{file.name}"'
    headers |= {"vary": "accept, accept-encoding", "content-disposition": disposition}
    if file.is_whole:
        return whole(next(file.blocks, b""), file.media, **headers)
    return StreamingResponse(compute.blocks(file.blocks), headers={**common(file.media), **headers})


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
    tag = tag_of(content)
    headers |= {"etag": tag, "vary": "accept-encoding", "attitude-version": attitude.__version__}
    if is_known(tag, request):
        return unchanged(**headers)
    return Response(content, headers=headers, media_type=media)  # text with its charset


def unchanged(**headers: str) -> Response:
    """The client has the answer of this tag already."""
    return Response(b"", HTTPStatus.NOT_MODIFIED, {"attitude-version": attitude.__version__, **headers})

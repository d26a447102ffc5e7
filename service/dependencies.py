"""What handlers depend on: the body within its limits, parameters once each, and the format to answer in."""

import asyncio
import re
from collections import Counter
from functools import lru_cache
from http import HTTPStatus
from typing import Annotated, Any, NamedTuple

from fastapi import Depends, Query, Request
from starlette.datastructures import UploadFile
from starlette.exceptions import HTTPException
from starlette.types import Message

from attitude.errors import FormatError, InputError, unknown_name
from attitude.formats import find_source
from attitude.formats.registry import FORMATS, READ_ONLY, Format

from .schemas import NoQuery
from .settings import variable
from .streaming import JSON


async def once(request: Request) -> None:
    """InputError for a parameter that is there twice, where it is not a list."""
    counts = Counter(name for name, _ in request.query_params.multi_items() if name != "method")
    for name, count in counts.items():
        if count > 1:
            raise InputError(name, "the parameter twice", "each parameter once")


async def body(request: Request) -> bytes:
    """The request's body; reading stops where a limit is passed, whatever length was announced."""
    settings, content = request.app.state.settings, bytearray()
    limit = f"at most {settings.max_body_bytes} bytes ({variable('max_body_bytes')})"
    too_large = HTTPException(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"document: {limit}; got more")
    if int(request.headers.get("content-length", "0")) > settings.max_body_bytes:
        raise too_large
    try:
        async with asyncio.timeout(settings.client_seconds):
            async for chunk in request.stream():
                content += chunk
                if len(content) > settings.max_body_bytes:
                    raise too_large
    except TimeoutError:
        detail = f"document: whole within {settings.client_seconds} s ({variable('client_seconds')})"
        end = {"connection": "close"}  # what is still to come of the document is not waited for
        raise HTTPException(HTTPStatus.REQUEST_TIMEOUT, detail, end) from None
    return bytes(content)


async def document(request: Request) -> bytes:
    """The body, if it is JSON; the library parses it, in a thread and in its own words."""
    media = request.headers.get("content-type", "nothing")
    if media.partition(";")[0].strip().lower() != JSON:
        raise HTTPException(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, f"content-type: {JSON}; got {media[:200]}")
    request.state.has_document = True
    return await body(request)


class Upload(NamedTuple):
    """A file: its name, which may be empty, its media type, and its content."""

    name: str
    media: str
    content: bytes


def files_of(*names: str) -> Any:
    """The dependency on files of a form by these names, and SPICE's clock kernel where it is sent.

    A body that is no form is the first of them.
    """

    async def files(request: Request) -> dict[str, Upload]:
        content, media = await body(request), request.headers.get("content-type", "")
        uploads = {names[0]: Upload("", media, content)}
        if media.lower().startswith("multipart/form-data"):
            uploads = await parts(request, content, (*names, "sclk"))
        for name in names:
            if name not in uploads:
                raise InputError(name, None, "a file of the form, of this name")
        return uploads

    return Depends(files)


async def parts(request: Request, content: bytes, known: tuple[str, ...]) -> dict[str, Upload]:
    """The files of a form by their fields; InputError for an unknown one, and for two of one name."""

    async def receive() -> Message:
        return {"type": "http.request", "body": content, "more_body": False}

    uploads: dict[str, Upload] = {}
    async with Request(request.scope, receive).form(max_files=3, max_fields=0) as form:
        for field, part in form.multi_items():
            if field not in known:
                raise unknown_name(field, "file", field, known)
            if field in uploads:
                raise InputError(field, "the file twice", "each file once")
            if isinstance(part, UploadFile):
                uploads[field] = Upload(part.filename or "", part.content_type or "", await part.read())
    return uploads


Document = Annotated[bytes, Depends(document)]
File = Annotated[dict[str, Upload], files_of("file")]
TwoFiles = Annotated[dict[str, Upload], files_of("file", "other")]
Nothing = Annotated[NoQuery, Query()]


def named_format(parameter: str, name: str) -> Format:
    known = FORMATS | READ_ONLY if parameter == "source" else FORMATS
    if name not in known:
        raise unknown_name(parameter, "format", name, known)
    return known[name]


def format_of(file: Upload, name: str | None) -> Format:
    """The format of a file: as named, else by its name, else by its media type."""
    if name is not None:
        return named_format("source", name)
    try:
        return find_source(file.name, None)
    except FormatError:
        by_media = {each.media: each for each in (FORMATS | READ_ONLY).values()}
        entry = by_media.get(file.media.partition(";")[0].strip().lower())
    if entry is None:
        expected = "the format of the file, here or by its name or type"
        raise InputError("source", file.name or file.media or None, expected)
    return entry


@lru_cache(maxsize=256)
def negotiated(name: str | None, accept: str) -> Format:
    """The format that `?format=` names, else the best that Accept names (RFC 9110, 12.5.1).

    Raises InputError for a name that is none, HTTPException 406 where nothing accepted is known.
    """
    if name is not None:
        return named_format("format", name)
    ranges = qualities(accept) if accept.strip() else {JSON: 1.0}

    def weight(each: Format) -> tuple[float, bool]:
        family = ranges.get(each.media.partition("/")[0] + "/*", ranges.get("*/*", 0.0))
        return ranges.get(each.media, family), each.name == "json"

    best = max(FORMATS.values(), key=weight)  # the first of equals, JSON before all
    if not weight(best)[0]:
        offered = ", ".join(each.media for each in FORMATS.values())
        raise HTTPException(HTTPStatus.NOT_ACCEPTABLE, f"accept: one of {offered}; got {accept[:200]}")
    return best


def qualities(header: str) -> dict[str, float]:
    """Weights of the members of Accept or Accept-Encoding (RFC 9110, 12.4.2); of twins the least."""
    weights: dict[str, float] = {}
    for member in re.sub(r"[ \t]", "", header.lower()).split(","):
        name, *others = member.split(";")
        quality = next((other[2:] for other in others if other.startswith("q=")), "1")
        is_number = re.fullmatch(r"[01](\.\d*)?", quality, re.ASCII)
        weights[name] = min(float(quality) if is_number else 0.0, weights.get(name, 1.0))
    return weights

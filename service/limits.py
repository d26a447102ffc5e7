"""What is refused for its size: a document before it is read whole, a scene before it is computed.

The refusal names the limit, its number, and the variable that sets it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from http import HTTPStatus
from typing import Any

from starlette.exceptions import HTTPException
from starlette.requests import Request

from attitude.documents.fields import parse_json
from attitude.errors import InputError
from attitude.scene.document import Scene

from .compute import current
from .settings import Settings, variable


async def read_body(request: Request, settings: Settings) -> bytes:
    """The request's body; reading stops where the limit is passed, whatever length was announced."""
    announced = request.headers.get("content-length", "")
    if announced.isdigit() and int(announced) > settings.max_body_bytes:
        raise _too_large(settings)
    try:
        async with asyncio.timeout(settings.client_seconds):
            return await _whole(request, settings)
    except TimeoutError:
        limit = f"whole within {settings.client_seconds} s ({variable('client_seconds')})"
        end = {"connection": "close"}  # what is still to come of the document is not waited for
        raise HTTPException(HTTPStatus.REQUEST_TIMEOUT, f"document: {limit}", headers=end) from None


async def _whole(request: Request, settings: Settings) -> bytes:
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > settings.max_body_bytes:
            raise _too_large(settings)
    return bytes(body)


def _too_large(settings: Settings) -> HTTPException:
    limit = f"at most {settings.max_body_bytes} bytes ({variable('max_body_bytes')})"
    return HTTPException(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"document: {limit}; got more")


def scene_of(document: bytes, settings: Settings) -> Scene:
    """The scene of a document's text.  Raises FormatError or InputError where there is none in it."""
    return scene_within(parse_json(document, "document"), settings)


def scene_within(document: Any, settings: Settings) -> Scene:
    """The scene of plain data, whose lengths are looked at before their members."""
    times = document.get("times") if isinstance(document, dict) else None
    for instants in (times.get("elapsed"), times.get("dates")) if isinstance(times, dict) else ():
        if (count := _length(instants)) > settings.max_samples:
            limit = f"at most {settings.max_samples} samples ({variable('max_samples')})"
            raise InputError("times", f"{count} samples", limit)
    if isinstance(document, dict) and (count := _length(document.get("effects"))) > settings.max_effects:
        limit = f"at most {settings.max_effects} effects ({variable('max_effects')})"
        raise InputError("effects", f"{count} effects", limit)
    return Scene.model_validate(document)


def _length(value: Any) -> int:
    return len(value) if isinstance(value, list) else 0


def check_predicted(settings: Settings) -> Callable[[float], None]:
    """What `Scene.run` is to ask before it computes: InputError for more seconds than one scene may need."""

    def check(seconds: float) -> None:
        if not seconds <= settings.max_seconds:
            limit = f"a scene predicted to take at most {settings.max_seconds} s ({variable('max_seconds')})"
            raise InputError("times", f"{seconds:.3g} s", limit)

    return check


def check_predicted_together(settings: Settings) -> Callable[[float], None]:
    """The same for several scenes in turn: what they need together is what may not be more."""
    check, needed = check_predicted(settings), 0.0

    def check_all(seconds: float) -> None:
        nonlocal needed
        check(needed + seconds)
        needed += seconds

    return check_all


def check_wanted(_done: float = 0.0) -> None:
    """What the library is to call between pieces of its work, as its `progress`.

    Raises ClientDisconnect where no client waits for the answer any more, InputError where its seconds are
    used up.
    """
    job = current.get()
    if job is not None:
        job.check()

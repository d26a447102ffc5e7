"""What is refused for its size: a document before it is read whole, a scene before it is computed.

The refusal names the limit, its number, and the variable that sets it.
"""

from __future__ import annotations

import asyncio
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
    body = bytearray()
    try:
        async with asyncio.timeout(settings.client_seconds):
            _check_size(int(request.headers.get("content-length", "0")), settings)
            async for chunk in request.stream():
                body += chunk
                _check_size(len(body), settings)
    except TimeoutError:
        detail = f"document: whole within {settings.client_seconds} s ({variable('client_seconds')})"
        end = {"connection": "close"}  # what is still to come of the document is not waited for
        raise HTTPException(HTTPStatus.REQUEST_TIMEOUT, detail, end) from None
    return bytes(body)


def _check_size(size: int, settings: Settings) -> None:
    if size > settings.max_body_bytes:
        limit = f"at most {settings.max_body_bytes} bytes ({variable('max_body_bytes')})"
        raise HTTPException(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"document: {limit}; got more")


def scene_of(document: bytes, settings: Settings) -> Scene:
    """The scene of a document's text.  Raises FormatError or InputError where there is none in it."""
    return scene_within(parse_json(document, "document"), settings)


def scene_within(document: Any, settings: Settings) -> Scene:
    """The scene of plain data, whose lengths are looked at before their members."""
    if isinstance(document, dict):
        check_length("effects", document.get("effects"), "effects", settings)
        if isinstance(times := document.get("times"), dict):
            check_length("times", times.get("elapsed"), "samples", settings)
            check_length("times", times.get("dates"), "samples", settings)
    return Scene.model_validate(document)


def check_length(field: str, value: Any, noun: str, settings: Settings) -> None:
    """InputError for a list of more members than the setting max_`noun` allows."""
    limit = getattr(settings, f"max_{noun}")
    if isinstance(value, list) and len(value) > limit:
        raise InputError(field, f"{len(value)} {noun}", f"at most {limit} {noun} ({variable(f'max_{noun}')})")


class Budget:
    """The seconds that the scenes of one request may need together."""

    def __init__(self, settings: Settings):
        self.max_seconds, self.predicted = settings.max_seconds, 0.0

    def check(self, seconds: float) -> None:
        """Add what one scene is predicted to need; InputError where all need more than they may."""
        predicted = self.predicted + seconds
        if not predicted <= self.max_seconds:
            limit = f"a scene predicted to take at most {self.max_seconds} s ({variable('max_seconds')})"
            raise InputError("times", f"{predicted:.3g} s", limit)
        self.predicted = predicted


def check_wanted(_done: float = 0.0) -> None:
    """What the library calls between pieces of its work, as its `progress`: raises as `Job.check`."""
    if (job := current.get()) is not None:
        job.check()

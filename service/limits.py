"""A document that is refused for its size, before it is read whole.

The refusal names the limit, its number, and the variable that sets it.
"""

from __future__ import annotations

from http import HTTPStatus

from starlette.exceptions import HTTPException
from starlette.requests import Request

from .settings import Settings, variable


async def read_body(request: Request, settings: Settings) -> bytes:
    """The request's body; reading stops where the limit is passed, whatever length was announced."""
    announced = request.headers.get("content-length", "")
    if announced.isdigit() and int(announced) > settings.max_body_bytes:
        raise _too_large(settings)
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > settings.max_body_bytes:
            raise _too_large(settings)
    return bytes(body)


def _too_large(settings: Settings) -> HTTPException:
    limit = f"at most {settings.max_body_bytes} bytes ({variable('max_body_bytes')})"
    return HTTPException(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"document: {limit}; got more")

"""What can go wrong, as HTTP answers: one table, and every answer a problem (RFC 9457).

The library's text goes out as it stands, so that library, command and HTTP refuse in the same
words; an unexpected error goes out as fixed text and an id that the log has.
"""

from __future__ import annotations

import logging
import secrets
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any

import orjson
from fastapi import FastAPI
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from attitude.errors import AttitudeError, FormatError, InputError, RegimeError, ToleranceError

log = logging.getLogger(__name__)

MEDIA_TYPE = "application/problem+json"
TYPE_PREFIX = "urn:problem-type:attitude:"
UNEXPECTED = "an unexpected error; the service's log has it under this id"


@dataclass(frozen=True)
class Kind:
    """A kind of problem: its status, the end of its type URI, and the title that all its cases share."""

    status: int
    name: str
    title: str


# The one table.  A class is looked up by its own name first, then by its parents'.
TABLE: dict[type[AttitudeError], Kind] = {
    FormatError: Kind(400, "format", "The document cannot be read"),
    InputError: Kind(422, "input", "A value in the document cannot be taken"),
    RegimeError: Kind(422, "regime", "The question has no answer for this motion"),
    ToleranceError: Kind(422, "tolerance", "The answer would not have the accuracy that is promised"),
    AttitudeError: Kind(422, "other", "The library refuses this document"),
}


def problem(
    status: int,
    detail: str,
    kind: Kind | None = None,
    headers: dict[str, str] | None = None,
    **more: Any,
) -> Response:
    """An answer that says what was wrong; members of `more` that are None are left out.

    Without a kind the type is about:blank: the status says it all.
    """
    document = {
        "type": TYPE_PREFIX + kind.name if kind else "about:blank",
        "title": kind.title if kind else HTTPStatus(status).phrase,
        "status": status,
        "detail": _sendable(detail),
    }
    document |= {name: _sendable(value) for name, value in more.items() if value is not None}
    return Response(orjson.dumps(document), status, headers, MEDIA_TYPE)


def _sendable(value: Any) -> Any:
    """Text that UTF-8 can hold: a document may name a key with half a surrogate pair, which it cannot."""
    return value.encode("utf-8", "backslashreplace").decode() if isinstance(value, str) else value


def refusal(_request: Request, error: Exception) -> Response:
    """The library's refusal, with the table's status."""
    kind = next(TABLE[parent] for parent in type(error).__mro__ if parent in TABLE)
    pointer, line = getattr(error, "pointer", None), getattr(error, "line", None)
    return problem(kind.status, str(error), kind, pointer=pointer, line=line)


def http_refusal(request: Request, error: Exception) -> Response:
    """What the framework or a handler refuses by its status: no such path, method, content type, size."""
    assert isinstance(error, HTTPException)  # noqa: S101 (for the type checker)
    headers = dict(error.headers or {})
    return problem(error.status_code, _explained(request, error), headers=headers)


def _explained(request: Request, error: HTTPException) -> str:
    """The framework's own text repeats the title; say what was asked for instead."""
    if error.detail != HTTPStatus(error.status_code).phrase:
        return error.detail
    if error.status_code == HTTPStatus.METHOD_NOT_ALLOWED:
        allowed = (error.headers or {}).get("Allow", "another method")
        return f"{request.method} is not answered at {request.url.path}; {allowed} is"
    if error.status_code == HTTPStatus.NOT_FOUND:
        return f"nothing is at {request.url.path}; /openapi.json lists what there is"
    return error.detail


class UnexpectedErrors:
    """Turns an unexpected error into a fixed text and an id, which the log has beside the traceback.

    A middleware rather than an exception handler: the framework's handler for Exception raises
    the error again after answering, and it would be logged twice.
    """

    def __init__(self, app: ASGIApp):
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        started = False

        async def watched(message: Message) -> None:
            nonlocal started
            started = True
            await send(message)

        try:
            await self.app(scope, receive, watched)
        except ClientDisconnect:
            log.info("the client went away before its document was whole")
        except Exception:
            if started or scope["type"] != "http":
                raise
            await unexpected(scope)(scope, receive, send)


def unexpected(scope: Scope) -> Response:
    """Called where an error is handled, which goes into the log."""
    identity = secrets.token_hex(8)
    log.exception("unexpected error %s at %s %r", identity, scope["method"], scope["path"])
    return problem(HTTPStatus.INTERNAL_SERVER_ERROR, UNEXPECTED, id=identity)


def install(app: FastAPI) -> None:
    """Make every error answer of `app` a problem."""
    app.add_exception_handler(AttitudeError, refusal)
    app.add_exception_handler(HTTPException, http_refusal)
    app.add_middleware(UnexpectedErrors)

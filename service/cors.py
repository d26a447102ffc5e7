"""Pages from elsewhere that may ask: none, unless ATTITUDE_CORS_ORIGINS names their origins."""

from __future__ import annotations

from http import HTTPStatus

from starlette.datastructures import Headers
from starlette.middleware.cors import CORSMiddleware
from starlette.responses import Response
from starlette.types import ASGIApp

from .errors import problem

METHODS = ("GET", "HEAD", "POST")
SENT = ("Accept", "Authorization", "Content-Type", "If-None-Match", "X-Request-ID")
SHOWN = ("Content-Disposition", "ETag", "Retry-After", "WWW-Authenticate", "X-Request-ID")


class CrossOrigin(CORSMiddleware):
    """The framework's, whose refusals are problems like all others."""

    def __init__(self, app: ASGIApp, origins: tuple[str, ...]):
        super().__init__(app, origins, METHODS, SENT, expose_headers=SHOWN)

    def preflight_response(self, request_headers: Headers) -> Response:
        answer = super().preflight_response(request_headers)
        if answer.status_code < HTTPStatus.BAD_REQUEST:
            return answer
        return problem(answer.status_code, bytes(answer.body).decode(), headers={"vary": "Origin"})

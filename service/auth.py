"""The bearer token, where one is set: without it nothing is computed, and little told.

Open are the health routes, which an orchestrator asks, and what is the same for everybody: pages, what
they load, and the description of the interface.
"""

from __future__ import annotations

import hmac
from http import HTTPStatus

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from .errors import problem

OPEN = frozenset(["/", "/healthz", "/readyz", "/docs", "/openapi.json", "/favicon.ico"])
OPEN_FOLDERS = ("/viewer/", "/static/", "/docs/")
SCHEME = "bearer"
CHALLENGE = 'Bearer realm="attitude"'


class BearerToken:
    """Refuses requests without the token before anything of them is read."""

    def __init__(self, app: ASGIApp, token: str):
        self.app = app
        self.token = token.encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or is_open(scope["path"]):
            await self.app(scope, receive, send)
            return
        given = Headers(scope=scope).get("authorization")
        if self._is_right(given):
            await self.app(scope, receive, send)
            return
        challenge = CHALLENGE if given is None else f'{CHALLENGE}, error="invalid_token"'
        detail = "authorization: Bearer and the service's token; got " + (
            "nothing" if given is None else "another"
        )
        headers = {"www-authenticate": challenge}
        await problem(HTTPStatus.UNAUTHORIZED, detail, headers=headers)(scope, receive, send)

    def _is_right(self, given: str | None) -> bool:
        """Compared in a time that does not tell how much of it was right."""
        scheme, _, token = (given or "").partition(" ")
        right = hmac.compare_digest(token.strip().encode(), self.token)
        return right and scheme.lower() == SCHEME


def is_open(path: str) -> bool:
    return path in OPEN or (path.startswith(OPEN_FOLDERS) and ".." not in path)

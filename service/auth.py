"""The bearer token, where one is set: who does not bring it finds the open routes and nothing else.

The request is handed to a router that has those alone.  So it is the router that decides what a path leads
to, under whatever prefix the service runs, and a route is closed unless it was included among the open ones.
"""

from __future__ import annotations

import hmac
from http import HTTPStatus

from fastapi import APIRouter
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocketClose

SCHEME = "bearer"
CHALLENGE = 'Bearer realm="attitude"'


class Guard:
    """The application's router for requests with the token, and the open routes alone for all others."""

    def __init__(self, everything: ASGIApp, open_routes: APIRouter, token: str):
        self.everything = everything
        self.open_routes = APIRouter(redirect_slashes=False, default=refuse)
        self.open_routes.include_router(open_routes)
        self.token = token.encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        may_ask = scope["type"] == "lifespan" or self._is_right(_given(scope))
        await (self.everything if may_ask else self.open_routes)(scope, receive, send)

    def _is_right(self, given: str | None) -> bool:
        """Compared in a time that does not tell how much of it was right."""
        scheme, _, token = (given or "").partition(" ")
        right = hmac.compare_digest(token.strip().encode(), self.token)
        return right and scheme.lower() == SCHEME


async def refuse(scope: Scope, receive: Receive, send: Send) -> None:
    """What answers where no open route does, before anything of the request's body is read."""
    if scope["type"] == "websocket":
        await WebSocketClose()(scope, receive, send)
        return
    given = _given(scope)
    challenge = CHALLENGE if given is None else f'{CHALLENGE}, error="invalid_token"'
    got = "nothing" if given is None else "another"
    detail = f"authorization: Bearer and the service's token; got {got}"
    raise HTTPException(HTTPStatus.UNAUTHORIZED, detail, {"www-authenticate": challenge})


def _given(scope: Scope) -> str | None:
    return Headers(scope=scope).get("authorization")

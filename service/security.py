"""The bearer token, where one is set: who does not bring it finds the open routes and nothing else.

The request is handed to a router that has those alone.  So it is the router that decides what a path leads
to, under whatever prefix the service runs, and a route is closed unless it was included among the open ones.
"""

from __future__ import annotations

import hmac
from collections.abc import Iterable
from http import HTTPStatus

from fastapi import APIRouter
from fastapi.security import HTTPBearer
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocketClose

CHALLENGE = 'Bearer realm="attitude"'
BEARER = HTTPBearer(scheme_name="token", auto_error=False)  # describes the closed routes; Guard refuses


class Guard:
    """The application's router for requests with the token, and the open routes alone for all others."""

    def __init__(self, everything: ASGIApp, open_routers: Iterable[APIRouter], token: str):
        self.everything = everything
        self.open_routes = APIRouter(redirect_slashes=False, default=refuse)
        for router in open_routers:
            self.open_routes.include_router(router)
        self.token = token.encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        may_ask = scope["type"] == "lifespan" or self._is_right(_credentials(scope))
        await (self.everything if may_ask else self.open_routes)(scope, receive, send)

    def _is_right(self, credentials: str | None) -> bool:
        """Compared in a time that does not tell how much of it was right."""
        scheme, _, token = (credentials or "").partition(" ")
        is_right = hmac.compare_digest(token.strip().encode(), self.token)
        return is_right and scheme.lower() == "bearer"


async def refuse(scope: Scope, receive: Receive, send: Send) -> None:
    """Refuse where no open route answers, before anything of the request's body is read."""
    if scope["type"] == "websocket":
        await WebSocketClose()(scope, receive, send)
        return
    credentials = _credentials(scope)
    challenge = CHALLENGE if credentials is None else f'{CHALLENGE}, error="invalid_token"'
    got = "nothing" if credentials is None else "another"
    detail = f"authorization: Bearer and the service's token; got {got}"
    raise HTTPException(HTTPStatus.UNAUTHORIZED, detail, {"www-authenticate": challenge})


def _credentials(scope: Scope) -> str | None:
    return Headers(scope=scope).get("authorization")

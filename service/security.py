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

bearer = HTTPBearer(scheme_name="token", auto_error=False)  # describes the closed routes; Guard refuses


class Guard:
    """The application's router for requests with the token, and the open routes alone for all others."""

    def __init__(self, everything: ASGIApp, open_routers: Iterable[APIRouter], token: str):
        self.everything = everything
        self.open_routes = APIRouter(redirect_slashes=False, default=refuse)
        for router in open_routers:
            self.open_routes.include_router(router)
        self.token = token.encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        is_open = scope["type"] == "lifespan" or self.is_authorized(Headers(scope=scope))
        await (self.everything if is_open else self.open_routes)(scope, receive, send)

    def is_authorized(self, headers: Headers) -> bool:
        """Whether the token is right; compared in a time that does not tell how much of it was."""
        scheme, _, token = headers.get("authorization", "").partition(" ")
        is_right = hmac.compare_digest(token.strip().encode(), self.token)
        return is_right and scheme.lower() == "bearer"


async def refuse(scope: Scope, receive: Receive, send: Send) -> None:
    """Refuse where no open route answers, before anything of the request's body is read."""
    if scope["type"] == "websocket":
        await WebSocketClose()(scope, receive, send)
        return
    is_sent = "authorization" in Headers(scope=scope)
    challenge = 'Bearer realm="attitude"' + (', error="invalid_token"' if is_sent else "")
    detail = f"authorization: Bearer and the service's token; got {'another' if is_sent else 'nothing'}"
    raise HTTPException(HTTPStatus.UNAUTHORIZED, detail, {"www-authenticate": challenge})

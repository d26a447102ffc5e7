"""The bearer token, where one is set: a route is closed unless it is among the open ones."""

import hmac
from collections.abc import Sequence
from http import HTTPStatus

from fastapi.security import HTTPBearer
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.routing import BaseRoute, Match
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocketClose

bearer = HTTPBearer(scheme_name="token", auto_error=False)  # describes the closed routes; Guard refuses


class Guard:
    """Around the router: refuses, before the body is read, what no open route answers and has no token.

    The routes themselves say what a path leads to, under whatever prefix the service runs.
    """

    def __init__(self, router: ASGIApp, open_routes: Sequence[BaseRoute], token: str):
        self.router, self.open_routes, self.token = router, open_routes, token.encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan" or self.is_authorized(scope) or self.is_open(scope):
            await self.router(scope, receive, send)
        elif scope["type"] == "websocket":
            await WebSocketClose()(scope, receive, send)
        else:
            got = "another" if "authorization" in Headers(scope=scope) else "nothing"
            challenge = 'Bearer realm="attitude"' + (', error="invalid_token"' if got == "another" else "")
            detail = f"authorization: Bearer and the service's token; got {got}"
            raise HTTPException(HTTPStatus.UNAUTHORIZED, detail, {"www-authenticate": challenge})

    def is_authorized(self, scope: Scope) -> bool:
        """Whether the token is right; compared in a time that does not tell how much of it was."""
        scheme, _, token = Headers(scope=scope).get("authorization", "").partition(" ")
        return hmac.compare_digest(token.strip().encode(), self.token) and scheme.lower() == "bearer"

    def is_open(self, scope: Scope) -> bool:
        return any(route.matches(scope)[0] is not Match.NONE for route in self.open_routes)

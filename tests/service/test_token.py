"""What is answered without the token: the open routes, under every prefix and spelling, and no more."""

from __future__ import annotations

import asyncio
import socket
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import unquote

import pytest
import uvicorn
from running import everything
from starlette.applications import Starlette
from starlette.responses import PlainTextResponse
from starlette.routing import Mount
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from service import create_app
from service.settings import Settings

TOKEN = "0123456789abcdef-A"
BEARER = {"authorization": f"Bearer {TOKEN}"}
ROOTS = [
    "",
    "/docs",
    "/docs/",
    "/viewer",
    "/viewer/x",
    "/static",
    "/healthz",
    "/v1",
    "/x/../docs",
    "/Docs",
    "/%2e",
]
# 503: not warm here, which is no refusal of who asks.
OPEN = {
    "/": 200,
    "/healthz": 200,
    "/readyz": 503,
    "/openapi.json": 200,
    "/docs": 200,
    "/docs/start.js": 200,
    "/viewer/viewer.js": 200,
    "/%68ealthz": 200,
}
# And what they are to who has the token.
CLOSED = {
    "/docs/nothing": 404,
    "/docs/..": 404,
    "/viewer/nothing": 404,
    "/version": 200,
    "/metrics": 200,
    "/v1/scenes": 200,
    "/v1/scenes/toutatis": 200,
    "/%76ersion": 200,
    "/v1/motion": 405,
    "/nothing": 404,
    "": 404,
    "//": 404,
    "//healthz": 404,
    "//version": 404,
    "/healthz/": 404,
    "/version/": 404,
    "/HEALTHZ": 404,
    "/Docs": 404,
    "/docs/": 404,
    "/docs/start.js/": 404,
    "/docs/../version": 404,
    "/docs/%2e%2e/version": 404,
    "/docs/..%2fversion": 404,
    "/viewer/../v1/scenes": 404,
    "/viewer/": 404,
    "/viewer/x/y": 404,
    "/static/": 404,
    "/static/../metrics": 404,
    "/favicon.ico": 404,
    "/version;/docs/": 404,
    "/version%3f/docs/": 404,
}
METHODS = ["GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS", "BREW"]


@pytest.fixture(scope="module")
def app() -> Any:
    return create_app(Settings(token=TOKEN, cors_origins=("https://a.example",)))


def status(
    app: Any, path: str, root: str = "", method: str = "GET", headers: Any = (), in_path: bool = True
) -> int:
    """Of an answer, as a server asks for it: `in_path` where the path that it hands over has the prefix."""
    prefix = root if in_path else ""
    scope = {
        "type": "http",
        "http_version": "1.1",
        "asgi": {"version": "3.0"},
        "method": method,
        "scheme": "http",
        "path": prefix + unquote(path),
        "raw_path": (prefix + path).encode(),
        "root_path": root,
        "query_string": b"",
        "headers": [(name.encode(), value.encode()) for name, value in dict(headers).items()],
    }
    sent: list[Any] = []

    async def receive() -> Any:
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message: Any) -> None:
        sent.append(message)

    with ThreadPoolExecutor(1) as thread:  # where no other event loop runs
        thread.submit(asyncio.run, app(scope, receive, send)).result()
    return int(sent[0]["status"])


@pytest.mark.parametrize("in_path", [True, False], ids=["prefix in the path", "prefix stripped"])
@pytest.mark.parametrize("root", ROOTS)
def test_prefix_neither_opens_what_is_closed_nor_closes_what_is_open(app, root, in_path):
    root = root.rstrip("/")
    # not asked: where the prefix is stripped, what begins with it all the same; nobody could tell
    told = [path for path in OPEN | CLOSED if in_path or not root or not unquote(path).startswith(root)]
    found = {path: status(app, path, root, in_path=in_path) for path in told}
    assert found == {path: OPEN.get(path, 401) for path in told}
    found = {path: status(app, path, root, headers=BEARER, in_path=in_path) for path in told}
    assert found == {path: (OPEN | CLOSED)[path] for path in told}


@pytest.mark.parametrize("root", ["", "/docs"])
@pytest.mark.parametrize("method", METHODS)
def test_no_method_opens_what_is_closed(app, root, method):
    assert {path: status(app, path, root, method) for path in CLOSED} == dict.fromkeys(CLOSED, 401)
    assert status(app, "/healthz", root, method) == (200 if method in ("GET", "HEAD") else 405)


@pytest.mark.parametrize(
    "name", ["x-forwarded-prefix", "x-original-url", "x-rewrite-url", "x-forwarded-path"]
)
def test_header_of_a_proxy_opens_nothing(app, name):
    assert status(app, "/version", headers={name: "/docs"}) == 401


@pytest.mark.parametrize("root", ["", "/docs"])
def test_preflight_of_a_named_origin_is_answered_and_the_request_itself_is_not(app, root):
    asked = {"origin": "https://a.example", "access-control-request-method": "POST"}
    assert status(app, "/v1/motion", root, "OPTIONS", asked) == 200
    assert status(app, "/v1/motion", root, "OPTIONS", {"origin": "https://a.example"}) == 401
    assert status(app, "/v1/motion", root, "POST", {"origin": "https://a.example"}) == 401


@pytest.mark.parametrize("prefix", ["/x", "/docs", "/viewer"])
def test_application_mounted_under_a_prefix_is_as_closed(app, prefix):
    outer = Starlette(routes=[Mount("/outer", Starlette(routes=[Mount(prefix, app)]))])
    found = {path: status(outer, f"/outer{prefix}{path}") for path in (*OPEN, *CLOSED) if path}
    assert found == OPEN | {path: 401 for path in CLOSED if path}


def test_route_is_closed_unless_it_says_otherwise():
    """However it comes to be in the application, also after that was made."""

    async def secret(request: Any) -> PlainTextResponse:
        return PlainTextResponse("secret")

    app = create_app(Settings(token=TOKEN))
    app.add_api_route("/new", secret)
    app.add_route("/docs/new/plain", secret)
    app.mount("/viewer/more", Starlette(routes=[Mount("/", secret)]))
    for path in ("/new", "/docs/new/plain", "/viewer/more/", "/viewer/more/docs"):
        assert status(app, path) == 401


def test_websocket_is_closed(app):
    with pytest.raises(WebSocketDisconnect), TestClient(app).websocket_connect("/docs"):
        pass


def test_without_a_token_everything_is_open():
    app = create_app(Settings())
    assert {path: status(app, path, "/docs") for path in OPEN | CLOSED} == OPEN | CLOSED


# -- over a socket, as `uvicorn service.app:app --root-path PREFIX` ------------------------------


@pytest.fixture(scope="module", params=["/docs", "/viewer", "/x"])
def port(request: Any) -> Iterator[int]:
    app = create_app(Settings(token=TOKEN))
    config = uvicorn.Config(app, port=0, root_path=request.param, log_config=None, lifespan="off", ws="none")
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    deadline = time.monotonic() + 30
    while not server.started:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    yield server.servers[0].sockets[0].getsockname()[1]
    server.should_exit = True
    thread.join(timeout=10)


def over_a_socket(port: int, path: str, head: str = "") -> int:
    """The path as it stands: clients would take dots and slashes out of it."""
    with socket.create_connection(("127.0.0.1", port), timeout=30) as bare:
        bare.sendall(f"GET {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n{head}\r\n".encode())
        return int(everything(bare).split(b" ", 2)[1])


def test_server_with_a_root_path_keeps_closed_what_is_closed(port):
    assert {path: over_a_socket(port, path) for path in OPEN} == OPEN
    paths = [path for path in CLOSED if path]
    assert {path: over_a_socket(port, path) for path in paths} == dict.fromkeys(paths, 401)
    head = f"Authorization: Bearer {TOKEN}\r\n"
    assert {path: over_a_socket(port, path, head) for path in paths} == {path: CLOSED[path] for path in paths}


# -- the description ------------------------------------------------------------------------------------


def test_description_says_what_wants_the_token(app):
    described = TestClient(app).get("/openapi.json").json()
    assert described["components"]["securitySchemes"] == {"token": {"type": "http", "scheme": "bearer"}}
    for path, operations in described["paths"].items():
        for method, operation in operations.items():
            (wanted,) = operation.get("security", [{}])
            asked = status(app, path.replace("{name}", "toutatis"), method=method.upper())
            assert (asked == 401) == ("token" in wanted)


def test_description_names_no_token_where_none_is_set(cold_client):
    described = cold_client.get("/openapi.json").json()
    assert "securitySchemes" not in described["components"]
    assert "security" not in described

"""The page that shows the description: vendored whole, so that it works where nothing else is reached."""

from __future__ import annotations

from functools import cache
from http import HTTPStatus
from pathlib import Path

from fastapi import APIRouter, Request
from starlette.exceptions import HTTPException
from starlette.responses import Response

from .answers import fixed

FOLDER = Path(__file__).parent / "static" / "swagger"
MEDIA = {
    "swagger-ui.css": "text/css; charset=utf-8",
    "swagger-ui-bundle.js": "text/javascript; charset=utf-8",
    "start.js": "text/javascript; charset=utf-8",
    "LICENSE": "text/plain; charset=utf-8",
    "NOTICE": "text/plain; charset=utf-8",
    "swagger-ui-bundle.js.LICENSE.txt": "text/plain; charset=utf-8",
}

router = APIRouter(include_in_schema=False)


@router.get("/docs")
async def page(request: Request) -> Response:
    return fixed(request, _content("index.html"), "text/html; charset=utf-8")


@router.get("/docs/{name}")
async def part(request: Request) -> Response:
    name = request.path_params["name"]
    if name not in MEDIA:
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return fixed(request, _content(name), MEDIA[name])


@cache
def _content(name: str) -> bytes:
    return (FOLDER / name).read_bytes()

"""Pages: the viewer at / (service/viewer, bundled beforehand), and the description's at /docs.

Swagger UI is that of fastapi-offline, so that the page loads nothing from other people's servers.
"""

from __future__ import annotations

import mimetypes
from functools import cache
from http import HTTPStatus
from pathlib import Path

import fastapi_offline
import orjson
from fastapi import APIRouter, Request
from starlette.exceptions import HTTPException
from starlette.responses import Response

from attitude.formats.registry import FORMATS

from .streaming import fixed

HERE = Path(__file__).parent
BUNDLE = HERE / "viewer" / "dist"
# What may be asked for; nothing else of the folders is served.
VIEWER_FILES = ("viewer.js", "viewer.css", "icon.svg", "licences.txt")

router = APIRouter(include_in_schema=False)


@router.get("/")
async def viewer(request: Request) -> Response:
    return page(request, BUNDLE / "index.html")


@router.get("/viewer/formats.json")
async def formats(request: Request) -> Response:
    """What the viewer offers to download, from the library's own list."""
    entries = [{"name": each.name, "endings": each.endings, "media": each.media} for each in FORMATS.values()]
    return fixed(request, orjson.dumps({"formats": entries}))


@router.get("/viewer/{name}")
async def viewer_file(request: Request, name: str) -> Response:
    if name not in VIEWER_FILES:
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return page(request, BUNDLE / name)


@router.get("/docs")
async def docs(request: Request) -> Response:
    return page(request, HERE / "docs" / "index.html")


@router.get("/docs/{name}")
async def docs_file(request: Request, name: str) -> Response:
    if name == "start.js":
        return page(request, HERE / "docs" / name)
    if name not in ("swagger-ui.css", "swagger-ui-bundle.js"):
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return page(request, Path(fastapi_offline.__file__).parent / "static" / name)


@router.get("/openapi.json")
async def description(request: Request) -> Response:
    return fixed(request, request.app.described)


def page(request: Request, file: Path) -> Response:
    media = mimetypes.guess_type(file.name)[0] or "application/octet-stream"
    # kept, but asked about at every visit: a new version of the service is seen at once
    return fixed(request, content(file), media, **{"cache-control": "no-cache"})


@cache
def content(file: Path) -> bytes:
    return file.read_bytes()

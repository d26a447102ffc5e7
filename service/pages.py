"""Pages: the viewer at / (service/viewer, bundled beforehand), and the description's at /docs."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import orjson
from fastapi import APIRouter, Request
from starlette.exceptions import HTTPException
from starlette.responses import Response

from attitude.formats.registry import FORMATS

from .streaming import fixed

BUNDLE = Path(__file__).parent / "viewer" / "dist"
SWAGGER = Path(__file__).parent / "static" / "swagger"
HTML, SCRIPT, TEXT = (f"text/{kind}; charset=utf-8" for kind in ("html", "javascript", "plain"))
# What may be asked for; nothing else of the folders is served.
MEDIA = {
    "index.html": HTML,
    "viewer.js": SCRIPT,
    "viewer.css": "text/css; charset=utf-8",
    "icon.svg": "image/svg+xml",
    "licences.txt": TEXT,
    "formats.json": "application/json",
}
DOCS_MEDIA = {
    "swagger-ui.css": "text/css; charset=utf-8",
    "swagger-ui-bundle.js": SCRIPT,
    "start.js": SCRIPT,
    "LICENSE": TEXT,
    "NOTICE": TEXT,
    "swagger-ui-bundle.js.LICENSE.txt": TEXT,
}

router = APIRouter(include_in_schema=False)


@router.get("/")
async def viewer(request: Request) -> Response:
    return _file(request, BUNDLE, "index.html", MEDIA)


@router.get("/viewer/{name}")
async def viewer_file(request: Request, name: str) -> Response:
    return _file(request, BUNDLE, name, MEDIA)


@router.get("/docs")
async def docs(request: Request) -> Response:
    return _file(request, SWAGGER, "index.html", {"index.html": HTML})


@router.get("/docs/{name}")
async def docs_file(request: Request, name: str) -> Response:
    return _file(request, SWAGGER, name, DOCS_MEDIA)


@router.get("/openapi.json")
async def description(request: Request) -> Response:
    return fixed(request, request.app.described)


def _file(request: Request, folder: Path, name: str, media: dict[str, str]) -> Response:
    if name not in media:
        raise HTTPException(404)
    # kept, but asked about at every visit: a new version of the service is seen at once
    return fixed(request, _content(folder, name), media[name], **{"cache-control": "no-cache"})


@cache
def _content(folder: Path, name: str) -> bytes:
    if name == "formats.json":  # what the page offers to download, from the library's own list
        formats = [
            {"name": each.name, "endings": each.endings, "media": each.media} for each in FORMATS.values()
        ]
        return orjson.dumps({"formats": formats})
    return (folder / name).read_bytes()

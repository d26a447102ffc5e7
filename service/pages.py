"""The viewer: a page at / and the few files it is made of, bundled beforehand (service/viewer)."""

from __future__ import annotations

import gzip
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

import orjson
from fastapi import APIRouter, Request
from starlette.exceptions import HTTPException
from starlette.responses import Response

from attitude.formats.registry import FORMATS

from .headers import policy

BUNDLE = Path(__file__).parent / "viewer" / "dist"
# What may be asked for; nothing else of the folder is served.
MEDIA = {
    "index.html": "text/html; charset=utf-8",
    "viewer.js": "text/javascript; charset=utf-8",
    "viewer.css": "text/css; charset=utf-8",
    "icon.svg": "image/svg+xml",
    "licences.txt": "text/plain; charset=utf-8",
    "formats.json": "application/json",
}
# Kept, but asked about at every visit: a new version of the service is seen at once.
CACHED = {"cache-control": "no-cache", "vary": "accept-encoding"}

router = APIRouter(include_in_schema=False)


class File(NamedTuple):
    """One file of the page, as it is sent."""

    content: bytes
    zipped: bytes
    digest: str


@router.api_route("/", methods=["GET", "HEAD"])
async def index(request: Request) -> Response:
    return _answer(request, "index.html")


@router.api_route("/viewer/{name}", methods=["GET", "HEAD"])
async def part(request: Request, name: str) -> Response:
    if name not in MEDIA:
        raise HTTPException(404)
    return _answer(request, name)


def _answer(request: Request, name: str) -> Response:
    file = _file(name)
    zips = "gzip" in request.headers.get("accept-encoding", "").lower()
    tag = f'"{file.digest}-gzip"' if zips else f'"{file.digest}"'
    headers = {**CACHED, "etag": tag}
    if tag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers | policy(MEDIA[name]))
    if zips:
        headers["content-encoding"] = "gzip"
    return Response(file.zipped if zips else file.content, headers=headers, media_type=MEDIA[name])


@cache
def _file(name: str) -> File:
    """Read and compressed once; they do not change while the service runs."""
    content = _formats() if name == "formats.json" else (BUNDLE / name).read_bytes()
    return File(content, gzip.compress(content, mtime=0), sha256(content).hexdigest()[:20])


def _formats() -> bytes:
    """What the page offers to download, from the library's own list."""
    formats = [{"name": each.name, "endings": each.endings, "media": each.media} for each in FORMATS.values()]
    return orjson.dumps({"formats": formats})

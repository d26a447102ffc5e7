"""The handlers: document in, one library call, answer out; and the pages."""

import mimetypes
import platform
from functools import cache
from http import HTTPStatus
from importlib.metadata import version as version_of
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any

import fastapi_offline
import orjson
from fastapi import APIRouter, Depends, Query, Request
from prometheus_client import CONTENT_TYPE_LATEST
from starlette.exceptions import HTTPException
from starlette.responses import Response

import attitude
from attitude.errors import unknown_name
from attitude.formats.registry import FORMATS
from attitude.scene.document import Scene, builtin_names

from . import computations, metrics
from .dependencies import Document, Files, negotiated, once
from .errors import problem
from .openapi import REFUSALS, UNCHANGED, file_responses, json_or_csv, tagged
from .schemas import (
    CompareQuery,
    ConvertQuery,
    CostQuery,
    Ephemerides,
    Ephemeris,
    EphemerisQuery,
    NoQuery,
    PlanQuery,
    SourceQuery,
    Windows,
    WindowsQuery,
)
from .streaming import answered, fixed, json_response

Nothing = Annotated[NoQuery, Query()]

router = APIRouter(dependencies=[Depends(once)], responses=REFUSALS)
open_router = APIRouter(responses=REFUSALS)  # of what is answered without a token too


# -- computing: beside the event loop -------------------------------------------------------------


@router.post("/v1/ephemeris", responses=file_responses(Ephemeris | Ephemerides) | UNCHANGED)
async def ephemeris(
    request: Request, query: Annotated[EphemerisQuery, Query()], document: Document
) -> Response:
    """Attitude and body rate at a scene's instants, or at those of each of a list of scenes."""
    target = negotiated(query.format, request.headers.get("accept", ""))
    return await answered(request, computations.ephemeris, document, query, target, request)


@router.post("/v1/convert", responses=file_responses(Ephemeris))
async def convert(request: Request, query: Annotated[ConvertQuery, Query()], files: Files) -> Response:
    """A file of attitudes in another format or frame."""
    target = negotiated(query.format, request.headers.get("accept", ""))
    return await answered(request, computations.convert, files, query, target)


@router.post("/v1/check", response_model=dict[str, Any])
async def check(request: Request, query: Annotated[SourceQuery, Query()], files: Files) -> Response:
    """What is off in a file of attitudes: coverage, gaps, spacing, signs, unit length, rates."""
    return await answered(request, computations.check, files, query)


@router.post("/v1/compare", response_model=dict[str, Any])
async def compare(request: Request, query: Annotated[CompareQuery, Query()], files: Files) -> Response:
    """How the attitudes of two files, `file` and `other`, differ."""
    return await answered(request, computations.compare, files, query)


@router.post("/v1/fit", response_model=dict[str, Any])
async def fit(request: Request, _: Nothing, document: Document) -> Response:
    """The free motion that fits a document's observations: scene, covariance, residuals, outliers."""
    return await answered(request, computations.fit, document)


@router.post("/v1/plan", response_model=dict[str, Any])
async def plan(request: Request, query: Annotated[PlanQuery, Query()], document: Document) -> Response:
    """What of a scene would be simulated, what not and why, by which solver, at what cost and error."""
    return await answered(request, computations.plan, document, query)


@router.post("/v1/motion", response_model=dict[str, Any])
async def motion(request: Request, _: Nothing, document: Document) -> Response:
    """Regime, periods, rates and constants of a scene's motion; null for what this motion has not."""
    return await answered(request, computations.motion, document)


@router.post("/v1/windows", responses=json_or_csv(Windows))
async def windows(request: Request, query: Annotated[WindowsQuery, Query()], document: Document) -> Response:
    """The intervals of a scene in which a condition holds; none that is wider than `width` is missed."""
    return await answered(request, computations.windows, document, query)


@router.post("/v1/cost", response_model=dict[str, Any])
async def cost(request: Request, query: Annotated[CostQuery, Query()], document: Document) -> Response:
    """What accuracy costs in time on a scene's body and state, measured here within a budget."""
    return await answered(request, computations.cost, document, query)


# -- the built-in scenes --------------------------------------------------------------------------


@router.get("/v1/scenes", responses=tagged(dict[str, list[dict[str, str]]]))
async def scenes(request: Request, _: Nothing) -> Response:
    """The scenes that come with the service."""
    scenes = {name: Scene.builtin(name) for name in builtin_names()}
    entries = [
        {"name": name, "title": each.name, "description": each.description, "href": f"/v1/scenes/{name}"}
        for name, each in scenes.items()
    ]
    return fixed(request, orjson.dumps({"scenes": entries}))


@router.get("/v1/scenes/{name}", responses=tagged(Scene))
async def scene(request: Request, name: str, _: Nothing) -> Response:
    """One of them, as a document to post."""
    if name not in builtin_names():
        refusal = unknown_name("scene", "scene", name, builtin_names())
        raise HTTPException(HTTPStatus.NOT_FOUND, str(refusal))
    return fixed(request, Scene.builtin(name).to_json().encode())


# -- the process: answered by the event loop, whatever is being computed --------------------------


@open_router.get("/healthz", response_model=dict[str, str])
async def healthz(request: Request) -> Response:
    """The process is alive."""
    if request.app.state.compute.is_stuck():
        detail = "a computation goes on long after it was stopped; this process is to be replaced"
        return problem(HTTPStatus.SERVICE_UNAVAILABLE, detail)
    return json_response(b'{"status":"alive"}')


@open_router.get("/readyz", response_model=dict[str, str])
async def readyz(request: Request) -> Response:
    """Work may be sent: the kernel is compiled and a known case came out right."""
    obstacle = request.app.state.readiness.obstacle
    if obstacle is not None:
        return problem(HTTPStatus.SERVICE_UNAVAILABLE, obstacle)
    return json_response(b'{"status":"ready"}')


@router.get("/version", responses=tagged(dict[str, str]))
async def version(request: Request, _: Nothing) -> Response:
    """Versions of the package and of what it computes with."""
    return fixed(request, versions())


@cache
def versions() -> bytes:
    packages = {name: version_of(name) for name in ("numpy", "numba", "astropy") if find_spec(name)}
    return orjson.dumps({"attitude": attitude.__version__, "python": platform.python_version(), **packages})


@router.get(
    "/metrics",
    response_class=Response,
    responses={200: {"description": "Prometheus' text format", "content": {CONTENT_TYPE_LATEST: {}}}},
)
async def figures() -> Response:
    """Requests, latency, samples, seconds of computing and refusals, for Prometheus."""
    return Response(metrics.text(), headers={"content-type": CONTENT_TYPE_LATEST})


# -- pages: the viewer (service/viewer, bundled beforehand), and the description's ------------------


@open_router.get("/openapi.json", include_in_schema=False)
async def description(request: Request) -> Response:
    return fixed(request, request.app.described)


@open_router.get("/viewer/formats.json", include_in_schema=False)
async def formats(request: Request) -> Response:
    """What the viewer offers to download, from the library's own list."""
    entries = [{"name": each.name, "endings": each.endings, "media": each.media} for each in FORMATS.values()]
    return fixed(request, orjson.dumps({"formats": entries}))


VIEWER, DOCS = (Path(__file__).parent / folder for folder in ("viewer/dist", "docs"))
SWAGGER = Path(fastapi_offline.__file__).parent / "static"
PAGES = {"/": VIEWER / "index.html", "/docs": DOCS / "index.html", "/docs/start.js": DOCS / "start.js"}
PAGES |= {
    f"/viewer/{name}": VIEWER / name for name in ("viewer.js", "viewer.css", "icon.svg", "licences.txt")
}
PAGES |= {f"/docs/{name}": SWAGGER / name for name in ("swagger-ui.css", "swagger-ui-bundle.js")}


async def page(request: Request) -> Response:
    """A file, which is kept by browsers but asked about at every visit."""
    file = PAGES[request.scope["route"].path]
    media = mimetypes.guess_type(file.name)[0] or "application/octet-stream"
    return fixed(request, content(file), media, **{"cache-control": "no-cache"})


content = cache(Path.read_bytes)
for path in PAGES:
    open_router.add_api_route(path, page, include_in_schema=False)

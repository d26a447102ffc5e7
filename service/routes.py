"""The handlers: document in, one library call, answer out; and the pages."""

import mimetypes
import platform
from functools import cache, wraps
from http import HTTPStatus
from importlib.metadata import version as version_of
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import fastapi_offline
import orjson
from fastapi import APIRouter, Depends, Request
from prometheus_client import CONTENT_TYPE_LATEST
from starlette.exceptions import HTTPException
from starlette.responses import Response

import attitude
from attitude.cost.answers import CostAnswer
from attitude.errors import unknown_name
from attitude.estimation.fit_result import FitAnswer
from attitude.formats.registry import FORMATS
from attitude.formats.tables.json import EphemerisAnswer
from attitude.quality.check import CheckAnswer
from attitude.quality.compare import ComparisonAnswer
from attitude.scene.builtin_scenes import builtin_names
from attitude.scene.motion_summary import MotionAnswer
from attitude.scene.planning import PlanAnswer
from attitude.scene.scene import Scene
from attitude.windows.window_table import WindowsAnswer

from . import computations, metrics
from .dependencies import Nothing, once
from .errors import problem
from .openapi import REFUSALS, UNCHANGED, Responses, file_responses, json_or_csv, tagged
from .schemas import Ephemerides
from .streaming import Whole, fixed

router = APIRouter(dependencies=[Depends(once)], responses=REFUSALS)
open_router = APIRouter(responses=REFUSALS)  # of what is answered without a token too


# -- computing: beside the event loop -------------------------------------------------------------


COMPUTATIONS: dict[str, tuple[Any, Responses]] = {
    "ephemeris": (computations.ephemeris, file_responses(EphemerisAnswer | Ephemerides) | UNCHANGED),
    "convert": (computations.convert, file_responses(EphemerisAnswer)),
    "check": (computations.check, {200: {"model": CheckAnswer}}),
    "compare": (computations.compare, {200: {"model": ComparisonAnswer}}),
    "fit": (computations.fit, {200: {"model": FitAnswer}}),
    "plan": (computations.plan, {200: {"model": PlanAnswer}}),
    "motion": (computations.motion, {200: {"model": MotionAnswer}}),
    "windows": (computations.windows, json_or_csv(WindowsAnswer)),
    "cost": (computations.cost, {200: {"model": CostAnswer}}),
}


def in_thread(work: Any) -> Any:
    """An endpoint that computes in a thread; what it takes FastAPI reads off the computation."""

    @wraps(work)
    async def endpoint(request: Request, **inputs: Any) -> Any:
        return await request.app.state.compute.run(work, request, **inputs)

    return endpoint


for name, (work, responses) in COMPUTATIONS.items():
    router.add_api_route(f"/v1/{name}", in_thread(work), methods=["POST"], responses=responses)


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
    return Whole({"status": "alive"})


@open_router.get("/readyz", response_model=dict[str, str])
async def readyz(request: Request) -> Response:
    """Work may be sent: the kernel is compiled and a known case came out right."""
    obstacle = request.app.state.readiness.obstacle
    if obstacle is not None:
        return problem(HTTPStatus.SERVICE_UNAVAILABLE, obstacle)
    return Whole({"status": "ready"})


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


HERE, SWAGGER_UI = Path(__file__).parent, Path(fastapi_offline.__file__).with_name("static")
PAGES = {
    "/": HERE / "viewer/dist/index.html",
    "/viewer/viewer.js": HERE / "viewer/dist/viewer.js",
    "/viewer/viewer.css": HERE / "viewer/dist/viewer.css",
    "/viewer/icon.svg": HERE / "viewer/dist/icon.svg",
    "/viewer/licences.txt": HERE / "viewer/dist/licences.txt",
    "/docs": HERE / "docs/index.html",
    "/docs/start.js": HERE / "docs/start.js",
    **{f"/docs/{name}": SWAGGER_UI / name for name in ("swagger-ui.css", "swagger-ui-bundle.js")},
}


async def page(request: Request) -> Response:
    """A file, which is kept by browsers but asked about at every visit."""
    file = PAGES[request.scope["route"].path]
    media = mimetypes.guess_type(file.name)[0] or "application/octet-stream"
    return fixed(request, content(file), media, **{"cache-control": "no-cache"})


content = cache(Path.read_bytes)
for path in PAGES:
    open_router.add_api_route(path, page, include_in_schema=False)

"""The handlers: document in, one library call, answer out."""

from __future__ import annotations

import platform
from functools import cache
from http import HTTPStatus
from importlib.metadata import version as version_of
from importlib.util import find_spec
from typing import Annotated, Any

import orjson
from fastapi import APIRouter, Depends, Query, Request
from prometheus_client import CONTENT_TYPE_LATEST
from starlette.exceptions import HTTPException
from starlette.responses import Response

import attitude
from attitude.errors import unknown_name
from attitude.scene.document import Scene, builtin_names

from . import computations, metrics
from .dependencies import CostQuery, Document, EphemerisQuery, NoParameters, PlanQuery, once
from .errors import problem
from .negotiation import negotiated
from .openapi import REFUSALS, file_responses, scene_body, tagged
from .schemas import Catalogue, Status
from .streaming import fixed, json_response, response

Nothing = Annotated[NoParameters, Query()]

router = APIRouter(dependencies=[Depends(once)], responses=REFUSALS)
open_router = APIRouter(responses=REFUSALS)  # of what is answered without a token too


# -- computing: beside the event loop -------------------------------------------------------------


@router.post("/v1/ephemeris", responses=file_responses(), openapi_extra=scene_body(is_list=True))
async def ephemeris(
    request: Request, query: Annotated[EphemerisQuery, Query()], document: Document
) -> Response:
    """Attitude and body rate at a scene's instants, or at those of each of a list of scenes."""
    compute = request.app.state.compute
    target = negotiated(query.format, request.headers.get("accept", ""))
    arguments = document, query, target, request, compute.settings
    return response(await compute.run(computations.ephemeris, *arguments), compute)


@router.post("/v1/plan", response_model=dict[str, Any], openapi_extra=scene_body())
async def plan(request: Request, query: Annotated[PlanQuery, Query()], document: Document) -> Response:
    """What of a scene would be simulated, what not and why, by which solver, at what cost and error."""
    state = request.app.state
    return json_response(await state.compute.run(computations.plan, document, query, state.settings))


@router.post("/v1/motion", response_model=dict[str, Any], openapi_extra=scene_body())
async def motion(request: Request, _: Nothing, document: Document) -> Response:
    """Regime, periods, rates and constants of a scene's motion; null for what this motion has not."""
    state = request.app.state
    return json_response(await state.compute.run(computations.motion, document, state.settings))


@router.post("/v1/cost", response_model=dict[str, Any], openapi_extra=scene_body())
async def cost(request: Request, query: Annotated[CostQuery, Query()], document: Document) -> Response:
    """What accuracy costs in time on a scene's body and state, measured here within a budget."""
    state = request.app.state
    return json_response(await state.compute.run(computations.cost, document, query, state.settings))


# -- the built-in scenes --------------------------------------------------------------------------


@router.get("/v1/scenes", responses=tagged(Catalogue))
async def scenes(request: Request, _: Nothing) -> Response:
    """The scenes that come with the service."""
    return fixed(request, catalogue())


@cache
def catalogue() -> bytes:
    entries = [(name, Scene.builtin(name)) for name in builtin_names()]
    return orjson.dumps(
        {
            "scenes": [
                {
                    "name": name,
                    "title": scene.name,
                    "description": scene.description,
                    "href": f"/v1/scenes/{name}",
                }
                for name, scene in entries
            ]
        }
    )


@router.get("/v1/scenes/{name}", responses=tagged(Scene))
async def scene(request: Request, name: str, _: Nothing) -> Response:
    """One of them, as a document to post."""
    if name not in builtin_names():
        raise HTTPException(HTTPStatus.NOT_FOUND, str(unknown_name("scene", "scene", name, builtin_names())))
    return fixed(request, scene_text(name))


@cache
def scene_text(name: str) -> bytes:
    return Scene.builtin(name).to_json().encode()


# -- the process: answered by the event loop, whatever is being computed --------------------------


@open_router.get("/healthz", response_model=Status)
async def healthz(request: Request) -> Response:
    """The process is alive."""
    if request.app.state.compute.is_stuck():
        detail = "a computation goes on long after it was stopped; this process is to be replaced"
        return problem(HTTPStatus.SERVICE_UNAVAILABLE, detail)
    return json_response(orjson.dumps({"status": "alive"}))


@open_router.get("/readyz", response_model=Status)
async def readyz(request: Request) -> Response:
    """Work may be sent: the kernel is compiled and a known case came out right."""
    obstacle = request.app.state.readiness.obstacle
    if obstacle is not None:
        return problem(HTTPStatus.SERVICE_UNAVAILABLE, obstacle)
    return json_response(orjson.dumps({"status": "ready"}))


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

"""The handlers: document in, one library call, answer out."""

from __future__ import annotations

import platform
from functools import cache
from http import HTTPStatus
from importlib.metadata import version as version_of
from importlib.util import find_spec
from typing import Any

import orjson
from fastapi import APIRouter, Request
from starlette.exceptions import HTTPException
from starlette.responses import Response

import attitude
from attitude.errors import InputError
from attitude.scene.document import Scene, builtin_names
from attitude.scene.motion_summary import motion_summary

from . import costs, ephemerides, limits, openapi
from . import query as queries
from .errors import problem
from .streaming import JSON, fixed, json_response, response, unchanged

PACKAGES = ("numpy", "numba", "astropy")

router = APIRouter()
open_router = APIRouter()  # of what is answered without a token too


async def _document(request: Request) -> bytes:
    """The raw document; the library parses it, so that it is refused in the library's words."""
    media = request.headers.get("content-type", "nothing")
    if media.partition(";")[0].strip().lower() != JSON:
        raise HTTPException(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, f"content-type: {JSON}; got {media[:200]}")
    return await limits.read_body(request, request.app.state.settings)


# -- computing: beside the event loop -------------------------------------------------------------


@router.post(
    "/v1/ephemeris",
    summary="Attitude and body rate at a scene's instants, or at those of each of a list of scenes",
    openapi_extra=openapi.ephemeris_request(),
    responses=openapi.ephemeris_answer(),
)
async def ephemeris(request: Request) -> Response:
    query = queries.Query.of(request)
    document = await _document(request)
    compute = request.app.state.compute
    computed = await compute.run(ephemerides.computed, document, query, compute.settings, request)
    return unchanged(computed) if isinstance(computed, str) else response(computed, compute)


@router.post(
    "/v1/plan",
    summary="What of a scene would be simulated, what not and why, by which solver, at what cost and error",
    openapi_extra=openapi.scene_request("drop_below"),
    responses=openapi.json_answer("The plan, units in its names"),
)
async def plan(request: Request) -> Response:
    given = queries.parameters(request, "drop_below")
    drop_below = queries.number(given, "drop_below", queries.ANGLE)
    document = await _document(request)
    state = request.app.state
    return json_response(await state.compute.run(_plan, document, drop_below, state.settings))


def _plan(document: bytes, drop_below: float | None, settings: Any) -> bytes:
    scene = limits.scene_of(document, settings)
    with queries.no_field("drop_below"):
        return orjson.dumps(scene.plan(drop_below).to_dict())


@router.post(
    "/v1/motion",
    summary="Regime, periods, rates and constants of a scene's motion",
    openapi_extra=openapi.scene_request(),
    responses=openapi.json_answer(
        "Constants of the motion, units in their names; null for what this motion has not"
    ),
)
async def motion(request: Request) -> Response:
    queries.none(request)
    document = await _document(request)
    state = request.app.state
    return json_response(await state.compute.run(_motion, document, state.settings))


def _motion(document: bytes, settings: Any) -> bytes:
    scene = limits.scene_of(document, settings)
    return motion_summary(scene.motion(), scene.name)


@router.post(
    "/v1/cost",
    summary="What accuracy costs in time on a scene's body and state, measured here within a budget",
    openapi_extra=openapi.scene_request("budget", "samples", "seed", "method"),
    responses=openapi.json_answer("Methods, their accuracy and their time, units in the names"),
)
async def cost(request: Request) -> Response:
    state = request.app.state
    asked = costs.CostQuery.of(request, state.settings)
    document = await _document(request)
    return json_response(await state.compute.run(costs.measured, document, asked, state.settings))


# -- the built-in scenes --------------------------------------------------------------------------


@router.get(
    "/v1/scenes",
    summary="The scenes that come with the service",
    responses=openapi.json_answer("Their names and titles", tagged=True),
)
async def scenes(request: Request) -> Response:
    queries.none(request)
    return fixed(request, _catalogue())


@cache
def _catalogue() -> bytes:
    return orjson.dumps({"scenes": [_entry(name) for name in builtin_names()]})


def _entry(name: str) -> dict[str, Any]:
    scene = Scene.builtin(name)
    return {"name": name, "title": scene.name, "description": scene.description, "href": f"/v1/scenes/{name}"}


@router.get(
    "/v1/scenes/{name}",
    summary="One of them, as a document to post",
    openapi_extra=openapi.parameters("name"),
    responses=openapi.json_answer("A scene document", openapi.SCHEMAS + "Scene", tagged=True),
)
async def scene(request: Request) -> Response:
    queries.none(request)
    name = request.path_params["name"]
    if name not in builtin_names():
        expected = f"a built-in scene, one of {', '.join(builtin_names())}"
        raise HTTPException(HTTPStatus.NOT_FOUND, str(InputError("scene", name, expected)))
    return fixed(request, _scene(name))


@cache
def _scene(name: str) -> bytes:
    return Scene.builtin(name).to_json().encode()


# -- the process: answered by the event loop, whatever is being computed --------------------------


@open_router.get(
    "/healthz",
    summary="The process is alive",
    responses=openapi.json_answer("It is"),
)
async def healthz(request: Request) -> Response:
    if request.app.state.compute.is_stuck():
        detail = "a computation goes on long after it was stopped; this process is to be replaced"
        return problem(HTTPStatus.SERVICE_UNAVAILABLE, detail)
    return json_response(orjson.dumps({"status": "alive"}))


@open_router.get(
    "/readyz",
    summary="Work may be sent: the kernel is compiled and a known case came out right",
    responses=openapi.json_answer("It may"),
)
async def readyz(request: Request) -> Response:
    obstacle = request.app.state.readiness.obstacle
    if obstacle is not None:
        return problem(HTTPStatus.SERVICE_UNAVAILABLE, obstacle)
    return json_response(orjson.dumps({"status": "ready"}))


@router.get(
    "/version",
    summary="Versions of the package and of what it computes with",
    responses=openapi.json_answer("Versions, by name", tagged=True),
)
async def version(request: Request) -> Response:
    queries.none(request)
    return fixed(request, _versions())


@cache
def _versions() -> bytes:
    packages = {name: version_of(name) for name in PACKAGES if find_spec(name)}  # images have no numba
    return orjson.dumps({"attitude": attitude.__version__, "python": platform.python_version(), **packages})

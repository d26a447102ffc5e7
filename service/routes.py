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
from starlette.exceptions import HTTPException
from starlette.responses import Response

import attitude
from attitude.errors import InputError
from attitude.formats import json
from attitude.formats.answer import Answer, answer, options_of
from attitude.scene import Scene, builtin_names

from . import jobs, limits
from .errors import problem
from .negotiation import wanted
from .openapi import ephemeris_answer, json_answer, scene_request
from .settings import Settings, variable

JSON = "application/json"
PACKAGES = ("numpy", "numba", "astropy")

router = APIRouter()


async def _settings(request: Request) -> Settings:
    settings: Settings = request.app.state.settings
    return settings


SettingsOf = Annotated[Settings, Depends(_settings)]


async def _document(request: Request, settings: SettingsOf) -> bytes:
    """The raw document; the library parses it, so that it is refused in the library's words."""
    given = request.headers.get("content-type", "nothing")
    if given.partition(";")[0].strip().lower() != JSON:
        raise HTTPException(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, f"content-type: {JSON}; got {given}")
    return await limits.read_body(request, settings)


Document = Annotated[bytes, Depends(_document)]


# As text: what is wrong with it is then said in the library's words.
DropBelow = Annotated[str | None, Query(description="rad: leave out torques that matter less over the span")]


FORMAT = "of the answer, instead of what Accept names; other parameters are options of the format"
FRAME = "attitudes relative to it, instead of the scene's"
INTERPOLATION = "rad: choose the instants so that what readers interpolate stays within it"


def _angle(text: str | None, name: str = "drop_below") -> float | None:
    if text is None:
        return None
    try:
        return float(text)
    except ValueError:
        raise InputError(name, text, "an angle in rad, above 0", steps=()) from None


def _answer(content: bytes | str) -> Response:
    return Response(content, media_type=JSON)


# -- computing: beside the event loop --------------------------------------------------------------


@router.post(
    "/v1/ephemeris",
    summary="Attitude and body rate at a scene's instants",
    openapi_extra=scene_request(),
    responses=ephemeris_answer(),
)
async def ephemeris(
    document: Document,
    settings: SettingsOf,
    request: Request,
    drop_below: DropBelow = None,
    format: Annotated[str | None, Query(description=FORMAT)] = None,
    frame: Annotated[str | None, Query(description=FRAME)] = None,
    interpolation_error: Annotated[str | None, Query(description=INTERPOLATION)] = None,
) -> Response:
    run = request.app.state.compute.run
    return await run(_ephemeris, document, settings, request, drop_below, format, frame, interpolation_error)


def _ephemeris(
    document: bytes,
    settings: Settings,
    request: Request,
    drop_below: str | None,
    format: str | None,
    frame: str | None,
    interpolation_error: str | None,
) -> Response:
    known = wanted(format, request.headers.get("accept", ""))
    scene = limits.check_effects(Scene.from_json(document), settings)
    most = settings.max_samples, variable("max_samples")
    ephemeris = scene.run(*most, _angle(drop_below), limits.check_predicted(settings))
    jobs.count_samples(len(ephemeris))
    ephemeris = ephemeris if frame is None else ephemeris.in_frame(frame)
    options = options_of(_other_parameters(request), known)
    if known.name == "json" and not options and interpolation_error is None:
        return _answer(json.dumps(ephemeris, cost=True))
    error = _angle(interpolation_error, "interpolation_error")
    return _file(answer(ephemeris, known, error, settings.max_samples, options))


def _file(file: Answer) -> Response:
    named = {"content-disposition": f'attachment; filename="{file.name}"'}
    return Response(file.content, media_type=file.media, headers=named)


def _other_parameters(request: Request) -> dict[str, str]:
    """What the query names besides: options of the format."""
    ours = ("drop_below", "format", "frame", "interpolation_error")
    return {name: value for name, value in request.query_params.items() if name not in ours}


@router.post(
    "/v1/plan",
    summary="What of a scene would be simulated, what not and why, by which solver, at what cost and error",
    openapi_extra=scene_request("envisat"),
    responses=json_answer("The plan, units in its names"),
)
async def plan(
    request: Request, document: Document, settings: SettingsOf, drop_below: DropBelow = None
) -> Response:
    return await request.app.state.compute.run(_plan, document, settings, drop_below)


def _plan(document: bytes, settings: Settings, drop_below: str | None) -> Response:
    scene = limits.check_effects(Scene.from_json(document), settings)
    return _answer(orjson.dumps(scene.plan(_angle(drop_below)).to_dict()))


@router.post(
    "/v1/motion",
    summary="Regime, periods, rates and constants of a scene's motion",
    openapi_extra=scene_request(),
    responses=json_answer("Constants of the motion, units in their names; null for what this motion has not"),
)
async def motion(request: Request, document: Document) -> Response:
    return await request.app.state.compute.run(_motion, document)


def _motion(document: bytes) -> Response:
    scene = Scene.from_json(document)
    return _answer(json.motion_summary(scene.motion(), scene.name))


# -- the built-in scenes --------------------------------------------------------------------------


@router.get(
    "/v1/scenes",
    summary="The scenes that come with the service",
    responses=json_answer("Their names and titles"),
)
async def scenes() -> Response:
    return _answer(_catalogue())


@cache
def _catalogue() -> bytes:
    return orjson.dumps({"scenes": [_entry(name) for name in builtin_names()]})


def _entry(name: str) -> dict[str, Any]:
    scene = Scene.builtin(name)
    return {"name": name, "title": scene.name, "description": scene.description, "href": f"/v1/scenes/{name}"}


@router.get(
    "/v1/scenes/{name}",
    summary="One of them, as a document to post",
    responses=json_answer("A scene document"),
)
async def scene(name: str) -> Response:
    try:
        return _answer(Scene.builtin(name).to_json())
    except InputError as error:
        raise HTTPException(HTTPStatus.NOT_FOUND, str(error)) from None


# -- the process: answered by the event loop, whatever the thread pool is busy with ---------------


@router.get("/healthz", summary="The process is alive", responses=json_answer("It is"))
async def healthz() -> Response:
    return _answer(orjson.dumps({"status": "alive"}))


@router.get(
    "/readyz",
    summary="Work may be sent: the kernel is compiled and a known case came out right",
    responses=json_answer("It may"),
)
async def readyz(request: Request) -> Response:
    obstacle = request.app.state.readiness.obstacle
    if obstacle is not None:
        return problem(HTTPStatus.SERVICE_UNAVAILABLE, obstacle)
    return _answer(orjson.dumps({"status": "ready"}))


@router.get(
    "/version",
    summary="Versions of the package and of what it computes with",
    responses=json_answer("Versions, by name"),
)
async def version() -> Response:
    return _answer(_versions())


@cache
def _versions() -> bytes:
    packages = {name: version_of(name) for name in PACKAGES if find_spec(name)}  # images have no numba
    return orjson.dumps({"attitude": attitude.__version__, "python": platform.python_version(), **packages})

"""The application: `uvicorn service.app:app`."""

import asyncio
import logging.config
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from fastapi import FastAPI, Security
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.middleware.cors import CORSMiddleware
from starlette.middleware.gzip import DEFAULT_EXCLUDED_CONTENT_TYPES, GZipMiddleware

import attitude
from attitude.errors import AttitudeError, InputError
from attitude.formats.registry import FORMATS

from . import logs, metrics
from .compute import Compute
from .deadline import end_stuck_process
from .errors import http_refusal, refusal, refused_query
from .middleware import Requests
from .openapi import DescribedAPI
from .readiness import Readiness
from .routes import open_router, router
from .security import Guard, bearer
from .settings import Settings, refused_start

app: FastAPI


def create_app(settings: Settings | None = None) -> FastAPI:
    """The service; without settings, those of the environment."""
    settings = settings or Settings.read()
    handlers: dict[Any, Any] = {
        AttitudeError: refusal,
        RequestValidationError: refused_query,
        HTTPException: http_refusal,
    }
    app = DescribedAPI(
        title="attitude",
        summary="Exact attitude ephemerides of freely rotating bodies",
        description=Path(__file__).with_name("description.md").read_text(),
        version=attitude.__version__,
        lifespan=lifespan,
        redirect_slashes=False,  # a path that is not there is a problem, not a redirection
        separate_input_output_schemas=False,  # a scene is one and the same, asked for or answered
        openapi_url=None,  # both are routes of ours: with tags, and no scripts from other people's servers
        docs_url=None,
        redoc_url=None,
        exception_handlers=handlers,
    )
    app.state.settings = settings
    app.state.readiness = Readiness()
    app.state.compute = Compute(settings)
    app.include_router(router, dependencies=[Security(bearer)] if settings.token else [])
    app.include_router(open_router)
    if settings.token is not None:  # innermost, where the router itself was
        app.router.middleware_stack = Guard(app.router.middleware_stack, open_router.routes, settings.token)
    # The last one added is the first one that a request passes.
    binary = [each.media for each in FORMATS.values() if not re.match(r"text/|.*(json|xml)$", each.media)]
    app.add_middleware(
        GZipMiddleware,
        minimum_size=1024,
        compresslevel=1,  # takes a quarter of the sixth's time, and packs digits nearly as well
        exclude_content_types=(*DEFAULT_EXCLUDED_CONTENT_TYPES, *binary),
    )
    app.add_middleware(Requests, compute=app.state.compute)
    if settings.cors_origins:
        shown = (
            "Attitude-Cost Attitude-Plan Attitude-Version Attitude-Warnings Allow Content-Disposition ETag"
        )
        app.add_middleware(
            CORSMiddleware,
            allow_origins=settings.cors_origins,
            allow_methods=("GET", "HEAD", "POST"),
            allow_headers=("Accept", "Authorization", "Content-Type", "If-None-Match", "X-Request-ID"),
            expose_headers=[*shown.split(), "Retry-After", "WWW-Authenticate", "X-Request-ID"],
        )
    return app


@asynccontextmanager
async def lifespan(app: FastAPI) -> AsyncIterator[None]:
    metrics.forget_dead_workers()
    app.state.readiness.start()
    compute = app.state.compute
    backstop = asyncio.create_task(end_stuck_process(compute.is_stuck, compute.settings.max_seconds))
    yield
    app.state.readiness.stop.set()
    backstop.cancel()
    await compute.stop()


def __getattr__(name: str) -> FastAPI:
    """`app`, made when a server asks for it: importing the package needs no settings."""
    if name != "app":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        settings = Settings.read()
    except InputError as error:
        raise refused_start(error) from None
    logging.config.dictConfig(logs.configuration(settings.log_level))
    logging.captureWarnings(True)  # those of other libraries
    made = globals()["app"] = create_app(settings)
    return made

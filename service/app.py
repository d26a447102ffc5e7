"""The application: `uvicorn service.app:app`."""

from __future__ import annotations

import asyncio
import logging.config
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import FastAPI, Security
from starlette.middleware.gzip import DEFAULT_EXCLUDED_CONTENT_TYPES

import attitude
from attitude.formats.registry import FORMATS

from . import logs, metrics, middleware, openapi, pages
from .compute import Compute
from .deadline import end_stuck_process
from .errors import install
from .readiness import Readiness
from .routes import open_router, router
from .security import Guard, bearer
from .settings import Settings

app: FastAPI


def create_app(settings: Settings | None = None) -> FastAPI:
    """The service; without settings, those of the environment."""
    settings = settings or Settings.read()
    app = openapi.DescribedAPI(
        title="attitude",
        summary="Exact attitude ephemerides of freely rotating bodies",
        description=openapi.DESCRIPTION,
        version=attitude.__version__,
        lifespan=lifespan,
        redirect_slashes=False,  # a path that is not there is a problem, not a redirection
        separate_input_output_schemas=False,  # a scene is one and the same, asked for or answered
        openapi_url=None,  # both are among the pages: with tags, and no scripts from other people's servers
        docs_url=None,
        redoc_url=None,
    )
    app.state.settings = settings
    app.state.readiness = Readiness()
    app.state.compute = Compute(settings)
    app.include_router(router, dependencies=[Security(bearer)] if settings.token else [])
    app.include_router(open_router)
    app.include_router(pages.router)
    if settings.token is not None:  # innermost, where the router itself was
        open_routes = [open_router, pages.router]
        app.router.middleware_stack = Guard(app.router.middleware_stack, open_routes, settings.token)
    install(app)
    # The last one added is the first one that a request passes.
    binary = [each.media for each in FORMATS.values() if not re.match(r"text/|.*(json|xml)$", each.media)]
    app.add_middleware(
        middleware.Compression,
        minimum_size=1024,
        compresslevel=1,  # takes a quarter of the sixth's time, and packs digits nearly as well
        exclude_content_types=(*DEFAULT_EXCLUDED_CONTENT_TYPES, *binary),
    )
    if settings.cors_origins:
        sent = ("Accept", "Authorization", "Content-Type", "If-None-Match", "X-Request-ID")
        shown = "Attitude-Cost Attitude-Plan Attitude-Version Content-Disposition ETag Retry-After"
        app.add_middleware(
            middleware.CrossOrigin,
            allow_origins=settings.cors_origins,
            allow_methods=("GET", "HEAD", "POST"),
            allow_headers=sent,
            expose_headers=[*shown.split(), "WWW-Authenticate", "X-Request-ID"],
        )
    app.add_middleware(middleware.Requests, compute=app.state.compute)
    return app


@asynccontextmanager
async def lifespan(app: FastAPI) -> AsyncIterator[None]:
    metrics.forget_dead_workers()
    app.state.readiness.start()
    compute = app.state.compute
    backstop = asyncio.create_task(end_stuck_process(compute.is_stuck, compute.settings.max_seconds))
    yield
    backstop.cancel()
    await compute.stop()


def __getattr__(name: str) -> FastAPI:
    """`app`, made when a server asks for it: importing the package needs no settings."""
    if name != "app":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    settings = Settings.read()
    logging.config.dictConfig(logs.configuration(settings.log_level))
    made = globals()["app"] = create_app(settings)
    return made

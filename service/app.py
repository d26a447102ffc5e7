"""The application: `uvicorn service.app:app`."""

from __future__ import annotations

import asyncio
import logging.config
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import FastAPI, Security

import attitude

from . import logs, metrics, middleware, pages
from .compute import Compute
from .deadline import end_stuck_process
from .errors import UnexpectedErrors, install
from .metrics import Metrics
from .openapi import DescribedAPI
from .readiness import Readiness
from .routes import open_router, router
from .security import BEARER, Guard
from .settings import Settings, warn_of_retired

app: FastAPI


def create_app(settings: Settings | None = None) -> FastAPI:
    """The service; without settings, those of the environment."""
    settings = settings or Settings.read()
    app = DescribedAPI(
        title="attitude",
        summary="Exact attitude ephemerides of freely rotating bodies",
        version=attitude.__version__,
        lifespan=_lifespan,
        redirect_slashes=False,  # a path that is not there is a problem, not a redirection
    )
    app.state.settings = settings
    app.state.readiness = Readiness()
    app.state.metrics = Metrics()
    app.state.compute = Compute(settings, app.state.metrics)
    closed = [Security(BEARER)] if settings.token else []
    app.include_router(router, dependencies=closed)
    app.include_router(metrics.router, dependencies=closed)
    app.include_router(open_router)
    app.include_router(pages.router)
    if settings.token is not None:  # innermost, where the router itself was
        open_routes = [open_router, pages.router]
        app.router.middleware_stack = Guard(app.router.middleware_stack, open_routes, settings.token)
    install(app)
    # The last one added is the first one that a request passes.
    app.add_middleware(middleware.Compression)
    app.add_middleware(middleware.HeadAsGet)
    if settings.cors_origins:
        app.add_middleware(middleware.CrossOrigin, origins=settings.cors_origins)
    app.add_middleware(UnexpectedErrors)
    app.add_middleware(middleware.Requests, metrics=app.state.metrics, compute=app.state.compute)
    return app


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
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
    warn_of_retired()
    made = globals()["app"] = create_app(settings)
    return made

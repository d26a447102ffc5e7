"""The application: wiring only."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import FastAPI

import attitude

from . import errors, metrics
from .auth import Guard
from .compute import Compute
from .cors import CrossOrigin
from .metrics import Metrics
from .openapi import DescribedAPI
from .readiness import Readiness
from .requests import Requests
from .routes import open_router, router
from .settings import Settings


def create_app(settings: Settings | None = None) -> FastAPI:
    """The service; without settings, those of the environment."""
    app = DescribedAPI(
        title="attitude",
        summary="Exact attitude ephemerides of freely rotating bodies",
        version=attitude.__version__,
        lifespan=_lifespan,
        redirect_slashes=False,  # a path that is not there is a problem, not a redirection
        docs_url=None,  # FastAPI's pages load their scripts from other people's servers
        redoc_url=None,
    )
    app.state.settings = settings or Settings.read(os.environ)
    app.state.readiness = Readiness()
    app.state.compute = Compute(app.state.settings)
    app.state.metrics = Metrics(app.state.compute)
    app.include_router(router)
    app.include_router(metrics.router)
    app.include_router(open_router)
    _add_layers(app)
    return app


def _add_layers(app: FastAPI) -> None:
    """What a request passes on its way to a handler; the last one added is the first one passed."""
    settings: Settings = app.state.settings
    if settings.token is not None:  # innermost, where the router itself was
        app.router.middleware_stack = Guard(app.router.middleware_stack, open_router, settings.token)
    if settings.cors_origins:
        app.add_middleware(CrossOrigin, origins=settings.cors_origins)
    errors.install(app)
    app.add_middleware(Requests, metrics=app.state.metrics, readiness=app.state.readiness)


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    app.state.readiness.start()
    yield

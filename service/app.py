"""The application: wiring only."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import uvicorn
from fastapi import FastAPI
from uvicorn.config import LOGGING_CONFIG

import attitude

from . import errors, pages
from .compute import Compute
from .openapi import DescribedAPI
from .readiness import Readiness
from .routes import router
from .settings import Settings

# uvicorn's own log, and ours beside it in the same form
LOGGING: dict[str, Any] = {
    **LOGGING_CONFIG,
    "loggers": {
        **LOGGING_CONFIG["loggers"],
        __package__: {"handlers": ["default"], "level": "INFO", "propagate": False},
    },
}


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
    app.include_router(router)
    app.include_router(pages.router)
    errors.install(app)
    return app


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    app.state.readiness.start()
    yield


def serve(host: str | None = None, port: int | None = None) -> None:
    """Serve until SIGTERM or SIGINT; what is in flight is answered first.

    What is given here wins over the environment.  Raises InputError for a bad setting.
    """
    settings = Settings.read(os.environ, host=host, port=port)
    uvicorn.run(create_app(settings), host=settings.host, port=settings.port, log_config=LOGGING)

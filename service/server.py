"""`attitude serve`: uvicorn with the options that the settings give it."""

import os
import tempfile

import uvicorn

from . import logs
from .deadline import GRACE_S
from .metrics import DIRECTORY
from .settings import Settings, variable

# Longer than proxies keep a connection: they are to end it, who know whether they are about to use it.
KEEP_ALIVE_S = 75


def serve(**options: object) -> None:
    """Serve until SIGTERM or SIGINT; what was accepted is answered first.

    options : settings by their names (host, port, workers ...), which win over the environment

    Raises InputError for a bad setting, and SystemExit for an address that cannot be listened at.
    """
    settings = Settings.read(**options)
    given = {variable(name): str(value) for name, value in options.items() if value is not None}
    os.environ.update(given)  # where the application, in each worker's process, reads its settings
    with tempfile.TemporaryDirectory(prefix="attitude-metrics-") as directory:
        if settings.workers > 1:
            os.environ.setdefault(DIRECTORY, directory)
        uvicorn.run(
            "service.app:app",
            host=settings.host,
            port=settings.port,
            workers=settings.workers,
            ws="none",
            lifespan="on",
            log_config=logs.configuration(settings.log_level),
            access_log=False,
            server_header=False,
            timeout_keep_alive=KEEP_ALIVE_S,
            timeout_worker_healthcheck=60,  # a worker that starts on a busy machine does not answer at once
            timeout_graceful_shutdown=settings.max_seconds + GRACE_S,
        )

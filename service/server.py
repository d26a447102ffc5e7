"""`attitude serve`: uvicorn with the options that the settings give it."""

import os
import tempfile
from contextlib import ExitStack

import uvicorn

from attitude.errors import InputError

from . import logs
from .deadline import GRACE_S
from .metrics import DIRECTORY
from .settings import Settings, variable


def serve(**options: object) -> None:
    """Serve until SIGTERM or SIGINT; what was accepted is answered first.

    options : settings by their names (host, port, workers ...), which win over the environment

    Raises InputError for a bad setting, and SystemExit for an address that cannot be listened at.
    """
    settings = Settings.read(**options)
    given = {variable(name): str(value) for name, value in options.items() if value is not None}
    os.environ.update(given)  # where the application, in each worker's process, reads its settings
    is_to_be_added_up = settings.workers > 1 and DIRECTORY not in os.environ
    with folder_of_figures(settings.workers) if is_to_be_added_up else ExitStack():
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
            timeout_keep_alive=75,  # longer than proxies: they are to end a connection, who know its use
            timeout_worker_healthcheck=60,  # a worker that starts on a busy machine does not answer at once
            timeout_graceful_shutdown=settings.max_seconds + GRACE_S,
        )


def folder_of_figures(workers: int) -> ExitStack:
    """Return a folder with room for the figures of all workers: a process that finds none there dies."""
    with ExitStack() as stack:
        try:
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="attitude-metrics-"))
            with tempfile.TemporaryFile(dir=folder) as room:
                os.posix_fallocate(room.fileno(), 0, workers << 20)
        except OSError as error:
            expected = f"a folder that can be written to, for the figures of {workers} workers"
            raise InputError(DIRECTORY, error.strerror, expected) from None
        os.environ[DIRECTORY] = folder
        return stack.pop_all()

"""The process that listens: started, stopped, and never in the middle of an answer."""

from __future__ import annotations

import asyncio
import logging
import logging.config
import os
import signal
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

import uvicorn
from fastapi import FastAPI

from attitude.errors import AttitudeError

from . import logs
from .app import create_app
from .protocol import MOST_HEADER_BYTES, protocol
from .readiness import Readiness
from .settings import Settings

log = logging.getLogger(__name__)

BACKLOG = 2048
# Longer than proxies keep a connection: they are to end it, who know whether they are about to use it.
KEEP_ALIVE_S = 75
# For requests on connections that were accepted just before listening ended.
LINGER_S = 0.25
# How long a thread that computes may keep the interpreter; the event loop needs it several times a request.
SWITCH_S = 0.001
TICK_S = 0.1


class Server(uvicorn.Server):
    """uvicorn's, that stops in the order of a rolling update.

    From the signal on it is not ready, but takes what a balancer that has not noticed yet still sends;
    then it listens no more, and ends when the last answer has been sent.  SIGINT, from a keyboard, skips the
    wait.
    """

    def __init__(self, config: uvicorn.Config, readiness: Readiness, drain_seconds: int):
        super().__init__(config)
        self.readiness = readiness
        self.drain_seconds = drain_seconds
        self._hurried = False

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        self.readiness.stop()
        self._hurried = self._hurried or sig == signal.SIGINT
        super().handle_exit(sig, frame)

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """uvicorn raises the signal again when all is done, and would end as if killed by it."""
        before = {sig: signal.signal(sig, self.handle_exit) for sig in (signal.SIGINT, signal.SIGTERM)}
        try:
            yield
        finally:
            for sig, handler in before.items():
                signal.signal(sig, handler)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        log.info("stopping; what is in flight is answered first")
        await self._drain()
        for server in self.servers:
            server.close()
        for listener in sockets or []:
            listener.close()
        await asyncio.sleep(LINGER_S)
        await super().shutdown(sockets)
        log.info("shutdown complete")

    async def _drain(self) -> None:
        for _ in range(round(self.drain_seconds / TICK_S)):
            if self._hurried:
                return
            await asyncio.sleep(TICK_S)


def serve(**flags: object) -> None:
    """Serve until SIGTERM or SIGINT; what is in flight is answered first.

    flags : settings by their names (host, port, workers ...), which win over the environment

    Raises InputError for a bad setting, AttitudeError for an address that cannot be listened at, and
    SystemExit where a worker did not end as it should.
    """
    from . import workers

    settings = Settings.read(os.environ, **flags)
    logging.config.dictConfig(logs.configuration(settings.log_level))
    listener = listen(settings)
    told = {
        "address": address(listener),
        "workers": settings.workers,
        "threads": settings.computing_threads,
        "requests": settings.requests_in_flight,
    }
    log.info("listening at %s", told["address"], extra={logs.FIELDS: told})
    if settings.workers == 1:
        run(create_app(settings), listener)
    else:
        workers.supervise(settings, listener)


def run(app: FastAPI, listener: socket.socket) -> None:
    """One process's serving, to its end."""
    settings: Settings = app.state.settings
    sys.setswitchinterval(SWITCH_S)
    config = uvicorn.Config(
        app,
        http=protocol(settings, app.state.metrics.count_refusal),
        ws="none",
        lifespan="on",
        log_config=None,
        access_log=False,
        proxy_headers=False,  # nothing here depends on who asks
        server_header=False,
        backlog=BACKLOG,
        timeout_keep_alive=KEEP_ALIVE_S,
        h11_max_incomplete_event_size=MOST_HEADER_BYTES,
    )
    Server(config, app.state.readiness, settings.drain_seconds).run(sockets=[listener])


def listen(settings: Settings) -> socket.socket:
    """Raises AttitudeError for an address that cannot be listened at.

    The protocol is named, as `socket.create_server` does not: asyncio turns off the collecting of small
    packets only where it is, and answers would wait for acknowledgements.
    """
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((settings.host, settings.port))
        listener.listen(BACKLOG)
    except (OSError, UnicodeError) as error:
        listener.close()
        reason = getattr(error, "strerror", None) or str(error)
        raise AttitudeError(f"cannot listen at {settings.host}, port {settings.port}: {reason}") from None
    return listener


def address(listener: socket.socket) -> str:
    host, port = listener.getsockname()[:2]
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"

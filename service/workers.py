"""Several processes at one port: each with its own warm-up, kept alive and stopped together."""

from __future__ import annotations

import logging
import logging.config
import multiprocessing
import os
import signal
import socket
import tempfile
import threading
from collections.abc import Sequence
from multiprocessing.connection import wait
from typing import Any

from prometheus_client.multiprocess import mark_process_dead

from . import logs, server
from .app import create_app
from .metrics import DIRECTORY
from .settings import Settings

log = logging.getLogger(__name__)

OTHERS = "another worker is not ready"
LOOK_EVERY_S = 0.1
_spawning = multiprocessing.get_context("spawn")  # a forked process would have no threads of what it inherits


def supervise(settings: Settings, listener: socket.socket) -> None:
    """Keep the workers going until SIGTERM or SIGINT; SystemExit where one did not end as it should."""
    with tempfile.TemporaryDirectory(prefix="attitude-metrics-") as directory:
        os.environ[DIRECTORY] = directory
        try:
            code = _Supervisor(settings, listener).run()
        finally:
            del os.environ[DIRECTORY]
    if code:
        raise SystemExit(code)


class _Supervisor:
    def __init__(self, settings: Settings, listener: socket.socket):
        self.settings = settings
        self.listener = listener
        self.ready: Any = _spawning.RawArray("b", settings.workers)  # 1 for each worker that is warm
        self.signals = 0
        for sig in (signal.SIGINT, signal.SIGTERM):
            signal.signal(sig, self._count_signal)
        self.workers = [self._start(index) for index in range(settings.workers)]

    def run(self) -> int:
        """The exit code."""
        while not self.signals:
            wait([worker.sentinel for worker in self.workers], LOOK_EVERY_S)
            if not all(self._kept_alive(index) for index in range(len(self.workers))):
                self._stop()
                return 1
        return self._stop()

    def _count_signal(self, sig: int, frame: object) -> None:
        self.signals += 1

    def _start(self, index: int) -> Any:
        arguments = self.settings, self.listener, self.ready, index
        worker = _spawning.Process(target=work, args=arguments, name=f"worker {index}")
        worker.start()
        log.info("worker %d has process %d", index, worker.pid, extra={logs.FIELDS: {"worker": worker.pid}})
        return worker

    def _kept_alive(self, index: int) -> bool:
        """False where a worker ended before it was ready: the next one would too."""
        worker = self.workers[index]
        if worker.exitcode is None or self.signals:
            return True
        log.error("worker %d ended with exit code %d", index, worker.exitcode)
        mark_process_dead(worker.pid)  # type: ignore[no-untyped-call]
        if not self.ready[index]:
            return False
        self.ready[index] = 0
        self.workers[index] = self._start(index)
        return True

    def _stop(self) -> int:
        """Let them finish; a second signal does not wait for that."""
        self.listener.close()  # else the system would go on taking connections that nobody answers
        for worker in self.workers:
            worker.terminate()
        asked = max(1, self.signals)
        while waited_for := [worker.sentinel for worker in self.workers if worker.exitcode is None]:
            wait(waited_for, LOOK_EVERY_S)
            if self.signals > asked:
                for worker in self.workers:
                    worker.kill()
        return int(any(worker.exitcode for worker in self.workers))


def work(settings: Settings, listener: socket.socket, ready: Any, index: int) -> None:
    """A worker, in its own process."""
    logging.config.dictConfig(logs.configuration(settings.log_level))
    threading.Thread(target=_end_with_parent, name="parent", daemon=True).start()
    app = create_app(settings)
    app.state.readiness.join(_Board(ready, index))
    server.run(app, listener)


class _Board:
    """Where workers tell each other that they are warm."""

    def __init__(self, ready: Any, index: int):
        self._ready: Sequence[int] = ready
        self._index = index

    def tell(self) -> None:
        self._ready[self._index] = 1  # type: ignore[index]

    def obstacle(self) -> str | None:
        return None if all(self._ready) else OTHERS


def _end_with_parent() -> None:
    """Without it a worker would go on listening where nobody keeps it, or stops it."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os.kill(os.getpid(), signal.SIGTERM)

"""A service in a process of its own, as it is deployed; asked over sockets."""

from __future__ import annotations

import http.client
import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Any
from urllib.parse import urlsplit

from asking import READY_WITHIN_S, wait_until_ready

COMMAND = (sys.executable, "-m", "attitude.cli", "serve", "--port", "0")
UVICORN = (sys.executable, "-m", "uvicorn", "service.app:app", "--port", "0")


class Running:
    """Started with the settings given by name; `log` is what it has written so far."""

    def __init__(
        self, command: tuple[str, ...] = COMMAND, variables: dict[str, str] | None = None, **settings: Any
    ):
        environment = {name: value for name, value in os.environ.items() if not name.startswith("ATTITUDE_")}
        environment |= {f"ATTITUDE_{name.upper()}": str(value) for name, value in settings.items()}
        environment |= variables or {}
        self._written = Path(tempfile.mkstemp(suffix=".log")[1])
        with self._written.open("wb") as log:
            self.process = subprocess.Popen(command, stderr=log, env=environment)

    def __enter__(self) -> Running:
        try:
            wait_until_ready(lambda: self.address is not None)
            wait_until_ready(self._is_ready)
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def _is_ready(self) -> bool:
        try:
            return self.get("/readyz")[0] == 200
        except ConnectionRefusedError:  # bound, and no worker listens yet
            return False

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        if error is not None:
            print(*self.log[-50:], sep="\n", file=sys.stderr)
        self._written.unlink()

    @property
    def log(self) -> list[dict[str, Any]]:
        """Every whole line."""
        text = self._written.read_text()
        lines = text[: text.rfind("\n") + 1].splitlines()
        return [json.loads(line) if line.startswith("{") else {"message": line} for line in lines]

    @property
    def address(self) -> tuple[str, int] | None:
        assert self.process.poll() is None, self._written.read_text()
        for line in self.log:
            if found := re.search(r"running on (http://\S+)", line["message"]):
                parts = urlsplit(found[1])
                assert parts.hostname
                assert parts.port
                return parts.hostname, parts.port
        return None

    def connect(self) -> socket.socket:
        address = self.address
        assert address is not None
        return socket.create_connection(address, timeout=60)

    def ask(
        self, method: str, path: str, body: Any = None, **headers: str
    ) -> tuple[int, dict[str, str], bytes]:
        """Status, headers, content; on a connection of its own."""
        assert self.address is not None
        connection = http.client.HTTPConnection(*self.address, timeout=60)
        try:
            named = {name.replace("_", "-"): value for name, value in headers.items()}
            if body is not None:
                body, named = json.dumps(body), {"content-type": "application/json"} | named
            connection.request(method, path, body, named)
            answer = connection.getresponse()
            return answer.status, {k.lower(): v for k, v in answer.getheaders()}, _whole(answer)
        finally:
            connection.close()

    def get(self, path: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
        return self.ask("GET", path, **headers)

    def post(self, path: str, document: Any, **headers: str) -> tuple[int, dict[str, str], bytes]:
        return self.ask("POST", path, document, **headers)

    def stop(self, sig: int = signal.SIGTERM) -> int:
        """Its exit code."""
        self.process.send_signal(sig)
        return self.process.wait(READY_WITHIN_S)


def _whole(answer: http.client.HTTPResponse) -> bytes:
    """A reset is an error of its own where an answer has begun."""
    try:
        return answer.read()
    except ConnectionError as error:
        raise AssertionError("an answer that ends before its end") from error


def everything(bare: socket.socket) -> bytes:
    """What comes until the other side ends the connection."""
    parts = []
    while part := bare.recv(1 << 16):
        parts.append(part)
    return b"".join(parts)

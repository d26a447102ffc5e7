"""What the benchmarks of the service share: servers as processes of their own, and clients on the loopback.

The clients are bare sockets: a library's parsing of an answer would be measured with it.
"""

from __future__ import annotations

import itertools
import os
import re
import selectors
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]
OURS = "from service import serve; serve(port={port})"
ECHO = """
import uvicorn
from fastapi import FastAPI
from attitude.scene.document import Scene
app = FastAPI()
@app.post("/")
async def echo(scene: Scene) -> Scene:
    return scene
uvicorn.run(app, port={port})
"""
LARGE = {"ATTITUDE_MAX_SAMPLES": "10000000", "ATTITUDE_MAX_SECONDS": "600"}
WITHIN_S = 300
RECEIVED = 1 << 20  # bytes at a time


@contextmanager
def serving(code, path, environment=()):
    """(port, process) of a server that answers GET `path` by anything but a refusal of its own readiness."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    around = os.environ | {"PYTHONPATH": str(ROOT), **dict(environment)}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen([sys.executable, "-c", code.format(port=port)], env=around, **quiet)
    try:
        _wait(port, path, process)
        yield port, process
    finally:
        process.terminate()
        process.wait()


def _wait(port, path, process):
    deadline = time.monotonic() + WITHIN_S
    asked = f"GET {path} HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\r\n".encode()
    while True:
        assert process.poll() is None, "the server has ended"
        try:
            with socket.create_connection(("127.0.0.1", port)) as connection:
                connection.sendall(asked)
                if connection.recv(RECEIVED)[9:12] not in (b"503", b""):
                    return
        except OSError:
            pass
        assert time.monotonic() < deadline
        time.sleep(0.1)


def request_bytes(path, document, headers=""):
    """A POST of a document, ready to be sent."""
    head = f"POST {path} HTTP/1.1\r\nhost: x\r\ncontent-type: application/json\r\n"
    return f"{head}content-length: {len(document)}\r\n{headers}\r\n".encode() + document


# -- one whole request --------------------------------------------------------------------------------


def ask(connection, request):
    """The answer's content, whole."""
    connection.sendall(request)
    received = bytearray()
    while (end := received.find(b"\r\n\r\n")) < 0:
        received += _received(connection)
    head, rest = bytes(received[:end]).lower(), received[end + 4 :]
    assert head.startswith(b"http/1.1 200"), bytes(received[:2000])
    length = re.search(rb"content-length: (\d+)", head)
    return _fixed(connection, rest, int(length[1])) if length else _chunked(connection, rest)


def _received(connection):
    data = connection.recv(RECEIVED)
    assert data, "the server hung up"
    return data


def _fixed(connection, rest, length):
    content = bytearray(length)
    content[: len(rest)] = rest
    view, have = memoryview(content), len(rest)
    while have < length:
        count = connection.recv_into(view[have:])
        assert count
        have += count
    return content


def _chunked(connection, rest):
    content = bytearray()
    while True:
        while (end := rest.find(b"\r\n")) < 0:
            rest += _received(connection)
        size = int(rest[:end], 16)
        rest = rest[end + 2 :]
        missing = size + 2 - len(rest)
        if missing > 0:
            rest += _fixed(connection, b"", missing)
        if not size:
            return content
        content += memoryview(rest)[:size]
        rest = rest[size + 2 :]


def drained(connection, request):
    """Bytes of the answer, counted and dropped: for answers too large to be held."""
    connection.sendall(request)
    total, last, room = 0, b"", bytearray(RECEIVED)
    while not last.endswith(b"\r\n0\r\n\r\n"):
        count = connection.recv_into(room)
        assert count
        total += count
        last = (last + room[max(0, count - 16) : count])[-16:]
    return total


def receive(connection, request, room):
    """All of an answer in chunks, as it comes, into `room`; how many bytes.

    Nothing is copied or looked through: that would be measured too.
    """
    connection.sendall(request)
    view, have = memoryview(room), 0
    while room[have - 7 : have] != b"\r\n0\r\n\r\n":
        count = connection.recv_into(view[have:])
        assert count
        have += count
    return have


# -- many small ones ----------------------------------------------------------------------------------


def requests_per_second(port, requests, connections, seconds):
    """One after the other, on each connection as soon as its answer is whole, which has a content-length."""
    chooser, requests = selectors.DefaultSelector(), itertools.cycle(requests)
    for _ in range(connections):
        connection = socket.create_connection(("127.0.0.1", port))
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        chooser.register(connection, selectors.EVENT_READ, bytearray())
        connection.sendall(next(requests))
    done, begun = 0, time.perf_counter()
    while (passed := time.perf_counter() - begun) < seconds:
        for key, _ in chooser.select(timeout=1):
            key.data.extend(_received(key.fileobj))
            if _is_whole(key.data):
                assert key.data.startswith(b"HTTP/1.1 200"), bytes(key.data)
                key.data.clear()
                done += 1
                key.fileobj.sendall(next(requests))
    for key in list(chooser.get_map().values()):
        key.fileobj.close()
    return done / passed


LENGTH = re.compile(rb"content-length: (\d+)", re.IGNORECASE)


def _is_whole(data):
    end = data.find(b"\r\n\r\n")
    return end >= 0 and len(data) - end - 4 >= int(LENGTH.search(data, 0, end + 2)[1])


def resident(pid, field="VmRSS"):
    """MiB of a process: VmRSS now, or VmHWM, the most so far."""
    text = Path(f"/proc/{pid}/status").read_text()
    return int(re.search(field + r":\s+(\d+)", text)[1]) / 1024


def forget_peak(pid):
    Path(f"/proc/{pid}/clear_refs").write_text("5")

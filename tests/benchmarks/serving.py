"""What the benchmarks of the service share: servers as processes of their own, and clients on the loopback.

Where time is measured the clients are bare sockets: a library's parsing would be measured with it.
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
from attitude.scene.scene import Scene
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


def request_bytes(path, document):
    """A POST of a document, ready to be sent."""
    head = f"POST {path} HTTP/1.1\r\nhost: x\r\ncontent-type: application/json\r\n"
    return f"{head}content-length: {len(document)}\r\n\r\n".encode() + document


# -- one whole request --------------------------------------------------------------------------------


def answered(connection, path, document):
    """The response of an `http.client.HTTPConnection` to a posted document."""
    connection.request("POST", path, document, {"content-type": "application/json"})
    response = connection.getresponse()
    assert response.status == 200, response.read()[:2000]
    return response


def ask(connection, path, document):
    """The answer's content, whole."""
    return answered(connection, path, document).read()


def drained(connection, path, document):
    """Bytes of the answer, counted and dropped: for answers too large to be held."""
    response, total, room = answered(connection, path, document), 0, bytearray(RECEIVED)
    while count := response.readinto(room):
        total += count
    return total


def receive(sock, request, room):
    """All of an answer in chunks, as it comes, into `room`; how many bytes.

    Nothing is copied or looked through: that would be measured too.
    """
    sock.sendall(request)
    view, have = memoryview(room), 0
    while room[have - 7 : have] != b"\r\n0\r\n\r\n":
        count = sock.recv_into(view[have:])
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
            received = key.fileobj.recv(RECEIVED)
            assert received, "the server hung up"
            key.data.extend(received)
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

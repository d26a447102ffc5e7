"""Count functions, files and changes of file in one request, by `sys.setprofile`.

    python tests/benchmarks/call_path.py [-v]

Two questions are traced, each as the second of its kind in the process, so that imports, compiled kernels
and tables are there already: the command `attitude run toutatis`, and a document of two instants that is
posted to `/v1/ephemeris`.  Only functions of `attitude` and `service` count; generated code does not.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import threading
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = (str(ROOT / "attitude"), str(ROOT / "service"))


class Count(NamedTuple):
    """Distinct functions and files that were entered, and how often control passed to another file."""

    functions: int
    files: int
    changes: int


class Tracer:
    """Records the functions that are entered while `count` runs.

    A profile function is set for a thread when it starts, so a tracer is made before any thread that is to be
    traced (Python 3.11 cannot set one for a running thread).
    """

    def __init__(self) -> None:
        self._entered: list[Any] | None = None
        threading.setprofile(self._profile)
        sys.setprofile(self._profile)

    def _profile(self, frame: Any, event: str, argument: Any) -> None:
        if event == "call" and self._entered is not None and frame.f_code.co_filename.startswith(PACKAGES):
            self._entered.append(frame.f_code)

    def count(self, question: Callable[[], Any]) -> Count:
        """What `question()` passes through, in all threads."""
        entered = self._entered = []
        question()
        self._entered = None
        if "-v" in sys.argv:
            print(*(f"{code.co_filename[len(str(ROOT)) :]} {code.co_qualname}" for code in entered), sep="\n")
        files = [code.co_filename for code in entered]
        changes = sum(a != b for a, b in pairwise(files))
        return Count(len(set(entered)), len(set(files)), changes)


def run_toutatis() -> None:
    """`attitude run toutatis`, its text thrown away."""
    from attitude.cli import main

    with contextlib.redirect_stdout(io.TextIOWrapper(io.BytesIO())):
        assert main(["run", "toutatis"]) == 0


def post_two_instants(client: Any) -> None:
    """A document of two instants, over HTTP without a socket."""
    document = {
        "body": {"moments": [3.0836, 3.235, 1.0], "unit": "kg m2"},
        "attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"},
        "angular_velocity": {"value": [14.51, 33.529, -98.709], "unit": "deg/d"},
        "times": {"elapsed": [0, 86400], "unit": "s"},
    }
    answer = client.post("/v1/ephemeris", content=json.dumps(document))
    assert answer.status_code == 200, answer.text


def main() -> None:
    """Print both counts; with -v also the calls, in order."""
    from starlette.testclient import TestClient

    from service import create_app
    from service.settings import Settings

    tracer = Tracer()
    run_toutatis()
    print("attitude run toutatis:", tracer.count(run_toutatis))
    with TestClient(create_app(Settings())) as client:
        client.headers["Content-Type"] = "application/json"
        while client.get("/readyz").status_code != 200:  # until then, seconds of compiling count as computing
            time.sleep(0.1)
        post_two_instants(client)
        print("posted document of two instants:", tracer.count(lambda: post_two_instants(client)))


if __name__ == "__main__":
    main()

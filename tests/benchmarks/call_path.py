"""Count functions, files and changes of file in one request, by `sys.setprofile`.

    python tests/benchmarks/call_path.py

Two requests are traced, each as the second of its kind in the process, so that imports, compiled kernels and
tables are loaded: the command `attitude run toutatis`, and a document of two instants posted to
`/v1/ephemeris`.  Only functions of `attitude` and `service` count; generated code does not.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import threading
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


def traced(question: Callable[[], Any]) -> Count:
    """What `question()` passes through, in all threads that it starts or uses."""
    functions: set[Any] = set()
    entered: list[str] = []

    def profile(frame: Any, event: str, argument: Any) -> None:
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(PACKAGES):
            functions.add(code)
            entered.append(code.co_filename)

    threading.setprofile_all_threads(profile) if hasattr(threading, "setprofile_all_threads") else None
    threading.setprofile(profile)
    sys.setprofile(profile)
    try:
        question()
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
        if hasattr(threading, "setprofile_all_threads"):
            threading.setprofile_all_threads(None)
    changes = sum(a != b for a, b in pairwise(entered))
    return Count(len(functions), len(set(entered)), changes)


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
    """Print both counts."""
    from starlette.testclient import TestClient

    from service.app import app

    run_toutatis()
    print("attitude run toutatis:", traced(run_toutatis))
    with TestClient(app) as client:
        client.headers["Content-Type"] = "application/json"
        post_two_instants(client)
        print("posted document of two instants:", traced(lambda: post_two_instants(client)))


if __name__ == "__main__":
    main()

"""A computation that ignores its deadline ends with its process, and nothing else is lost."""

from __future__ import annotations

import os
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

from asking import PROBLEM, wait_until_ready
from running import Running

HERE = str(Path(__file__).parent)
NEVER_ENDING = (sys.executable, "-m", "uvicorn", "never_ending:app", "--app-dir", HERE, "--port", "0")
LIMIT_S = 1


def posted(running, path):
    """The thread of a request whose answer nobody waits for."""

    def post():
        with suppress(OSError):  # the process ends
            running.post(path, {})

    client = threading.Thread(target=post)
    client.start()
    return client


def test_one_of_several_processes_ends_where_a_computation_is_stuck_and_is_replaced():
    with Running((*NEVER_ENDING, "--workers", "2"), max_seconds=LIMIT_S, threads=1) as running:
        lines = [line for line in running.log if line["message"].startswith("Started server process")]
        assert len(lines) == 2
        assert running.post("/ignores-stop", {})[0] == 422  # at its limit, in a process that does not end yet
        wait_until_ready(lambda: any("died" in line["message"] for line in running.log))
        wait_until_ready(lambda: sum(line["message"].startswith("ready:") for line in running.log) == 3)
        assert all(running.get("/healthz")[0] == 200 for _ in range(10))
        assert running.stop() == 0


def test_process_alone_says_that_it_is_unhealthy_and_ends_when_it_is_told_to():
    """Nothing would replace it but what asks for its health."""
    with Running(NEVER_ENDING, max_seconds=LIMIT_S, threads=2) as running:
        assert running.post("/ignores-stop", {})[0] == 422
        wait_until_ready(lambda: running.get("/healthz")[0] == 503)
        assert running.post("/v1/motion", {})[1]["content-type"] == PROBLEM
        assert ends_within_its_time(running)


def test_process_whose_interpreter_is_held_ends_too():
    with Running(NEVER_ENDING, max_seconds=LIMIT_S, threads=1) as running:
        client = posted(running, "/holds-lock")
        time.sleep(0.3)
        assert ends_within_its_time(running)
        client.join()


def ends_within_its_time(running):
    """Longer where others compute on the machine too: by as much as each of them gets less of it."""
    begun = time.monotonic()
    assert running.stop() == 1
    share = max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))
    return time.monotonic() - begun < (LIMIT_S + 2) * share

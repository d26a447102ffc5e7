"""No document occupies the service longer than its limit and a second: the table of hostile.py, over HTTP.

That a computation took more of a processor's time is a warning in the log (service/deadline.py), which does
not depend on what else the machine does.
"""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from http.client import IncompleteRead

import pytest
from hostile import HOSTILE
from running import Running

THREADS = 8  # at once: each takes its limit
LIMIT_S = 1
AT_ONCE_S = 0.1
CUT = "cut"


@pytest.fixture(scope="module")
def answered():
    """The service, and the status of each hostile request, all of which have been answered."""
    with Running(max_seconds=LIMIT_S, threads=THREADS) as running, ThreadPoolExecutor(THREADS) as clients:
        requests = {name: clients.submit(status, running, *request) for name, request in HOSTILE.items()}
        yield running, {name: answer.result() for name, answer in requests.items()}


def status(running, *request):
    """Of an answer; CUT where it had begun when its seconds were used up."""
    try:
        return running.post(*request)[0]
    except IncompleteRead:
        return CUT


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_request_is_answered_or_refused(answered, name):
    assert answered[1][name] in (200, 422, 503, CUT)


def test_all_computations_ended_soon_after_their_limit(answered):
    running, _ = answered
    assert not [line for line in running.log if "a computation took" in line["message"]]
    assert running.get("/healthz")[0] == 200


def test_next_request_is_answered_at_once(answered, document):
    running, _ = answered
    seconds = []
    for _ in range(10):
        begun = time.monotonic()
        assert running.post("/v1/ephemeris", document)[0] == 200
        seconds.append(time.monotonic() - begun)
    assert min(seconds) < AT_ONCE_S

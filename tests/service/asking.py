"""What several tests of the service share."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from typing import Any

from attitude import Scene
from attitude.formats.tables import json

# Limits of the service that the tests ask.
MAX_SAMPLES = 10_000
MAX_BODY_BYTES = 20_000
# Compiling the kernel takes most of a minute on a busy machine; loading it takes a second.
READY_WITHIN_S = 300
PROBLEM = "application/problem+json"


def wait_until_ready(is_ready: Callable[[], bool]) -> None:
    deadline = time.monotonic() + READY_WITHIN_S
    while not is_ready():
        assert time.monotonic() < deadline, f"not ready within {READY_WITHIN_S} s"
        time.sleep(0.05)


def assert_problem(answer: Any, status: int) -> dict[str, Any]:
    """What every problem has; returns it."""
    assert answer.status_code == status
    assert answer.headers["content-type"] == PROBLEM
    problem: dict[str, Any] = answer.json()
    assert problem["status"] == status
    assert {"type", "title", "detail"} <= set(problem)
    assert "\n" not in problem["detail"]
    return problem


def without_cost(content: bytes) -> bytes:
    """The bytes of an answer but for what no two answers share: the time they took."""
    without, times = re.subn(rb',"cost":\{"set_up_s":[^{}]*\}\}\n', b"}\n", content)
    assert times == 1
    return without


def library_json(scene: Scene) -> bytes:
    """What the library itself makes of a scene, without what that took."""
    return without_cost(b"".join(json.blocks_with_plan(scene.samples())))

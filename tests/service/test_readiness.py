"""Ready means: the kernel is compiled, and a known case came out right."""

from __future__ import annotations

import subprocess
import sys

import pytest
from asking import assert_problem, wait_until_ready
from starlette.testclient import TestClient

from service import create_app, readiness
from service.settings import Settings

WARMING = "the kernel is being compiled or loaded"


def test_alive_before_ready(cold_client):
    assert cold_client.get("/healthz").status_code == 200
    assert assert_problem(cold_client.get("/readyz"), 503)["detail"] == WARMING


def test_ready_once_the_warm_up_is_over(client):
    assert client.get("/readyz").json() == {"status": "ready"}


def test_wrong_known_case_keeps_the_service_unready_and_says_why(monkeypatch):
    w, x, y, z = readiness.KNOWN_QUATERNION_WXYZ
    monkeypatch.setattr(readiness, "KNOWN_QUATERNION_WXYZ", (w, x, y, z + 2 * readiness.KNOWN_WITHIN))
    with TestClient(create_app(Settings())) as client:
        wait_until_ready(lambda: client.get("/readyz").json()["detail"] != WARMING)
        assert "nasa-brick" in assert_problem(client.get("/readyz"), 503)["detail"]
        assert client.get("/healthz").status_code == 200


def test_failing_warm_up_keeps_the_service_unready_and_tells_no_secret(monkeypatch):
    def fail():
        raise OSError("a secret of /srv/attitude")

    monkeypatch.setattr(readiness, "warm_up", fail)
    with TestClient(create_app(Settings())) as client:
        wait_until_ready(lambda: client.get("/readyz").json()["detail"] != WARMING)
        assert assert_problem(client.get("/readyz"), 503)["detail"].startswith(
            "the warm-up ended with an unexpected error"
        )


def test_known_case_is_within_a_tenth_of_what_the_check_allows():
    """So the check can only fail for a kernel that is wrong, not for another processor's rounding."""
    quaternion = readiness.Scene.builtin(readiness.KNOWN_SCENE).run().quaternion("wxyz")[-1]
    assert quaternion == pytest.approx(readiness.KNOWN_QUATERNION_WXYZ, rel=0, abs=1e-13)


# Listens for compilations after the warm-up, in requests of many more kinds.
COUNT = """
import sys
from attitude import Scene
from attitude.runtime import compiled, kernel_cache
from attitude.formats.tables import json
from service import readiness
from attitude.scene.motion_summary import motion_summary

readiness.warm_up()
compilations = []
kernel_cache.on_compilation.append(compilations.append)
base = Scene.builtin("nasa-brick").document()
epoch = {"epoch": {"time": "2026-01-01T00:00:00", "scale": "tt"}}
forms = [
    {"body": {"tensor": [[2, 0.1, 0.2], [0.1, 3, 0], [0.2, 0, 4]], "unit": "g cm2"}},
    {"body": {"moments": [1, 1, 1], "unit": "kg m2"}},
    {"body": {"moments": [1, 1, 2], "unit": "kg m2"}},
    {"angular_velocity": {"value": [0, 0, 0], "unit": "rad/s"}},
    {"angular_velocity": {"value": [0, 1, 1e-12], "unit": "rad/s"}},
    {"times": {"elapsed": [5], "unit": "s"}},
    {"times": {"elapsed": [0.1, 3], "unit": "d"}},
    {"times": {"start": -3, "stop": 3, "count": 7, "unit": "h"}},
    {"times": {"start": 0, "stop": 0.3, "step": 0.1, "unit": "s"}},
    {"times": {"dates": ["2026-01-01T00:00:00", "2027-06-01T00:00:00.123"], "scale": "utc"}},
    {"times": {"dates": ["2026-01-01T00:00:01"], "scale": "tai"}},
    {"attitude": {"mrp": [0.1, 0.2, 0.3]}},
]
for change in forms:
    for dated in ({}, epoch):
        if "dates" in change.get("times", {}) and not dated:
            continue
        scene = Scene.model_validate(base | dated | change)
        json.dumps(scene.run())
        motion_summary(scene.motion(), scene.name)
assert "sample" in {signature.kernel for signature in compiled.loaded()}
assert not compilations
assert "numba" not in sys.modules
"""


def test_no_request_waits_for_a_compiler_after_the_warm_up():
    subprocess.run([sys.executable, "-c", COUNT], check=True, timeout=600)

"""A service with small limits, asked through the client as anybody would."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from asking import MAX_BODY_BYTES, MAX_SAMPLES, wait_until_ready
from starlette.testclient import TestClient

from service import create_app
from service.settings import Settings


@pytest.fixture(scope="session", autouse=True)
def nothing_is_frozen() -> Iterator[None]:
    """What a warm-up freezes has no referrers for the collector, and Hypothesis warns where it finds none."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("gc.freeze", lambda: None)
        yield


@pytest.fixture(scope="session")
def client() -> Iterator[TestClient]:
    """A running service, warm; unexpected errors come as answers, not as exceptions."""
    app = create_app(Settings(max_samples=MAX_SAMPLES, max_body_bytes=MAX_BODY_BYTES))
    with TestClient(app, raise_server_exceptions=False) as client:
        wait_until_ready(lambda: client.get("/readyz").status_code == 200)
        yield client


@pytest.fixture
def cold_client() -> TestClient:
    """A service whose warm-up has not begun."""
    return TestClient(create_app(Settings()), raise_server_exceptions=False)


@pytest.fixture
def document() -> dict[str, Any]:
    """A scene that is right, for tests to spoil."""
    return {
        "name": "tumbling box",
        "body": {"moments": [1.0, 2.0, 2.5], "unit": "kg m2"},
        "epoch": {"time": "2026-01-01T00:00:00", "scale": "utc"},
        "frame": "ICRF",
        "attitude": {"quaternion": [1.0, 0.0, 0.0, 0.0], "order": "wxyz"},
        "angular_velocity": {"value": [0.1, 1.0, 0.2], "unit": "rad/s"},
        "times": {"start": 0, "stop": 10, "step": 0.1, "unit": "s"},
        "effects": [],
    }

"""The service against its own description: what it promises and takes, by generated requests.

A few cases of each route here; all checks over some thousands, against a process, by

    st --config-file tests/service/schemathesis.toml run URL/openapi.json --checks all --max-examples 200
"""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from worked import examples

CONFIG = Path(__file__).with_name("schemathesis.toml")
FILES = {"/v1/convert", "/v1/check", "/v1/compare"}
SLOW = "/v1/cost"  # measures, for seconds


@pytest.fixture(scope="module")
def described(client):
    import schemathesis  # takes seconds, which only this file has to spend

    config = schemathesis.config.SchemathesisConfig.from_path(CONFIG)
    return schemathesis.openapi.from_asgi("/openapi.json", client.app, config=config)


@pytest.mark.parametrize("path", sorted({*examples(), *FILES} - {SLOW}))
def test_service_keeps_to_its_description(described, path):
    (operation,) = described[path].values()

    @given(operation.as_strategy())
    @settings(max_examples=10, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
    def check(case):
        case.call_and_validate()

    check()

"""The description: valid references, the document's schema, and an example that works."""

from __future__ import annotations

import pytest

from attitude import Scene

COMPUTING = ("/v1/ephemeris", "/v1/plan", "/v1/motion")


@pytest.fixture(scope="module")
def description(client):
    return client.get("/openapi.json").json()


def references(node):
    if isinstance(node, dict):
        if isinstance(node.get("$ref"), str):
            yield node["$ref"]
        for child in node.values():
            yield from references(child)
    elif isinstance(node, list):
        for child in node:
            yield from references(child)


def test_every_reference_leads_somewhere(description):
    found = set(references(description))
    assert "#/components/schemas/Scene" in found
    for reference in found:
        node = description
        for step in reference.removeprefix("#/").split("/"):
            node = node[step]


def test_description_has_every_route(description):
    assert set(description["paths"]) == {
        "/v1/ephemeris",
        "/v1/motion",
        "/v1/plan",
        "/v1/scenes",
        "/v1/scenes/{name}",
        "/healthz",
        "/readyz",
        "/version",
        "/metrics",
    }


@pytest.mark.parametrize("path", COMPUTING)
def test_example_in_the_description_is_answered(client, description, path):
    request = description["paths"][path]["post"]["requestBody"]["content"]["application/json"]
    assert request["example"] == Scene.builtin("envisat" if path == "/v1/plan" else "toutatis").document()
    assert client.post(path, json=request["example"]).status_code == 200


def test_every_route_promises_problems_and_nothing_else(description):
    for path in description["paths"].values():
        for operation in path.values():
            assert set(operation["responses"]) == {"200", "default"}
            assert set(operation["responses"]["default"]["content"]) == {"application/problem+json"}


def test_schema_of_the_document_is_the_librarys(description):
    fields = description["components"]["schemas"]["Scene"]["properties"]
    assert set(fields) == set(Scene.model_fields)


def test_no_page_loads_scripts_from_elsewhere(client):
    assert client.get("/docs").status_code == 404
    assert client.get("/redoc").status_code == 404

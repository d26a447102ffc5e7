"""The description: valid references, the document's schema, and worked examples that work."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import get_type_hints

import pytest
from jsonschema import Draft202012Validator
from worked import answered, examples, examples_of, routes

from attitude import Scene
from attitude.cost import Cell
from attitude.cost.answers import CostCell, CostGrowth
from attitude.cost.report import Growth
from attitude.scene.builtin_scenes import builtin_names


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
        "/v1/convert",
        "/v1/check",
        "/v1/compare",
        "/v1/motion",
        "/v1/plan",
        "/v1/windows",
        "/v1/cost",
        "/v1/fit",
        "/v1/scenes",
        "/v1/scenes/{name}",
        "/healthz",
        "/readyz",
        "/version",
        "/metrics",
    }


@pytest.mark.parametrize("path", sorted(examples()))
def test_worked_examples_are_what_is_answered(client, description, path):
    """All that an answer says, but for times, versions and machines, which differ from run to run."""
    method, operation = next(iter(description["paths"][path].items()))
    assert examples_of(operation) == examples()[path]
    for name, expected in examples()[path]["answers"].items():
        answer = answered(client, method, path, name, examples()[path].get("requests", {}).get(name))
        assert_alike(answer, expected, MINIMUM if path == "/v1/fit" else DIGITS)


def test_every_described_route_has_a_worked_example(description):
    assert set(examples()) | {"/metrics", "/v1/convert", "/v1/check", "/v1/compare"} == set(
        description["paths"]
    )
    assert set(routes(description)) >= set(examples())


VARYING = ("cost", "version", "attitude", "python", "numpy", "numba", "astropy")
MEASURED = "attitude-cost/1"
DIGITS = {"rel_tol": 1e-13, "abs_tol": 1e-15}  # a few units of the last one
MINIMUM = {"rel_tol": 1e-6, "abs_tol": 1e-9}  # of a sum of squares: where the search for it stops


def assert_alike(found, expected, tolerance):
    """The same structure, and numbers within the tolerance."""
    assert type(found) is type(expected)
    if isinstance(found, dict):
        assert set(found) == set(expected)
        if found.get("kind") == MEASURED:
            return
        for name in set(found) - set(VARYING):
            assert_alike(found[name], expected[name], tolerance)
    elif isinstance(found, list):
        for one, other in zip(found, expected, strict=True):
            assert_alike(one, other, tolerance)
    elif isinstance(found, float):
        assert math.isclose(found, expected, **tolerance)
    else:
        assert found == expected


STATES = {  # moments and rates whose constants are infinite, or not there
    "separatrix": ([3, 5, 6], [1, 1, 1]),
    "symmetric": ([1, 1, 1.5], [1, 0, 1]),
    "rest": ([3, 5, 6], [0, 0, 0]),
}


def free(moments, rate):
    unit = {"body": {"moments": moments, "unit": "kg m2"}}
    return {"scene": "toutatis", "angular_velocity": {"value": rate, "unit": "rad/s"}} | unit


SCENES = [*({"scene": name} for name in builtin_names()), *(free(*each) for each in STATES.values())]
ASKED = [(path, scene) for path in ("/v1/plan", "/v1/motion") for scene in SCENES]
ASKED += [(path, *examples()[path]["requests"].values()) for path in ("/v1/fit", "/v1/windows")]


@pytest.mark.parametrize(("path", "asked"), ASKED)
def test_answers_are_as_described_and_say_nothing_else(client, description, path, asked):
    schema = description["paths"][path]["post"]["responses"]["200"]["content"]["application/json"]["schema"]
    answer = client.post(path, json=asked).json()
    Draft202012Validator({"components": description["components"], **schema}).validate(answer)
    model = description["components"]["schemas"][schema["$ref"].rpartition("/")[2]]
    assert set(answer) <= set(model["properties"])


def test_cells_of_a_cost_are_described_as_the_library_makes_them():
    """Apart from what measures, whose import takes 100 MiB."""
    for described, made in ((CostCell, Cell), (CostGrowth, Growth)):
        kinds = {name: kind for name, kind in get_type_hints(described).items() if name != "status"}
        assert [*get_type_hints(described)] == [field.name for field in fields(made)]
        assert kinds.items() <= get_type_hints(made).items()


def test_every_route_promises_problems_and_nothing_else(description):
    for path, operations in description["paths"].items():
        if path == "/metrics":
            continue
        for operation in operations.values():
            assert {"200", "default"} <= set(operation["responses"]) <= {"200", "304", "default"}
            assert set(operation["responses"]["default"]["content"]) == {"application/problem+json"}


def test_limits_of_parameters_are_described_as_they_are_checked(description):
    def schema(path, name):
        parameters = description["paths"][path]["post"]["parameters"]
        (found,) = (each["schema"] for each in parameters if each["name"] == name)
        return found

    samples, error = schema("/v1/cost", "samples"), schema("/v1/ephemeris", "interpolation_error")
    assert (samples["minimum"], samples["maximum"]) == (2, 100_000)
    assert (error["exclusiveMinimum"], error["maximum"]) == (0, 1)
    assert not {"ge", "le"} & {*samples, *error}


def test_schema_of_the_document_is_the_librarys(description):
    fields = description["components"]["schemas"]["Scene"]["properties"]
    assert set(fields) == {*Scene.model_fields, "scene", "apm"}

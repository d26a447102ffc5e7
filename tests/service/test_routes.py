"""Answers: what the library computed, to the bit."""

from __future__ import annotations

import platform
import re
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import orjson
import pytest
from asking import assert_problem, library_json, without_cost
from starlette.responses import Response

import attitude
from attitude import Scene
from attitude.scene.builtin_scenes import builtin_names
from attitude.scene.motion_summary import motion_summary
from service import computations


def test_answer_says_what_it_cost_and_is_worth(client, document):
    answer = client.post("/v1/ephemeris", json=document).json()
    said, cost, plan = answer["plan"], answer["cost"], Scene(**document).run().plan
    assert (said["solver"], said["samples"]) == (plan.solver, plan.samples)
    assert (said["error_bound_rad"], said["error_bound_source"]) == (plan.error_bound, plan.bound_source)
    assert answer["version"] == attitude.__version__
    assert 0.0 < cost["sample_s"] < 60.0
    assert 0.0 < cost["set_up_s"] < 60.0


@pytest.mark.parametrize("name", builtin_names())
def test_built_in_scene_comes_back_as_a_document_that_answers(client, name):
    scene = client.get(f"/v1/scenes/{name}")
    assert scene.json() == Scene.builtin(name).document()
    answer = client.post("/v1/ephemeris", content=scene.content, headers={"content-type": "application/json"})
    assert answer.headers["content-type"] == "application/json"
    assert without_cost(answer.content) == library_json(Scene.builtin(name))
    # orjson writes NaN as null without a word
    assert not any(None in column for column in answer.json()["columns"].values())


@pytest.mark.parametrize("name", builtin_names())
def test_motion_answer_is_the_librarys_own_bytes(client, name):
    scene = Scene.builtin(name)
    answer = client.post("/v1/motion", json=scene.document())
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "application/json"
    assert answer.content == motion_summary(scene.motion(), scene.name)


def test_list_of_scenes_names_every_built_in_one_and_where_it_is(client):
    scenes = client.get("/v1/scenes").json()["scenes"]
    assert [scene["name"] for scene in scenes] == builtin_names()
    for scene in scenes:
        document = client.get(scene["href"]).json()
        assert (scene["title"], scene["description"]) == (document["name"], document["description"])


def test_version_names_the_package_and_what_it_computes_with(client):
    answer = client.get("/version").json()
    assert set(answer) == {"attitude", "python", "numpy", "numba", "astropy"}
    assert answer["attitude"] == attitude.__version__
    assert answer["python"] == platform.python_version()
    assert answer["numpy"] == np.__version__


def test_content_type_may_carry_a_charset_and_any_case(client, document):
    headers = {"content-type": "Application/JSON; charset=utf-8"}
    assert client.post("/v1/motion", content=orjson.dumps(document), headers=headers).status_code == 200


def test_health_is_answered_while_a_computation_is_under_way(client, document, monkeypatch):
    begun, go_on = threading.Event(), threading.Event()

    def slow(*given):
        begun.set()
        assert go_on.wait(60)
        return Response(b"{}")

    monkeypatch.setattr(computations, "single", slow)
    with ThreadPoolExecutor(1) as pool:
        computation = pool.submit(client.post, "/v1/ephemeris", json=document)
        assert begun.wait(60)
        assert client.get("/healthz").status_code == 200
        assert not computation.done()
        go_on.set()
        assert computation.result().content == b"{}"


NEAR = {"axis": "z", "to": "sun", "below": {"value": 60, "unit": "deg"}}


@pytest.mark.parametrize("scene", ["envisat", Scene.builtin("envisat").document()], ids=["name", "document"])
def test_windows_are_the_librarys(client, scene):
    expected = Scene.builtin("envisat").crossings(NEAR, 0.01)
    request = {"scene": scene, "condition": NEAR}
    assert client.post("/v1/windows?width=0.01", json=request).json() == expected.to_dict()
    answer = client.post("/v1/windows?width=0.01&format=csv", json=request)
    assert (answer.headers["content-type"], answer.text) == ("text/csv", expected.to_csv())


@pytest.mark.parametrize(
    ("document", "pointer", "message"),
    [
        ([], "", "a JSON object with scene and condition"),
        ({"scene": "envisat"}, "/condition", "condition: a value"),
        ({"scene": "envisat", "condition": NEAR, "conditions": 1}, "/conditions", "did you mean 'condition'"),
        ({"scene": "envisatt", "condition": NEAR}, "/scene/scene", "did you mean 'envisat'"),
        ({"scene": {"body": {}}, "condition": NEAR}, "/scene/body/unit", "body.unit"),
        (
            {"scene": "envisat", "condition": NEAR | {"to": "mars"}},
            "/condition/to",
            "condition.to: one of sun",
        ),
        ({"scene": "toutatis", "condition": {"shadow": "umbra"}}, None, "no scene that has an orbit"),
        (
            {"scene": {"scene": "envisat", "times": {"elapsed": [0], "unit": "s"}}, "condition": NEAR},
            "/scene/times",
            "instants that span a time",
        ),
    ],
)
def test_faults_of_windows_are_pointed_at(client, document, pointer, message):
    problem = assert_problem(client.post("/v1/windows", json=document), 422)
    assert problem.get("pointer") == pointer
    assert message in problem["detail"]


def test_the_page_of_questions_asks_from_javascript_as_the_service_answers(client):
    page = (Path(attitude.__file__).parents[1] / "docs" / "guides" / "from-javascript.md").read_text()
    block = re.search(r"```js\n(.*?)```", page, re.DOTALL)[1]
    path = re.search(r'fetch\("https://[^/]+([^"]+)"', block)[1]
    document = orjson.loads(re.sub(r"(\w+):", r'"\1":', re.search(r"stringify\((.*?)\)", block)[1]))
    assert "Authorization: `Bearer ${token}`" in block
    answer = client.post(path, json=document, headers={"Authorization": "Bearer any"}).json()
    assert list(answer["columns"]) == ["time", "q_w", "q_x", "q_y", "q_z"]

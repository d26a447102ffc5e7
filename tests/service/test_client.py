"""The client that openapi-python-client generates from the description asks every route, unchanged."""

from __future__ import annotations

import importlib
import io
import json
import os
import subprocess
import sys
from importlib.util import find_spec

import pytest
from worked import examples

from attitude import Scene
from attitude.formats.encoding import encoded_file
from attitude.formats.registry import FORMATS

pytestmark = pytest.mark.skipif(
    find_spec("openapi_python_client") is None, reason="openapi-python-client is not installed"
)


@pytest.fixture(scope="module")
def generated(client, tmp_path_factory):
    """The package, importable as `generated`, and its client, which asks the service of the tests."""
    folder = tmp_path_factory.mktemp("client")
    (folder / "openapi.json").write_bytes(client.get("/openapi.json").content)
    command = [sys.executable, "-m", "openapi_python_client", "generate", "--path", "openapi.json"]
    (folder / "config.yml").write_text("post_hooks: []\n")
    command += ["--meta", "none", "--output-path", "generated", "--config", "config.yml", "--fail-on-warning"]
    subprocess.run(command, cwd=folder, check=True, timeout=120, env={**os.environ, "COLUMNS": "200"})
    sys.path.insert(0, str(folder))
    try:
        yield importlib.import_module("generated").Client("http://testserver").set_httpx_client(client)
    finally:
        sys.path.remove(str(folder))


def api(name):
    return importlib.import_module(f"generated.api.default.{name}")


def model(name):
    return getattr(importlib.import_module("generated.models"), name)


def test_routes_without_a_document_are_parsed(generated):
    assert api("healthz_healthz_get").sync(client=generated)["status"] == "alive"
    assert api("readyz_readyz_get").sync(client=generated)["status"] == "ready"
    assert api("version_version_get").sync(client=generated)["attitude"]
    names = [each["name"] for each in api("scenes_v1_scenes_get").sync(client=generated)["scenes"]]
    scene = api("scene_v1_scenes_name_get").sync("toutatis", client=generated)
    assert scene.name == Scene.builtin("toutatis").name
    assert "toutatis" in names
    assert api("figures_metrics_get").sync_detailed(client=generated).status_code == 200


@pytest.mark.parametrize("name", ["toutatis", "envisat", "thruster-plan", "drop"])
def test_scenes_are_posted_and_their_answers_parsed(generated, name):
    document = Scene.builtin(name).document()
    scene = model("Scene").from_dict(document)
    assert json.loads(json.dumps(scene.to_dict())) == document
    ephemeris = api("ephemeris_v1_ephemeris_post").sync(client=generated, body=scene)
    assert isinstance(ephemeris, model("EphemerisAnswer"))
    assert len(ephemeris.columns["q_w"]) == ephemeris.shape[0]
    assert ephemeris.plan.solver
    chosen = api("ephemeris_v1_ephemeris_post").sync(
        client=generated, body=scene, columns="elapsed,direction:z"
    )
    assert chosen.chosen_columns == ["elapsed", "direction:z"]
    assert len(chosen.columns["direction_z_x"]) == ephemeris.shape[0]
    plan = api("plan_v1_plan_post").sync(client=generated, body=scene)
    assert [each.type_ for each in plan.effects] == [each["type"] for each in document.get("effects", [])]
    assert all(each.predicted_s > 0 for each in plan.considered)
    motion = api("motion_v1_motion_post").sync(client=generated, body=scene)
    assert motion.kinetic_energy_j == Scene.builtin(name).motion().kinetic_energy


def test_list_of_scenes_and_refusals_are_parsed(generated):
    named = model("Scene")(scene=model("SceneScene").TOUTATIS)
    answers = api("ephemeris_v1_ephemeris_post").sync(client=generated, body=[named, 5]).answers
    assert [type(each).__name__ for each in answers] == ["EphemerisAnswer", "Problem"]
    refusal = api("motion_v1_motion_post").sync(client=generated, body=model("Scene")(name="x"))
    assert (refusal.status, refusal.pointer) == (422, "/body")


def test_cost_is_measured(generated):
    scene = model("Scene").from_dict(Scene.builtin("toutatis").document())
    report = api("cost_v1_cost_post").sync(
        client=generated, body=scene, budget=20.0, samples=100, method=["ours"]
    )
    assert report.kind == "attitude-cost/1"
    assert all(each.attitude_error_rad < 4e-15 for each in report.cells)


def test_fit_is_parsed(generated):
    (asked,) = examples()["/v1/fit"]["requests"].values()
    fit = api("fit_v1_fit_post").sync(client=generated, body=model("FitV1FitPostBody").from_dict(asked))
    assert fit.scene.name == asked["name"]
    assert fit.parameters["attitude.x"].sigma > 0
    assert [len(each.sizes) for each in fit.residuals] == [6]


@pytest.fixture
def tracked():
    """A short ephemeris, and a function that makes a file of it, as the generated client sends one."""
    document = {"scene": "toutatis", "times": {"elapsed": [0, 9, 99], "unit": "s"}}
    samples = Scene.model_validate(document).samples()

    def file(name):
        content = io.BytesIO(b"".join(encoded_file(samples, FORMATS[name]).blocks))
        name = "x" + FORMATS[name].endings[0]
        return importlib.import_module("generated.types").File(payload=content, file_name=name)

    return samples, file


def test_file_is_converted(generated, tracked):
    samples, file = tracked
    body = model("ConvertV1ConvertPostFilesBody")(file=file("aem"))
    ephemeris = api("convert_v1_convert_post").sync(client=generated, body=body, columns="time,euler:ZYX")
    assert list(ephemeris.columns.to_dict()) == ["time", *(f"euler_zyx_{i}_deg" for i in (1, 2, 3))]
    assert len(ephemeris.columns["time"]) == samples.count


def test_file_is_checked_in_a_form_and_as_a_body(generated, tracked):
    _, file = tracked
    check, source = api("check_v1_check_post").sync, model("CheckV1CheckPostSource")
    reports = [
        check(client=generated, body=model("CheckV1CheckPostFilesBody")(file=file("csv"))),
        check(client=generated, body=file("csv"), source=source.CSV),
    ]
    assert reports[0].findings == reports[1].findings != []


def test_two_files_are_compared(generated, tracked):
    samples, file = tracked
    body = model("CompareV1ComparePostBody")(file=file("csv"), other=file("npz"))
    report = api("compare_v1_compare_post").sync(client=generated, body=body, frame="ICRF")
    assert report.instants == samples.count
    assert report.rate_rad_s.greatest == 0.0

"""Orbits and parameter messages over HTTP: their content inline, and no file of the machine."""

import numpy as np
import pytest
from asking import assert_problem

from attitude import Scene
from tests.formats.apm_texts import SPINNER
from tests.formats.orbit_texts import csv, oem, oem_segment, oem_xml, stk

ROWS = np.arange(0.0, 601.0, 60.0)
DOCUMENT = {
    "body": {"moments": [1.0, 2.0, 2.5], "unit": "kg m2"},
    "epoch": {"time": "2026-01-01T00:00:00", "scale": "utc"},
    "frame": "EME2000",
    "attitude": {"quaternion": [1.0, 0.0, 0.0, 0.0], "order": "wxyz"},
    "angular_velocity": {"value": [0.0, 0.01, 0.0], "unit": "rad/s"},
    "times": {"start": 0, "stop": 600, "step": 100, "unit": "s"},
    "effects": [{"type": "gravity_gradient"}],
}


@pytest.mark.parametrize(
    "orbit",
    [{"oem": oem(oem_segment(ROWS))}, {"oem": oem_xml(ROWS)}, {"stk": stk(ROWS)}, {"csv": csv(ROWS)}],
    ids=["oem", "oem xml", "stk", "csv"],
)
def test_content_of_a_file_is_an_orbit(client, orbit):
    document = DOCUMENT | {"orbit": orbit}
    answer = client.post("/v1/ephemeris?frame=LVLH", json=document)
    assert answer.status_code == 200, answer.text
    expected = Scene.model_validate(document).run().in_frame("LVLH").quaternion("wxyz")
    found = np.transpose([answer.json()["columns"][f"q_{letter}"] for letter in "wxyz"])
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("path", ["/v1/ephemeris", "/v1/plan", "/v1/motion", "/v1/cost"])
def test_no_file_is_read_over_http(client, tmp_path, path):
    """Neither one that is there nor one that is not: the answers do not differ."""
    there = tmp_path / "x.oem"
    there.write_text(oem(oem_segment(ROWS)))
    for name in (str(there), str(tmp_path / "none.oem"), "/etc/hostname", "../x.oem"):
        problem = assert_problem(client.post(path, json=DOCUMENT | {"orbit": {"file": name}}), 422)
        assert problem["pointer"] == "/orbit/file"
        assert "no file is read here" in problem["detail"]


def test_no_file_is_read_of_one_scene_of_several(client, tmp_path):
    there = tmp_path / "x.oem"
    there.write_text(oem(oem_segment(ROWS)))
    documents = [DOCUMENT | {"orbit": {"oem": there.read_text()}}, DOCUMENT | {"orbit": {"file": str(there)}}]
    good, bad = client.post("/v1/ephemeris", json=documents).json()["answers"]
    assert len(good["columns"]["q_w"]) == 7
    assert "no file is read here" in bad["detail"]


def test_coverage_is_refused_before_anything_is_computed(client):
    document = DOCUMENT | {"orbit": {"oem": oem(oem_segment(ROWS[:8]))}}
    problem = assert_problem(client.post("/v1/plan", json=document), 422)
    assert problem["pointer"] == "/orbit/oem"
    assert "covers from 0 s" in problem["detail"]


def test_message_of_parameters_is_a_scene_over_http(client):
    document = {"apm": SPINNER, "times": {"start": 0, "stop": 3000, "step": 1000, "unit": "s"}}
    answer = client.post("/v1/ephemeris", json=document)
    assert answer.status_code == 200, answer.text
    found = np.transpose([answer.json()["columns"][f"q_{letter}"] for letter in "wxyz"])
    np.testing.assert_array_equal(found, Scene.model_validate(document).run().quaternion("wxyz"))
    problem = assert_problem(client.post("/v1/plan", json=document | {"apm": {"file": "/etc/hostname"}}), 422)
    assert problem["pointer"] == "/apm/file"
    assert "no file is read here" in problem["detail"]

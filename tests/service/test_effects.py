"""Scenes with effects over HTTP: the library's plan and ephemeris, and limits of their own."""

from __future__ import annotations

import re

import numpy as np
import pytest
from asking import assert_problem

from attitude import InputError, Scene
from attitude.scene.builtin_scenes import builtin_names
from service.compute import Compute, Job
from service.settings import Settings

WITH_EFFECTS = [name for name in builtin_names() if Scene.builtin(name).effects]
ORBIT = {"altitude": {"value": 600, "unit": "km"}}
GRADIENT = {"effects": [{"type": "gravity_gradient"}], "orbit": ORBIT}
PUSH = {"type": "constant_torque", "torque": {"value": [1e-9, 0, 0], "unit": "N m"}, "frame": "body"}


@pytest.mark.parametrize("name", WITH_EFFECTS)
def test_plan_is_the_librarys(client, name):
    scene = Scene.builtin(name)
    answer = client.post("/v1/plan", json=scene.document())
    assert answer.status_code == 200
    plan = answer.json()
    assert plan == scene.plan().to_dict()
    assert [effect["type"] for effect in plan["effects"]] == [effect.type for effect in scene.effects]
    assert plan["predicted_s"] > 0.0


def test_effects_that_do_not_matter_are_left_out_only_when_asked(client, document):
    document["effects"] = [PUSH]
    asked = "/v1/plan?drop_below=1e-3"
    assert client.post("/v1/plan", json=document).json()["effects"][0]["simulated"] is True
    left_out = client.post(asked, json=document).json()["effects"][0]
    assert left_out["simulated"] is False
    assert "1.0e-03 rad" in left_out["reason"]
    free, pushed, dropped = (
        client.post(path, json=body).json()["columns"]["q_w"]
        for path, body in (
            ("/v1/ephemeris", {**document, "effects": []}),
            ("/v1/ephemeris", document),
            ("/v1/ephemeris?drop_below=1e-3", document),
        )
    )
    assert dropped == free
    assert 0.0 < np.abs(np.subtract(pushed, free)).max() < 1e-3


@pytest.mark.parametrize("text", ["much", "-1", "0", "nan", "inf", ""])
@pytest.mark.parametrize("path", ["/v1/plan", "/v1/ephemeris"])
def test_drop_below_that_is_no_angle_is_a_problem(client, document, path, text):
    document["effects"] = [PUSH]
    problem = assert_problem(client.post(f"{path}?drop_below={text}", json=document), 422)
    assert problem["detail"].startswith("drop_below: ")


@pytest.mark.parametrize(
    ("change", "pointer", "words"),
    [
        ({"effects": [{"type": "gravity_gradient"}]}, "/orbit", "gravity_gradient needs"),
        ({"effects": [{"type": "tides"}]}, "/effects/0/type", "gravity_gradient"),
        ({"effects": [PUSH], "tolerance": {"value": 1e-20, "unit": "rad"}}, "/tolerance", "1e-13"),
        ({"effects": [PUSH, {**PUSH, "frame": "moving"}]}, "/effects/1/frame", "inertial"),
    ],
)
@pytest.mark.parametrize("path", ["/v1/plan", "/v1/ephemeris"])
def test_bad_scene_is_a_problem_that_points_at_its_field(client, document, path, change, pointer, words):
    problem = assert_problem(client.post(path, json=document | change), 422)
    assert problem["pointer"].startswith(pointer)
    assert words in problem["detail"]


def test_more_effects_than_the_limit_are_a_problem_that_names_it(client, document):
    document["effects"] = [PUSH] * 101
    problem = assert_problem(client.post("/v1/ephemeris", json=document), 422)
    assert problem["pointer"] == "/effects"
    assert "at most 100 effects (ATTITUDE_MAX_EFFECTS)" in problem["detail"]


def test_more_computing_than_the_limit_is_a_problem_that_names_it(client, document):
    day = {"elapsed": [0, 4e8], "unit": "s"}
    problem = assert_problem(client.post("/v1/ephemeris", json=document | GRADIENT | {"times": day}), 422)
    assert problem["pointer"] == "/times"
    assert "at most 30 s (ATTITUDE_MAX_SECONDS)" in problem["detail"]


def test_free_motion_is_never_checked_and_torques_once_by_what_the_plan_predicts(document):
    asked = []
    Scene(**document).run(check=asked.append)
    assert asked == []
    pushed = Scene(**document | {"effects": [PUSH]})
    pushed.run(check=asked.append)
    assert asked == [pushed.plan().predicted_seconds]


def test_prediction_that_is_no_number_is_refused():
    with pytest.raises(InputError, match="ATTITUDE_MAX_SECONDS"):
        Job("test", None, Compute(Settings())).predict(float("nan"))


def test_answer_says_what_was_simulated_and_what_not(client, document):
    gravity = {"type": "uniform_gravity", "acceleration": {"value": [0, 0, -9.81], "unit": "m/s2"}}
    plan = client.post("/v1/ephemeris", json=document | {"effects": [gravity, PUSH]}).json()["plan"]
    assert plan["simulated"] == ["constant_torque"]
    assert [text.split(":")[0] for text in plan["left_out"]] == ["uniform_gravity"]
    assert plan["error_bound_source"].startswith("estimated over the whole span")
    assert 0.0 < plan["error_bound_rad"] <= 1e-9
    plain = client.post("/v1/ephemeris", json=document).json()["plan"]
    assert plain["simulated"] == plain["left_out"] == []


def test_answer_of_a_bounce_carries_its_event_and_its_parabola(client):
    answer = client.post("/v1/ephemeris", json=Scene.builtin("drop").document()).json()
    (event,) = answer["events"]
    assert (event["kind"], event["details"]["points"]) == ("contact", 1)
    assert {"position_z_m", "velocity_z_m_s"} <= set(answer["columns"])


@pytest.mark.parametrize(
    ("member", "value", "expected"),
    [
        ("body", {"moments": [4.8, 4.8, 1e-300], "unit": "kg m2"}, "moments from 1e-50 to 1e.50 kg m2"),
        ("angular_velocity", {"value": [1, 0, 1e150], "unit": "rad/s"}, "a rate of at most 1e.50 rad/s"),
    ],
)
def test_body_so_thin_or_fast_that_no_step_follows_its_torques_is_a_problem(client, member, value, expected):
    document = Scene.builtin("explorer-1").document() | {member: value}
    for path in ("/v1/plan", "/v1/ephemeris"):
        problem = assert_problem(client.post(path, json=document), 422)
        assert problem["type"].endswith(":input")
        assert re.search(f"{expected} in a scene with effects", problem["detail"])

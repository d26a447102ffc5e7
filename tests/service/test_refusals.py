"""Refusals: a problem with the library's own text, a status, and a pointer to the field."""

from __future__ import annotations

import asyncio
import logging
import re

import pytest
from asking import MAX_BODY_BYTES, MAX_SAMPLES, assert_problem

from attitude import AttitudeError, InputError, Scene, errors
from service import computations
from service.computations import scene_within
from service.errors import TABLE, UNEXPECTED
from service.settings import Settings

# -- values that cannot be taken ------------------------------------------------------------------


def body(unit="kg m2", **inertia):
    return {"body": {**inertia, "unit": unit}}


def quaternion(*value, **order):
    return {"attitude": {"quaternion": value, **order}}


def times(**fields):
    return {"times": {"unit": "s", **fields}}


ASYMMETRIC = [[1.0, 0.1, 0.0], [0.2, 1.0, 0.0], [0.0, 0.0, 1.0]]
RATE_IN_METRES = {"angular_velocity": {"value": [1, 1, 1], "unit": "m"}}
UNDATED = {"epoch": None, "times": {"dates": ["2026-01-01"], "scale": "utc"}}
LIMIT = f"at most {MAX_SAMPLES} samples (ATTITUDE_MAX_SAMPLES)"

# claim: (what is put into the document, the pointer to expect, words of the refusal)
REFUSED = {
    "zero moment": (body(moments=[1, 0, 1]), "/body/moments/1", "positive"),
    "negative moment": (body(moments=[1, 1, -1]), "/body/moments/2", "positive"),
    "non-triangular moments": (body(moments=[1, 1, 3]), "/body/moments/2", "sum of the other"),
    "asymmetric tensor": (body(tensor=ASYMMETRIC), "/body/tensor/", "symmetric"),
    "moments and tensor": (body(moments=[1, 1, 1], tensor=ASYMMETRIC), "/body", "exactly one of"),
    "two moments": (body(moments=[1, 1]), "/body/moments", "3 elements"),
    "moment that is text": (body(moments=[1, "1", 1]), "/body/moments/1", "a number"),
    "moment that is true": (body(moments=[1, True, 1]), "/body/moments/1", "a number"),
    "missing moment": (body(moments=[1, None, 1]), "/body/moments/1", "a number"),
    "missing unit": ({"body": {"moments": [1, 1, 1]}}, "/body/unit", "required"),
    "unknown unit": (body(moments=[1, 1, 1], unit="furlong"), "/body/unit", "kg m2"),
    "unit of another kind": (RATE_IN_METRES, "/angular_velocity/unit", "rad/s"),
    "zero quaternion": (quaternion(0, 0, 0, 0, order="wxyz"), "/attitude/quaternion", "unit"),
    "quaternion off unit": (quaternion(1, 0, 0, 0.2, order="wxyz"), "/attitude/quaternion", "length"),
    "missing order": (quaternion(1, 0, 0, 0), "/attitude/order", "wxyz"),
    "unknown order": (quaternion(1, 0, 0, 0, order="xyz"), "/attitude/order", "wxyz"),
    "missing attitude": ({"attitude": {}}, "/attitude", "exactly one of"),
    "missing epoch for dates": (UNDATED, "/times/dates", "an epoch"),
    "unknown scale": ({"epoch": {"time": "2026-01-01", "scale": "gmt"}}, "/epoch/scale", "utc"),
    "date that is none": ({"epoch": {"time": "yesterday", "scale": "utc"}}, "/epoch/time", "ISO 8601"),
    "unknown frame": ({"frame": "ITRF"}, "/frame", "ICRF"),
    "unknown key": ({"bodies": []}, "/bodies", "unknown key 'bodies'; did you mean 'body'?"),
    "unknown key inside": (
        body(moments=[1, 1, 1], weight=1),
        "/body/weight",
        "unknown key 'weight'; known: moments, tensor, unit, mass",
    ),
    "unknown effect": ({"effects": [{"type": "tides"}]}, "/effects/0/type", "effect"),
    "stop before start": (times(start=0, stop=-1, step=1), "/times/stop", "not before start"),
    "step of zero": (times(start=0, stop=1, step=0), "/times/step", "greater than 0"),
    "too many samples": (times(start=0, stop=1, count=MAX_SAMPLES + 1), "/times", LIMIT),
    "far too many samples": (times(start=0, stop=1e9, step=1e-3), "/times", LIMIT),
}


@pytest.mark.parametrize(("change", "pointer", "words"), REFUSED.values(), ids=REFUSED)
def test_bad_value_is_a_problem_that_points_at_its_field(client, document, change, pointer, words):
    problem = assert_problem(client.post("/v1/ephemeris", json=document | change), 422)
    assert problem["type"].endswith(":input")
    assert problem["pointer"].startswith(pointer)
    assert words in problem["detail"]


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e400"])
def test_number_that_is_not_finite_is_a_problem(client, document, number):
    text = Scene(**document).to_json().replace("2.5", number)
    problem = assert_problem(post_text(client, text), 422)
    assert "finite number" in problem["detail"]


@pytest.mark.parametrize("change", [change for change, _, _ in REFUSED.values()], ids=REFUSED)
def test_http_refuses_in_the_librarys_words(client, document, change):
    def compute():
        return Scene.model_validate(document | change).run(MAX_SAMPLES, "ATTITUDE_MAX_SAMPLES")

    with pytest.raises(AttitudeError) as refusal:
        compute()
    assert client.post("/v1/ephemeris", json=document | change).json()["detail"] == str(refusal.value)


def test_motion_refuses_what_ephemeris_refuses(client, document):
    spoilt = document | body(moments=[1, 1, 3])
    answers = [client.post(path, json=spoilt) for path in ("/v1/motion", "/v1/ephemeris")]
    assert answers[0].content == answers[1].content


def test_time_too_far_for_the_promised_accuracy_is_a_problem(client, document):
    far = document | times(start=0, stop=1e300, count=2)
    problem = assert_problem(client.post("/v1/ephemeris", json=far), 422)
    assert problem["type"].endswith(":tolerance")
    assert "nearer instants" in problem["detail"]


LONG = MAX_SAMPLES // 10  # more than the test's limits of effects and scenes, in a short document


@pytest.mark.parametrize("path", ["/v1/ephemeris", "/v1/plan", "/v1/motion", "/v1/cost"])
def test_lengths_are_looked_at_before_members(client, document, path, monkeypatch):
    monkeypatch.setattr(Scene, "model_validate", None)
    spoilt = document | {"effects": [{}] * LONG}
    problem = assert_problem(client.post(path, json=spoilt), 422)
    assert problem["detail"] == "effects: at most 100 effects (ATTITUDE_MAX_EFFECTS); got '1000 effects'"
    assert problem["pointer"] == "/effects"


@pytest.mark.parametrize("name", ["elapsed", "dates"])
def test_instants_are_counted_before_they_are_read(document, name):
    spoilt = document | times(**{name: [""] * 11})
    with pytest.raises(
        InputError, match=r"^times: at most 10 samples \(ATTITUDE_MAX_SAMPLES\); got '11 samples'"
    ):
        scene_within(spoilt, Settings(max_samples=10))


def test_list_of_more_scenes_than_may_be_is_a_problem(client):
    problem = assert_problem(client.post("/v1/ephemeris", json=[0] * 1001), 422)
    assert problem["detail"] == "document: at most 1000 scenes (ATTITUDE_MAX_SCENES); got '1001 scenes'"


# -- documents that cannot be read ----------------------------------------------------------------


def post_text(client, text, content_type="application/json"):
    return client.post("/v1/ephemeris", content=text, headers={"content-type": content_type})


@pytest.mark.parametrize(
    "text",
    ["", "{", "{'name': 1}", b"\xff\xfe{}", "[" * 10_000],
    ids=["empty", "open", "quotes", "bytes", "deep"],
)
def test_what_is_not_json_is_a_problem_of_format(client, text):
    problem = assert_problem(post_text(client, text), 400)
    assert problem["type"].endswith(":format")
    assert "not JSON" in problem["detail"]


def test_problem_of_format_names_the_line(client):
    assert assert_problem(post_text(client, '{\n"name": "x",\n}'), 400)["line"] == 3


@pytest.mark.parametrize("text", ["null", "[]", "3", '"x"', '{"name": 1, "name": 2}'])
def test_json_that_is_no_scene_is_a_problem(client, text):
    assert_problem(post_text(client, text), 422)


def test_key_that_is_half_a_surrogate_pair_is_a_problem(client):
    """UTF-8 cannot hold it, so neither can an answer that would repeat it."""
    assert_problem(post_text(client, r'{"\ud800": 1}'), 422)


# -- what HTTP refuses ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("method", "path"),
    [("GET", "/nothing"), ("GET", "/v1/scenes/"), ("POST", "/v1"), ("GET", "/v1/scenes/..%2fx")],
)
def test_path_that_is_not_there_is_a_problem(client, method, path):
    assert "nothing is at /" in assert_problem(client.request(method, path), 404)["detail"]


def test_scene_that_is_not_there_is_a_problem_that_names_those_that_are(client):
    detail = assert_problem(client.get("/v1/scenes/vulcan"), 404)["detail"]
    assert "toutatis" in detail
    assert "'vulcan'" in detail


@pytest.mark.parametrize(
    ("method", "path", "allowed"), [("GET", "/v1/motion", "POST"), ("PUT", "/healthz", "GET")]
)
def test_wrong_method_is_a_problem_that_names_the_right_one(client, method, path, allowed):
    answer = client.request(method, path)
    assert f"{allowed} is" in assert_problem(answer, 405)["detail"]
    assert answer.headers["allow"] == allowed


@pytest.mark.parametrize(
    "content_type", ["text/plain", "application/x-www-form-urlencoded", "application/jsonp", ""]
)
def test_wrong_content_type_is_a_problem_that_names_the_right_one(client, content_type):
    problem = assert_problem(post_text(client, "{}", content_type), 415)
    assert problem["detail"].startswith("content-type: application/json; got")


def test_missing_content_type_is_a_problem(client):
    assert_problem(client.post("/v1/motion", content="{}"), 415)


def test_document_over_the_limit_is_a_problem_that_names_it(client):
    detail = assert_problem(post_text(client, " " * (MAX_BODY_BYTES + 1)), 413)["detail"]
    assert f"at most {MAX_BODY_BYTES} bytes (ATTITUDE_MAX_BODY_BYTES)" in detail


def test_document_at_the_limit_is_read(client, document):
    text = Scene(**document).to_json()
    assert post_text(client, text + " " * (MAX_BODY_BYTES - len(text))).status_code == 200


def test_document_of_no_announced_length_is_refused_at_the_limit(client):
    chunks = (b" " * 1000 for _ in range(1000))
    assert_problem(post_text(client, chunks), 413)


def test_reading_stops_where_the_limit_is_passed(client):
    """The client's transport gathers a body first, so this asks the application itself."""
    received = 0

    async def receive():
        nonlocal received
        received += 1000
        return {"type": "http.request", "body": b" " * 1000, "more_body": True}

    sent = call_application(client.app, receive)
    assert sent[0]["status"] == 413
    assert received <= MAX_BODY_BYTES + 2000


def test_client_that_goes_away_is_no_error(client, caplog):
    async def receive():
        return {"type": "http.disconnect"}

    with caplog.at_level(logging.WARNING):
        assert call_application(client.app, receive) == []
    assert not caplog.records


def call_application(app, receive):
    """What the application sends for a POST whose body `receive` gives."""
    sent = []

    async def send(message):
        sent.append(message)

    scope = {
        "type": "http",
        "method": "POST",
        "path": "/v1/ephemeris",
        "raw_path": b"/v1/ephemeris",
        "query_string": b"",
        "headers": [(b"content-type", b"application/json")],
        "app": app,
    }
    asyncio.run(app(scope, receive, send))
    return sent


# -- what nobody expected -------------------------------------------------------------------------


def test_unexpected_error_gives_fixed_text_and_an_id_that_the_log_has(client, document, monkeypatch, caplog):
    def fail(*given):
        raise RuntimeError("a secret of /srv/attitude")

    monkeypatch.setattr(computations, "encoded_file", fail)
    answer = client.post("/v1/ephemeris", json=document)
    problem = assert_problem(answer, 500)
    assert problem["detail"] == UNEXPECTED
    assert re.fullmatch("[0-9a-f]{16}", problem["id"])
    assert "secret" not in answer.text
    assert [record for record in caplog.records if problem["id"] in record.message and record.exc_info]


# -- the table ------------------------------------------------------------------------------------


def test_table_has_every_exception_of_the_library():
    found = {
        kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, AttitudeError)
    }
    assert set(TABLE) == found

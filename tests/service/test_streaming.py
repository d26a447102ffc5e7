"""Answers in blocks, with tags, packed, of lists; and HEAD."""

from __future__ import annotations

import asyncio
import gzip
import re
import time

import orjson
import pytest
from asking import MAX_SAMPLES, assert_problem, library_json, without_cost
from starlette.testclient import TestClient

import attitude
from attitude import Scene
from attitude.formats.encoding import EncodedFile, coalesced, encoded_file
from attitude.formats.registry import FORMATS
from attitude.samples.chunks import CHUNK_INSTANTS
from service import computations, create_app, streaming
from service.errors import UNEXPECTED
from service.settings import Settings

LONG = 4 * CHUNK_INSTANTS + 1000


@pytest.fixture(autouse=True)
def little_is_held(monkeypatch):
    """More than a block is computed piece by piece: sooner than usual, for the tests' sake."""
    monkeypatch.setattr("attitude.scene.scene.MAX_SAMPLES_HELD", CHUNK_INSTANTS)


def long(document, count=LONG):
    """More samples than are held at once."""
    return document | {"times": {"start": 0, "stop": count - 1, "count": count, "unit": "s"}}


@pytest.fixture(scope="module")
def large_client(client):
    """Limits for long answers; warm, for `client` is."""
    return TestClient(create_app(Settings(max_samples=2 * LONG)), raise_server_exceptions=False)


@pytest.mark.parametrize("encoding", ["identity", "gzip"])
def test_seconds_used_up_before_the_second_block_cut_the_answer_and_are_no_error(
    large_client, document, monkeypatch, caplog, encoding
):
    def spent(request, *_):
        job = computations.current.get()
        job.max_seconds = 0  # as if the first block had taken all
        file = EncodedFile(iter([b"first,\n" * 200, b"second\n"]), "a.csv", "text/csv", False)
        return streaming.file_response(request, file)

    monkeypatch.setattr(computations, "single", spent)
    answer = large_client.post("/v1/ephemeris", json=document, headers={"accept-encoding": encoding})
    assert answer.status_code == 200
    assert "second" not in answer.text
    assert "unexpected error" not in caplog.text


# -- blocks ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["json", "arrows", "npz"])
def test_long_answer_is_the_librarys_own_bytes(large_client, document, name):
    got = large_client.post(f"/v1/ephemeris?format={name}", json=long(document))
    assert got.status_code == 200
    assert "content-length" not in got.headers
    expected = b"".join(encoded_file(Scene(**long(document)).samples(), FORMATS[name]).blocks)
    if name == "json":
        assert without_cost(got.content) == without_cost(expected)
    elif name == "arrows":
        assert got.content == expected
    else:
        assert len(got.content) == len(expected)


def test_long_answer_in_json_says_what_a_short_one_says(large_client, document):
    streamed = large_client.post("/v1/ephemeris", json=long(document)).json()
    assert streamed["columns"] == orjson.loads(library_json(Scene(**long(document))))["columns"]
    short = large_client.post("/v1/ephemeris", json=document).json()
    assert list(streamed) == list(short)
    assert streamed["plan"]["samples"] == LONG
    assert 0.0 < streamed["cost"]["sample_s"] < 60.0


def test_short_answer_has_its_length(client, document):
    got = client.post("/v1/ephemeris", json=document, headers={"accept-encoding": "identity"})
    assert int(got.headers["content-length"]) == len(got.content)


def test_blocks_are_sent_while_others_are_computed(large_client, document):
    """No message holds half of the answer: neither does the service."""
    sent = messages(large_client.app, "/v1/ephemeris", orjson.dumps(long(document)))
    bodies = [len(message["body"]) for message in sent[1:]]
    assert sent[0]["status"] == 200
    assert max(bodies) < sum(bodies) / 2
    assert bodies[-1] == 0


def messages(app, path, body):
    sent, given = [], [{"type": "http.request", "body": body, "more_body": False}]

    async def receive():
        return given.pop() if given else await asyncio.Event().wait()

    async def send(message):
        sent.append(message)

    headers = [(b"content-type", b"application/json")]
    scope = {"type": "http", "method": "POST", "path": path, "raw_path": path.encode()}
    asyncio.run(app(scope | {"query_string": b"", "headers": headers, "app": app}, receive, send))
    return sent


@pytest.mark.parametrize("name", ["json", "csv", "arrows"])
def test_what_the_last_instant_refuses_is_refused_before_the_first_block(large_client, document, name):
    far = document | {"times": {"start": 0, "stop": 1e300, "count": LONG, "unit": "s"}}
    answer = large_client.post(f"/v1/ephemeris?format={name}", json=far)
    assert "nearer instants" in assert_problem(answer, 422)["detail"]


def test_dates_that_no_calendar_has_are_refused_before_the_first_block(large_client, document):
    slow = {"angular_velocity": {"value": [1e-9, 0, 0], "unit": "rad/s"}}
    far = {"times": {"start": 0, "stop": 1e9, "count": LONG, "unit": "yr"}}
    assert_problem(large_client.post("/v1/ephemeris?format=csv", json=document | slow | far), 422)


# -- what an answer says --------------------------------------------------------------------------


@pytest.mark.parametrize("count", [100, LONG])
def test_file_says_version_plan_and_cost_in_its_headers(large_client, document, count):
    headers = large_client.post("/v1/ephemeris?format=arrows", json=long(document, count)).headers
    assert headers["attitude-version"] == attitude.__version__
    plan, cost = orjson.loads(headers["attitude-plan"]), orjson.loads(headers["attitude-cost"])
    assert (plan["solver"], plan["samples"]) == (Scene(**document).run().plan.solver, count)
    assert all(0.0 < seconds < 60.0 for seconds in cost.values())
    assert set(cost) == ({"set_up_s", "sample_s"} if count < LONG else {"set_up_s", "predicted_s"})


def test_name_of_the_file_is_the_scenes(client, document):
    got = client.post("/v1/ephemeris", json=document)
    assert got.headers["content-disposition"] == 'inline; filename="tumbling-box.json"'
    named = client.post("/v1/ephemeris?format=csv", json=document | {"name": '../"x"\r\ny'})
    assert named.headers["content-disposition"] == 'attachment; filename="x-y.csv"'


# -- tags -----------------------------------------------------------------------------------------


def tag(client, document, **query):
    return client.post("/v1/ephemeris", json=document, params=query).headers["etag"]


def test_tag_is_the_same_for_the_same_document(client, document):
    first, again = (client.post("/v1/ephemeris", json=document) for _ in range(2))
    assert first.headers["etag"] == again.headers["etag"]
    assert re.fullmatch('W/"[0-9a-f]{32}"', first.headers["etag"])


def test_tag_is_another_for_another_question(client, document):
    tags = {
        tag(client, document),
        tag(client, document | {"name": "other"}),
        tag(client, document, format="csv"),
        tag(client, document, frame="EME2000"),
        tag(client, document, drop_below="1e-3"),
    }
    assert len(tags) == 5


@pytest.mark.parametrize("form", ["{}", 'W/"x", {}', '"x" ,{} , "y"'])
def test_what_the_client_has_is_not_computed_again(client, document, form, monkeypatch):
    known = tag(client, document)
    monkeypatch.setattr(Scene, "samples", None)
    got = client.post("/v1/ephemeris", json=document, headers={"if-none-match": form.format(known)})
    assert (got.status_code, got.content, got.headers["etag"]) == (304, b"", known)


def test_other_tags_change_nothing(client, document):
    got = client.post("/v1/ephemeris", json=document, headers={"if-none-match": 'W/"x", "y"'})
    assert got.status_code == 200


@pytest.mark.parametrize("path", ["/v1/scenes", "/v1/scenes/toutatis", "/version", "/openapi.json", "/docs"])
def test_fixed_answers_have_tags_too(client, path):
    first = client.get(path)
    again = client.get(path, headers={"if-none-match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


# -- gzip -----------------------------------------------------------------------------------------


def packed(client, document, accepted, path="/v1/ephemeris"):
    """(headers, raw bytes)"""
    headers = {"accept-encoding": accepted}
    with client.stream("POST", path, json=document, headers=headers) as got:
        return got.headers, b"".join(got.iter_raw())


@pytest.mark.parametrize("count", [100, LONG])
def test_text_is_packed_where_that_is_asked_for(large_client, document, count):
    headers, content = packed(
        large_client, long(document, count), "br, gzip;q=0.5", "/v1/ephemeris?format=csv"
    )
    assert headers["content-encoding"] == "gzip"
    assert {"accept", "accept-encoding"} == {name.strip().lower() for name in headers["vary"].split(",")}
    plain = b"".join(encoded_file(Scene(**long(document, count)).samples(), FORMATS["csv"]).blocks)
    assert gzip.decompress(content) == plain
    assert len(content) < 0.6 * len(plain)


@pytest.mark.parametrize("accepted", ["identity", "gzip;q=0", "*;q=0", "br", ""])
def test_text_is_not_packed_where_it_is_not(client, document, accepted):
    headers, content = packed(client, document, accepted)
    assert "content-encoding" not in headers
    assert orjson.loads(content)["name"] == "tumbling box"


def test_binary_is_not_packed(client, document):
    headers, _ = packed(client, document, "gzip", "/v1/ephemeris?format=arrows")
    assert "content-encoding" not in headers


# -- lists ----------------------------------------------------------------------------------------

HEAVY = {"body": {"moments": [1, 1, 3], "unit": "kg m2"}}
FAR = {"times": {"start": 0, "stop": 1e300, "count": 2, "unit": "s"}}


def test_list_of_scenes_gets_an_answer_or_a_problem_for_each(client, document):
    scenes = [document, document | HEAVY, 3, document | FAR, Scene.builtin("drop").document()]
    got = client.post("/v1/ephemeris", json=scenes)
    assert got.status_code == 200
    first, heavy, number, far, drop = got.json()["answers"]
    assert first["columns"] == orjson.loads(library_json(Scene(**document)))["columns"]
    assert (heavy["status"], heavy["pointer"]) == (422, "/1/body/moments/2")
    assert (number["status"], number["pointer"]) == (422, "/2")
    assert far["type"].endswith(":tolerance")
    assert drop["events"][0]["kind"] == "contact"


def test_problem_in_a_list_has_the_words_that_it_has_alone(client, document):
    alone = client.post("/v1/ephemeris", json=document | HEAVY).json()
    (listed,) = client.post("/v1/ephemeris", json=[document | HEAVY]).json()["answers"]
    assert listed | {"pointer": alone["pointer"]} == alone
    assert listed["pointer"] == "/0" + alone["pointer"]


def test_unexpected_error_in_a_list_leaves_the_others_their_answers(client, document, monkeypatch, caplog):
    run = Scene.run

    def broken(scene, *arguments, **named):
        if scene.name == "broken":
            raise RuntimeError("secret")
        return run(scene, *arguments, **named)

    monkeypatch.setattr(Scene, "run", broken)
    asked = [document, document | {"name": "broken"}, document]
    first, second, third = client.post("/v1/ephemeris", json=asked).json()["answers"]
    assert first["columns"] == third["columns"]
    assert (second["status"], second["detail"]) == (500, UNEXPECTED)
    assert second["id"] in caplog.text
    assert "secret" in caplog.text
    assert "secret" not in str(second)


def test_short_list_that_takes_too_long_is_refused_and_not_cut(document, monkeypatch):
    run = Scene.run
    monkeypatch.setattr(Scene, "run", lambda *given, **named: time.sleep(0.7) or run(*given, **named))
    refused = TestClient(create_app(Settings(max_seconds=1))).post("/v1/ephemeris", json=[document] * 3)
    assert "at most 1 s to compute" in assert_problem(refused, 422)["detail"]


@pytest.mark.parametrize(
    ("first_bytes", "sizes"), [(1, [3, 1 << 21, 5]), (9, [(1 << 20) + 3, (1 << 20) + 5])]
)
def test_first_block_is_sent_at_once_unless_it_should_be_longer(first_bytes, sizes):
    blocks = [b"xyz", b"x" * (1 << 20), b"x" * (1 << 20), b"", b"xxxxx"]
    joined = list(coalesced(blocks, first_bytes))
    assert [len(block) for block in joined] == sizes
    assert b"".join(joined) == b"".join(blocks)


def test_list_as_lines(client, document):
    got = client.post("/v1/ephemeris?format=ndjson", json=[document, document | HEAVY, document])
    lines = [orjson.loads(line) for line in got.content.splitlines()]
    assert got.headers["content-type"] == "application/x-ndjson"
    assert [line.get("status") for line in lines] == [None, 422, None]
    assert lines[0]["columns"] == lines[2]["columns"]


def test_limit_of_samples_holds_for_a_list_together(client, document):
    half = document | {"times": {"start": 0, "stop": 1, "count": MAX_SAMPLES // 2 + 1, "unit": "s"}}
    assert client.post("/v1/ephemeris", json=[half]).status_code == 200
    problem = assert_problem(client.post("/v1/ephemeris", json=[half, half]), 422)
    assert f"at most {MAX_SAMPLES} samples in all scenes (ATTITUDE_MAX_SAMPLES)" in problem["detail"]


@pytest.mark.parametrize(("query", "words"), [("format=csv", "json, ndjson"), ("frame=MARS", "frame: ")])
def test_list_that_cannot_be_answered_so_is_a_problem(client, document, query, words):
    assert words in assert_problem(client.post(f"/v1/ephemeris?{query}", json=[document]), 422)["detail"]


def test_empty_list_is_a_problem(client):
    assert "at least one scene" in assert_problem(client.post("/v1/ephemeris", json=[]), 422)["detail"]


# -- the query ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("POST", "/v1/ephemeris?colour=blue"),
        ("POST", "/v1/ephemeris?format=csv&format=csv"),
        ("POST", "/v1/plan?format=csv"),
        ("POST", "/v1/plan?drop_below=little"),
        ("POST", "/v1/motion?drop_below=1"),
        ("POST", "/v1/cost?budget=1&budget=2"),
        ("POST", "/v1/cost?budget=31"),
        ("POST", "/v1/cost?samples=1e3"),
        ("POST", f"/v1/cost?samples={MAX_SAMPLES + 1}"),
        ("POST", "/v1/cost?method=magic"),
        ("GET", "/v1/scenes?page=2"),
        ("GET", "/v1/scenes/toutatis?x"),
        ("GET", "/version?x=1"),
    ],
)
def test_parameter_that_cannot_be_taken_is_a_problem_that_points_at_no_field(client, document, method, path):
    given = {"json": document} if method == "POST" else {}
    problem = assert_problem(client.request(method, path, **given), 422)
    assert problem["pointer"] == ""
    named = path.partition("?")[2].partition("=")[0]
    assert problem["detail"].startswith(f"{named}: ")


@pytest.mark.parametrize(
    ("path", "meant"),
    [
        ("/v1/ephemeris?fromat=csv", "format"),
        ("/v1/ephemeris?format=aem&object_nmae=x", "object_name"),
        ("/v1/plan?drop_bellow=1", "drop_below"),
        ("/v1/cost?bugdet=1", "budget"),
    ],
)
def test_parameter_that_is_unknown_is_answered_with_the_one_that_was_meant(client, document, path, meant):
    name = path.rpartition("=")[0].rpartition("?")[2].rpartition("&")[2]
    detail = assert_problem(client.post(path, json=document), 422)["detail"]
    assert detail.startswith(f"{name}: unknown query parameter {name!r}; did you mean {meant!r}?")


def test_all_parameters_that_are_wrong_are_named(client, document):
    path = "/v1/cost?samples=1&budgte=3&seed=-1&colour=blue"
    problem = assert_problem(client.post(path, json=document), 422)
    assert problem["detail"] == (
        "budgte: unknown query parameter 'budgte'; did you mean 'budget'?; got '3' (also unknown: colour; "
        "samples: greater than or equal to 2; seed: greater than or equal to 0)"
    )


@pytest.mark.parametrize(
    "query", ["source=ck&clock_id=x", "columns=time,colour", "frame=MARS", "inertia=1,2"]
)
def test_parameter_of_a_file_points_at_no_field_of_a_document(client, document, query):
    short = document | {"times": {"start": 0, "stop": 1, "step": 0.1, "unit": "s"}}
    file = ("a.csv", client.post("/v1/ephemeris?format=csv", json=short).content)
    answer = client.post(f"/v1/convert?format=csv&{query}", files={"file": file})
    assert assert_problem(answer, 422)["pointer"] == ""


# -- cost -----------------------------------------------------------------------------------------


def test_cost_keeps_to_its_budget_and_names_what_was_asked(client, document):
    query = {"budget": "20", "samples": "500", "method": ["ours", "published"], "seed": "1"}
    report = client.post("/v1/cost", json=document, params=query).json()
    assert (report["samples"], report["seed"], report["budget_s"]) == (500, 1, 20.0)
    assert {cell["family"] for cell in report["cells"]} == {"closed form", "van Zon & Schofield (SciPy)"}


def test_cost_without_what_tells_the_truth_is_a_problem(client, document, monkeypatch):
    monkeypatch.setattr("service.computations.find_spec", lambda name: None)
    assert "attitude[cost]" in assert_problem(client.post("/v1/cost", json=document), 501)["detail"]


# -- HEAD and the page ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "path", ["/healthz", "/readyz", "/version", "/v1/scenes", "/v1/scenes/toutatis", "/openapi.json", "/docs"]
)
def test_head_says_what_get_says(client, path):
    same = {"x-request-id": "same"}
    head, get = client.head(path, headers=same), client.get(path, headers=same)
    assert (head.status_code, head.content) == (200, b"")
    assert head.headers == get.headers


def test_head_of_what_needs_a_document_is_a_problem(client):
    assert client.head("/v1/ephemeris").status_code == 405


def test_page_of_the_description_loads_nothing_from_elsewhere(client):
    page = client.get("/docs").text
    loaded = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert "docs/swagger-ui-bundle.js" in loaded
    for path in loaded:
        assert not path.startswith(("http:", "https:", "//"))
        if not path.startswith("data:"):
            assert client.get("/" + path).status_code == 200
    assert not re.search(r"<script(?![^>]*\bsrc=)", page)
    assert "url(http" not in client.get("/docs/swagger-ui.css").text


@pytest.mark.parametrize("path", ["/docs/index.html", "/docs/..%2fapp.py", "/docs/README.md", "/docs/"])
def test_page_gives_out_no_other_file(client, path):
    assert_problem(client.get(path), 404)


def test_tags_do_not_run_together():
    assert streaming.tag_of("ab", "c") != streaming.tag_of("a", "bc")

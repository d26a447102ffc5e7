"""Who may ask, what browsers are told, and what is counted."""

from __future__ import annotations

import json
import logging
import os
from functools import partial

import pytest
from asking import assert_problem
from starlette.responses import Response
from starlette.testclient import TestClient

from attitude import __version__
from service import create_app, metrics
from service.middleware import listed
from service.settings import Settings

TOKEN = "0123456789abcdef-A"


def asking(**settings):
    return TestClient(create_app(Settings(**settings)), raise_server_exceptions=False)


@pytest.fixture(scope="module")
def guarded():
    return asking(token=TOKEN)


# -- the token ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("method", "path"),
    [("POST", "/v1/motion"), ("GET", "/v1/scenes"), ("GET", "/version"), ("GET", "/metrics"), ("GET", "/x")],
)
def test_everything_else_needs_the_token(guarded, method, path):
    answer = guarded.request(method, path)
    assert "got nothing" in assert_problem(answer, 401)["detail"]
    assert answer.headers["www-authenticate"] == 'Bearer realm="attitude"'


@pytest.mark.parametrize(
    "given",
    [f"Bearer {TOKEN}x", f"Bearer {TOKEN[:-1]}", "Bearer", "Bearer \xe9", f"Basic {TOKEN}", TOKEN, ""],
)
def test_wrong_token_is_refused_and_not_repeated(guarded, given):
    answer = guarded.get("/version", headers={"authorization": given.encode("latin-1")})
    assert_problem(answer, 401)
    assert 'error="invalid_token"' in answer.headers["www-authenticate"]
    assert TOKEN[:8] not in answer.text


@pytest.mark.parametrize("scheme", ["Bearer", "bearer", "BEARER"])
def test_right_token_is_let_in(guarded, scheme):
    assert guarded.get("/version", headers={"authorization": f"{scheme} {TOKEN}"}).status_code == 200


def test_document_of_a_stranger_is_not_even_measured(guarded):
    assert guarded.post("/v1/motion", content=b"x" * 10_000_000).status_code == 401


def test_token_stands_neither_in_the_log_nor_in_the_settings_text(guarded, caplog):
    with caplog.at_level(logging.DEBUG):
        guarded.get("/version", headers={"authorization": f"Bearer {TOKEN}"})
    assert TOKEN not in caplog.text
    assert TOKEN not in repr(Settings(token=TOKEN))


# -- headers --------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", ["/healthz", "/readyz", "/nothing", "/v1/scenes"])
def test_every_answer_tells_browsers_to_make_nothing_else_of_it(client, path):
    headers = client.get(path).headers
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["attitude-version"] == __version__
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["content-security-policy"].startswith("default-src 'none'")
    assert "server" not in headers


def test_page_may_load_from_here_only_and_be_framed_by_nobody():
    app = create_app(Settings())

    @app.get("/page")
    async def page():
        from starlette.responses import HTMLResponse

        return HTMLResponse("<p>")

    headers = TestClient(app).get("/page").headers
    policy = headers["content-security-policy"]
    assert policy.startswith("default-src 'self';")
    assert "frame-ancestors 'none'" in policy
    assert "unsafe" not in policy
    assert headers["x-frame-options"] == "DENY"


POLICY = {
    "content-security-policy",
    "cross-origin-opener-policy",
    "cross-origin-resource-policy",
    "referrer-policy",
    "x-content-type-options",
    "x-frame-options",
}
KEPT = [
    "/",
    *(f"/viewer/{name}" for name in ("viewer.js", "viewer.css", "icon.svg", "licences.txt", "formats.json")),
    "/docs",
    *(f"/docs/{name}" for name in ("start.js", "swagger-ui.css", "swagger-ui-bundle.js")),
    "/openapi.json",
    "/version",
    "/v1/scenes",
    "/v1/scenes/toutatis",
]


def policy(answer):
    return {name: value for name, value in answer.headers.items() if name in POLICY}


def varies(answer):
    return {name.strip().lower() for name in answer.headers["vary"].split(",")}


@pytest.mark.parametrize("encoding", ["gzip", "identity"])
@pytest.mark.parametrize("method", ["GET", "HEAD"])
@pytest.mark.parametrize("path", KEPT)
def test_answer_that_is_kept_keeps_its_policy(client, path, method, encoding):
    """A browser puts the headers of a 304 over those of the answer it keeps (RFC 9111, 3.2)."""
    headers = {"accept-encoding": encoding}
    full = client.request(method, path, headers=headers)
    again = client.request(method, path, headers=headers | {"if-none-match": full.headers["etag"]})
    assert (full.status_code, again.status_code) == (200, 304)
    assert policy(again).items() <= policy(full).items()  # what is not repeated stays as it is kept
    for name in ("cache-control", "etag"):
        assert again.headers.get(name) == full.headers.get(name)
    assert varies(again) == varies(full) == {"accept-encoding"}


@pytest.mark.parametrize("format", ["json", "csv", "npz"])
def test_ephemeris_that_is_kept_keeps_its_policy(client, document, format):
    path = f"/v1/ephemeris?format={format}"
    full = client.post(path, json=document)
    again = client.post(path, json=document, headers={"if-none-match": full.headers["etag"]})
    assert (full.status_code, again.status_code) == (200, 304)
    assert policy(again).items() <= policy(full).items()


def test_304_of_whoever_makes_it_changes_no_policy():
    app = create_app(Settings())

    @app.get("/page")
    async def page():
        return Response(status_code=304, headers={"etag": '"x"'})

    headers = TestClient(app).get("/page").headers
    assert "content-security-policy" not in headers
    assert headers["x-content-type-options"] == "nosniff"


def test_unexpected_error_has_the_headers_and_the_id_too(client, document, monkeypatch):
    from attitude.scene.scene import Scene

    monkeypatch.setattr(Scene, "model_validate", None)
    answer = client.post("/v1/motion", json=document, headers={"x-request-id": "mine"})
    assert_problem(answer, 500)
    assert answer.headers["x-request-id"] == "mine"
    assert answer.headers["x-content-type-options"] == "nosniff"


@pytest.mark.parametrize("name", ["accept", "x-request-id", "x" * 9000])
def test_header_over_8_kb_is_a_problem_and_one_below_is_none(client, name):
    answer = client.get("/healthz", headers={name: "," * 8192})
    assert "at most 8192 bytes" in assert_problem(answer, 431)["detail"]
    assert client.get("/healthz", headers={name[:20]: "," * 8000}).status_code == 200


# -- pages from elsewhere -------------------------------------------------------------------------

PREFLIGHT = {"origin": "https://a.example", "access-control-request-method": "POST"}


def test_no_page_from_elsewhere_may_ask_unless_set(client):
    assert_problem(client.options("/v1/motion", headers=PREFLIGHT), 405)
    headers = client.get("/healthz", headers={"origin": "https://a.example"}).headers
    assert not [name for name in headers if name.startswith("access-control")]


def test_named_origin_may_ask_with_its_token_and_others_get_a_problem():
    asked = asking(cors_origins=("https://a.example",), token=TOKEN)
    sent = {"access-control-request-headers": "authorization, content-type"}
    allowed = asked.options("/v1/motion", headers=PREFLIGHT | sent)
    assert allowed.status_code == 200
    assert allowed.headers["access-control-allow-origin"] == "https://a.example"
    refused = asked.options("/v1/motion", headers=PREFLIGHT | {"origin": "https://b.example"})
    assert (refused.status_code, "access-control-allow-origin" in refused.headers) == (400, False)
    answer = asked.get("/version", headers={"origin": "https://a.example"})
    assert answer.status_code == 401
    assert answer.headers["access-control-allow-origin"] == "https://a.example"  # the page may read why


# What a page reads without being allowed to, and what is for browsers and proxies, not for it.
SAFELISTED = {"cache-control", "content-language", "content-length", "content-type", "expires"}
SAFELISTED |= {"last-modified", "pragma"}
FOR_OTHERS = {*POLICY, "vary", "connection", "content-encoding"}
ROUNDED = {"attitude": {"quaternion": [0.7071, 0.0, 0.7071, 0.0], "order": "wxyz"}}  # warned of


def answers_of_every_kind(document):
    """By name: 200 as JSON, as a file and whole, with a warning, 304, 401, 404, 405, 413, 503 ..."""
    page = {"origin": "https://a.example"}
    ask = partial(asking, cors_origins=("https://a.example",))
    free, full = ask(max_body_bytes=2000), ask()
    full.app.state.compute.in_flight = full.app.state.settings.requests_in_flight
    csv = free.post("/v1/ephemeris?format=csv", json=document | ROUNDED, headers=page)
    again = page | {"if-none-match": csv.headers["etag"]}
    return {
        "file with a warning": csv,
        "known": free.post("/v1/ephemeris?format=csv", json=document | ROUNDED, headers=again),
        "json": free.post("/v1/ephemeris", json=document, headers=page),
        "scenes": free.get("/v1/scenes", headers=page),
        "no token": ask(token=TOKEN).get("/version", headers=page),
        "no path": free.get("/nothing", headers=page),
        "no method": free.delete("/v1/motion", headers=page),
        "too large": free.post("/v1/motion", content=b" " * 2001, headers=page),
        "too long": free.get("/version", headers=page | {"accept": "," * 9000}),
        "busy": full.post("/v1/motion", json=document, headers=page),
    }


def test_page_from_elsewhere_reads_every_header_that_it_may_need(document):
    seen = set()
    for name, answer in answers_of_every_kind(document).items():
        shown = set(answer.headers["access-control-expose-headers"].lower().split(", "))
        sent = {header for header in answer.headers if not header.startswith("access-control-")}
        assert sent - SAFELISTED - FOR_OTHERS <= shown, name
        seen |= sent
    own = {"attitude-warnings", "attitude-plan", "attitude-cost", "attitude-version", "x-request-id"}
    assert own | {"etag", "content-disposition", "retry-after", "allow", "www-authenticate"} <= seen


# -- warnings -------------------------------------------------------------------------------------


@pytest.mark.parametrize("changed", [ROUNDED, {"solver": "splitting"}], ids=["rounded", "solver"])
@pytest.mark.parametrize("path", ["/v1/ephemeris", "/v1/motion", "/v1/plan"])
def test_answer_has_the_warnings_of_the_library_each_time(client, document, path, changed):
    for _ in range(2):
        (text,) = json.loads(client.post(path, json=document | changed).headers["attitude-warnings"])
        assert next(iter(changed)) in text


@pytest.mark.parametrize("count", [0, 1, 1000])
@pytest.mark.parametrize("text", ["short", "\u20ac" * 5000, '"' * 5000])
def test_warnings_are_a_list_in_json_that_a_header_holds(text, count):
    shown = listed([f"{text} {k}" for k in range(count)])
    assert shown.isascii()
    assert len(shown) <= 3000
    assert [text[:5]] * min(count, 1) == [each[:5] for each in json.loads(shown)][:1]


# -- figures --------------------------------------------------------------------------------------


def figures(client):
    text = client.get("/metrics").text
    lines = (line.rpartition(" ") for line in text.splitlines() if not line.startswith("#"))
    return {name: float(value) for name, _, value in lines}


def test_metrics_count_requests_samples_seconds_and_refusals(client, document):
    before = figures(client)
    assert client.post("/v1/ephemeris", json=document).status_code == 200
    assert_problem(client.post("/v1/ephemeris", json=document | {"frame": "x"}), 422)
    assert_problem(client.get("/nothing/at/all"), 404)
    after = figures(client)

    def more(name):
        return after[name] - before.get(name, 0.0)

    assert more('attitude_requests_total{method="POST",route="/v1/ephemeris",status="200"}') == 1
    assert more('attitude_requests_total{method="POST",route="/v1/ephemeris",status="422"}') == 1
    assert more('attitude_requests_total{method="GET",route="none",status="404"}') == 1
    assert more('attitude_request_seconds_count{route="/v1/ephemeris"}') == 2
    assert more("attitude_samples_total") == 101
    assert more("attitude_compute_seconds_total") > 0.0
    assert more('attitude_refusals_total{reason="value"}') == 1
    assert after["attitude_requests_in_flight"] == after["attitude_threads_busy"] == 0.0


def test_head_is_counted_at_its_route(client):
    name = 'attitude_requests_total{method="HEAD",route="/v1/scenes/{name}",status="200"}'
    before = figures(client).get(name, 0.0)
    assert client.head("/v1/scenes/toutatis").status_code == 200
    assert figures(client)[name] == before + 1


def test_methods_and_paths_that_are_none_make_no_series_of_their_own(client):
    for word in ("BREW", "POUR"):
        client.request(word, f"/{word}")
    assert not [name for name in figures(client) if "BREW" in name or "POUR" in name]


def test_worker_that_was_killed_counts_no_more(monkeypatch, tmp_path):
    monkeypatch.setenv(metrics.DIRECTORY, str(tmp_path))
    dead, alive = tmp_path / "gauge_livesum_4194305.db", tmp_path / f"gauge_livesum_{os.getpid()}.db"
    for path in (dead, alive):
        path.touch()
    metrics.forget_dead_workers()
    assert [path.exists() for path in (dead, alive)] == [False, True]

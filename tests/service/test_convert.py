"""Files over HTTP: in any format, out in any other, as the library reads and writes them."""

from __future__ import annotations

import io
import json
import zipfile

import numpy as np
import pytest
from asking import MAX_BODY_BYTES, assert_problem
from starlette.testclient import TestClient

from attitude import Ephemeris, Scene
from attitude.formats.encoding import encoded_file
from attitude.formats.registry import FORMATS
from attitude.quality.check import check_file
from service import create_app
from service.settings import Settings

TIMES = {"elapsed": [0, 100, 200, 300, 400, 500], "unit": "s"}
OPTIONS = {"ck": {"naif_id": 2004179}, "stk": {}, "czml": {}}


def encoded(name):
    """A short ephemeris as a file of a format."""
    samples = Scene.model_validate({"scene": "toutatis", "times": TIMES}).samples()
    return b"".join(encoded_file(samples, FORMATS[name], options=OPTIONS.get(name)).blocks)


def uploaded(name):
    """Files of a form; of the archive of a CK the two that reading needs."""
    if not FORMATS[name].has_companions:
        return {"file": ("x" + FORMATS[name].endings[0], encoded(name))}
    with zipfile.ZipFile(io.BytesIO(encoded(name))) as archive:
        members = {member[-3:]: (member, archive.read(member)) for member in archive.namelist()}
    return {"file": members[".bc"], "sclk": members["tsc"]}


@pytest.mark.parametrize("name", [name for name in FORMATS if name != "ck"])
def test_file_of_any_format_becomes_json(client, name):
    answer = client.post("/v1/convert?frame=ECLIPJ2000", files=uploaded(name))
    assert answer.status_code == 200, answer.text
    columns = answer.json()["columns"]
    found = np.transpose([columns[f"q_{letter}"] for letter in "wxyz"])
    truth = Scene.model_validate({"scene": "toutatis", "times": TIMES}).run().quaternion("wxyz")
    np.testing.assert_allclose(np.abs((found * truth).sum(1)), 1.0, atol=1e-12)
    plan = answer.json()["plan"]
    assert (plan["error_bound_rad"], f"({name})" in plan["solver"]) == (None, True)


def test_kernel_of_spice_is_read_with_its_clock(client):
    pytest.importorskip("spiceypy")
    answer = client.post("/v1/convert?format=csv", files=uploaded("ck"))
    assert answer.status_code == 200, answer.text


@pytest.mark.parametrize("name", ["csv", "aem", "parquet", "npz"])
def test_body_is_read_by_its_type_and_written_as_the_library_writes_it(client, tmp_path, name):
    content, path = encoded(name), tmp_path / f"x{FORMATS[name].endings[0]}"
    path.write_bytes(content)
    turned = Ephemeris.read(path).in_frame("EME2000")
    for query in ({}, {"source": name}):
        media = FORMATS[name].media if not query else "application/octet-stream"
        answer = client.post(
            "/v1/convert",
            params={"frame": "EME2000", "format": "csv", **query},
            content=content,
            headers={"content-type": media},
        )
        assert answer.content == b"".join(encoded_file(turned, FORMATS["csv"]).blocks)


@pytest.mark.parametrize("name", ["csv", "ecsv", "ndjson", "arrow", "parquet"])
def test_columns_of_a_file_are_chosen_as_the_library_does_it(client, tmp_path, name):
    path = tmp_path / "x.aem"
    path.write_bytes(encoded("aem"))
    columns = "time,euler:ZYX,angle:z:sun"
    query = {"format": name, "frame": "GCRF", "columns": columns, "step": "50 s"}
    answer = client.post("/v1/convert", params=query, files=uploaded("aem"))
    data = Ephemeris.read(path).in_frame("GCRF").resampled(np.arange(0.0, 501.0, 50.0))
    expected = encoded_file(data.with_columns(columns), FORMATS[name])
    assert answer.content == b"".join(expected.blocks)


REFUSED = {
    "unknown column": ({"source": "csv", "columns": "tim"}, None, 422, "columns: each of time"),
    "column without an orbit": ({"source": "csv", "columns": "position"}, None, 422, "orbit: "),
    "no format": ({}, b"x", 422, "source: the format of the file"),
    "unknown format": ({"source": "eam"}, b"x", 422, "source: unknown format 'eam'; did you mean 'aem'?"),
    "unknown target": ({"source": "aem", "format": "cvs"}, b"x", 422, "format: unknown format 'cvs'"),
    "no such file": ({"source": "aem"}, b"x", 400, "file"),
    "empty": ({"source": "csv"}, b"", 400, "file"),
    "unknown option": ({"source": "czml", "entiti": "x"}, b"x", 422, "entiti: unknown query parameter"),
    "path of the server": (
        {"source": "ck", "sclk": "/etc/passwd"},
        b"x",
        422,
        "sclk: unknown query parameter",
    ),
    "unknown frame": ({"source": "csv", "frame": "MARS", "format": "json"}, None, 422, "frame: "),
}


@pytest.mark.parametrize(("query", "content", "status", "words"), REFUSED.values(), ids=REFUSED)
def test_file_that_cannot_be_converted_is_a_problem(client, query, content, status, words):
    content = encoded("csv") if content is None else content
    answer = client.post("/v1/convert", params=query, content=content)
    assert assert_problem(answer, status)["detail"].startswith(words)


def test_limits_hold_for_files_too(client):
    answer = client.post("/v1/convert?source=csv", content=b"x" * (MAX_BODY_BYTES + 1))
    assert assert_problem(answer, 413)["detail"].startswith("document: at most")
    small = create_app(Settings(max_samples=5))
    refused = TestClient(small).post("/v1/convert?format=csv", files=uploaded("aem"))
    detail = "file: at most 5 samples (ATTITUDE_MAX_SAMPLES); got '6 samples'"
    assert assert_problem(refused, 422)["detail"] == detail


@pytest.mark.parametrize(
    ("path", "names", "detail"),
    [
        ("convert", ["sclk"], "file: a file of the form, of this name; got nothing"),
        ("check", ["sclk"], "file: a file of the form"),
        ("compare", ["other"], "file: a file of the form"),
        ("compare", ["file", "sclk"], "other: a file of the form"),
        ("convert", ["file", "other"], "other: unknown file 'other'; known: file, sclk"),
        ("check", ["file", "slck"], "slck: unknown file 'slck'; did you mean 'sclk'?"),
        ("convert", ["file", "file"], "file: each file once; got 'the file twice'"),
    ],
)
def test_form_with_other_files_than_the_route_takes_is_a_problem(client, path, names, detail):
    answer = client.post(f"/v1/{path}", files=[(name, ("x.csv", b"x")) for name in names])
    problem = assert_problem(answer, 422)
    assert problem["detail"].startswith(detail)
    assert problem["pointer"] == ""


def test_form_of_too_many_files_is_a_problem(client):
    files = dict.fromkeys(("file", "other", "sclk", "more"), ("x.csv", b"x"))
    assert_problem(client.post("/v1/convert", files=files), 400)


# -- other instants, reports ------------------------------------------------------------------------


def test_file_is_resampled_as_the_library_does_it(client, tmp_path):
    path = tmp_path / "x.aem"
    path.write_bytes(encoded("aem"))
    expected = Ephemeris.read(path).resampled(np.arange(0.0, 501.0, 50.0)).quaternion("wxyz")
    for query in ({"step": "50 s"}, {"times": "0,50,100,150,200,250,300,350,400,450,500"}):
        answer = client.post("/v1/convert", params=query, files=uploaded("aem"))
        assert answer.status_code == 200, answer.text
        columns = answer.json()["columns"]
        found = np.transpose([columns[f"q_{letter}"] for letter in "wxyz"])
        np.testing.assert_array_equal(found, expected)


def gappy(name):
    """Toutatis over 40 days, without ten of them, as a file of a format that holds its inertia."""
    days = [*range(15), *range(25, 41)]
    scene = Scene.model_validate({"scene": "toutatis", "times": {"elapsed": days, "unit": "d"}})
    return b"".join(encoded_file(scene.samples(), FORMATS[name]).blocks)


@pytest.mark.parametrize(
    "body", [None, "3.0836,3.235,1", '{"body": {"moments": [3.0836, 3.235, 1], "unit": "kg m2"}}']
)
def test_gaps_of_a_file_are_filled_by_dynamics(client, body):
    given = {} if body is None else {"inertia": body}
    files = {"file": ("x.csv", gappy("csv"))}
    answer = client.post("/v1/convert", params={"by": "dynamics", "step": "1 d", **given}, files=files)
    assert answer.status_code == 200, answer.text
    columns = answer.json()["columns"]
    found = np.transpose([columns[f"q_{letter}"] for letter in "wxyz"])
    scene = Scene.model_validate(
        {"scene": "toutatis", "times": {"start": 0, "stop": 40, "step": 1, "unit": "d"}}
    )
    truth = scene.run().quaternion("wxyz")
    np.testing.assert_allclose(np.abs((found * truth).sum(1)), 1.0, atol=1e-12)
    assert "by free rotation" in answer.json()["events"][0]["text"]


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ({"by": "dynamics"}, "by: times or step beside it; got 'dynamics'"),
        ({"by": "slerp", "step": "1 d"}, "by: "),
        ({"inertia": "1,2,2.5", "step": "1 d"}, "inertia: by dynamics beside it"),
        ({"inertia": "1,2,9", "step": "1 d", "by": "dynamics"}, "no principal moment greater than the sum"),
        ({"inertia": "1,2", "step": "1 d", "by": "dynamics"}, "moments: shape (..., 3)"),
        ({"inertia": "/etc/passwd", "step": "1 d", "by": "dynamics"}, "not JSON"),
        ({"inertia": '{"bdoy": 1}', "step": "1 d", "by": "dynamics"}, "bdoy: unknown key 'bdoy'"),
        (
            {"inertia": "{}", "step": "1 d", "by": "dynamics"},
            "inertia: three moments by commas, or a document",
        ),
    ],
)
def test_dynamics_that_cannot_be_followed_are_a_problem(client, query, words):
    answer = client.post("/v1/convert", params=query, files={"file": ("x.csv", gappy("csv"))})
    problem = assert_problem(answer, 400 if words == "not JSON" else 422)
    assert words in problem["detail"]
    assert problem.get("pointer", "") == ""


@pytest.mark.parametrize(
    ("name", "value"), [("step", "0"), ("step", "1e-9"), ("times", "x"), ("step", "9 kg")]
)
def test_instants_that_are_none_are_a_problem(client, name, value):
    answer = client.post("/v1/convert", params={name: value}, files=uploaded("aem"))
    problem = assert_problem(answer, 422)
    assert problem["detail"].startswith(f"{name}: ")
    assert problem["pointer"] == ""


def test_report_of_a_file_is_the_librarys(client, tmp_path):
    path = tmp_path / "x.csv"
    path.write_bytes(encoded("csv"))
    report = client.post("/v1/check", files={"file": ("x.csv", encoded("csv"))})
    expected = check_file(path).to_dict()
    assert report.json()["findings"] == json.loads(json.dumps(expected))["findings"]
    assert client.post("/v1/check?source=csv", content=encoded("csv")).status_code == 200


def test_two_files_are_compared_as_the_library_does_it(client):
    pair = {"file": ("a.csv", encoded("csv")), "other": ("b.aem", encoded("aem"))}
    same = client.post("/v1/compare", files=pair)
    assert same.status_code == 200, same.text
    wrong = client.post("/v1/compare?frame=MARS", files=pair)
    assert assert_problem(wrong, 422)["detail"].startswith("frame: ")

"""Answers in every format: chosen by Accept or by name, the library's own bytes, refusals as problems."""

from __future__ import annotations

import io
import re
import zipfile

import numpy as np
import orjson
import pytest
from asking import MAX_SAMPLES, assert_problem
from starlette.testclient import TestClient

from attitude import Ephemeris, Scene
from attitude.formats.encoding import encoded_file
from attitude.formats.registry import FORMATS
from attitude.pointing.columns import parse
from service import create_app
from service.settings import Settings

SMALL = Scene.builtin("toutatis").document()
SMALL_SPAN = {"start": 0, "stop": 600, "step": 60, "unit": "s"}
FILES = [name for name in FORMATS if name != "json"]
# What a file says of the moment it was made; given, two of them are the same.
MADE = {"aem": {"creation_date": "2026-01-01T00:00:00"}, "aem-xml": {"creation_date": "2026-01-01T00:00:00"}}


@pytest.fixture(scope="module")
def large_client():
    """A service with the usual limits."""
    return TestClient(create_app(Settings()))


def library(name, document=SMALL, **options):
    return encoded_file(Scene(**document).samples(), FORMATS[name], options={**MADE.get(name, {}), **options})


def unzipped(content):
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_utc_is_taken_for_ut1_where_the_query_says_so(client):
    late = {**SMALL, "epoch": {"time": "2028-06-01T00:00:00", "scale": "utc"}}
    late["times"] = {"start": 0, "stop": 60, "count": 3, "unit": "s"}
    path = "/v1/ephemeris?format=csv&frame=ITRF"
    assert 'ut1=\\"utc\\" takes UTC for UT1 beyond them' in client.post(path, json=late).text
    got = client.post(f"{path}&ut1=utc", json=late)
    assert got.status_code == 200
    assert "UTC is taken for UT1" in got.text
    assert client.post(path, json={**late, "ut1": "utc"}).text == got.text
    assert client.post(f"{path}&ut1=x", json=late).status_code == 422


def test_path_of_a_frame_kernel_is_no_parameter_of_the_query(client):
    refused = client.post("/v1/convert?source=ck&fk=/etc/hostname", content=b"DAF/CK  ")
    assert refused.status_code == 422
    assert "unknown query parameter 'fk'" in refused.text


@pytest.mark.parametrize("name", FILES)
def test_file_is_the_librarys_own(client, name):
    got = client.post("/v1/ephemeris", json=SMALL, params={"format": name, **MADE.get(name, {})})
    expected = library(name)
    content = b"".join(expected.blocks)
    assert got.status_code == 200
    assert got.headers["content-type"].partition(";")[0] == expected.media
    assert got.headers["content-disposition"] == f'attachment; filename="{expected.name}"'
    if name == "ck":
        assert unzipped(got.content).keys() == unzipped(content).keys()
    elif name not in ("npz", "fits"):  # which hold dates of their own making
        assert got.content == content


@pytest.mark.parametrize("name", FILES)
def test_file_reads_back_as_the_ephemeris(client, name, tmp_path):
    got = client.post("/v1/ephemeris", json=SMALL, params={"format": name})
    path = tmp_path / re.search('filename="(.*)"', got.headers["content-disposition"])[1]
    path.write_bytes(got.content)
    if path.suffix == ".zip":
        for inner, content in unzipped(got.content).items():
            (tmp_path / inner).write_bytes(content)
        (path,) = tmp_path.glob("*.bc")
    expected = Scene(**SMALL).run()
    back = Ephemeris.read(path)
    assert len(back) == len(expected)
    assert abs((back.time - expected.time).sec).max() < 1e-6
    turned = back if name == "czml" else expected.in_frame(back.frame)
    assert back.frame == turned.frame


@pytest.mark.parametrize("known", FORMATS.values(), ids=lambda known: known.name)
def test_accept_names_the_format(client, known):
    got = client.post("/v1/ephemeris", json=SMALL, headers={"accept": known.media})
    assert got.status_code == 200
    expected = "application/zip" if known.has_companions else known.media
    assert got.headers["content-type"].partition(";")[0] == expected


@pytest.mark.parametrize(
    ("accept", "media"),
    [
        ("*/*", "application/json"),
        ("", "application/json"),
        ("text/html,application/xhtml+xml,*/*;q=0.8", "application/json"),
        ("application/*", "application/json"),
        ("text/csv;q=0.5, application/x-ndjson", "application/x-ndjson"),
        ("text/csv, */*;q=0.1", "text/csv"),
        ("application/json;q=0, text/csv;q=0.2", "text/csv"),
        ("text/csv;q=what, application/json", "application/json"),
    ],
)
def test_best_of_what_is_accepted(client, accept, media):
    got = client.post("/v1/ephemeris", json=SMALL, headers={"accept": accept})
    assert got.headers["content-type"].partition(";")[0] == media


def test_name_wins_over_accept(client):
    got = client.post("/v1/ephemeris?format=csv", json=SMALL, headers={"accept": "application/json"})
    assert got.headers["content-type"].startswith("text/csv")
    got = client.post("/v1/ephemeris?format=json", json=SMALL, headers={"accept": "text/csv"})
    assert got.headers["content-type"] == "application/json"


def test_nothing_acceptable_is_a_problem(client):
    problem = assert_problem(
        client.post("/v1/ephemeris", json=SMALL, headers={"accept": "image/png, text/html"}), 406
    )
    assert "application/json" in problem["detail"]
    assert "image/png" in problem["detail"]


def test_options_of_the_format_are_parameters(client):
    got = client.post("/v1/ephemeris?format=aem&object_id=1989-067A&rates=false", json=SMALL)
    assert "OBJECT_ID = 1989-067A" in re.sub(" +", " ", got.text)
    assert "ATTITUDE_TYPE = QUATERNION\n" in re.sub(" +", " ", got.text)


def test_nodes_are_chosen_for_the_tolerance(client):
    got = client.post("/v1/ephemeris?format=stk&interpolation_error=1e-3", json=SMALL)
    assert got.status_code == 200
    assert len(got.text.splitlines()) > 480


def test_frame_is_the_one_asked_for(client):
    got = client.post("/v1/ephemeris?frame=EME2000", json=SMALL).json()
    assert got["frame"] == "EME2000"


@pytest.mark.parametrize(
    ("query", "detail"),
    [
        ({"format": "xls"}, "format: unknown format 'xls'; known: ecsv, csv, json"),
        (
            {"format": "csv", "naif_id": "5"},
            "naif_id: unknown query parameter 'naif_id'; known: ",
        ),
        ({"format": "csv", "interpolation_error": "1e-3"}, "interpolation_error: none for csv"),
        ({"format": "aem", "interpolation_error": "little"}, "interpolation_error: a decimal number"),
        ({"format": "aem", "interpolation_error": "0"}, "interpolation_error: greater than 0"),
        ({"format": "aem", "degree": "many"}, "degree: "),
        ({"frame": "MARS"}, "frame: "),
        ({"columns": "time,quaternoin"}, "columns: each of time, elapsed, quaternion, "),
        ({"columns": "time,time"}, "columns: each once; got 'time'"),
        ({"columns": ""}, "columns: each of time"),
        ({"columns": "angle:z:sum"}, "columns: each of "),
        ({"columns": "angle:z:earth"}, "orbit: "),
        ({"columns": "angle:z:sun", "frame": "INERTIAL"}, "frame: "),
        ({"format": "aem", "columns": "quaternion"}, "columns: none for aem, which is no table"),
        ({"colums": "time"}, "colums: unknown query parameter 'colums'; did you mean 'columns'?"),
    ],
)
def test_what_cannot_be_had_is_a_problem(client, query, detail):
    problem = assert_problem(client.post("/v1/ephemeris", json=SMALL, params=query), 422)
    assert problem["detail"].startswith(detail)


COLUMNS = "elapsed,quaternion,euler:ZYX,direction:-x,angle:z:sun,angle:y:momentum,spin,angular_momentum"
TABLES = [name for name in FORMATS if name not in ("acm", "acm-xml", "aem", "aem-xml", "stk", "czml", "ck")]


@pytest.mark.parametrize("count", [3, 40_000])
@pytest.mark.parametrize("name", TABLES)
def test_columns_of_choice_are_those_of_the_library(large_client, name, count):
    """Of instants in memory, and of those that are computed chunk by chunk, as they are sent."""
    document = SMALL | {"times": {"start": 0, "stop": 9, "count": count, "unit": "d"}}
    query = {"format": name, "columns": COLUMNS}
    got = large_client.post("/v1/ephemeris", json=document, params=query)
    assert got.status_code == 200, got.text[:300]
    columns = parse(COLUMNS)
    expected = encoded_file(Scene(**document).samples(columns=columns), FORMATS[name])
    content = b"".join(expected.blocks)
    if name == "json":
        assert orjson.loads(got.content)["columns"] == orjson.loads(content)["columns"]
        assert got.json()["chosen_columns"] == list(columns)
    elif name in ("npz", "fits"):  # which hold dates of their own making
        assert len(got.content) == len(content)
    else:
        assert got.content == content


def test_columns_of_choice_are_what_the_methods_give(client):
    scene = Scene.model_validate({"scene": "envisat", "times": SMALL_SPAN, "effects": []})
    query = {"columns": "time,euler:ZXZ,direction:y,angle:-y:sun,angle:z:earth,velocity", "frame": "EME2000"}
    got = client.post("/v1/ephemeris", json=scene.document(), params=query).json()["columns"]
    data = scene.run().in_frame("EME2000")
    expected = {
        "euler_zxz_2_deg": data.euler("ZXZ", "deg")[:, 1],
        "direction_y_z": data.direction("y")[:, 2],
        "angle_minus_y_sun_deg": data.angle("-y", "sun", "deg"),
        "angle_z_earth_deg": data.angle("z", "earth", "deg"),
        "velocity_x_m_s": data.velocity[:, 0],
    }
    assert len(got) == 1 + 3 + 3 + 1 + 1 + 3
    for name, values in expected.items():
        np.testing.assert_allclose(got[name], values, rtol=1e-13, err_msg=name)


def test_columns_of_choice_hold_for_every_scene_of_a_list(client):
    answer = client.post("/v1/ephemeris?columns=elapsed,spin", json=[SMALL, SMALL | {"name": "other"}])
    assert [list(each["columns"])[:2] for each in answer.json()["answers"]] == [
        ["elapsed_s", "spin_ra_deg"]
    ] * 2
    refused = client.post("/v1/ephemeris?columns=elapsd", json=[SMALL])
    assert "did you mean 'elapsed'?" in assert_problem(refused, 422)["detail"]


def test_limit_of_samples_holds_for_nodes_too(client):
    query = {"format": "stk", "interpolation_error": "1e-9"}
    problem = assert_problem(client.post("/v1/ephemeris", json=SMALL, params=query), 422)
    assert f"no more than {MAX_SAMPLES} nodes" in problem["detail"]


def test_format_that_cannot_hold_the_ephemeris_is_a_problem(client):
    undated = {key: value for key, value in SMALL.items() if key != "epoch"}
    problem = assert_problem(client.post("/v1/ephemeris?format=aem", json=undated), 422)
    assert problem["detail"].startswith("format: ")

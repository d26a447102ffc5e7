"""The viewer's files: what is served, what it is built from, what a package of it holds. No browser."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from attitude.formats.registry import FORMATS
from service import create_app
from service.routes import HERE, PAGES
from service.settings import Settings

VIEWER, BUNDLE = HERE / "viewer", HERE / "viewer/dist"
VIEWER_FILES = [path.rpartition("/")[2] for path in PAGES if path.startswith("/viewer/")]
ROOT = VIEWER.parents[1]
MEDIA = {
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8",
}
BUILT = "run `npm install && npm run build` in service/viewer, and commit dist/"


@pytest.fixture(scope="module")
def client() -> TestClient:
    return TestClient(create_app(Settings()), raise_server_exceptions=False)


@pytest.fixture(scope="module")
def page() -> str:
    return (BUNDLE / "index.html").read_text()


def test_page_is_html_that_a_browser_asks_about_at_every_visit(client: TestClient, page: str) -> None:
    answer = client.get("/")
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    assert answer.headers["cache-control"] == "no-cache"
    assert answer.text == page


@pytest.mark.parametrize("name", VIEWER_FILES)
def test_file_is_served_whole_under_its_media_type(client: TestClient, name: str) -> None:
    content = (BUNDLE / name).read_bytes()
    answer = client.get(f"/viewer/{name}", headers={"accept-encoding": "identity"})
    assert answer.content == content
    assert answer.headers["content-type"] == MEDIA[Path(name).suffix]
    assert "content-encoding" not in answer.headers
    zipped = client.get(f"/viewer/{name}", headers={"accept-encoding": "gzip, br"})
    assert zipped.headers.get("content-encoding") == (None if len(content) < 1024 else "gzip")
    assert zipped.content == content  # as the client unpacks it
    assert int(zipped.headers["content-length"]) < (0.6 * len(content) if len(content) >= 1024 else 1024)


def test_file_that_is_kept_is_not_sent_again(client: TestClient) -> None:
    first = client.get("/viewer/viewer.js")
    again = client.get("/viewer/viewer.js", headers={"if-none-match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    assert client.get("/viewer/viewer.js", headers={"if-none-match": '"other"'}).status_code == 200


def test_head_of_the_page_has_no_body(client: TestClient) -> None:
    answer = client.head("/")
    assert (answer.status_code, answer.content) == (200, b"")


@pytest.mark.parametrize(
    "name", ["sources.sha256", "main.js", "..%2f..%2fsettings.py", "%2e%2e/pages.py", ""]
)
def test_nothing_else_is_served(client: TestClient, name: str) -> None:
    answer = client.get(f"/viewer/{name}")
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"


def test_every_format_of_the_library_is_offered(client: TestClient) -> None:
    offered = client.get("/viewer/formats.json").json()["formats"]
    assert {each["name"]: (tuple(each["endings"]), each["media"]) for each in offered} == {
        name: (known.endings, known.media) for name, known in FORMATS.items()
    }


def test_pages_are_no_part_of_the_described_interface(client: TestClient) -> None:
    assert not [
        path for path in client.get("/openapi.json").json()["paths"] if "viewer" in path or path == "/"
    ]


# -- the bundle -----------------------------------------------------------------------------------


def digest_of_sources() -> str:
    """As build.mjs takes it."""
    sources = (path.relative_to(VIEWER).as_posix() for path in (VIEWER / "src").rglob("*.*"))
    files = ["build.mjs", "package.json", *sources]
    hashed = sha256()
    for file in sorted(files):
        hashed.update(f"{file}\n".encode() + (VIEWER / file).read_bytes() + b"\n")
    return hashed.hexdigest()


@pytest.mark.skipif(
    not (VIEWER / "src").is_dir(), reason="the viewer's sources are not installed, only its bundle"
)
def test_bundle_was_built_from_the_sources_as_they_are() -> None:
    assert (BUNDLE / "sources.sha256").read_text().strip() == digest_of_sources(), BUILT


def test_page_names_only_files_that_are_served(page: str) -> None:
    named = set(re.findall(r'(?:src|href)="([^"#]+)"', page))
    assert {f"viewer/{name}" for name in VIEWER_FILES} >= {
        name for name in named if name.startswith("viewer/")
    }
    assert {name for name in named if not name.startswith("viewer/")} == {"docs"}


def test_page_keeps_to_a_strict_content_security_policy(page: str) -> None:
    assert not re.search(r"<style|\sstyle=|\son[a-z]+=|javascript:", page)
    assert re.findall(r"<script([^>]*)>([^<]*)", page) == [(' type="module" src="viewer/viewer.js"', "")]
    script = (BUNDLE / "viewer.js").read_text()
    assert not re.search(r"\beval\(|new Function\(", script)
    assert "url(" not in (BUNDLE / "viewer.css").read_text()


def test_bundle_carries_the_licence_of_each_package(page: str) -> None:
    wanted = json.loads((VIEWER / "package.json").read_text())["devDependencies"]
    licences = (BUNDLE / "licences.txt").read_text()
    for name, version in wanted.items():
        assert name == "esbuild" or f"{name} {version} (MIT)" in licences
    assert licences.count("ermission is hereby granted, free of charge") == len(
        re.findall(r"^\S+ \d+\.\d+\.\d+ \(MIT\)$", licences, flags=re.MULTILINE)
    )
    assert "viewer/licences.txt" in page


def test_versions_are_exact_and_no_registry_is_named() -> None:
    wanted = json.loads((VIEWER / "package.json").read_text())["devDependencies"]
    assert all(re.fullmatch(r"\d+\.\d+\.\d+", version) for version in wanted.values())
    assert not (VIEWER / "package-lock.json").exists()


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[zipfile.ZipFile]:
    """Of the project as it stands; built by hatchling itself, which asks no registry."""
    pytest.importorskip("hatchling", reason="hatchling is what builds the wheel")
    if not (ROOT / "pyproject.toml").is_file():
        pytest.skip("installed, not a checkout: there is nothing to build a wheel from")
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True, timeout=60)
    with zipfile.ZipFile(next(Path(folder).glob("*.whl"))) as built:
        yield built


def test_wheel_holds_the_bundle_and_not_what_it_is_built_from(wheel: zipfile.ZipFile) -> None:
    held = {name for name in wheel.namelist() if name.startswith("service/viewer/")}
    served = {*VIEWER_FILES, "index.html", "sources.sha256"}
    assert held == {f"service/viewer/dist/{name}" for name in served}
    assert wheel.read("service/viewer/dist/viewer.js") == (BUNDLE / "viewer.js").read_bytes()


@pytest.mark.parametrize(
    "accepted", ["gzip;q=0", "gzip; q=0.0, br", "gzip; q = 0", "gzip, gzip;q=0", "*;q=0", "identity"]
)
def test_page_is_not_packed_for_who_refuses_that(client: TestClient, accepted: str) -> None:
    answer = client.get("/viewer/viewer.js", headers={"accept-encoding": accepted})
    assert "content-encoding" not in answer.headers

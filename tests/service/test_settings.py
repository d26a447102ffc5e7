"""Settings: read once, frozen, and a bad one says in one line which variable and value it was."""

from __future__ import annotations

import os

import pytest
from pydantic import ValidationError

from attitude import InputError
from attitude.runtime.threads import processors
from service import create_app
from service.settings import Settings


@pytest.fixture(autouse=True)
def clean(monkeypatch):
    """No setting but those of the test."""
    for name in [name for name in os.environ if name.startswith("ATTITUDE_")]:
        monkeypatch.delenv(name)


@pytest.fixture
def read(monkeypatch):
    """Settings of an environment that has these variables."""

    def read(environment, **options):
        with monkeypatch.context() as patched:
            for name, value in environment.items():
                patched.setenv(name, value)
            return Settings.read(**options)

    return read


def test_environment_that_says_nothing_gives_the_defaults(read):
    assert read({}) == Settings()
    assert (Settings().host, Settings().port, Settings().workers) == ("127.0.0.1", 8000, 1)
    assert Settings().token is None
    assert Settings().cors_origins == ()


GIVEN = {
    "host": ("0.0.0.0", "0.0.0.0"),
    "port": ("9000", 9000),
    "max_samples": ("10", 10),
    "max_effects": ("3", 3),
    "max_scenes": ("3", 3),
    "max_seconds": ("5", 5),
    "max_body_bytes": ("2000", 2000),
    "max_requests": ("7", 7),
    "workers": ("2", 2),
    "threads": ("3", 3),
    "client_seconds": ("4", 4),
    "token": ("0123456789abcdef", "0123456789abcdef"),
    "cors_origins": (
        "https://a.example, http://b.example:8080",
        ("https://a.example", "http://b.example:8080"),
    ),
    "log_level": ("Warning", "warning"),
}


@pytest.mark.parametrize(("name", "text", "value"), [(name, *pair) for name, pair in GIVEN.items()])
def test_every_setting_has_its_variable(read, name, text, value):
    assert read({f"ATTITUDE_{name.upper()}": text}) == Settings(**{name: value})


def test_no_setting_is_forgotten_here():
    assert {*GIVEN, "token_file"} == set(Settings.model_fields)


def test_token_is_read_from_its_file(read, tmp_path):
    path = tmp_path / "token"
    path.write_text("0123456789abcdef\n")
    assert read({"ATTITUDE_TOKEN_FILE": str(path)}).token == "0123456789abcdef"
    with pytest.raises(InputError, match="either this or ATTITUDE_TOKEN"):
        read({"ATTITUDE_TOKEN_FILE": str(path), "ATTITUDE_TOKEN": "0123456789abcdef"})
    for text in ("", "short", "with blanks in it all over"):
        path.write_text(text)
        with pytest.raises(InputError, match=r"^ATTITUDE_TOKEN_FILE: at least 16"):
            read({"ATTITUDE_TOKEN_FILE": str(path)})


def test_bad_token_is_not_repeated(read):
    with pytest.raises(InputError) as refusal:
        read({"ATTITUDE_TOKEN": "my secret"})
    assert "secret" not in str(refusal.value)


def test_threads_and_requests_follow_the_processors_and_workers(monkeypatch):
    monkeypatch.setattr("service.settings.processors", lambda: 8)
    assert Settings().computing_threads == 8
    assert Settings(workers=3).computing_threads == 2
    assert Settings(workers=16).computing_threads == 1
    assert Settings(threads=5).requests_in_flight == 16 * 5
    assert Settings(max_requests=2).requests_in_flight == 2


@pytest.mark.parametrize(("text", "count"), [("50000 100000", 1), ("max 100000", None), ("nonsense", None)])
def test_processors_are_those_of_the_containers_share(monkeypatch, tmp_path, text, count):
    path = tmp_path / "cpu.max"
    path.write_text(text)
    monkeypatch.setattr("attitude.runtime.threads.CPU_SHARE", path)
    assert processors() == (count or len(os.sched_getaffinity(0)))


def test_flag_wins_over_the_environment(read):
    environment = {"ATTITUDE_HOST": "0.0.0.0", "ATTITUDE_PORT": "9000"}
    settings = read(environment, host=None, port=9001)
    assert (settings.host, settings.port) == ("0.0.0.0", 9001)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("ATTITUDE_HOST", " "),
        ("ATTITUDE_PORT", "eighty"),
        ("ATTITUDE_PORT", ""),
        ("ATTITUDE_PORT", "65536"),
        ("ATTITUDE_PORT", "-1"),
        ("ATTITUDE_PORT", "tcp://10.0.0.1:8000"),
        ("ATTITUDE_MAX_SAMPLES", "1e6"),
        ("ATTITUDE_MAX_SAMPLES", "0"),
        ("ATTITUDE_MAX_BODY_BYTES", "4 MiB"),
        ("ATTITUDE_MAX_BODY_BYTES", "9" * 5000),
        ("ATTITUDE_MAX_REQUESTS", "0"),
        ("ATTITUDE_WORKERS", "0"),
        ("ATTITUDE_WORKERS", "1025"),
        ("ATTITUDE_THREADS", "two"),
        ("ATTITUDE_CLIENT_SECONDS", "0"),
        ("ATTITUDE_TOKEN_FILE", ""),
        ("ATTITUDE_TOKEN_FILE", "no/such/file"),
        ("ATTITUDE_CORS_ORIGINS", "example.org"),
        ("ATTITUDE_CORS_ORIGINS", "https://a.example/path"),
        ("ATTITUDE_CORS_ORIGINS", "null"),
        ("ATTITUDE_LOG_LEVEL", "loud"),
    ],
)
def test_bad_setting_names_the_variable_and_the_value_in_one_line(read, name, value):
    with pytest.raises(InputError) as refusal:
        read({name: value})
    text = str(refusal.value)
    assert text.startswith(f"{name}: ")
    assert repr(value)[:50] in text
    assert "\n" not in text


def test_bad_flag_names_the_flag(read):
    with pytest.raises(InputError, match=r"^--port: .*; got '70000'$"):
        read({"ATTITUDE_PORT": "8000"}, port=70000)


def test_variables_that_are_no_settings_are_let_be(read):
    """An orchestrator adds some of its own under the same prefix (ATTITUDE_SERVICE_HOST)."""
    assert read({"ATTITUDE_SERVICE_HOST": "10.0.0.1"}) == Settings()


def test_settings_are_frozen():
    with pytest.raises(ValidationError):
        Settings().port = 1


def test_application_without_settings_reads_the_environment(monkeypatch):
    monkeypatch.setenv("ATTITUDE_MAX_SAMPLES", "7")
    assert create_app().state.settings.max_samples == 7

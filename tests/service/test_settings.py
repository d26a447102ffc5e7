"""Settings: read once, frozen, and a bad one says in one line which variable and value it was."""

from __future__ import annotations

import dataclasses

import pytest

from attitude import InputError
from service import create_app
from service.settings import Settings


def test_environment_that_says_nothing_gives_the_defaults():
    assert Settings.read({}) == Settings("127.0.0.1", 8000, 1_000_000, 100, 30, 4 * 2**20)


def test_every_setting_has_its_variable():
    environment = {
        "ATTITUDE_HOST": "0.0.0.0",
        "ATTITUDE_PORT": "9000",
        "ATTITUDE_MAX_SAMPLES": "10",
        "ATTITUDE_MAX_EFFECTS": "3",
        "ATTITUDE_MAX_SECONDS": "5",
        "ATTITUDE_MAX_BODY_BYTES": "2000",
    }
    assert Settings.read(environment) == Settings("0.0.0.0", 9000, 10, 3, 5, 2000)


def test_flag_wins_over_the_environment():
    environment = {"ATTITUDE_HOST": "0.0.0.0", "ATTITUDE_PORT": "9000"}
    settings = Settings.read(environment, host=None, port=9001)
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
    ],
)
def test_bad_setting_names_the_variable_and_the_value_in_one_line(name, value):
    with pytest.raises(InputError) as refusal:
        Settings.read({name: value})
    text = str(refusal.value)
    assert text.startswith(f"{name}: ")
    assert repr(value)[:50] in text
    assert "\n" not in text


def test_bad_flag_names_the_flag():
    with pytest.raises(InputError, match=r"^--port: .*; got '70000'$"):
        Settings.read({"ATTITUDE_PORT": "8000"}, port=70000)


def test_variables_that_are_no_settings_are_let_be():
    """An orchestrator adds some of its own under the same prefix (ATTITUDE_SERVICE_HOST)."""
    assert Settings.read({"ATTITUDE_SERVICE_HOST": "10.0.0.1"}) == Settings()


def test_settings_are_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        Settings().port = 1


def test_application_without_settings_reads_the_environment(monkeypatch):
    monkeypatch.setenv("ATTITUDE_MAX_SAMPLES", "7")
    assert create_app().state.settings.max_samples == 7

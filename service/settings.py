"""What the environment decides: ATTITUDE_* variables, read once into a frozen object."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from attitude.errors import InputError
from attitude.runtime.threads import processors

PREFIX = "ATTITUDE_"
GREATEST_PORT = 65535
LEVELS = ("debug", "info", "warning", "error")
MOST_THREADS = 1024
SHORTEST_TOKEN = 16
ORIGINS = "origins such as https://example.org, by commas, or * for all"
TOKEN = f"at least {SHORTEST_TOKEN} letters, digits or any of -._~+/="
TOKEN_MARKS = "-._~+/="


def _text(name: str, value: str) -> str:
    if not value.strip():
        raise InputError(name, value, "an address to listen at, such as 127.0.0.1 or 0.0.0.0")
    return value.strip()


def _port(name: str, value: str) -> int:
    if not _is_whole(value) or int(value) > GREATEST_PORT:
        raise InputError(name, value, f"a port, a whole number from 0 (any free one) to {GREATEST_PORT}")
    return int(value)


def _count(name: str, value: str) -> int:
    if not _is_whole(value) or int(value) < 1:
        raise InputError(name, value, "a whole number, at least 1")
    return int(value)


def _few(name: str, value: str) -> int:
    if not _is_whole(value) or not 1 <= int(value) <= MOST_THREADS:
        raise InputError(name, value, f"a whole number from 1 to {MOST_THREADS}")
    return int(value)


def _seconds(name: str, value: str) -> int:
    if not _is_whole(value):
        raise InputError(name, value, "a whole number of seconds, 0 or more")
    return int(value)


def _is_whole(value: str) -> bool:
    return value.isascii() and value.isdigit() and len(value) < 20


def _level(name: str, value: str) -> str:
    if value.lower() not in LEVELS:
        raise InputError(name, value, f"one of {', '.join(LEVELS)}")
    return value.lower()


def _origins(name: str, value: str) -> tuple[str, ...]:
    origins = tuple(origin.strip() for origin in value.split(",") if origin.strip())
    for origin in origins:
        if origin != "*" and not _is_origin(origin):
            raise InputError(name, origin, ORIGINS)
    return origins


def _is_origin(text: str) -> bool:
    try:
        parts = urlsplit(text)
    except ValueError:
        return False
    return (
        parts.scheme in ("http", "https")
        and bool(parts.netloc)
        and text == f"{parts.scheme}://{parts.netloc}"
    )


def _token(name: str, value: str) -> str:
    """Never repeated in an error: it is a secret even where it is a bad one."""
    token = value.strip()
    if len(token) < SHORTEST_TOKEN or not all(
        mark.isascii() and (mark.isalnum() or mark in TOKEN_MARKS) for mark in token
    ):
        raise InputError(name, f"{len(token)} characters", TOKEN)
    return token


def _path(name: str, value: str) -> str:
    if not value.strip():
        raise InputError(name, value, "the path of a file that holds the token")
    return value


def _setting(default: Any, read: Callable[[str, str], Any], meaning: str, secret: bool = False) -> Any:
    metadata = {"read": read, "meaning": meaning, "secret": secret}
    return field(default=default, metadata=metadata, repr=not secret)


@dataclass(frozen=True)
class Settings:
    """Each field is the variable ATTITUDE_ + its name in capitals; its metadata says what it means."""

    host: str = _setting("127.0.0.1", _text, "address to listen at")
    port: int = _setting(8000, _port, "port to listen at; 0 is any free one")
    max_samples: int = _setting(1_000_000, _count, "instants that one answer may hold")
    max_effects: int = _setting(100, _count, "effects that one scene may name")
    max_seconds: int = _setting(30, _count, "seconds of computing that one request may need")
    max_body_bytes: int = _setting(4 * 2**20, _count, "bytes that a request's document may have")
    max_requests: int | None = _setting(
        None, _count, "requests that a worker computes or keeps waiting; by default 16 for each thread"
    )
    workers: int = _setting(1, _few, "processes that answer")
    threads: int | None = _setting(
        None, _few, "threads of a worker that compute; by default the processors, shared among the workers"
    )
    client_seconds: int = _setting(
        20, _count, "seconds that a client may take to send a request, or to take anything of an answer"
    )
    drain_seconds: int = _setting(
        1, _seconds, "seconds from SIGTERM, not ready any more, to when nothing new is taken"
    )
    token: str | None = _setting(
        None, _token, "bearer token that requests have to bring; none by default", True
    )
    token_file: str | None = _setting(None, _path, "file that holds the token, instead of the token itself")
    cors_origins: tuple[str, ...] = _setting(
        (), _origins, "origins whose pages may ask, by commas; none by default"
    )
    log_level: str = _setting("info", _level, f"what is logged: {', '.join(LEVELS)}")

    @classmethod
    def read(cls, environment: Mapping[str, str], **flags: object) -> Settings:
        """From the environment; a flag that is not None wins.

        Raises InputError, in one line that names the variable (or flag), the value and what would be right.
        """
        values = {}
        for each in fields(cls):
            name, flag = variable(each.name), flags.get(each.name)
            if flag is not None:
                values[each.name] = each.metadata["read"](f"--{each.name.replace('_', '-')}", str(flag))
            elif name in environment:
                values[each.name] = each.metadata["read"](name, environment[name])
        return cls(**values)._with_token()

    def _with_token(self) -> Settings:
        """The token of the file, where one is named."""
        if self.token_file is None:
            return self
        name = variable("token_file")
        if self.token is not None:
            raise InputError(name, self.token_file, f"either this or {variable('token')}")
        try:
            text = Path(self.token_file).read_text()
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or "not text"
            raise InputError(name, self.token_file, f"a file that can be read ({reason})") from None
        return replace(self, token=_token(name, text))

    @property
    def computing_threads(self) -> int:
        """Of each worker: together near the number of processors, more would only take turns."""
        return self.threads or max(1, processors() // self.workers)

    @property
    def requests_in_flight(self) -> int:
        """Of each worker: computing, or waiting for a thread."""
        return self.max_requests or 16 * self.computing_threads


def variable(field_name: str) -> str:
    """The environment variable of a setting: "max_samples" is "ATTITUDE_MAX_SAMPLES"."""
    return PREFIX + field_name.upper()

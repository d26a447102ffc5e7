"""Settings: the ATTITUDE_* variables of the environment, as pydantic-settings reads them.

`python -m service.settings` prints them as a table.
"""

import multiprocessing
import re
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, ValidationInfo, field_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict
from uvicorn import config

from attitude.errors import InputError
from attitude.runtime.threads import processors

PREFIX = "ATTITUDE_"


class Settings(BaseSettings):
    """Each field is the variable ATTITUDE_ + its name in capitals; arguments win over the environment."""

    model_config = SettingsConfigDict(
        env_prefix=PREFIX, frozen=True, extra="ignore", str_strip_whitespace=True, hide_input_in_errors=True
    )

    host: str = Field("127.0.0.1", min_length=1, description="address to listen at")
    port: int = Field(8000, ge=0, le=65535, description="port to listen at; 0 is any free one")
    max_samples: int = Field(1_000_000, ge=1, description="instants that one answer may hold")
    max_effects: int = Field(100, ge=1, description="effects that one scene may name")
    max_scenes: int = Field(1000, ge=1, description="scenes that one list may hold")
    max_seconds: int = Field(30, ge=1, description="seconds of computing that one request may need")
    max_body_bytes: int = Field(4 * 2**20, ge=1, description="bytes that a request's body may have")
    max_requests: int | None = Field(None, ge=1, description="requests at a worker; by default 16 per thread")
    workers: int = Field(1, ge=1, le=1024, description="processes that answer")
    threads: int | None = Field(
        None,
        ge=1,
        le=1024,
        description="threads of a worker that compute; by default its share of processors",
    )
    client_seconds: int = Field(20, ge=1, description="seconds to send a document in, or to take a block in")
    token_file: str | None = Field(None, description="file that holds the token, instead of the token itself")
    token: str | None = Field(None, repr=False, validate_default=True, description="bearer token to bring")
    cors_origins: Annotated[tuple[str, ...], NoDecode] = Field(
        (), description="origins whose pages may ask, by commas"
    )
    log_level: Literal["debug", "info", "warning", "error"] = Field(
        "info", description="what is logged: debug, info, warning, error"
    )

    @field_validator("token_file")
    @classmethod
    def check_token_file(cls, path: str | None) -> str | None:
        if path is not None:
            check_token(read_token(path))
        return path

    @field_validator("token")
    @classmethod
    def find_token(cls, token: str | None, info: ValidationInfo) -> str | None:
        path = info.data.get("token_file")
        if token is not None and path is not None:
            raise ValueError(f"either this or {variable('token_file')}, not both")
        if path is not None:
            return read_token(path)
        return None if token is None else check_token(token)

    @field_validator("cors_origins", mode="before")
    @classmethod
    def split_origins(cls, value: Any) -> Any:
        origins = [each.strip() for each in value.split(",")] if isinstance(value, str) else value
        if not all(re.fullmatch(r"\*|https?://[^/?#\s]+", origin) for origin in origins):
            raise ValueError("origins such as https://example.org, by commas, or * for all")
        return origins

    @field_validator("log_level", mode="before")
    @classmethod
    def lower(cls, value: Any) -> Any:
        return value.lower() if isinstance(value, str) else value

    @classmethod
    def read(cls, **options: object) -> "Settings":
        """Settings of the environment; an option that is not None wins.

        Raises InputError, in one line that names the variable (or option), the value and what would be right.
        """
        given = {name: str(value) for name, value in options.items() if value is not None}
        try:
            return cls(**given)  # type: ignore[arg-type]
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
        name = str(first["loc"][0])
        value = f"{len(first['input'])} characters" if name == "token" else first["input"]
        shown = f"--{name.replace('_', '-')}" if name in given else variable(name)
        message = first["msg"].removeprefix("Value error, ")
        raise InputError(shown, value, message[0].lower() + message[1:])

    @property
    def computing_threads(self) -> int:
        """Threads of each worker: together near the number of processors, more would only take turns."""
        return self.threads or max(1, processors() // self.workers)

    @property
    def requests_in_flight(self) -> int:
        """Requests of each worker that compute, or wait for a thread."""
        return self.max_requests or 16 * self.computing_threads


def read_token(path: str) -> str:
    try:
        return Path(path).read_text().strip()
    except OSError as error:
        raise ValueError(f"a file that can be read ({error.strerror})") from None


def check_token(token: str) -> str:
    if not re.fullmatch(r"[A-Za-z0-9\-._~+/=]{16,}", token):
        raise ValueError("at least 16 letters, digits or any of -._~+/=")
    return token


def refused_start(error: InputError) -> SystemExit:
    """One line on standard error, and the command's exit code for bad arguments; of a worker uvicorn's own,
    by which its supervisor ends too, instead of starting another for ever.
    """
    print(f"attitude: {error}", file=sys.stderr)
    return SystemExit(2 if multiprocessing.parent_process() is None else config.STARTUP_FAILURE)


def variable(field_name: str) -> str:
    """The environment variable of a setting: "max_samples" is "ATTITUDE_MAX_SAMPLES"."""
    return PREFIX + field_name.upper()


def table() -> str:
    """The settings as a Markdown table; a setting without a default says in words what holds then."""
    rows = [
        f"| `{variable(name)}` | {f'`{field.default}`' if field.default else ''} | {field.description} |"
        for name, field in Settings.model_fields.items()
    ]
    return "\n".join(["| variable | default | what |", "|---|---|---|", *rows])


if __name__ == "__main__":
    print(table())

"""What the environment decides: ATTITUDE_* variables, read once into a frozen object."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from attitude.errors import InputError

PREFIX = "ATTITUDE_"
GREATEST_PORT = 65535


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


def _is_whole(value: str) -> bool:
    return value.isascii() and value.isdigit() and len(value) < 20


def _setting(default: Any, read: Callable[[str, str], Any], meaning: str) -> Any:
    return field(default=default, metadata={"read": read, "meaning": meaning})


@dataclass(frozen=True)
class Settings:
    """Each field is the variable ATTITUDE_ + its name in capitals; its metadata says what it means."""

    host: str = _setting("127.0.0.1", _text, "address to listen at")
    port: int = _setting(8000, _port, "port to listen at")
    max_samples: int = _setting(1_000_000, _count, "instants that one answer may hold")
    max_effects: int = _setting(100, _count, "effects that one scene may name")
    max_seconds: int = _setting(30, _count, "seconds of computing that a plan may predict")
    max_body_bytes: int = _setting(4 * 2**20, _count, "bytes that a request's document may have")

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
        return cls(**values)


def variable(field_name: str) -> str:
    """The environment variable of a setting: "max_samples" is "ATTITUDE_MAX_SAMPLES"."""
    return PREFIX + field_name.upper()

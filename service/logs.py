"""The log: one JSON object a line, on standard error; never a document, never a token."""

from __future__ import annotations

import logging
from datetime import UTC, datetime
from typing import Any

import orjson

from .compute import current

FIELDS = "fields"  # of a record: members of the line beside its message


class JsonLines(logging.Formatter):
    """time, level, logger, message; the request it was about; the fields it was given; the error, if any."""

    def format(self, record: logging.LogRecord) -> str:
        job = current.get()
        line: dict[str, Any] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": plain(record.getMessage()),
        }
        if job is not None and job.identity:
            line["request_id"] = job.identity
        line |= getattr(record, FIELDS, {})
        if record.exc_info:
            line["error"] = plain(self.formatException(record.exc_info))
        return orjson.dumps(line, default=str).decode()


def plain(text: str) -> str:
    """What UTF-8 can hold: a request's path may name half a surrogate pair."""
    return text.encode("utf-8", "backslashreplace").decode()


def configuration(level: str) -> dict[str, Any]:
    """For logging.config: this service's lines and the server's in one form; requests are logged by ours."""
    ours = {"handlers": ["stderr"], "level": level.upper(), "propagate": False}
    silent: dict[str, Any] = {"handlers": [], "propagate": False}
    return {
        "version": 1,
        "disable_existing_loggers": False,
        "formatters": {"json": {"()": JsonLines}},
        "handlers": {"stderr": {"class": "logging.StreamHandler", "formatter": "json"}},
        "loggers": {
            __package__: ours,
            "uvicorn": ours,
            "uvicorn.error": silent | {"propagate": True},
            "uvicorn.access": silent,
        },
    }

"""The log: one JSON object a line, on standard error; never a document, never a token."""

import logging
from datetime import UTC, datetime
from typing import Any

import orjson

from .compute import current


class JsonLines(logging.Formatter):
    """time, level, logger, message; the request it was about; the `fields` it was given; the error."""

    def format(self, record: logging.LogRecord) -> str:
        job = current.get()
        line: dict[str, Any] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            **({"request_id": job.identity} if job else {}),
            **getattr(record, "fields", {}),
            **({"error": self.formatException(record.exc_info)} if record.exc_info else {}),
        }
        return orjson.dumps({name: plain(value) for name, value in line.items()}, default=str).decode()


def plain(value: Any) -> Any:
    """Text that UTF-8 can hold: a request may name half a surrogate pair."""
    return value.encode("utf-8", "backslashreplace").decode() if isinstance(value, str) else value


def configuration(level: str) -> dict[str, Any]:
    """Return what logging.config takes: lines of service and server in one form; ours log the requests."""
    ours = {"handlers": ["stderr"], "level": level.upper(), "propagate": False}
    silent: dict[str, Any] = {"handlers": [], "propagate": False}
    uvicorn = {"uvicorn": ours, "uvicorn.error": silent | {"propagate": True}, "uvicorn.access": silent}
    return {
        "version": 1,
        "disable_existing_loggers": False,
        "formatters": {"json": {"()": JsonLines}},
        "handlers": {"stderr": {"class": "logging.StreamHandler", "formatter": "json"}},
        "loggers": {__package__: ours, "py.warnings": ours, **uvicorn},
    }

"""What a request asks for beside its document: the query's parameters, and headers that choose."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from starlette.requests import Request

from attitude.errors import InputError
from attitude.formats.encoding import parse_options
from attitude.formats.registry import Format

from .negotiation import accepts_gzip, wanted

# Python would also take "1_0", "nan" and digits of other scripts.
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
NO_QUERY = "[]"
OURS = ("drop_below", "format", "frame", "interpolation_error")


class Asked(NamedTuple):
    """How an ephemeris is to be answered.

    options : of the format, as text
    text : of the query, in one order whatever order it came in
    seen : the tags of answers that the client has
    """

    known: Format
    drop_below: float | None
    frame: str | None
    interpolation_error: float | None
    options: dict[str, object]
    text: str
    seen: str
    gzip: bool

    @property
    def has_query(self) -> bool:
        return self.text != NO_QUERY

    @classmethod
    def of(cls, request: Request) -> Asked:
        given = parameters(request)
        known = wanted(given.get("format"), request.headers.get("accept", ""))
        others = {name: text for name, text in given.items() if name not in OURS}
        return cls(
            known,
            angle(given, "drop_below"),
            given.get("frame"),
            angle(given, "interpolation_error"),
            parse_options(others, known),
            repr(sorted(given.items())),
            request.headers.get("if-none-match", ""),
            accepts_gzip(request.headers.get("accept-encoding", "")),
        )


def parameters(request: Request, *taken: str, repeated: str = "") -> dict[str, str]:
    """Of the query, each given once; InputError for any but those `taken`, where they are named."""
    given: dict[str, str] = {}
    if not request.scope["query_string"]:
        return given
    for name, text in request.query_params.multi_items():
        if name in given and name != repeated:
            raise InputError(name, "the parameter twice", "each parameter once", steps=())
        if taken and name not in taken:
            raise InputError(name, text, f"a parameter of {', '.join(taken)}", steps=())
        given[name] = text
    return given


def none(request: Request) -> None:
    """InputError for any parameter, at a route that has none."""
    for name, text in parameters(request).items():
        raise InputError(name, text, "no parameter: none is taken here", steps=())


def angle(given: dict[str, str], name: str) -> float | None:
    return number(given, name, "an angle in rad, above 0")


def number(given: dict[str, str], name: str, expected: str) -> float | None:
    if name not in given:
        return None
    if not NUMBER.fullmatch(given[name]):
        raise InputError(name, given[name], expected, steps=())
    return float(given[name])


def whole(given: dict[str, str], name: str, expected: str) -> int | None:
    text = given.get(name)
    if text is None:
        return None
    if not (text.isascii() and text.isdigit() and len(text) < 20):
        raise InputError(name, text, expected, steps=())
    return int(text)


@contextmanager
def no_field(*names: str) -> Iterator[None]:
    """An error about one of these parameters points at no field of the document."""
    try:
        yield
    except InputError as error:
        if error.field in names:
            error.steps = ()
        raise

"""What a request asks for beside its document: the query's parameters, and headers that choose."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from http import HTTPStatus
from typing import NamedTuple

from starlette.exceptions import HTTPException
from starlette.requests import Request

from attitude.errors import InputError
from attitude.formats import module_of, option_names
from attitude.formats.encoding import parse_options
from attitude.formats.registry import FORMATS, Format

# Python would also take "1_0", "nan" and digits of other scripts.
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
WHOLE = re.compile(r"\d{1,19}", re.ASCII)
ANGLE = "an angle in rad, above 0"
OURS = ("drop_below", "format", "frame", "interpolation_error")


class Query(NamedTuple):
    """How an ephemeris is to be answered.

    options : of the format, as text
    text : of the query, in one order whatever order it came in
    if_none_match : the tags of answers that the client has
    """

    format: Format
    drop_below: float | None
    frame: str | None
    interpolation_error: float | None
    options: dict[str, object]
    text: str
    if_none_match: str

    @classmethod
    def of(cls, request: Request) -> Query:
        given = parameters(request)
        format = wanted(given.get("format"), request.headers.get("accept", ""))  # noqa: A001 (the query parameter)
        others = {name: text for name, text in given.items() if name not in OURS}
        if others:
            _check_known(others, (*OURS, *option_names(module_of(format).blocks)))
        return cls(
            format,
            number(given, "drop_below", ANGLE),
            given.get("frame"),
            number(given, "interpolation_error", ANGLE),
            parse_options(others, format),
            repr(sorted(given.items())),
            request.headers.get("if-none-match", ""),
        )


# -- parameters --------------------------------------------------------------------------------------


def parameters(request: Request, *known: str, repeatable: str = "") -> dict[str, str]:
    """Of the query, each given once; InputError for any but those `known`, where they are named."""
    given: dict[str, str] = {}
    for name, text in request.query_params.multi_items():
        if name in given and name != repeatable:
            raise InputError(name, "the parameter twice", "each parameter once", steps=())
        given[name] = text
    if known:
        _check_known(given, known)
    return given


def none(request: Request) -> None:
    """InputError for any parameter, at a route that has none."""
    _check_known(parameters(request), ())


def _check_known(given: dict[str, str], known: tuple[str, ...]) -> None:
    for name, text in given.items():
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            others = f"a parameter of {', '.join(known)}" if known else "no parameter: none is taken here"
            meant = f"did you mean {near[0]!r}?" if near else others
            raise InputError(name, text, f"unknown query parameter {name!r}; {meant}", steps=())


def number(given: dict[str, str], name: str, expected: str) -> float | None:
    if name not in given:
        return None
    if not NUMBER.fullmatch(given[name]):
        raise InputError(name, given[name], expected, steps=())
    return float(given[name])


def whole(given: dict[str, str], name: str, expected: str) -> int | None:
    if name not in given:
        return None
    if not WHOLE.fullmatch(given[name]):
        raise InputError(name, given[name], expected, steps=())
    return int(given[name])


@contextmanager
def no_field(*names: str) -> Iterator[None]:
    """An error about one of these parameters points at no field of the document."""
    try:
        yield
    except InputError as error:
        if error.field in names:
            error.steps = ()
        raise


# -- headers -----------------------------------------------------------------------------------------


@lru_cache(maxsize=256)
def wanted(name: str | None, accept: str) -> Format:
    """The format that `?format=` names, else the best that Accept names.

    Raises InputError for a name that is none, HTTPException 406 where nothing accepted is known.
    """
    if name is not None:
        if name not in FORMATS:
            raise InputError("format", name, f"one of {', '.join(FORMATS)}", steps=())
        return FORMATS[name]
    if not accept.strip():
        return FORMATS["json"]
    ranges = qualities(accept)
    weights = {each: _weight(each.media, ranges) for each in FORMATS.values()}
    best = max(weights, key=lambda each: (weights[each], each.name == "json"))  # the first of equals
    if weights[best] <= 0.0:
        offered = ", ".join(each.media for each in weights)
        raise HTTPException(HTTPStatus.NOT_ACCEPTABLE, f"accept: one of {offered}; got {accept[:200]}")
    return best


def _weight(media: str, ranges: dict[str, float]) -> float:
    """Of a media type by the most specific range that names it (RFC 9110, 12.5.1); 0 where none does."""
    family = media.partition("/")[0] + "/*"
    return ranges.get(media, ranges.get(family, ranges.get("*/*", 0.0)))


@lru_cache(maxsize=256)
def accepts_gzip(accept_encoding: str) -> bool:
    """Whether Accept-Encoding names gzip, or anything, with a weight above 0 (RFC 9110, 12.5.3)."""
    weights = qualities(accept_encoding)
    return weights.get("gzip", weights.get("x-gzip", weights.get("*", 0.0))) > 0.0


def qualities(header: str) -> dict[str, float]:
    """Weights of the members of Accept or Accept-Encoding, by name (RFC 9110, 12.4.2)."""
    found: dict[str, float] = {}
    for member in header.lower().split(","):
        name, *others = (part.strip() for part in member.split(";"))
        quality = next((other[2:] for other in others if other.startswith("q=")), "1")
        try:
            found.setdefault(name, min(max(float(quality), 0.0), 1.0))
        except ValueError:
            found.setdefault(name, 0.0)
    return found

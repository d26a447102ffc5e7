"""Which format an answer is in: the one that `?format=` names, else the best that Accept names."""

from __future__ import annotations

from functools import lru_cache
from http import HTTPStatus

from starlette.exceptions import HTTPException

from attitude.errors import InputError
from attitude.formats.registry import FORMATS, Format

USUAL = FORMATS["json"]


@lru_cache(maxsize=256)
def wanted(name: str | None, accept: str) -> Format:
    """Raises InputError for a name that is none, HTTPException 406 where nothing accepted is known."""
    if name is not None:
        if name not in FORMATS:
            raise InputError("format", name, f"one of {', '.join(FORMATS)}", steps=())
        return FORMATS[name]
    if not accept.strip():
        return USUAL
    weights = [
        (_weight(known.media, accept), known is USUAL, -i, known) for i, known in enumerate(FORMATS.values())
    ]
    weight, _, _, best = max(weights)
    if weight <= 0.0:
        offered = ", ".join(known.media for known in FORMATS.values())
        raise HTTPException(HTTPStatus.NOT_ACCEPTABLE, f"accept: one of {offered}; got {accept}")
    return best


def _weight(media: str, accept: str) -> float:
    """Of a media type by the most specific range that names it (RFC 9110, 12.5.1); 0 where none does."""
    best, weight = 0, 0.0
    for part in accept.split(","):
        wanted, *parameters = (piece.strip().lower() for piece in part.split(";"))
        specific = {"*/*": 1, f"{media.partition('/')[0]}/*": 2, media: 3}.get(wanted, 0)
        if specific > best:
            best, weight = specific, _quality(parameters)
    return weight


def _quality(parameters: list[str]) -> float:
    for parameter in parameters:
        name, _, value = parameter.partition("=")
        if name.strip() == "q":
            try:
                return min(max(float(value), 0.0), 1.0)
            except ValueError:
                return 0.0
    return 1.0


@lru_cache(maxsize=256)
def accepts_gzip(accept_encoding: str) -> bool:
    """Whether Accept-Encoding names gzip, or anything, with a weight above 0 (RFC 9110, 12.5.3)."""
    if not accept_encoding:
        return False
    weights: dict[str, float] = {}
    for part in accept_encoding.split(","):
        name, *parameters = (piece.strip().lower() for piece in part.split(";"))
        weights[name] = _quality(parameters)
    return weights.get("gzip", weights.get("x-gzip", weights.get("*", 0.0))) > 0.0

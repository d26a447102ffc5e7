"""Content negotiation: weights of Accept and Accept-Encoding, and the format that an answer has."""

from __future__ import annotations

from functools import lru_cache
from http import HTTPStatus

from starlette.exceptions import HTTPException

from attitude.errors import unknown_name
from attitude.formats.registry import FORMATS, Format


@lru_cache(maxsize=256)
def negotiated(name: str | None, accept: str) -> Format:
    """The format that `?format=` names, else the best that Accept names.

    Raises InputError for a name that is none, HTTPException 406 where nothing accepted is known.
    """
    if name is not None:
        if name not in FORMATS:
            raise unknown_name("format", "format", name, FORMATS, steps=())
        return FORMATS[name]
    if not accept.strip():
        return FORMATS["json"]
    ranges = qualities(accept)
    weights = {each: weight(each.media, ranges) for each in FORMATS.values()}
    best = max(weights, key=lambda each: (weights[each], each.name == "json"))  # the first of equals
    if not weights[best]:
        offered = ", ".join(each.media for each in weights)
        raise HTTPException(HTTPStatus.NOT_ACCEPTABLE, f"accept: one of {offered}; got {accept[:200]}")
    return best


def weight(media: str, ranges: dict[str, float]) -> float:
    """Of a media type by the most specific range that names it (RFC 9110, 12.5.1); 0 where none does."""
    family = media.partition("/")[0] + "/*"
    return ranges.get(media, ranges.get(family, ranges.get("*/*", 0.0)))


def qualities(header: str) -> dict[str, float]:
    """Weights of the members of Accept or Accept-Encoding, by name (RFC 9110, 12.4.2)."""
    weights: dict[str, float] = {}
    for member in header.lower().split(","):
        name, *others = (part.strip() for part in member.split(";"))
        quality = next((other[2:] for other in others if other.startswith("q=")), "1")
        try:
            weights.setdefault(name, min(max(float(quality), 0.0), 1.0))
        except ValueError:
            weights.setdefault(name, 0.0)
    return weights

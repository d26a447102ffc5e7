"""What /openapi.json says beyond what FastAPI finds by itself: openapi.json beside this, laid over it.

Documents are parsed by the library from the raw body, so FastAPI does not see their schema; and of the worked
examples, which are tested, it would leave out what is null.
"""

from functools import cache, cached_property
from pathlib import Path
from typing import Any

import orjson
from fastapi import FastAPI
from fastapi.utils import deep_dict_update

from attitude.formats.registry import FORMATS

from .errors import PROBLEM

Responses = dict[int | str, dict[str, Any]]

# One entry for every refusal: FastAPI would otherwise promise validation errors of its own shape.
REFUSALS: Responses = {
    "default": {
        "description": "A refusal, with what would be right",
        "content": {PROBLEM: {"schema": {"$ref": "#/components/schemas/Problem"}}},
    }
}


UNCHANGED: Responses = {304: {"description": "The client has this answer: its tag is in If-None-Match"}}


def tagged(model: Any) -> Responses:
    """The responses of a route whose answer has a tag."""
    return {200: {"model": model}, **UNCHANGED}


def file_responses(model: Any) -> Responses:
    """Responses of a route that answers in every format: JSON as any answer, the others as files."""
    media = [each.media for each in FORMATS.values() if each.name != "json"] + ["application/zip"]
    file = {"schema": {"type": "string", "format": "binary"}}
    content: dict[str, Any] = {each: {"schema": {}} if each.endswith("+json") else file for each in media}
    description = "Columns and how to read them, plan and cost; or a file"
    return {200: {"model": model, "description": description, "content": content}}


def json_or_csv(model: Any) -> Responses:
    """Responses of a route that answers as JSON or as CSV."""
    content = {FORMATS["csv"].media: {"schema": {"type": "string"}}}
    return {200: {"model": model, "description": "As JSON, or as CSV", "content": content}}


@cache
def overlay() -> dict[str, Any]:
    parts: dict[str, Any] = orjson.loads(Path(__file__).with_suffix(".json").read_bytes())
    return parts


class DescribedAPI(FastAPI):
    """FastAPI, with the overlay on its description."""

    def openapi(self) -> dict[str, Any]:
        description = super().openapi()
        deep_dict_update(description, overlay())
        return description

    @cached_property
    def described(self) -> bytes:
        return orjson.dumps(self.openapi())

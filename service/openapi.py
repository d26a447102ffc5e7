"""What /openapi.json says beyond what FastAPI finds by itself.

Documents are parsed by the library from the raw body, so FastAPI does not see their schema: it is
put in here, from the library's own models.
"""

from __future__ import annotations

from typing import Any

from fastapi import FastAPI

from attitude.formats.known import KNOWN
from attitude.scene import Scene

from . import errors

SCHEMAS = "#/components/schemas/"
EXAMPLE = "toutatis"

PROBLEM_SCHEMA: dict[str, Any] = {
    "title": "Problem",
    "description": "What was wrong (RFC 9457).",
    "type": "object",
    "required": ["type", "title", "status", "detail"],
    "properties": {
        "type": {"type": "string", "format": "uri"},
        "title": {"type": "string"},
        "status": {"type": "integer"},
        "detail": {"type": "string", "description": "the field, what would be right, and what was found"},
        "pointer": {"type": "string", "description": "JSON pointer to the field in the request's document"},
        "line": {"type": "integer", "description": "line of the document that cannot be read"},
        "id": {"type": "string", "description": "under which the service's log has an unexpected error"},
    },
}

# One entry for every refusal: FastAPI would otherwise promise validation errors of its own shape.
REFUSALS: dict[int | str, dict[str, Any]] = {
    "default": {
        "description": "A refusal, with what would be right",
        "content": {errors.MEDIA_TYPE: {"schema": {"$ref": SCHEMAS + "Problem"}}},
    }
}


def scene_request(example: str = EXAMPLE) -> dict[str, Any]:
    """The request of a route that takes a scene document; a built-in scene as the example."""
    content = {"schema": {"$ref": SCHEMAS + "Scene"}, "example": Scene.builtin(example).document()}
    return {"requestBody": {"required": True, "content": {"application/json": content}}}


def json_answer(description: str) -> dict[int | str, dict[str, Any]]:
    """The responses of a route that answers with a JSON object."""
    content = {"application/json": {"schema": {"type": "object"}}}
    return {200: {"description": description, "content": content}, **REFUSALS}


def ephemeris_answer() -> dict[int | str, dict[str, Any]]:
    """Of the route that answers in every format: JSON as any answer, the others as files."""
    answer = json_answer("Columns, one list each, with convention, frame, epoch, shape and cost; or a file")
    others = (known.media for known in KNOWN if known.name != "json")
    answer[200]["content"].update({media: {"schema": {"type": "string"}} for media in others})
    return answer


class DescribedAPI(FastAPI):
    """FastAPI whose description also holds the library's schemas and the problem's."""

    def openapi(self) -> dict[str, Any]:
        if self.openapi_schema is None:
            description = super().openapi()
            description.setdefault("components", {}).setdefault("schemas", {}).update(_schemas())
        return super().openapi()


def _schemas() -> dict[str, Any]:
    scene = Scene.model_json_schema(ref_template=SCHEMAS + "{model}")
    return {**scene.pop("$defs", {}), "Scene": scene, "Problem": PROBLEM_SCHEMA}

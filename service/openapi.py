"""What /openapi.json says beyond what FastAPI finds by itself.

Documents are parsed by the library from the raw body, so FastAPI does not see their schema: it is
put in here, from the library's own models.  The worked examples are in examples.json, and are tested.
"""

from __future__ import annotations

from functools import cache, cached_property
from pathlib import Path
from typing import Any

import orjson
from fastapi import FastAPI

from attitude.formats.registry import FORMATS
from attitude.scene.document import Scene, builtin_names

from . import errors

SCHEMAS = "#/components/schemas/"
JSON = "application/json"
EXAMPLES = Path(__file__).with_name("examples.json")
PARTS: dict[str, Any] = orjson.loads(Path(__file__).with_name("openapi_parts.json").read_bytes())
PARTS["parameters"]["format"]["schema"]["enum"] = [known.name for known in FORMATS.values()]
PARTS["parameters"]["name"]["schema"]["enum"] = builtin_names()

DESCRIPTION = """\
A scene document in, an answer out; `GET /v1/scenes` lists documents to begin with.

* Every refusal is a problem (RFC 9457), in the library's words, with a JSON pointer to the field. A query
  parameter that is unknown, or there twice, is refused too. The schema of a scene says how it is written;
  what no body or motion can have, only the library knows: that is refused by 422.
* HEAD is answered wherever GET is. `POST /v1/ephemeris` only reads: it answers with an `ETag`, made of the
  document (however its keys are ordered and spaced), the query, the format and the version; sent back in
  `If-None-Match`, it is answered by 304 and nothing is computed. The tags are weak, for what computing took
  is never the same.
* gzip where `Accept-Encoding` asks for it and the format is text.
* JSON says version, plan and cost as members; files say them in the headers `Attitude-Version`,
  `Attitude-Plan` and `Attitude-Cost` (JSON), and name, convention, frame and time scale as their formats do.
* Long answers come in blocks while they are computed. What could be refused has been before the first; should
  anything fail later, the connection ends without the last block.
"""

# One entry for every refusal: FastAPI would otherwise promise validation errors of its own shape.
REFUSALS: dict[int | str, dict[str, Any]] = {
    "default": {
        "description": "A refusal, with what would be right",
        "content": {errors.MEDIA_TYPE: {"schema": {"$ref": SCHEMAS + "Problem"}}},
    }
}
UNCHANGED = {"description": "The client has this answer: its tag is in If-None-Match"}


# -- requests -------------------------------------------------------------------------------------


@cache
def examples() -> dict[str, Any]:
    """By path: {"requests": {name: document}, "answers": {name: document}}; of a GET an answer alone."""
    found: dict[str, Any] = orjson.loads(EXAMPLES.read_bytes())
    return found


def _put_examples(operation: dict[str, Any], path: str) -> None:
    """Here rather than with the routes: FastAPI leaves out what is null, of examples too."""
    worked = examples().get(path, {})
    places = {"requests": operation.get("requestBody", {}), "answers": operation["responses"]["200"]}
    for part, found in worked.items():
        named = {name: {"value": value} for name, value in found.items()}
        places[part]["content"][JSON]["examples"] = named


def parameters(*names: str) -> dict[str, Any]:
    """The parameters of a route, by their names among the components of the description."""
    return {"parameters": [{"$ref": f"#/components/parameters/{name}"} for name in names]}


def scene_request(*names: str) -> dict[str, Any]:
    """The request of a route that takes a scene document, with parameters of these names."""
    return _request({"$ref": SCHEMAS + "Scene"}, names)


def ephemeris_request() -> dict[str, Any]:
    scene = {"$ref": SCHEMAS + "Scene"}
    each = {"anyOf": [scene, {"description": "Anything else has a problem for its answer."}]}
    scenes = {"type": "array", "items": each, "minItems": 1, "title": "Scenes"}
    return _request({"oneOf": [scene, scenes]}, ("drop_below", "format", "frame", "interpolation_error"))


def _request(schema: dict[str, Any], names: tuple[str, ...]) -> dict[str, Any]:
    body = {"requestBody": {"required": True, "content": {JSON: {"schema": schema}}}}
    return {**body, **(parameters(*names) if names else {})}


# -- answers --------------------------------------------------------------------------------------


def json_answer(description: str, schema: str = "", tagged: bool = False) -> dict[int | str, dict[str, Any]]:
    """The responses of a route that answers with a JSON object."""
    held = {"schema": {"$ref": schema} if schema else {"type": "object"}}
    unchanged: dict[int | str, dict[str, Any]] = {304: UNCHANGED} if tagged else {}
    return {200: {"description": description, "content": {JSON: held}}, **unchanged, **REFUSALS}


def ephemeris_answer() -> dict[int | str, dict[str, Any]]:
    """Of the route that answers in every format: JSON as any answer, the others as files."""
    answer = json_answer(
        "Columns, one list each, with how to read them, plan and cost; of a list of scenes, each its answer "
        "or its problem; or a file",
        tagged=True,
    )
    content = answer[200]["content"]
    content[JSON]["schema"] = {"anyOf": [{"$ref": SCHEMAS + "Ephemeris"}, {"$ref": SCHEMAS + "Ephemerides"}]}
    media = [known.media for known in FORMATS.values() if known.name != "json"] + ["application/zip"]
    file = {"schema": {"type": "string", "format": "binary"}}
    content.update({each: {"schema": {}} if each.endswith("+json") else file for each in media})
    answer[200]["headers"] = PARTS["headers"]
    return answer


# -- the whole ------------------------------------------------------------------------------------


class DescribedAPI(FastAPI):
    """FastAPI whose description also holds the library's schemas and the problem's."""

    def __init__(self, **given: Any):
        # both are routes of ours: with tags, packed, and without scripts from other people's servers
        super().__init__(**given | {"openapi_url": None, "docs_url": None, "redoc_url": None})
        self.description = DESCRIPTION

    def openapi(self) -> dict[str, Any]:
        description = super().openapi()
        components = description.setdefault("components", {})
        components.setdefault("schemas", {}).update(_schemas())
        components["parameters"] = PARTS["parameters"]
        for path, operations in description["paths"].items():
            for operation in operations.values():
                _put_examples(operation, path)
        return description

    @cached_property
    def described(self) -> bytes:
        return orjson.dumps(self.openapi())


@cache
def _schemas() -> dict[str, Any]:
    scene = Scene.model_json_schema(ref_template=SCHEMAS + "{model}")
    return {**scene.pop("$defs", {}), "Scene": scene, **PARTS["schemas"]}

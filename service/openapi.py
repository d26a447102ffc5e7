"""What /openapi.json says beyond what FastAPI finds by itself.

Documents are parsed by the library from the raw body, so FastAPI does not see their schema: it is
put in here, from the library's own model.  The worked examples are in examples.json, and are tested.
"""

from __future__ import annotations

from functools import cache, cached_property
from pathlib import Path
from typing import Any

import orjson
from fastapi import FastAPI

from attitude.formats.registry import FORMATS
from attitude.scene.document import Scene

from .dependencies import JSON
from .errors import MEDIA_TYPE
from .schemas import Ephemerides, Ephemeris, Problem

SCHEMAS = "#/components/schemas/"

DESCRIPTION = """\
A scene document in, an answer out; `GET /v1/scenes` lists documents to begin with.

* Every refusal is a problem (RFC 9457), in the library's words, with a JSON pointer to the field. A query
  parameter that is unknown, or there twice, is refused too. The schema of a scene says how it is written;
  what no body or motion can have, only the library knows: that is refused by 422.
* HEAD is answered wherever GET is. `POST /v1/ephemeris` only reads: it answers with an `ETag`, made of the
  document, the query, the format and the version; sent back in `If-None-Match`, it is answered by 304 and
  nothing is computed. The tags are weak, for what computing took is never the same.
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
        "content": {MEDIA_TYPE: {"schema": {"$ref": SCHEMAS + Problem.__name__}}},
    }
}


def tagged(model: Any, **response: Any) -> dict[int | str, dict[str, Any]]:
    """The responses of a route whose answer has a tag."""
    unchanged = {"description": "The client has this answer: its tag is in If-None-Match"}
    return {200: {"model": model, **response}, 304: unchanged}


def file_responses() -> dict[int | str, dict[str, Any]]:
    """Of a route that answers in every format: JSON as any answer, the others as files."""
    media = [each.media for each in FORMATS.values() if each.name != "json"] + ["application/zip"]
    file = {"schema": {"type": "string", "format": "binary"}}
    headers = {
        "ETag": "of the document, the query, the format and the version",
        "Content-Disposition": "the file's name",
        "Attitude-Version": "of the library",
        "Attitude-Plan": "of a file: how it was computed and what it is worth, as JSON",
        "Attitude-Cost": "of a file: what computing took, or is predicted to take, as JSON",
    }
    return tagged(
        Ephemeris | Ephemerides,
        description="Columns, with how to read them, plan and cost; or a file; of a list of scenes, each its "
        "answer or its problem",
        content={each: {"schema": {}} if each.endswith("+json") else file for each in media},
        headers={name: {"description": text, "schema": {"type": "string"}} for name, text in headers.items()},
    )


def scene_body(is_list: bool = False) -> dict[str, Any]:
    """The request of a route that takes a scene document, or also a list of them."""
    scene: dict[str, Any] = {"$ref": SCHEMAS + Scene.__name__}
    each = {"anyOf": [scene, {"description": "Anything else has a problem for its answer."}]}
    scenes = {"type": "array", "items": each, "minItems": 1, "title": "Scenes"}
    schema = {"oneOf": [scene, scenes]} if is_list else scene
    return {"requestBody": {"required": True, "content": {JSON: {"schema": schema}}}}


@cache
def examples() -> dict[str, Any]:
    """By path: {"requests": {name: document}, "answers": {name: document}}; of a GET an answer alone."""
    worked: dict[str, Any] = orjson.loads(Path(__file__).with_name("examples.json").read_bytes())
    return worked


class DescribedAPI(FastAPI):
    """FastAPI whose description holds the worked examples: of these it would leave out what is null."""

    def openapi(self) -> dict[str, Any]:
        description = super().openapi()
        for path, worked in examples().items():
            (operation,) = description["paths"][path].values()
            places = {"requests": operation.get("requestBody"), "answers": operation["responses"]["200"]}
            for part, documents in worked.items():
                named = {name: {"value": document} for name, document in documents.items()}
                places[part]["content"][JSON]["examples"] = named
        return description

    @cached_property
    def described(self) -> bytes:
        return orjson.dumps(self.openapi())

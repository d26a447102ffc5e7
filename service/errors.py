"""What can go wrong, as HTTP answers: one table, and every answer a problem (RFC 9457).

The library's text goes out as it stands, so that library, command and HTTP refuse in the same
words; an unexpected error goes out as fixed text and an id that the log has.
"""

import logging
import secrets
from http import HTTPStatus
from typing import Any, NamedTuple

import orjson
from starlette.requests import Request
from starlette.responses import Response

from attitude.documents.fields import joined_faults
from attitude.errors import AttitudeError, FormatError, InputError, RegimeError, ToleranceError
from attitude.scene.scene import Scene

log = logging.getLogger(__name__)

PROBLEM = "application/problem+json"
UNEXPECTED = "an unexpected error; the service's log has it under this id"


class Kind(NamedTuple):
    """A kind of problem: its status, the end of its type URI, and the title that all its cases share."""

    status: int
    name: str
    title: str


# The one table.  A class is looked up by its own name first, then by its parents'.
TABLE: dict[type[AttitudeError], Kind] = {
    FormatError: Kind(400, "format", "The document cannot be read"),
    InputError: Kind(422, "input", "A value in the document cannot be taken"),
    RegimeError: Kind(422, "regime", "The question has no answer for this motion"),
    ToleranceError: Kind(422, "tolerance", "The answer would not have the accuracy that is promised"),
    AttitudeError: Kind(422, "other", "The library refuses this document"),
}


def problem(
    status: int, detail: str, kind: Kind | None = None, headers: Any = None, **members: Any
) -> Response:
    """An answer that says what was wrong; members that are None are left out.

    Without a kind the type is about:blank: the status says it all.  Text is what UTF-8 can hold: a document
    may name a key with half a surrogate pair, which it cannot.
    """
    name = f"urn:problem-type:attitude:{kind.name}" if kind else "about:blank"
    title = kind.title if kind else HTTPStatus(status).phrase
    document = {"type": name, "title": title, "status": status, "detail": detail, **members}
    sendable = {
        name: value.encode("utf-8", "backslashreplace").decode() if isinstance(value, str) else value
        for name, value in document.items()
        if value is not None
    }
    return Response(orjson.dumps(sendable), status, headers, PROBLEM)


def refusal(request: Request, error: Any) -> Response:
    """The library's refusal, with the table's status; it points at a field of a document alone.

    A parameter of the query is none, unless a field of scenes has its name.
    """
    kind = next(TABLE[parent] for parent in type(error).__mro__ if parent in TABLE)
    if isinstance(error, InputError):
        parameters = {*request.query_params, *query_names(request)} - Scene.model_fields.keys()
        if not getattr(request.state, "has_document", False):
            error.steps = ()
        elif error.field in parameters and error.steps[-1:] == (error.field,):
            error.steps = error.steps[:-1]
    pointer, line = getattr(error, "pointer", None), getattr(error, "line", None)
    return problem(kind.status, str(error), kind, pointer=pointer, line=line)


def query_names(request: Request) -> list[str]:
    """The parameters that the route of a request has."""
    dependant = getattr(request.scope.get("route"), "dependant", None)
    models = [each.field_info.annotation for each in (dependant.query_params if dependant else ())]
    return [name for model in models for name in getattr(model, "model_fields", ())]


def refused_query(request: Request, error: Any) -> Response:
    """Parameters that FastAPI refuses, in the library's words; of each the first fault."""
    faults: dict[Any, Any] = {}
    for each in error.errors():
        faults.setdefault(name := each["loc"][1:2], {**each, "loc": name})
    known = query_names(request)
    refused = joined_faults(list(faults.values()), lambda _: known, "query parameter")
    refused.steps = ()
    return refusal(request, refused)


def http_refusal(request: Request, error: Any) -> Response:
    """What the framework or a handler refuses by its status: no such path, method, content type, size."""
    detail, headers, path = error.detail, error.headers or {}, request.url.path
    if detail == HTTPStatus.METHOD_NOT_ALLOWED.phrase:  # the framework's own text, which repeats the title
        detail = f"{request.method} is not answered at {path}; {headers.get('Allow', 'another method')} is"
    elif detail == HTTPStatus.NOT_FOUND.phrase:
        detail = f"nothing is at {path}; /openapi.json lists what there is"
    return problem(error.status_code, detail, headers=headers)


def unexpected(request: Request) -> Response:
    """Answer an error that nothing else handles, which goes into the log."""
    identity = secrets.token_hex(8)
    log.exception("unexpected error %s at %s %r", identity, request.method, request.scope["path"])
    return problem(HTTPStatus.INTERNAL_SERVER_ERROR, UNEXPECTED, id=identity)

"""What routes depend on: the query's parameters, as models, and the raw document.

FastAPI validates the parameters and describes them; documents are parsed by the library, in a thread, so
that they are refused in its words and never hold the event loop.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from typing import Annotated, Any

from fastapi import Depends, Request
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic.json_schema import SkipJsonSchema
from starlette.exceptions import HTTPException

from attitude.errors import InputError, unknown
from attitude.formats import module_of, option_names
from attitude.formats.encoding import parse_options
from attitude.formats.registry import FORMATS, Format

from . import limits

JSON = "application/json"


def _decimal(text: Any) -> Any:
    """Python would also take "1_0", "nan" and digits of other scripts."""
    if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", text, re.ASCII):
        raise ValueError("a decimal number")
    return text


Decimal = BeforeValidator(_decimal)
Number = Annotated[float, Field(gt=0, allow_inf_nan=False), Decimal]


class NoParameters(BaseModel):
    """Of a route that has none; any other is refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class PlanQuery(NoParameters):
    """Of a plan, and of what is computed by it."""

    drop_below: Number | SkipJsonSchema[None] = Field(
        None, description="rad: leave out torques that matter less over the span"
    )


class CostQuery(NoParameters):
    """What is to be measured, within which budget."""

    budget: Number | SkipJsonSchema[None] = Field(
        None, description="s, wall-clock, for all of it", examples=[2]
    )
    samples: Annotated[int, Field(ge=2), Decimal] | SkipJsonSchema[None] = Field(
        None, description="instants of each horizon", examples=[1000]
    )
    seed: Annotated[int, Field(ge=0), Decimal] = Field(
        0, description="of the instants compared with the truth"
    )
    method: list[str] | SkipJsonSchema[None] = Field(
        None, description="only this family; repeatable", examples=[["ours"]]
    )


class FileQuery(BaseModel):
    """How attitudes are written; parameters beside the named ones are options of the format."""

    model_config = ConfigDict(extra="allow", frozen=True)

    format: str | SkipJsonSchema[None] = Field(
        None,
        description="of the answer, instead of what Accept names; other parameters are options of the format",
        json_schema_extra={"enum": list(FORMATS)},
    )
    frame: str | SkipJsonSchema[None] = Field(
        None, description="attitudes relative to it, instead of the document's"
    )
    interpolation_error: Number | SkipJsonSchema[None] = Field(
        None,
        description="rad: choose the instants so that what readers of the format interpolate stays within it",
        json_schema_extra={"minimum": 1e-13, "maximum": 1},
    )

    def options(self, target: Format) -> dict[str, Any]:
        """Options of a format; InputError for one that it has not."""
        options = self.model_extra or {}
        known = (*type(self).model_fields, *option_names(module_of(target).blocks)) if options else ()
        for name, text in options.items():
            if name not in known:
                raise unknown_parameter(name, text, known)
        return parse_options(options, target)


class EphemerisQuery(FileQuery, PlanQuery):
    """How an ephemeris is computed and written."""

    model_config = ConfigDict(extra="allow", frozen=True)


def unknown_parameter(name: str, text: Any, known: tuple[str, ...]) -> InputError:
    return InputError(name, text, unknown("query parameter", name, known), steps=())


async def once(request: Request) -> None:
    """InputError for a parameter that is there twice, where it is not a list."""
    counts = Counter(name for name, _ in request.query_params.multi_items() if name != "method")
    for name, count in counts.items():
        if count > 1:
            raise InputError(name, "the parameter twice", "each parameter once", steps=())


@contextmanager
def no_field(*names: str) -> Iterator[None]:
    """An error about one of these parameters points at no field of the document."""
    try:
        yield
    except InputError as error:
        if error.field in names:
            error.steps = ()
        raise


async def document(request: Request) -> bytes:
    """The body, if it is JSON and no longer than it may be."""
    media = request.headers.get("content-type", "nothing")
    if media.partition(";")[0].strip().lower() != JSON:
        raise HTTPException(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, f"content-type: {JSON}; got {media[:200]}")
    return await limits.read_body(request, request.app.state.settings)


Document = Annotated[bytes, Depends(document)]

"""What requests ask for in the query, and what answers hold: FastAPI validates and describes these."""

import re
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic.json_schema import SkipJsonSchema

from attitude.errors import InputError, unknown
from attitude.formats import options_of
from attitude.formats.encoding import parse_options
from attitude.formats.registry import FORMATS, READ_ONLY, Format
from attitude.formats.tables.json import EphemerisAnswer
from attitude.frames.rotations import check_any_frame
from attitude.pointing.columns import KINDS, parse

Text = str | SkipJsonSchema[None]
FormatName = Annotated[Text, Field(json_schema_extra={"enum": list(FORMATS)})]


def decimal(text: str) -> str:
    """Python would also take "1_0", "nan" and digits of other scripts."""
    if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", text, re.ASCII):
        raise ValueError("a decimal number")
    return text


Decimal = BeforeValidator(decimal)
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False), Decimal] | SkipJsonSchema[None]
Angle = Annotated[float, Field(gt=0, le=1, allow_inf_nan=False), Decimal] | SkipJsonSchema[None]  # rad
Samples = Annotated[int, Field(ge=2, le=100_000), Decimal] | SkipJsonSchema[None]  # of some 500 bytes each


class NoQuery(BaseModel):
    """The query of a route without parameters; any is refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class PlanQuery(NoQuery):
    """The query of a plan, and of what is computed by it."""

    drop_below: Positive = Field(None, description="rad: leave out torques that matter less over the span")


class WindowsQuery(PlanQuery):
    """How windows are searched and written."""

    format: Literal["json", "csv"] = Field("json", description="of the answer")
    width: Positive = Field(None, description="s: what may be missed is narrower", examples=[0.001])


class CostQuery(NoQuery):
    """What is to be measured, within which budget."""

    budget: Positive = Field(None, description="s, wall-clock, for all of it", examples=[2])
    samples: Samples = Field(None, description="instants", examples=[1000])
    seed: Annotated[int, Field(ge=0), Decimal] = Field(
        0, description="of the instants compared with the truth"
    )
    method: list[str] = Field([], description="only this family; repeatable", examples=[["ours"]])


class FileQuery(BaseModel):
    """How attitudes are written; parameters beside the named ones are options of the formats."""

    model_config = ConfigDict(extra="allow", frozen=True)

    format: FormatName = Field(None, description="of the answer, instead of what Accept names")
    frame: Text = Field(None, description="attitudes relative to it")
    columns: Text = Field(
        None,
        description=f"what a table holds, by commas: {'; '.join(map(' '.join, KINDS.items()))}",
        examples=["time,euler:ZYX,angle:z:sun"],
    )
    ut1: Literal["tables", "utc"] | SkipJsonSchema[None] = Field(
        None, description="utc takes UTC for UT1 in ITRF, beyond astropy's tables"
    )
    interpolation_error: Angle = Field(
        None, description="rad: instants such that readers of the format interpolate within it"
    )

    @model_validator(mode="after")
    def check(self) -> "FileQuery":
        if self.frame is not None:
            check_any_frame(self.frame)
        self.requested_columns()
        return self

    def requested_columns(self) -> tuple[str, ...]:
        return () if self.columns is None else parse(self.columns)

    def options(self, target: Format, source: Format | None = None) -> tuple[dict[str, Any], dict[str, Any]]:
        """Options of the format that is written, and of the one that is read; InputError for any other."""
        options = self.model_extra or {}
        of_writer = options_of(target)
        of_reader = options_of(source, reading=True) if source else {}
        known = sorted({*of_writer, *of_reader} - {"sclk", "fk"})  # which are paths
        for name, text in options.items():
            if name not in known:
                expected = unknown("query parameter", name, (*type(self).model_fields, *known))
                raise InputError(name, text, expected)
        writing = {name: text for name, text in options.items() if name in of_writer}
        reading = {name: text for name, text in options.items() if name not in of_writer}
        if self.ut1 is not None and "ut1" in of_reader:
            reading["ut1"] = self.ut1
        return parse_options(writing, target), parse_options(reading, source or target, reading=True)


class EphemerisQuery(FileQuery, PlanQuery):
    """How an ephemeris is computed and written."""

    model_config = ConfigDict(extra="allow", frozen=True)


SourceName = Annotated[Text, Field(json_schema_extra={"enum": [*FORMATS, *READ_ONLY]})]
Source = Annotated[SourceName, Field(description="format of the file, instead of what its name or type says")]


class ConvertQuery(FileQuery):
    """What format a file is in, and how its attitudes are written."""

    source: Source = None
    times: Text = Field(None, description="at these instants: dates, or seconds since the epoch, by commas")
    step: Text = Field(None, description="from the first instant to the last in such steps, as in 10 s")
    by: Literal["dynamics"] | SkipJsonSchema[None] = Field(
        None, description="in gaps, free rotation fitted to both sides, beside times or step"
    )
    inertia: Text = Field(
        None,
        description="of the body, for by: three moments, whose ratios matter, or a document with a body; "
        "by default the file's",
        examples=["10,13,17"],
    )


class SourceQuery(NoQuery):
    """What format a file is in."""

    source: Source = None


class CompareQuery(NoQuery):
    """The frame in which files are compared; their names say what formats they are in."""

    frame: Text = Field(None, description="instead of that of the first file")


class Problem(BaseModel):
    """What was wrong (RFC 9457)."""

    type: str = Field(json_schema_extra={"format": "uri-reference"})
    title: str
    status: int
    detail: str = Field(description="the field, what would be right, and what was found")
    pointer: str | None = Field(None, description="JSON pointer to the field in the request's document")
    line: int | None = Field(None, description="line of the document that cannot be read")
    id: str | None = Field(None, description="under which the service's log has an unexpected error")


class Ephemerides(BaseModel):
    """Answers to a list of scenes: an answer or a problem for each, in its order."""

    answers: list[EphemerisAnswer | Problem]

"""What answers hold, for the description: problems, ephemerides in JSON, and lists of them."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, Field


class Problem(BaseModel):
    """What was wrong (RFC 9457)."""

    type: str = Field(json_schema_extra={"format": "uri-reference"})
    title: str
    status: int
    detail: str = Field(description="the field, what would be right, and what was found")
    pointer: str | None = Field(None, description="JSON pointer to the field in the request's document")
    line: int | None = Field(None, description="line of the document that cannot be read")
    id: str | None = Field(None, description="under which the service's log has an unexpected error")


class PlanSummary(BaseModel):
    """How an ephemeris was computed, and what it is worth."""

    solver: str
    samples: int
    simulated: list[str]
    left_out: list[str]
    error_bound_rad: float
    error_bound_source: str


class ComputingTime(BaseModel):
    """Wall-clock seconds of the computation."""

    set_up_s: float
    sample_s: float


class Ephemeris(BaseModel):
    """Columns, one list each, units in their names, and how to read them."""

    kind: Literal["attitude-ephemeris/1"]
    name: str
    convention: str
    quaternion_order: Literal["wxyz"]
    frame: str
    epoch: dict[str, Any] | None
    time_scale: str | None
    body: dict[str, Any] | None
    shape: list[int]
    events: list[dict[str, Any]] = Field(default_factory=list)
    version: str
    plan: PlanSummary | None
    columns: dict[str, list[float | str]]
    cost: ComputingTime | None


class Ephemerides(BaseModel):
    """Of a list of scenes: an answer or a problem for each, in its order."""

    answers: list[Ephemeris | Problem]


class Status(BaseModel):
    """Of the process."""

    status: Literal["alive", "ready"]


class SceneEntry(BaseModel):
    """A scene that comes with the service."""

    name: str
    title: str
    description: str
    href: str


class Catalogue(BaseModel):
    """The scenes that come with the service."""

    scenes: list[SceneEntry]

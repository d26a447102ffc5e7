"""Columnar JSON: metadata, then a list for each column; the service sends the same bytes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any, BinaryIO, Literal, NotRequired

import numpy as np
import orjson
from pydantic import Field
from typing_extensions import TypedDict

from ...errors import FormatError
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from ...samples.provenance import Plan
from ...version import __version__
from .. import bounded_read, schema

ROWS_PER_DUMP = 1 << 12  # orjson holds the interpreter's lock: other threads wait for the end of a dump


class ComputationAnswer(TypedDict):
    """How an ephemeris was computed, and its error bound; null where none is known."""

    solver: str
    samples: int
    simulated: tuple[str, ...]
    left_out: tuple[str, ...]
    error_bound_rad: float | None
    error_bound_source: str
    tolerance_span_s: NotRequired[tuple[float, float]]
    notes: NotRequired[tuple[str, ...]]
    orbit: NotRequired[str]


class EphemerisAnswer(TypedDict):
    """What `blocks_with_plan` says: columns, one list each, units in their names, and how to read them."""

    kind: Literal["attitude-ephemeris/1"]
    name: str
    convention: str
    quaternion_order: Literal["wxyz"]
    frame: str
    epoch: dict[str, Any] | None
    time_scale: str | None
    body: dict[str, Any] | None
    shape: list[int]
    events: NotRequired[list[dict[str, Any]]]
    chosen_columns: NotRequired[Annotated[list[str], Field(description="those that were requested")]]
    version: str
    plan: ComputationAnswer | None
    columns: dict[str, list[float | str]]
    cost: Annotated[dict[str, float] | None, Field(description="wall-clock seconds of the computation")]


def dumps(ephemeris: EphemerisData) -> bytes:
    """The whole ephemeris as JSON text; floats in their shortest form that reads back to the same bits."""
    samples = Samples.of(ephemeris)
    return _whole(ephemeris, schema.names(samples), schema.metadata(samples)) + b"}"


def blocks_with_plan(samples: Samples) -> Iterator[bytes]:
    """The blocks with the library's version, the plan of the ephemeris, and the cost of computing it.

    For responses: the bytes of a file should not depend on these.
    """
    plan, sample_seconds = samples.first.plan, 0.0

    def timed(chunk: EphemerisData) -> EphemerisData:
        nonlocal sample_seconds
        sample_seconds += chunk.plan.sample_seconds if chunk.plan else 0.0
        return chunk

    meta = schema.metadata(samples) | {"version": __version__, "plan": plan_of(plan, samples)}
    yield from _members(samples if samples.in_memory else samples.transformed(timed), meta)
    cost = cost_of(plan, None if samples.in_memory else sample_seconds)
    yield b',"cost":' + _dump(cost) + b"}\n"


def plan_of(plan: Plan | None, samples: Samples) -> dict[str, Any] | None:
    """How the ephemeris was computed, and its error bound, as plain data; None of one read from a file."""
    if plan is None:
        return None
    optional = {
        "tolerance_span_s": plan.tolerance_span,
        "notes": plan.notes or None,
        "orbit": plan.orbit or None,
    }
    return {
        "solver": plan.solver,
        "samples": math.prod(samples.shape),
        "simulated": plan.simulated,
        "left_out": plan.left_out,
        "error_bound_rad": plan.error_bound,
        "error_bound_source": plan.bound_source,
        **{name: value for name, value in optional.items() if value is not None},
    }


def cost_of(plan: Plan | None, sample_seconds: float | None = None) -> dict[str, float] | None:
    """Wall-clock seconds of the computation; `sample_seconds`: the sum over chunks, if several."""
    if plan is None:
        return None
    return {
        "set_up_s": plan.set_up_seconds,
        "sample_s": plan.sample_seconds if sample_seconds is None else sample_seconds,
    }


def blocks(samples: Samples) -> Iterator[bytes]:
    """Column after column; those of a list of instants in chunks, so that no column is held in memory."""
    yield from _members(samples, schema.metadata(samples))
    yield b"}\n"


def _whole(ephemeris: EphemerisData, names: list[str], meta: dict[str, Any]) -> bytes:
    """The object without its closing brace, at once."""
    table = {name: _plain(values) for name, values in schema.columns(ephemeris, names).items()}
    return _dump({**meta, "columns": table})[:-1]


def _members(samples: Samples, meta: dict[str, Any]) -> Iterator[bytes]:
    """The object without its closing brace: metadata, then the columns."""
    names = schema.names(samples)
    if (samples.is_one_chunk and samples.count <= ROWS_PER_DUMP) or not samples.is_list:
        yield _whole(samples.ephemeris(), names, meta)
        samples.progress(1.0)
        return
    table = schema.columns(samples.ephemeris(), names) if samples.is_one_chunk else {}
    yield _dump(meta)[:-1] + b',"columns":{'
    for i, name in enumerate(names):
        yield (b"," if i else b"") + _dump(name) + b":["
        if table:
            yield from _column(table[name])
        else:
            for k, chunk in enumerate(samples.chunks(i, len(names))):
                if k:
                    yield b","
                yield from _column(schema.columns(chunk, (name,))[name])
        yield b"]"
    if table:
        samples.progress(1.0)
    yield b"}"


def _column(values: Any) -> Iterator[bytes]:
    """The text of a column without its brackets."""
    plain = _plain(values)
    for first in range(0, len(plain), ROWS_PER_DUMP):
        yield (b"," if first else b"") + _dump(plain[first : first + ROWS_PER_DUMP])[1:-1]


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """The ephemeris in a stream of this format; FormatError, with its place, for anything else."""
    document = bounded_read.json(stream, source)
    if not isinstance(document, dict) or not isinstance(document.get("columns"), dict):
        is_scene = isinstance(document, dict) and "times" in document
        cure = ": a scene's document, of which `attitude run` makes one" if is_scene else ""
        raise FormatError(f"not an ephemeris: no columns{cure}", source)
    table = {name: values for name, values in document["columns"].items() if name != schema.TIME}
    return schema.ephemeris_from(document, table, source)


def _plain(value: Any) -> Any:
    """A value that orjson serializes: contiguous arrays, lists of text, plain scalars."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "S":
        return value.astype("U").tolist()
    if isinstance(value, np.ndarray) and value.ndim:
        return np.ascontiguousarray(value)
    return float(value) if isinstance(value, (np.floating, np.ndarray)) else value


def _dump(document: Any) -> bytes:
    return orjson.dumps(document, option=orjson.OPT_SERIALIZE_NUMPY)

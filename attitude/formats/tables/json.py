"""The columnar JSON answer: metadata, then one list a column; the service sends these very bytes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import orjson

from ...errors import FormatError
from ...samples.chunks import Samples
from ...version import __version__
from .. import bounded_read, schema

if TYPE_CHECKING:
    from ...samples.ephemeris_data import EphemerisData
    from ...samples.provenance import Plan

# Written at once: meanwhile no other thread goes on, be it one that has only to say that it is alive.
ROWS = 1 << 12
MOST_BYTES = 1 << 30  # the whole text is read at once


def dumps(ephemeris: EphemerisData) -> bytes:
    """The whole ephemeris as JSON text; floats in their shortest form that reads back to the same bits."""
    samples = Samples.of(ephemeris)
    table = {
        name: _plain(values) for name, values in schema.columns(ephemeris, schema.names(samples)).items()
    }
    return _dump({**schema.metadata(samples), "columns": table})


def answer(samples: Samples) -> Iterator[bytes]:
    """What `blocks` gives, with the library's version, how it was computed, and what that took.

    (A file's bytes should not depend on these.)
    """
    plan, spent = samples.head.plan, [0.0]

    def cut(first: int, last: int) -> EphemerisData:
        piece = samples.cut(first, last)
        spent[0] += piece.plan.sample_seconds if piece.plan else 0.0
        return piece

    counted = samples if samples.is_held else Samples(samples.count, cut, samples.progress, samples.instants)
    said = {"version": __version__, "plan": plan_of(plan, samples)}
    yield from _members(counted, {**schema.metadata(samples), **said})
    cost = cost_of(plan, None if samples.is_held else spent[0])
    yield b',"cost":' + _dump(cost) + b"}\n"


def plan_of(plan: Plan | None, samples: Samples) -> dict[str, Any] | None:
    """How the ephemeris was computed and what it is worth, as plain data; None of one from a file."""
    if plan is None:
        return None
    return {
        "solver": plan.solver,
        "samples": math.prod(samples.shape),
        "simulated": plan.simulated,
        "left_out": plan.left_out,
        "error_bound_rad": plan.error_bound,
        "error_bound_source": plan.bound_source,
    }


def cost_of(plan: Plan | None, sample_seconds: float | None = None) -> dict[str, float] | None:
    """What computing took; of samples in pieces, all pieces together."""
    if plan is None:
        return None
    return {
        "set_up_s": plan.set_up_seconds,
        "sample_s": plan.sample_seconds if sample_seconds is None else sample_seconds,
    }


def blocks(samples: Samples) -> Iterator[bytes]:
    """Column after column; of a list of instants each in pieces, so that no column need be held."""
    yield from _members(samples, schema.metadata(samples))
    yield b"}\n"


def _members(samples: Samples, said: dict[str, Any]) -> Iterator[bytes]:
    """The object but for its end, with what is said before the columns."""
    names = schema.names(samples)
    if (samples.is_short and samples.count <= ROWS) or not samples.is_list:
        table = {name: _plain(values) for name, values in schema.columns(samples.whole(), names).items()}
        yield _dump({**said, "columns": table})[:-1]
        samples.progress(1.0)
        return
    held = schema.columns(samples.whole(), names) if samples.is_short else {}
    yield _dump(said)[:-1] + b',"columns":{'
    for i, name in enumerate(names):
        yield (b"," if i else b"") + _dump(name) + b":["
        yield from _column(held[name]) if held else _pieces(samples, name, i, len(names))
        yield b"]"
    if held:
        samples.progress(1.0)
    yield b"}"


def _pieces(samples: Samples, name: str, part: int, of: int) -> Iterator[bytes]:
    for k, piece in enumerate(samples.pieces(part, of)):
        if k:
            yield b","
        yield from _column(schema.columns(piece, (name,))[name])


def _column(values: Any) -> Iterator[bytes]:
    """The text of a column but for its brackets."""
    plain = _plain(values)
    for first in range(0, len(plain), ROWS):
        yield (b"," if first else b"") + _dump(plain[first : first + ROWS])[1:-1]


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    text = bounded_read.text(stream, source, MOST_BYTES)
    try:
        answer = orjson.loads(text)
    except orjson.JSONDecodeError as error:
        raise FormatError(f"not JSON: {error.msg}", source, error.lineno) from None
    if not isinstance(answer, dict) or not isinstance(answer.get("columns"), dict):
        raise FormatError("not an ephemeris: no columns", source)
    table = {name: values for name, values in answer["columns"].items() if name != schema.TIME}
    return schema.ephemeris_from(answer, table, source)


def _plain(value: Any) -> Any:
    """What orjson writes directly: contiguous arrays, lists of text, plain scalars."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "S":
        return value.astype("U").tolist()
    if isinstance(value, np.ndarray) and value.ndim:
        return np.ascontiguousarray(value)
    return float(value) if isinstance(value, (np.floating, np.ndarray)) else value


def _dump(document: Any) -> bytes:
    return orjson.dumps(document, option=orjson.OPT_SERIALIZE_NUMPY)

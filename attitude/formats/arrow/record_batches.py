"""What Arrow's file and its stream have in common: the columns of an ephemeris, a record batch a piece.

Arrays are stored by component, so that a batch is made of them as they stand, without a copy.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import orjson
import pyarrow as pa

from ...errors import FormatError
from ...samples.chunks import Samples
from .. import columnar, schema
from ..binary import Sink, one_line, refuse_trailing
from ..text_rows import array

if TYPE_CHECKING:
    from ...samples.ephemeris_data import EphemerisData

METADATA = b"attitude"  # the key, in the schema's metadata, of ours as JSON
NUMBERS = (schema.ELAPSED, schema.REST, *schema.QUATERNION, *schema.RATE, *schema.MOMENTUM)
KNOWN = (columnar.TIME_TAI, *NUMBERS, *schema.POSITION, *schema.VELOCITY)


def blocks(samples: Samples, begin: Callable[[Sink, Any], Any]) -> Iterator[bytes]:
    """`begin` is pyarrow's: the writer, of the sink and the schema."""
    if not samples.is_list:
        raise FormatError(
            f"Arrow holds one body at a list of instants, not shape {samples.shape}; ecsv, json and npz do"
        )
    sink, names = Sink(), columnar.names(samples)
    schema = _schema(samples, names)
    with begin(sink, schema) as writer:
        for piece in samples.chunks():
            writer.write_batch(_batch(columnar.columns(piece, names), schema))
            yield from sink.take()
    yield from sink.take()


def _schema(samples: Samples, names: list[str]) -> Any:
    meta = schema.metadata(samples)
    types = {columnar.TIME_TAI: pa.timestamp("ns")}
    fields = [pa.field(name, types.get(name, pa.float64()), nullable=False) for name in names]
    said = {METADATA: orjson.dumps(meta), b"convention": meta["convention"].encode()}
    if samples.first.epoch is not None:
        dated = columnar.TIME_TAI in names
        said[columnar.TIME_TAI.encode()] = (columnar.MEANING if dated else columnar.LEFT_OUT).encode()
    return pa.schema(fields, metadata=said)


def _batch(table: dict[str, np.ndarray], schema: Any) -> Any:
    arrays = [array(table[name], kind) for name, kind in zip(schema.names, schema.types, strict=True)]
    return pa.record_batch(arrays, schema=schema)


def parse(begin: Callable[[BinaryIO], Any], stream: BinaryIO, source: str) -> EphemerisData:
    """`begin` is pyarrow's: the reader, of the stream."""
    try:
        reader = begin(stream)
        _check(reader.schema, source)
        table = _table(reader, source)
        table.validate(full=True)
        if not has_footer(reader):
            refuse_trailing(stream, source)
    except FormatError:
        raise
    except Exception as error:  # pyarrow's own kinds, and Python's of what the stream does
        raise FormatError(f"not Arrow: {one_line(error)}", source) from None
    if any(column.null_count for column in table.columns):
        raise FormatError("a column with missing values", source)
    names = [name for name in table.column_names if name != columnar.TIME_TAI]
    numbers = {name: table.column(name).to_numpy() for name in names}
    return schema.ephemeris_from(_metadata(table.schema, source), numbers, source)


def has_footer(reader: Any) -> bool:
    """Whether it is of a file, at whose end it says where all of it is."""
    return hasattr(reader, "num_record_batches")


def _table(reader: Any, source: str) -> Any:
    """A stream may go on without an end: no more of it is taken than its metadata state."""
    if has_footer(reader):
        return reader.read_all()
    stated = schema.stated_count(_metadata(reader.schema, source), source)
    batches, found = [], 0
    for batch in reader:
        batches.append(batch)
        found += max(1, batch.num_rows)
        schema.refuse_more(found, stated, source)
    return pa.Table.from_batches(batches, reader.schema)


def _check(schema: Any, source: str) -> None:
    """Before anything is read: the columns are ours, each once, each of its type."""
    for name, kind in zip(schema.names, schema.types, strict=True):
        if name not in KNOWN or schema.names.count(name) > 1:
            raise FormatError(f"column {name!r:.40}, unknown or there twice", source)
        wanted = pa.timestamp("ns") if name == columnar.TIME_TAI else pa.float64()
        if kind != wanted:
            raise FormatError(f"column {name!r} of {kind}, not {wanted}", source)
    _metadata(schema, source)


def _metadata(schema: Any, source: str) -> Any:
    text = (schema.metadata or {}).get(METADATA)
    if text is None:
        raise FormatError("not an ephemeris of this library: no metadata under 'attitude'", source)
    try:
        return orjson.loads(text)
    except orjson.JSONDecodeError:
        raise FormatError("metadata that are not JSON", source) from None

"""The columns of an ephemeris as Arrow record batches, one per chunk; shared by the file and the stream.

Arrays are stored by component, so that a batch holds them without a copy.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, BinaryIO

import orjson
import pyarrow as pa

from ...errors import FormatError, library_errors
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from .. import columnar, schema
from ..binary import Sink, refuse_trailing
from ..text_rows import array

METADATA = b"attitude"  # the key of our metadata, as JSON, in the Arrow schema's


def blocks(samples: Samples, new_writer: Callable[[Sink, Any], Any]) -> Iterator[bytes]:
    """The file; `new_writer` is `pyarrow.ipc.new_file` or `new_stream`."""
    schema.refuse_unless_list(samples, "Arrow")
    sink, names, meta = Sink(), columnar.names(samples), schema.metadata(samples)
    metadata = {METADATA: orjson.dumps(meta), b"convention": meta["convention"].encode()}
    if samples.first.epoch is not None:
        text = columnar.MEANING if columnar.TIME_TAI in names else columnar.LEFT_OUT
        metadata[columnar.TIME_TAI.encode()] = text.encode()
    types = {name: pa.from_numpy_dtype(columnar.dtype(name)) for name in names}
    fields = [pa.field(name, kind, nullable=False) for name, kind in types.items()]
    arrow_schema = pa.schema(fields, metadata=metadata)
    with new_writer(sink, arrow_schema) as writer:
        for chunk in samples.chunks():
            table = columnar.columns(chunk, names)
            arrays = [array(table[name], types[name]) for name in names]
            writer.write_batch(pa.record_batch(arrays, schema=arrow_schema))
            yield from sink.take()
    yield from sink.take()


def parse(open_reader: Callable[[BinaryIO], Any], stream: BinaryIO, source: str) -> EphemerisData:
    """The ephemeris; `open_reader` is `pyarrow.ipc.open_file` or `open_stream`."""
    with library_errors("not Arrow", source):
        reader = open_reader(stream)
        columnar.check_names(reader.schema.names, source)  # before any data is read
        for name, kind in zip(reader.schema.names, reader.schema.types, strict=True):
            expected = pa.from_numpy_dtype(columnar.dtype(name))
            if kind != expected:
                raise FormatError(f"column {name!r} of {kind}, not {expected}", source)
        text = (reader.schema.metadata or {}).get(METADATA)
        if text is None:
            raise FormatError("not an ephemeris of this library: no metadata under 'attitude'", source)
        try:
            meta = orjson.loads(text)
        except orjson.JSONDecodeError:
            raise FormatError("metadata that are not JSON", source) from None
        table = _table(reader, meta, source)
        table.validate(full=True)
        if not has_footer(reader):
            refuse_trailing(stream, source)
    if any(column.null_count for column in table.columns):
        raise FormatError("a column with missing values", source)
    names = [name for name in table.column_names if name != columnar.TIME_TAI]
    numbers = {name: table.column(name).to_numpy() for name in names}
    return schema.ephemeris_from(meta, numbers, source)


def has_footer(reader: Any) -> bool:
    """Whether this is the reader of a file, which has a footer with the offsets of its batches."""
    return hasattr(reader, "num_record_batches")


def _table(reader: Any, meta: Any, source: str) -> Any:
    """All batches; of a stream, which may be endless, no more instants than its metadata state."""
    if has_footer(reader):
        return reader.read_all()
    stated = schema.stated_count(meta, source)
    batches, count = [], 0
    for batch in reader:
        batches.append(batch)
        count += max(1, batch.num_rows)
        schema.refuse_more(count, stated, source)
    return pa.Table.from_batches(batches, reader.schema)

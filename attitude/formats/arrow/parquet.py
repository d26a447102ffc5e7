"""Parquet as astropy writes its tables: `QTable.read` returns the table of `Ephemeris.to_table`.

The schema, with astropy's own metadata, is that of the first row's table; each chunk is a row group.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from astropy.table import QTable, Table, serialize
from astropy.table import meta as table_meta
from astropy.utils.data_info import serialize_context_as

from ...errors import FormatError, library_errors
from ...pointing import vector_columns
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from .. import schema
from ..binary import Sink, refuse_inflated, seekable
from ..tables.qtable import CELLS, refuse_unfolding, to_table

ASTROPY_METADATA = "table_meta_yaml"  # the key of astropy's metadata in the Arrow schema's
SCALARS = {"elapsed": schema.ELAPSED, "elapsed_rest": schema.REST}
DATES = ("time.jd1", "time.jd2")  # not read: the seconds are exact


def blocks(samples: Samples) -> Iterator[bytes]:
    """The file of these samples, block by block, in the memory of one chunk."""
    schema.refuse_unless_list(samples, "Parquet")  # astropy would flatten the dimensions of a cell
    sink = Sink()
    first = _without_mixins(to_table(samples.first, samples.shape))
    fields = [(name, _type(first[name].shape[1:])) for name in first.colnames]
    arrow_schema = pa.schema(
        fields, metadata={ASTROPY_METADATA: "\n".join(table_meta.get_yaml_from_table(first))}
    )
    # the numbers hardly repeat: a dictionary or compression takes time and gains nothing
    with pq.ParquetWriter(
        sink, arrow_schema, version="2.4", use_dictionary=False, compression="none"
    ) as writer:
        for batch in rows(samples):
            writer.write_batch(batch)
            yield from sink.take()
    yield from sink.take()


def rows(samples: Samples) -> Iterator[pa.RecordBatch]:
    """The file without its header: the row groups."""
    for chunk in samples.chunks():
        table, arrays = _without_mixins(to_table(chunk)), []
        for name in table.colnames:
            column = np.asarray(table[name])
            numbers = pa.array(np.ascontiguousarray(column).reshape(-1))
            is_vector = column.ndim > 1
            arrays.append(
                pa.FixedSizeListArray.from_arrays(numbers, column.shape[1]) if is_vector else numbers
            )
        yield pa.record_batch(arrays, table.colnames)


def _without_mixins(table: QTable) -> Table:
    """The table as columns of numbers: a Time becomes two, a Quantity's unit goes to the metadata."""
    with serialize_context_as("parquet"):
        return serialize.represent_mixins_as_columns(table)


def _type(shape: tuple[int, ...]) -> Any:
    return pa.list_(pa.float64(), shape[0]) if shape else pa.float64()


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """The ephemeris in a stream of this format; FormatError, with its place, for anything else."""
    stream = seekable(stream, source)
    with library_errors("not Parquet as astropy writes it", source):
        file = pq.ParquetFile(stream)
        meta = _check(file.schema_arrow, source)
        groups = [file.metadata.row_group(i).num_rows for i in range(file.metadata.num_row_groups)]
        stated_rows = max(sum(groups), file.metadata.num_rows)
        refuse_inflated(8 * stated_rows * file.metadata.num_columns, stream, source)
        table = file.read()
        table.validate(full=True)
    columns = {}
    for name, column in SCALARS.items():
        if name in table.column_names:
            columns[column] = _numbers(table, name, source)
    for name, (names, _) in vector_columns.VECTORS.items():
        if name in table.column_names:
            matrix = _numbers(table, name, source).reshape(-1, len(names))
            columns.update(zip(names, matrix.T, strict=True))
    return schema.ephemeris_from(meta, columns, source)


def _check(arrow_schema: Any, source: str) -> dict[str, Any]:
    """The metadata; refuses, before any data is read, unknown columns and other types and units."""
    text = (arrow_schema.metadata or {}).get(ASTROPY_METADATA.encode())
    if text is None:
        raise FormatError("not a table of astropy: no metadata 'table_meta_yaml'", source)
    refuse_unfolding(text.decode())
    header = table_meta.get_header_from_yaml(text.decode().split("\n"))
    units = {column["name"]: column.get("unit") for column in header["datatype"]}
    cells = CELLS | dict.fromkeys(DATES, ((), None))
    for name, kind in zip(arrow_schema.names, arrow_schema.types, strict=True):
        if name not in cells or name == "time" or arrow_schema.names.count(name) > 1:
            raise FormatError(f"column {name!r:.40}, unknown or repeated", source)
        (shape, expected), unit = cells[name], units.get(name)
        if not kind.equals(_type(shape)):
            raise FormatError(f"column {name!r} of {kind}, not {_type(shape)}", source)
        if name not in DATES and str(unit) != str(expected):
            raise FormatError(f"column {name!r} in {unit}, not in {expected}", source)
    return dict(header["meta"])


def _numbers(table: Any, name: str, source: str) -> np.ndarray:
    column = table.column(name)
    numbers = column.combine_chunks()
    flat = numbers if name in SCALARS else numbers.flatten()
    if column.null_count or flat.null_count:
        raise FormatError(f"column {name!r} with missing values", source)
    return flat.to_numpy()

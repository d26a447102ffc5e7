"""Parquet as astropy writes its tables: `QTable.read` gives what `Ephemeris.to_table` does.

The schema, with astropy's own metadata in it, is of the first row; a row group is a piece.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from astropy.table import QTable, Table

from ...errors import FormatError
from ...samples.chunks import Samples
from .. import schema
from ..binary import Sink, one_line, refuse_inflated, seekable
from ..tables.qtable import VECTORS, refuse_unfolding, to_table

if TYPE_CHECKING:
    from ...samples.ephemeris_data import EphemerisData

ASTROPYS = "table_meta_yaml"  # the key, in the schema's metadata, of what astropy says of a table
SCALARS = {"elapsed": schema.ELAPSED, "elapsed_rest": schema.REST}
DATES = ("time.jd1", "time.jd2")  # not read: the seconds are exact
UNITS = {"elapsed": "s", "elapsed_rest": "s", **{name: unit and str(unit) for name, _, unit in VECTORS}}


def blocks(samples: Samples) -> Iterator[bytes]:
    if not samples.is_list:
        # astropy's tables come back from Parquet with the dimensions of a cell run together
        raise FormatError(
            f"Parquet holds one body at a list of instants, not shape {samples.shape}; ecsv, json and npz do"
        )
    sink = Sink()
    schema = _schema(_plain(to_table(samples.first, samples.shape, samples.has_seconds_low)))
    # numbers that hardly repeat: a dictionary of them, or packing, takes time and gains nothing
    with pq.ParquetWriter(sink, schema, version="2.4", use_dictionary=False, compression="none") as writer:
        for piece in samples.chunks():
            writer.write_batch(
                _batch(_plain(to_table(piece, has_seconds_low=samples.has_seconds_low)), schema)
            )
            yield from sink.take()
    yield from sink.take()


def _plain(table: QTable) -> Table:
    """Columns of numbers: a Time is two of them, a Quantity's unit is said in the metadata."""
    from astropy.table import serialize
    from astropy.utils.data_info import serialize_context_as

    with serialize_context_as("parquet"):
        return serialize.represent_mixins_as_columns(table)


def _schema(table: Table) -> Any:
    from astropy.table import meta

    said = {ASTROPYS: "\n".join(meta.get_yaml_from_table(table))}
    return pa.schema([(name, _type(table[name].shape[1:])) for name in table.colnames], metadata=said)


def _type(shape: tuple[int, ...]) -> Any:
    return pa.list_(pa.float64(), shape[0]) if shape else pa.float64()


def _batch(table: Table, schema: Any) -> Any:
    return pa.record_batch([_array(np.asarray(table[name])) for name in table.colnames], schema=schema)


def _array(column: np.ndarray) -> Any:
    numbers = pa.array(np.ascontiguousarray(column).reshape(-1))
    return numbers if column.ndim == 1 else pa.FixedSizeListArray.from_arrays(numbers, column.shape[1])


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    stream = seekable(stream, source)
    try:
        file = pq.ParquetFile(stream)
        meta = _check(file.schema_arrow, source)
        refuse_inflated(_told(file.metadata), stream, source)
        table = file.read()
        table.validate(full=True)
    except FormatError:
        raise
    except Exception as error:  # pyarrow's own kinds, those of astropy's YAML, and Python's of the stream
        raise FormatError(f"not Parquet as astropy writes it: {one_line(error)}", source) from None
    return schema.ephemeris_from(meta, _columns(table, source), source)


def _told(metadata: Any) -> int:
    """Bytes of what is to be read, unpacked; in each group of rows of which it is told."""
    rows = sum(metadata.row_group(i).num_rows for i in range(metadata.num_row_groups))
    return max(rows, metadata.num_rows) * metadata.num_columns * np.dtype(float).itemsize


def _check(schema: Any, source: str) -> dict[str, Any]:
    """The metadata; refuses columns that are not ours, of our types and units, before they are read."""
    from astropy.table import meta

    text = (schema.metadata or {}).get(ASTROPYS.encode())
    if text is None:
        raise FormatError("not a table of astropy: no metadata 'table_meta_yaml'", source)
    refuse_unfolding(text.decode())
    header = meta.get_header_from_yaml(text.decode().split("\n"))
    units = {column["name"]: column.get("unit") for column in header["datatype"]}
    shapes = dict.fromkeys((*DATES, *SCALARS), ()) | {name: (len(names),) for name, names, _ in VECTORS}
    for name, kind in zip(schema.names, schema.types, strict=True):
        if name not in shapes or schema.names.count(name) > 1:
            raise FormatError(f"column {name!r:.40}, unknown or there twice", source)
        if not kind.equals(_type(shapes[name])):
            raise FormatError(f"column {name!r} of {kind}, not {_type(shapes[name])}", source)
        unit = units.get(name)
        if name not in DATES and (None if unit is None else str(unit)) != UNITS[name]:
            raise FormatError(f"column {name!r} in {unit}, not in {UNITS[name]}", source)
    return dict(header["meta"])


def _columns(table: Any, source: str) -> dict[str, np.ndarray]:
    """The columns of `parts`, of those of the table."""
    columns = {}
    for name, ours in SCALARS.items():
        if name in table.column_names:
            columns[ours] = _numbers(table, name, source)
    for name, names, _ in VECTORS:
        if name in table.column_names:
            matrix = _numbers(table, name, source).reshape(-1, len(names))
            columns.update(zip(names, matrix.T, strict=True))
    return columns


def _numbers(table: Any, name: str, source: str) -> np.ndarray:
    column = table.column(name)
    numbers = column.combine_chunks()
    flat = numbers if name in SCALARS else numbers.flatten()
    if column.null_count or flat.null_count:
        raise FormatError(f"column {name!r} with missing values", source)
    return flat.to_numpy()

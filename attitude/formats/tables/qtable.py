"""An ephemeris as an astropy QTable, a row per instant."""

from __future__ import annotations

from typing import Any

import numpy as np
from astropy import units as u
from astropy.table import QTable
from astropy.time import Time

from ...errors import FormatError, InputError, shown
from ...pointing import vector_columns
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from .. import schema

# Columns of a table: the last dimensions of a cell, and the unit.
CELLS: dict[str, tuple[tuple[int, ...], u.UnitBase | None]] = {
    "time": ((2,), u.d),
    "elapsed": ((), u.s),
    "elapsed_rest": ((), u.s),
    **{
        name: ((len(names),) if len(names) > 1 else (), u.Unit(unit) if unit else None)
        for name, (names, unit) in vector_columns.KNOWN_VECTORS.items()
    },
}


def to_table(ephemeris: EphemerisData, shape: tuple[int, ...] | None = None) -> QTable:
    """See `Ephemeris.to_table`; for a chunk, `shape` is that of all samples."""
    if len(ephemeris.instants.shape) != 1:
        raise InputError(
            "instants", f"shape {ephemeris.instants.shape}", "a list of instants, for the rows of a table"
        )
    meta = schema.metadata(Samples.of(ephemeris))
    table = QTable(meta=meta if shape is None else {**meta, "shape": list(shape)})
    names = schema.names(Samples.of(ephemeris))
    if schema.TIME in names:
        time = ephemeris.time  # whose TDB - TT astropy may have stored, and would write as a column
        table["time"] = Time(time.jd1, time.jd2, format="jd", scale=time.scale)
        table["time"].format, table["time"].precision = time.format, time.precision
        table["time"].info.serialize_method["ecsv"] = "jd1_jd2"  # as text it would lose digits
    if schema.ELAPSED in names:
        table["elapsed"] = ephemeris.elapsed * u.s
    if not ephemeris.columns:
        table["elapsed_rest"] = ephemeris.instants.low * u.s
    for column in vector_columns.vectors(ephemeris):
        values = column.values if len(column.names) > 1 else column.values[..., 0]
        rows = np.moveaxis(values, len(ephemeris.batch_shape), 0)
        table[column.label] = rows * u.Unit(column.unit) if column.unit else rows
    return table


def cells(table: QTable) -> dict[str, np.ndarray]:
    """The numbers of each column; of dates, (n, 2) Julian dates."""
    columns = {name: table[name] for name in table.colnames}
    return {
        name: np.stack([column.jd1, column.jd2], axis=-1)
        if name == "time"
        else np.asarray(getattr(column, "value", column))
        for name, column in columns.items()
    }


def refuse_unfolding(header: str) -> None:
    """Raises ValueError for YAML whose aliases expand to more than a million nodes."""
    if "&" not in header:
        return
    import yaml  # type: ignore[import-untyped]  # astropy's own

    limit, sizes = 1_000_000, dict[int, int]()

    def size(node: Any) -> int:
        """The number of nodes of a tree, with every alias expanded."""
        if id(node) not in sizes:
            sizes[id(node)] = limit  # of a node within itself
            items = node.value if isinstance(node.value, list) else []
            sizes[id(node)] = 1 + sum(
                size(child) for item in items for child in (item if isinstance(item, tuple) else (item,))
            )
        return sizes[id(node)]

    if size(yaml.compose(header, Loader=yaml.SafeLoader)) > limit:
        raise ValueError("a header whose aliases expand to more than a million nodes")


def from_table(table: QTable, source: str) -> EphemerisData:
    """The ephemeris of a table that `to_table` made; FormatError for any other."""
    unknown = [name for name in table.colnames if name not in CELLS]
    if unknown:
        raise FormatError(f"column {shown(unknown[0])} is unknown", source)
    shape = table.meta.get("shape")
    axis = len(shape) - 1 if isinstance(shape, list) and shape else 0
    columns = {schema.ELAPSED: _values(table, "elapsed", source)}
    if "elapsed_rest" in table.colnames:
        columns[schema.REST] = _values(table, "elapsed_rest", source)
    for name, (names, _) in vector_columns.VECTORS.items():
        if name in table.colnames or names is vector_columns.QUATERNION:
            vector = _values(table, name, source)
            # (instant, batch, component) to (component, batch, instant)
            components = np.moveaxis(np.moveaxis(vector, 0, min(axis, vector.ndim - 2)), -1, 0)
            columns.update(zip(names, components, strict=True))
    return schema.ephemeris_from(dict(table.meta), columns, source)


def _values(table: QTable, name: str, source: str) -> np.ndarray:
    """The numbers of a column; refuses a missing one, another unit, and another shape."""
    column, (last, unit) = table[name] if name in table.colnames else None, CELLS[name]
    if (
        column is None
        or getattr(column, "unit", None) != unit
        or column.shape[column.ndim - len(last) :] != last
    ):
        shape = f" of {last[0]} numbers" if last else ""
        raise FormatError(f"no column {name!r}{shape}" + (f" in {unit}" if unit else ""), source)
    return np.asarray(column.value if unit else column)

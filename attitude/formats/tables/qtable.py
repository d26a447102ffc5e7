"""An astropy QTable, one row an instant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from astropy import units as u
from astropy.table import QTable
from astropy.time import Time

from ...errors import FormatError, InputError, shown
from ...samples.chunks import Samples
from .. import schema

if TYPE_CHECKING:
    from ...samples.ephemeris_data import EphemerisData

# A table's columns of vectors, what their components are called in other formats, and units.
VECTORS: tuple[tuple[str, tuple[str, ...], u.UnitBase | None], ...] = (
    ("quaternion", schema.QUATERNION, None),
    ("angular_velocity", schema.RATE, u.rad / u.s),
    ("angular_momentum", schema.MOMENTUM, u.N * u.m * u.s),
    ("position", schema.POSITION, u.m),
    ("velocity", schema.VELOCITY, u.m / u.s),
)


MOST_PARTS = 1_000_000  # of a header


def to_table(
    ephemeris: EphemerisData, shape: tuple[int, ...] | None = None, has_seconds_low: bool | None = None
) -> QTable:
    """See `Ephemeris.to_table`; of a piece, `shape` and `has_seconds_low` are those of the whole."""
    rest = ephemeris.instants.seconds_low
    has_seconds_low = rest is not None if has_seconds_low is None else has_seconds_low
    if len(ephemeris.instants.shape) != 1:
        raise InputError(
            "instants", f"shape {ephemeris.instants.shape}", "a list of instants, for the rows of a table"
        )
    meta = schema.metadata(Samples.of(ephemeris))
    table = QTable(meta=meta if shape is None else {**meta, "shape": list(shape)})
    if ephemeris.epoch is not None:
        table["time"] = _without_delta(ephemeris.time)
        table["time"].info.serialize_method["ecsv"] = "jd1_jd2"  # as text it would lose digits
    table["elapsed"] = ephemeris.elapsed * u.s
    if has_seconds_low:
        table["elapsed_rest"] = (np.zeros(len(ephemeris)) if rest is None else rest) * u.s
    row, column = len(ephemeris.batch_shape), {names: (name, unit) for name, names, unit in VECTORS}
    for names, vector in schema.vectors(ephemeris):
        name, unit = column[names]
        along_rows = np.moveaxis(vector, row, 0)
        table[name] = along_rows if unit is None else along_rows * unit
    return table


def _without_delta(time: Time) -> Time:
    """The same instants, without the TDB - TT that astropy may have kept, and would write as a column."""
    plain = Time(time.jd1, time.jd2, format="jd", scale=time.scale)
    plain.format, plain.precision = time.format, time.precision
    return plain


def refuse_unfolding(header: str) -> None:
    """Refuses YAML whose parts are repeated by name, and parts of such parts, beyond all measure.

    Raises ValueError, or what the parser raises.
    """
    if "&" not in header:
        return
    import yaml  # type: ignore[import-untyped]  # astropy's own

    sizes: dict[int, int] = {}

    def size(node: Any) -> int:
        """Nodes below one, those counted again that are named again."""
        if id(node) not in sizes:
            sizes[id(node)] = MOST_PARTS  # of a part within itself
            below = node.value if isinstance(node.value, list) else []
            sizes[id(node)] = 1 + sum(
                size(each) for pair in below for each in (pair if isinstance(pair, tuple) else (pair,))
            )
        return sizes[id(node)]

    if size(yaml.compose(header, Loader=yaml.SafeLoader)) > MOST_PARTS:
        raise ValueError("a header whose aliases stand for more than memory holds")


def from_table(table: QTable, source: str) -> EphemerisData:
    """The ephemeris that `to_table` made it of."""
    known = ("time", "elapsed", "elapsed_rest", *(name for name, _, _ in VECTORS))
    unknown = [name for name in table.colnames if name not in known]
    if unknown:
        raise FormatError(f"column {shown(unknown[0])} is not known here", source)
    shape = table.meta.get("shape")
    row = len(shape) - 1 if isinstance(shape, list) and shape else 0
    columns = {schema.ELAPSED: _values(table, "elapsed", u.s, (), source)}
    if "elapsed_rest" in table.colnames:
        columns[schema.REST] = _values(table, "elapsed_rest", u.s, (), source)
    for name, names, unit in VECTORS:
        if name in table.colnames or names is schema.QUATERNION:
            vector = _values(table, name, unit, (len(names),), source)
            columns.update(zip(names, _components(vector, row), strict=True))
    return schema.ephemeris_from(dict(table.meta), columns, source)


def _values(
    table: QTable, name: str, unit: u.UnitBase | None, last: tuple[int, ...], source: str
) -> np.ndarray:
    """A column's numbers; refuses one that is not there, in another unit, or of another shape."""
    column = table[name] if name in table.colnames else None
    if (
        column is None
        or getattr(column, "unit", None) != unit
        or column.shape[column.ndim - len(last) :] != last
    ):
        wanted = f" of {last[0]} numbers" if last else ""
        raise FormatError(f"no column {name!r}{wanted}" + (f" in {unit}" if unit else ""), source)
    return np.asarray(column.value if unit else column)


def _components(column: np.ndarray, row: int) -> np.ndarray:
    """(component, batch, instant) of (instant, batch, component)."""
    return np.moveaxis(np.moveaxis(column, 0, min(row, column.ndim - 2)), -1, 0)

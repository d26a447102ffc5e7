"""Tables read by row groups: a table in memory is one, so is a row group of Parquet, or a Dask partition.

Columns are read as doubles, NaN where a value is missing.
"""

from __future__ import annotations

from collections import OrderedDict
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from astropy import units as u
from astropy.table import Table

from ...errors import FormatError, InputError

Arrays = dict[str, np.ndarray]


class RowGroups:
    """A table whose rows are read by groups.

    Attributes
    ----------
    names : of the columns
    units : by column, of those that have one
    """

    def __init__(self, names: list[str], units: dict[str, str], lengths: list[int]):
        self.names, self.units = names, units
        self._ends = np.cumsum(lengths, dtype=np.int64) if lengths else np.zeros(0, np.int64)
        self._cached: OrderedDict[int, Arrays] = OrderedDict()
        self._lock = Lock()

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self._ends[-1]) if len(self._ends) else 0

    def read(self, names: list[str], first: int, last: int) -> Arrays:
        """Columns of the rows from first to last, the last one excluded."""
        parts = []
        for i in range(int(np.searchsorted(self._ends, first, side="right")), len(self._ends)):
            begin = int(self._ends[i - 1]) if i else 0
            if begin >= last:
                break
            group = self._group(i, names)
            parts.append({name: group[name][max(first - begin, 0) : last - begin] for name in names})
        if len(parts) == 1:
            return parts[0]
        return {name: np.concatenate([part[name] for part in parts]) for name in names} if parts else {}

    def _group(self, i: int, names: list[str]) -> Arrays:
        with self._lock:
            group = self._cached.pop(i, None)
            if group is None or not set(names) <= set(group):
                group = self.load(i, names)
            self._cached[i] = group
            while len(self._cached) > 4:  # parallel tasks read neighbours
                self._cached.popitem(last=False)
            return group

    def load(self, i: int, names: list[str]) -> Arrays:
        """Columns of all rows of a group."""
        raise NotImplementedError

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_cached": OrderedDict(), "_lock": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._lock = Lock()


def row_groups(table: Any, units: dict[str, str]) -> RowGroups:
    """Return the table's row groups; `units` are those of columns that have none of their own.

    Raises InputError for an object that is no table, FormatError for a file that cannot be read.
    """
    if isinstance(table, Table):
        own = {name: str(column.unit) for name, column in table.items() if column.unit is not None}
        return InMemory(table, list(table.colnames), units | own, len(table))
    if isinstance(table, (str, Path)):
        return ParquetFiles(Path(table), units)
    package = type(table).__module__.partition(".")[0]
    if package == "pandas" and hasattr(table, "columns"):
        return InMemory(table, list(map(str, table.columns)), units, len(table))
    if package.startswith("dask") and hasattr(table, "partitions"):
        return Partitions(table, units)
    expected = "a QTable, a pandas or dask DataFrame, or the path of a Parquet file or a directory of them"
    raise InputError("table", table, expected)


class InMemory(RowGroups):
    """An astropy table or a pandas DataFrame."""

    def __init__(self, table: Any, names: list[str], units: dict[str, str], rows: int):
        super().__init__(names, units, [rows])
        self._table = table

    def load(self, i: int, names: list[str]) -> Arrays:  # noqa: ARG002 -- the only group
        """Columns of all rows."""
        return {name: column(self._table[name], name) for name in names}


class Partitions(RowGroups):
    """A Dask DataFrame, whose partitions are computed in the thread that reads them."""

    def __init__(self, frame: Any, units: dict[str, str]):
        lengths = frame.map_partitions(len, meta=("rows", "i8")).compute().tolist()
        super().__init__([str(name) for name in frame.columns], units, lengths)
        self._frame = frame

    def load(self, i: int, names: list[str]) -> Arrays:
        """Columns of a partition."""
        part = self._frame.partitions[i][names].compute(scheduler="synchronous")
        return {name: column(part[name], name) for name in names}


class ParquetFiles(RowGroups):
    """A Parquet file, or all files of a directory in the order of their names.

    A column's unit is that of its field's metadata ("unit"), or of the table that astropy has written.
    """

    def __init__(self, path: Path, units: dict[str, str]):
        self._files = sorted(path.glob("*.parquet")) if path.is_dir() else [path]
        if not self._files:
            raise FormatError("no *.parquet in this directory", str(path))
        opened = [self._open(file) for file in self._files]
        self._groups = [(i, j) for i, file in enumerate(opened) for j in range(file.metadata.num_row_groups)]
        lengths = [opened[i].metadata.row_group(j).num_rows for i, j in self._groups]
        schema = opened[0].schema_arrow
        super().__init__(list(schema.names), units | units_of(schema), lengths)

    def _open(self, file: Path) -> Any:
        from pyarrow import parquet

        try:
            return parquet.ParquetFile(file)
        except OSError as error:
            raise FormatError(f"cannot be read ({error.strerror or error})", str(file)) from None
        except Exception as error:  # pyarrow's own kinds
            raise FormatError(f"not Parquet: {' '.join(str(error).split())}", str(file)) from None

    def load(self, i: int, names: list[str]) -> Arrays:
        """Columns of a row group of a file."""
        number, group = self._groups[i]
        file = self._files[number]
        try:
            table = self._open(file).read_row_group(group, columns=names)
        except FormatError:
            raise
        except Exception as error:  # pyarrow's own kinds
            raise FormatError(f"cannot be read ({' '.join(str(error).split())})", str(file)) from None
        missing = [name for name in names if name not in table.column_names]
        if missing:
            raise FormatError(f"no column {missing[0]!r}, which other files of the directory have", str(file))
        return {name: doubles_of_arrow(table.column(name).combine_chunks(), name) for name in names}


def units_of(schema: Any) -> dict[str, str]:
    """Units by column, of its field's metadata or of the table that astropy has written."""
    units = {}
    text = (schema.metadata or {}).get(b"table_meta_yaml")
    if text is not None:
        from astropy.table import meta

        header = meta.get_header_from_yaml(text.decode().split("\n"))
        units = {
            column["name"]: str(column["unit"])
            for column in header["datatype"]
            if column.get("unit") is not None
        }
    for field in schema:
        if field.metadata and b"unit" in field.metadata:
            units[field.name] = field.metadata[b"unit"].decode()
    return units


def doubles_of_arrow(array: Any, name: str) -> np.ndarray:
    """(n, ...) of scalars, or of lists of equal length; nulls are NaN."""
    import pyarrow as pa

    if isinstance(array, pa.ChunkedArray):  # of no rows
        array = pa.concat_arrays(array.chunks)
    if not pa.types.is_nested(array.type):
        return column(array.to_numpy(zero_copy_only=False), name)
    if pa.types.is_fixed_size_list(array.type) and not array.null_count:
        flat = doubles_of_arrow(array.flatten(), name)
        return flat.reshape(len(array), -1, *flat.shape[1:])
    return column(np.array([*array.to_pylist(), None], dtype=object)[:-1], name)


def column(values: Any, name: str) -> np.ndarray:
    """Return a column as doubles (n, ...), NaN where masked.  Raises InputError if it has no numbers."""
    if isinstance(values, u.Quantity):
        mask = getattr(values, "mask", None)
        values = np.ma.array(
            np.asarray(getattr(values, "unmasked", values)), mask=False if mask is None else mask
        )
    elif hasattr(values, "to_numpy"):
        values = values.to_numpy()
    try:
        if np.ma.isMaskedArray(values):
            return np.ma.filled(np.ma.asarray(values).astype(np.float64), np.nan)
        array = np.asarray(values)
        if array.dtype.kind == "O":
            cells = [None if cell is None else np.asarray(_numbers(cell), dtype=np.float64) for cell in array]
            shape = next((cell.shape for cell in cells if cell is not None), ())
            rows = [np.full(shape, np.nan) if cell is None else cell for cell in cells]
            return np.stack(rows) if rows else np.zeros((0, *shape))
        if array.dtype.kind not in "iuf":
            raise TypeError
        return array.astype(np.float64)
    except (TypeError, ValueError):
        raise InputError(f"table.{name}", f"{getattr(values, 'dtype', type(values))}", "numbers") from None


def _numbers(cell: Any) -> Any:
    """Return a cell, with NaN where it misses numbers.  Raises TypeError for text."""
    if isinstance(cell, (str, bytes, bool)):
        raise TypeError
    if isinstance(cell, (list, tuple, np.ndarray)):
        return [_numbers(each) for each in cell]
    return np.nan if cell is None else cell

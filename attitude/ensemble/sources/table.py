"""Bodies of the rows of a table: its columns and their units, and the rows that are bad."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ... import units as si
from ...errors import InputError
from ...frames import rotations
from ...frames.rotations import UNIT, off_unit
from ...rigid_body.body import MAX_ROUNDING, RigidBody, asymmetry, principal_moments, unphysical
from ...rigid_body.constants_of_motion import RATES, beyond_rates
from ...units import MOMENT, RATE
from .row_groups import row_groups
from .states import MAX_BODIES, States

MAX_LISTED = 1000  # bad rows; all are counted
CHECKED_ROWS = 2**16  # at a time


class Field(NamedTuple):
    """A field of a body: how many numbers, of what unit, and names of scalars instead of one of vectors."""

    width: int
    unit: Any
    scalars: tuple[tuple[str, ...], ...]


FIELDS = {
    "moments": Field(3, MOMENT, (("moments_1", "moments_2", "moments_3"),)),
    "tensor": Field(9, MOMENT, (tuple(f"tensor_{at}" for at in ("xx", "xy", "xz", "yy", "yz", "zz")),)),
    "quaternion": Field(4, None, (("q_w", "q_x", "q_y", "q_z"),)),
    "angular_velocity": Field(
        3,
        RATE,
        (
            tuple(f"angular_velocity_{axis}" for axis in "xyz"),
            tuple(f"omega_{axis}_rad_s" for axis in "xyz"),
        ),
    ),
}


class BadRow(NamedTuple):
    """A bad field of a row: its value (in SI), and what would be right."""

    row: int
    field: str
    value: Any
    expected: str

    def __str__(self) -> str:
        return f"table[{self.row}].{self.field}: {self.expected}; got {self.value}"


class LeftOut:
    """Bad rows of a table, which are no bodies.

    Attributes
    ----------
    rows : indices of all of them, ascending
    listed : tuple of BadRow, a thousand fields at most
    """

    def __init__(self, rows: Any = (), listed: tuple[BadRow, ...] = ()):
        self.rows = np.asarray(rows, dtype=np.int64)
        self.listed = listed

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __str__(self) -> str:
        lines = [f"{self.count} bad rows", *map(str, self.listed)]
        others = self.count - len({bad.row for bad in self.listed})
        return "\n".join(lines + ([f"and {others} rows more"] if others else []))


class BadRowsError(InputError):
    """Bad rows of a table; `left_out` lists them."""

    def __init__(self, left_out: LeftOut, size: int):
        first, *others = left_out.listed
        named = "; ".join(map(str, others[:4]))
        more = f" ({left_out.count} bad rows of {size}{': also ' + named if named else ''})"
        super().__init__(f"table[{first.row}].{first.field}", first.value, first.expected + more)
        self.left_out = left_out


class Columns(NamedTuple):
    """Moments (n, 3) or tensor (n, 3, 3), quaternion (n, 4), rate (n, 3), in SI; NaN for missing values."""

    moments: np.ndarray | None
    tensor: np.ndarray | None
    quaternion: np.ndarray
    angular_velocity: np.ndarray

    def of(self, rows: np.ndarray) -> Columns:
        """Return these rows of all columns."""
        return self._replace(**{name: x[rows] for name, x in self._asdict().items() if x is not None})


class Tabled:
    """Source of the bodies of a table's rows; see `Ensemble.from_table`.

    Attributes
    ----------
    size : number of good rows; left_out : the others

    Raises
    ------
    InputError : columns are missing; BadRowsError where rows are bad, and `bad_rows` is "stop".
    """

    def __init__(self, table: Any, bad_rows: str = "stop", units: dict[str, str] | None = None):
        if bad_rows not in ("stop", "leave out"):
            raise InputError("bad_rows", bad_rows, '"stop" or "leave out"')
        pairs = [] if units is None else units.items() if isinstance(units, dict) else [(units,)]
        if not all(isinstance(part, str) for pair in pairs for part in pair):
            raise InputError("units", units, 'units by column, such as {"angular_velocity": "deg/s"}')
        self._table = row_groups(table, units or {})
        self._names = _names(self._table.names)
        self._factors = {
            name: self._factor(field, name) for field, names in self._names.items() for name in names
        }
        self.left_out = self._bad_rows()
        if self.left_out.count and bad_rows == "stop":
            raise BadRowsError(self.left_out, self._table.size)
        self.size = self._table.size - self.left_out.count
        if self.size < 1:
            rows = f"{self._table.size} rows, {self.left_out.count} of them bad"
            raise InputError("table", rows, "at least one good row")
        if self.size > MAX_BODIES:
            raise InputError("table", f"{self.size} rows", f"at most {MAX_BODIES}")

    def part(self, first: int, last: int) -> States:
        """States of the bodies from first to last."""
        rows = self.rows(first, last)
        begin, end = int(rows[0]), int(rows[-1]) + 1
        columns = self._read(begin, end)
        if end - begin > last - first:
            columns = columns.of(rows - begin)
        if columns.moments is not None:
            body = RigidBody.from_moments(columns.moments)
        else:
            body = RigidBody(columns.tensor)
        quaternion = rotations.of_unit_length(columns.quaternion, rotations.off_unit(columns.quaternion)[0])
        return States(body, quaternion, columns.angular_velocity)

    def rows(self, first: int, last: int) -> np.ndarray:
        """Return the indices of the rows of these bodies."""
        bodies, bad = np.arange(first, last), self.left_out.rows
        return bodies + np.searchsorted(bad - np.arange(len(bad)), bodies, side="right")

    def identity(self) -> dict[str, Any]:
        """Plain data that identifies this source, together with a digest of its states."""
        return {"kind": "table", "bodies": self.size, "left_out": self.left_out.count}

    def _read(self, first: int, last: int) -> Columns:
        cells = self._table.read(list(self._factors), first, last)
        fields: dict[str, np.ndarray | None] = {"moments": None, "tensor": None}
        for field, names in self._names.items():
            with np.errstate(over="ignore", invalid="ignore"):
                parts = [cells[name] * self._factors[name] for name in names]
            array = parts[0] if len(parts) == 1 else np.stack(parts, axis=-1)
            fields[field] = _shaped(field, array)
        return Columns(**fields)  # type: ignore[arg-type]

    def _factor(self, field: str, name: str) -> float:
        """Return the column's unit in SI."""
        unit, dimension = self._table.units.get(name), FIELDS[field].unit
        if unit is None or dimension is None:
            if unit not in (None, ""):
                raise InputError(f"table.{name}", unit, "no unit: the components of a quaternion are numbers")
            return 1.0
        return si.parse_unit(unit, dimension, f"table.{name}")

    def _bad_rows(self) -> LeftOut:
        rows: list[np.ndarray] = []
        listed: list[BadRow] = []
        lengths = [1.0, 1.0]  # the least and the greatest of good quaternions
        for first in range(0, self._table.size, CHECKED_ROWS):
            columns = self._read(first, min(first + CHECKED_ROWS, self._table.size))
            bad = np.zeros(len(columns.quaternion), np.bool_)
            fields: list[BadRow] = []
            for field, wrong, values, expected in _faults(columns):
                bad |= wrong
                fields += [
                    BadRow(first + int(row), field, values[row].tolist(), expected)
                    for row in np.flatnonzero(wrong)[: MAX_LISTED - len(listed)]
                ]
            rows.append(first + np.flatnonzero(bad))
            good = rotations.off_unit(columns.quaternion[~bad])[0]
            lengths = [good.min(initial=lengths[0]), good.max(initial=lengths[1])]
            listed += sorted(fields, key=lambda bad: (bad.row, list(FIELDS).index(bad.field)))[
                : MAX_LISTED - len(listed)
            ]
        rotations.warn_of_lengths(np.array(lengths), "table.quaternion")
        return LeftOut(np.concatenate(rows) if rows else (), tuple(listed))


# -- columns ----------------------------------------------------------------------------------------


def _names(names: list[str]) -> dict[str, tuple[str, ...]]:
    """Names of the columns of each field: one of vectors, or scalars."""
    columns: dict[str, tuple[str, ...]] = {}
    for field, numbers in FIELDS.items():
        forms = [form for form in ((field,), *numbers.scalars) if set(form) <= set(names)]
        if len(forms) > 1:
            raise InputError(f"table.{field}", " and ".join(", ".join(form) for form in forms), "one of them")
        columns |= {field: forms[0]} if forms else {}
    if "moments" in columns and "tensor" in columns:
        raise InputError("table", "moments and tensor", "one of them")
    for field in ("tensor" if "tensor" in columns else "moments", "quaternion", "angular_velocity"):
        if field not in columns:
            also = " (or a tensor)" if field == "moments" else ""
            expected = f"a column {field}{also}, or scalars {', '.join(FIELDS[field].scalars[0])}"
            raise InputError(f"table.{field}", f"columns {', '.join(names)}", expected)
    return columns


def _shaped(field: str, array: np.ndarray) -> np.ndarray:
    """(n, 3), (n, 4) or (n, 3, 3)."""
    width = FIELDS[field].width
    if field == "tensor" and array.shape[1:] == (6,):
        array = array[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]]  # of the nine components, in the six scalars
    if (array[:1].size != width and len(array)) or array.ndim < 2:
        raise InputError(f"table.{field}", f"shape {array.shape}", f"{width} numbers in each row")
    return np.ascontiguousarray(array).reshape(len(array), *((3, 3) if field == "tensor" else (width,)))


# -- rows -------------------------------------------------------------------------------------------


def _faults(columns: Columns) -> Iterator[tuple[str, np.ndarray, np.ndarray, str]]:
    """(field, bad rows (n,), values by row, what would be right), for a row's first fault in each field."""
    bad = {field: np.zeros(len(columns.quaternion), np.bool_) for field in FIELDS}
    for field, wrong, values, expected in _checks(columns):
        rows = wrong.reshape(len(wrong), -1).any(axis=1)
        yield field, rows & ~bad[field], values, expected
        bad[field] |= rows


def _checks(columns: Columns) -> Iterator[tuple[str, np.ndarray, np.ndarray, str]]:
    """(field, what is wrong (n, ...), values by row, what would be right), of all that is checked."""
    for field in FIELDS:
        if (values := getattr(columns, field)) is not None:
            yield field, ~np.isfinite(values), values, "finite numbers"
    with np.errstate(over="ignore", invalid="ignore"):
        if columns.moments is not None:
            for wrong, expected in unphysical(columns.moments):
                yield "moments", wrong, columns.moments, expected
        length, off = off_unit(columns.quaternion)
        yield "quaternion", off, length, UNIT
        yield "angular_velocity", beyond_rates(columns.angular_velocity), columns.angular_velocity, RATES
    if (tensor := columns.tensor) is not None:
        missing = (~np.isfinite(tensor)).any(axis=(1, 2), keepdims=True)
        sound = np.where(missing, np.eye(3), tensor)
        skew = asymmetry(sound) > MAX_ROUNDING
        yield "tensor", skew, tensor, "a symmetric tensor"
        skew = np.asarray(skew.any(axis=(1, 2), keepdims=True))
        sound = np.where(skew, np.eye(3), 0.5 * sound + 0.5 * np.swapaxes(sound, 1, 2))
        moments = principal_moments(sound)
        for wrong, expected in unphysical(moments):
            yield "tensor", wrong, moments, expected

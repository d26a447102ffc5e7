"""Observations as columns, with the units in their names: of CSV files, and of documents.

    time [utc] or elapsed [s]
    q_w, q_x, q_y, q_z; or euler_ZXZ_1 [deg], ..._2, ..._3       attitude_sigma [deg]
    omega_x [deg/s], omega_y, omega_z                            omega_sigma [deg/s]
    body_x, body_y, body_z, inertial_x, inertial_y, inertial_z   direction_sigma [deg]
    range_offset [m], point_x [m], ..., sight_x, ...             range_sigma [m]

Units may also be in parentheses, or at the end as in the tables that this library writes: "omega_x (deg/s)",
"omega_x_deg_s", "time_utc".  A row whose cells of one kind are all empty has no observation of that kind.  In
a CSV file a comment line "# name [unit]: value" is a column of one value, "# frame: ECLIPJ2000" the frame,
"# bias: true" asks for constant biases of rates and ranges.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, get_args

import numpy as np
from astropy import units as u
from astropy.time import Time

from .. import stopping, units
from ..errors import FormatError, InputError, emit_warning, file_errors, unknown
from ..frames import rotations
from ..times.iso8601 import Scale, parse_times
from .observations import Attitudes, BodyRates, Directions, ObservationSet, RangeOffsets

EULER = re.compile(r"euler_([XYZ]{3})_([123])")


class Kind(NamedTuple):
    """Observations of one kind: the columns that have values for each, and the one with deviations.

    members : of the set, by the columns that they are
    """

    columns: tuple[str, ...]
    sigma: str
    made: type[ObservationSet]
    members: Mapping[str, int | slice]


def xyz(name: str) -> tuple[str, ...]:
    """Names of the columns of a vector's components."""
    return tuple(f"{name}_{axis}" for axis in "xyz")


KINDS = {
    kind.made: kind
    for kind in (
        Kind(("q_w", "q_x", "q_y", "q_z"), "attitude_sigma", Attitudes, {"attitude": slice(0, 4)}),
        Kind(xyz("omega"), "omega_sigma", BodyRates, {"rate": slice(0, 3)}),
        Kind(
            (*xyz("body"), *xyz("inertial")),
            "direction_sigma",
            Directions,
            {"body": slice(0, 3), "inertial": slice(3, 6)},
        ),
        Kind(
            ("range_offset", *xyz("point"), *xyz("sight")),
            "range_sigma",
            RangeOffsets,
            {"offset": 0, "point": slice(1, 4), "line_of_sight": slice(4, 7)},
        ),
    )
}
# The kind of unit that a column has, an example of it, or none.
COLUMNS: dict[str, tuple[u.UnitBase, str] | None] = {
    **dict.fromkeys((*xyz("omega"), "omega_sigma"), (units.RATE, "deg/s")),
    **dict.fromkeys(("range_offset", *xyz("point"), "range_sigma"), (units.LENGTH, "m")),
    **dict.fromkeys(("attitude_sigma", "direction_sigma"), (units.ANGLE, "deg")),
    "elapsed": (units.SECOND, "s"),
    **dict.fromkeys(("time", *KINDS[Attitudes].columns, *KINDS[Directions].columns, *xyz("sight"))),
}
WITH_SUFFIX = re.compile(
    rf"({'|'.join(sorted(COLUMNS, key=len, reverse=True))}|euler_[xyz]{{3}}_[123])_([a-z]+(?:_[a-z]+)?)"
)


def parse_header(header: str) -> tuple[str, str | None]:
    """Name of a column and its unit, or scale; a header that is none is a name without."""
    match = re.fullmatch(r"\s*(\w+)\s*(?:\[(.+)\]|\((.+)\))?\s*", header)
    if match is None:
        return header, None
    name, unit = match[1].lower(), match[2] or match[3]
    if unit is None and (suffixed := WITH_SUFFIX.fullmatch(name)):
        name, unit = suffixed[1], suffixed[2].replace("_", "/")
    if name.startswith("euler_"):
        name = name[:6] + name[6:].upper()
    return name, unit


class Table:
    """Columns by their names without units: numbers in SI with NaN for empty cells, and instants.

    Raises InputError for names, units and cells that are not understood, with the row counted from 0.
    """

    def __init__(self, columns: Mapping[str, Any], frame: str, label: str = "", has_bias: bool = False):
        self.frame, self.label, self.has_bias = frame, label, has_bias
        self.times: Any = None
        self.columns: dict[str, np.ndarray] = {}
        lengths = {name: len(each) for name, each in columns.items() if isinstance(each, (list, tuple))}
        self.count = max(lengths.values(), default=0)
        for header, values in columns.items():
            if lengths.get(header, self.count) != self.count:
                raise InputError(header, f"{lengths[header]} values", f"{self.count}, as the other columns")
            self._add(header, values)
        if self.times is None:
            raise InputError("time", None, 'a column "time [utc]", or of another scale, or "elapsed [s]"')

    def _add(self, header: str, values: Any) -> None:
        name, unit = parse_header(header)
        if name in self.columns or (name in ("time", "elapsed") and self.times is not None):
            raise InputError(header, name, "each quantity once, and either dates or elapsed times")
        if name == "time":
            self.times = self._dates(header, unit, values)
            return
        is_euler = EULER.fullmatch(name)
        if not is_euler and name not in COLUMNS:
            raise InputError(header, name, unknown("column", name, (*COLUMNS, "euler_ZXZ_1")))
        like, example = (units.ANGLE, "deg") if is_euler else COLUMNS[name] or (None, "")
        if (like is None) != (unit is None):
            expected = f'its unit in brackets, such as "{name} [{example}]"' if example else "no unit"
            raise InputError(header, unit, expected)
        if is_euler:
            rotations.check_sequence(is_euler[1], header)
        numbers = _numbers(values, header)
        if name.endswith("_sigma"):
            units.refuse_where(numbers <= 0.0, numbers, header, "greater than 0")
        numbers *= 1.0 if like is None or unit is None else units.parse_unit(unit, like, header)
        numbers = np.broadcast_to(numbers, (self.count,)) if numbers.ndim == 0 else numbers
        if name == "elapsed":
            units.refuse_where(~np.isfinite(numbers), numbers, header, "a time in every row")
            self.times = numbers
        else:
            self.columns[name] = numbers

    def _dates(self, header: str, scale: str | None, values: Any) -> Time:
        if scale is None or scale.lower() not in get_args(Scale):
            raise InputError(
                header, scale, f'a time scale in brackets, such as "time [utc]": {", ".join(get_args(Scale))}'
            )
        if not isinstance(values, (list, tuple)) or not all(isinstance(each, str) for each in values):
            raise InputError(header, values, "dates (ISO 8601)")
        try:
            return parse_times([each.strip() for each in values], scale.lower())
        except InputError as error:
            raise InputError(
                header + error.field.removeprefix("times.dates"), error.value, error.expected
            ) from None

    def sets(self) -> list[ObservationSet]:
        """The observations of every kind that there is."""
        sets = [each for kind in KINDS.values() if (each := self._of_kind(kind)) is not None]
        if not sets:
            raise InputError(
                "columns",
                list(self.columns),
                "observations: q_w, euler_ZXZ_1, omega_x, body_x or range_offset",
            )
        if self.has_bias and not any(each.biases for each in sets):
            raise InputError("bias", True, "rates or range offsets, which may have a bias")
        return sets

    def _of_kind(self, kind: Kind) -> ObservationSet | None:
        """The observations of a kind, if there are any; errors name row and columns of the table."""
        euler = self._euler_sequence() if kind.made is Attitudes else None
        columns = kind.columns if euler is None else tuple(f"euler_{euler}_{i}" for i in (1, 2, 3))
        rows, values, sigma = self._part(columns, kind.sigma)
        if values is None:
            return None
        members: dict[str, Any] = {name: values[:, part] for name, part in kind.members.items()}
        if kind.made is Attitudes:
            members["order"] = "wxyz"
        if euler is not None:
            members["attitude"] = rotations.from_euler(euler, values)
        if hasattr(kind.made, "has_bias"):
            members["has_bias"] = self.has_bias
        name = f"{self.label} {kind.made.KIND}".strip()
        try:
            return kind.made(self.times[rows], sigma, name, self.frame, **members)
        except InputError as error:
            index = re.search(r"\[(\d+)\]", error.field)
            if index is None:
                raise
            row = int(np.flatnonzero(rows)[int(index[1])])
            column = kind.sigma if error.field.startswith(f"{name}.sigma") else ", ".join(columns)
            raise InputError(f"{column}[{row}]", error.value, error.expected) from None

    def _euler_sequence(self) -> str | None:
        """The sequence of the attitudes that are Euler angles."""
        sequences = {match[1] for name in self.columns if (match := EULER.fullmatch(name))}
        has_both = sequences and self.columns.keys() & {*KINDS[Attitudes].columns}
        if len(sequences) > 1 or has_both:
            raise InputError("columns", list(self.columns), "attitudes in one form")
        return next(iter(sequences), None)

    def _part(
        self, names: Sequence[str], sigma_name: str
    ) -> tuple[np.ndarray, np.ndarray | None, np.ndarray | None]:
        """Mask of the rows that have these columns, their values (n, k), and their standard deviations."""
        present = [name for name in names if name in self.columns]
        if not present:
            if sigma_name in self.columns:
                raise InputError(sigma_name, "a column", f"the columns {', '.join(names)} beside it")
            return np.zeros(0, dtype=bool), None, None
        for name in names:
            if name not in self.columns:
                raise InputError(name, None, f"a column, beside {present[0]}")
        values = np.stack([self.columns[name] for name in names], axis=1)
        listed = [i for i, name in enumerate(names) if self.columns[name].strides != (0,)] or [0]
        is_empty = np.isnan(values[:, listed])
        rows = ~is_empty.all(axis=1)
        for i, name in enumerate(names):
            units.refuse_where(
                rows & np.isnan(values[:, i]), values[:, i], name, f"a number, as in {present[0]}"
            )
        sigma = self.columns.get(sigma_name)
        if sigma is not None:
            units.refuse_where(rows & np.isnan(sigma), sigma, sigma_name, f"a number beside {present[0]}")
        return rows, values[rows], None if sigma is None else sigma[rows]


def _numbers(values: Any, header: str) -> np.ndarray:
    """A number, or (n,) with NaN for empty cells; InputError for text, NaN and infinities in words."""
    is_list = isinstance(values, (list, tuple))
    numbers = np.empty(len(values) if is_list else 1)
    for i, cell in enumerate(values if is_list else [values]):
        field = f"{header}[{i}]" if is_list else header
        if i % 1000 == 0:
            stopping.check()
        try:
            is_empty = cell is None or (isinstance(cell, str) and not cell.strip())
            numbers[i] = np.nan if is_empty else float(cell)
        except (TypeError, ValueError, OverflowError):
            raise InputError(field, cell, "a number, or nothing") from None
        if not is_empty and not np.isfinite(numbers[i]):
            raise InputError(field, cell, "a finite number, or nothing")
    return numbers if is_list else numbers[0]


def read_table(path: str | Path, frame: str | None = None) -> list[ObservationSet]:
    """The observations of a CSV file; `frame` of the values where the file names none (ICRF by default).

    Raises FormatError where it cannot be read, InputError that names line and column.
    """
    with file_errors(path):
        text = Path(path).read_text(encoding="utf-8-sig")
    lines = text.splitlines()
    comment = re.compile(r"#\s*(\w+(?:\s*(?:\[[^\]]+\]|\([^)]+\)))?)\s*:\s*(\S+)\s*")
    comments: dict[str, str] = {match[1]: match[2] for line in lines if (match := comment.fullmatch(line))}
    columns: dict[str, Any] = {}
    for header, value in comments.items():
        name, unit = parse_header(header)
        if name in COLUMNS:
            columns[header] = value
        elif unit is not None:  # other comments are of no account
            emit_warning(f"{path}: the comment {header!r} is not used: {unknown('column', name, COLUMNS)}", 3)
    numbers = [i + 1 for i, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    if len(numbers) < 2:
        raise FormatError("no observations: a line of column names, then a line for each instant", str(path))
    delimiter = next((each for each in ",;\t" if each in lines[numbers[0] - 1]), ",")
    rows = list(csv.reader((lines[number - 1] for number in numbers), delimiter=delimiter))
    for row, number in zip(rows, numbers, strict=True):
        if len(row) != len(rows[0]):
            raise FormatError(f"{len(row)} cells, but {len(rows[0])} columns", str(path), number)
    for name, values in zip(rows[0], zip(*rows[1:], strict=True), strict=True):
        if name in columns:
            raise FormatError(f"the column {name!r} twice", str(path), numbers[0])
        columns[name] = values
    bias = comments.get("bias", "false").lower()
    if bias not in ("true", "false"):
        raise FormatError(f"bias: {bias!r} is neither true nor false", str(path))
    try:
        frame = rotations.check_frame(comments.get("frame", frame or "ICRF"), "frame")
        return Table(columns, frame, "", bias == "true").sets()
    except InputError as error:
        index = re.search(r"\[(\d+)\]$", error.field)
        line = f", line {numbers[1 + int(index[1])]}" if index else ""
        raise InputError(f"{path}{line}: {error.field}", error.value, error.expected, ()) from None

"""Positions of an orbit in CSV: names with units in the first row, a row an instant.

`time` (ISO 8601 dates) or `elapsed_s`; x, y, z with their unit: `x_km` or `position_x_m`; optionally
velocities: `vx_km_s` or `velocity_x_m_s`.  Other columns are not read.  A file that this library wrote with
the columns position and velocity is one.
"""

from __future__ import annotations

import csv
import re
from typing import BinaryIO

import numpy as np

from ...errors import FormatError, InputError
from ...frames.rotations import INERTIAL_FRAMES, TURNING_FRAMES
from ...times.instants import Instants, as_instants
from ...times.iso8601 import parse_times
from .. import bounded_read
from ..orbits import OrbitRows, OrbitSegment
from ..schema import epoch_of_record
from ..text_reader import TextReader, finite_number
from .csv import metadata_of

MAX_BYTES = 1 << 28
POSITION = re.compile(r"(?:position_|pos_)?([xyz])_(k?m)")
VELOCITY = re.compile(r"(?:velocity_|vel_|v)([xyz])_(k?m)_s")


def parse_orbit(stream: BinaryIO, source: str, object_name: str | None = None) -> OrbitRows:
    """Orbit in a table; FormatError with the line of what is wrong."""
    if object_name is not None:
        raise FormatError(f"one object without a name, not {object_name!r}", source)
    content = bounded_read.text(stream, source, MAX_BYTES).removeprefix(b"\xef\xbb\xbf")
    lines = content.decode("utf-8", errors="replace").splitlines()
    numbered = [(i, line) for i, line in enumerate(lines, start=1) if line.strip() and line[0] != "#"]
    if len(numbered) < 2:
        raise FormatError("no rows", source)
    names = [name.strip().lower() for name in next(csv.reader([numbered[0][1]]))]
    rows = list(csv.reader([line for _, line in numbered[1:]]))
    numbers = [i for i, _ in numbered[1:]]
    if len(rows) != len(numbers):
        raise FormatError("quoted text that goes on over a line", source)
    for row, number in zip(rows, numbers, strict=True):
        if len(row) != len(names):
            raise FormatError(f"{len(row)} values where {len(names)} belong", source, number)
    table = _Table(names, rows, numbers, source)
    meta = metadata_of(lines[:64], source) or {}
    instants = table.instants(meta)
    velocities = table.vectors(VELOCITY, "velocity_x_m_s, velocity_y_m_s and velocity_z_m_s", False)
    positions = table.vectors(POSITION, "position_x_m, position_y_m and position_z_m", True)
    assert positions is not None
    later = np.diff(instants.seconds) > 0.0
    if not later.all():
        number = numbers[int(np.argmin(later)) + 1]
        raise FormatError("an instant that is not after the one before", source, number)
    useable = float(instants.seconds[0]), float(instants.seconds[-1])
    frame = meta.get("frame", "")
    if frame not in ("", *INERTIAL_FRAMES, *TURNING_FRAMES):
        raise FormatError(f"frame {frame!r} of the metadata is not known", source)
    return OrbitRows((OrbitSegment(instants, positions, velocities, None, useable),), frame, "", source)


class _Table(TextReader):
    """Columns of text by their names."""

    def __init__(self, names: list[str], rows: list[list[str]], numbers: list[int], source: str):
        super().__init__(source)
        self.names, self.rows, self.numbers = names, rows, numbers
        if len(set(names)) < len(names):
            raise FormatError("a column name twice", source)

    def column(self, index: int) -> np.ndarray:
        """(n,) finite numbers."""
        values = np.empty(len(self.rows))
        for k, row in enumerate(self.rows):
            values[k] = finite_number(row[index].strip())
            if np.isnan(values[k]):
                reason = f"{self.names[index]} is {row[index][:40]!r}, not a finite number"
                raise self.error(reason, self.numbers[k])
        return values

    def vectors(self, form: re.Pattern[str], expected: str, is_needed: bool) -> np.ndarray | None:
        """(n, 3) in SI; None where there are no such columns."""
        matches = {i: match for i, name in enumerate(self.names) if (match := form.fullmatch(name))}
        axes = sorted(match[1] for match in matches.values())
        if not axes and not is_needed:
            return None
        if axes != ["x", "y", "z"]:
            found = ", ".join(self.names)
            raise self.error(f"columns {expected} (or in km) belong here; there are {found[:200]}")
        ordered = sorted(matches.items(), key=lambda item: item[1][1])
        scale = {"m": 1.0, "km": 1e3}
        return np.stack([scale[match[2]] * self.column(i) for i, match in ordered], axis=1)

    def instants(self, meta: dict[str, object]) -> Instants:
        """Instants by the dates, in UTC or the scale of the metadata; or by elapsed seconds alone."""
        if "time" in self.names:
            index = self.names.index("time")
            texts = [row[index].strip() for row in self.rows]
            scale = str(meta.get("time_scale") or "utc")
            try:
                dates = parse_times([text.removesuffix("Z") for text in texts], scale)
                return as_instants(dates, dates[0])
            except InputError as error:
                row = error.steps[-1] if error.steps and isinstance(error.steps[-1], int) else 0
                raise self.error(str(error), self.numbers[row]) from None
        if "elapsed_s" not in self.names:
            raise self.error("no column time or elapsed_s")
        epoch = None
        if isinstance(meta.get("epoch"), dict):
            try:
                epoch = epoch_of_record(meta["epoch"])  # type: ignore[arg-type]
            except (KeyError, TypeError, ValueError) as error:
                raise self.error(f"epoch of the metadata: {error}") from None
        return Instants(self.column(self.names.index("elapsed_s")), None, epoch)

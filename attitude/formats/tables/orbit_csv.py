"""Positions of an orbit in CSV: names with units in the first row, a row an instant.

`time` (ISO 8601 dates) or `elapsed_s`; x, y, z with their unit: `x_km` or `position_x_m`; optionally
velocities: `vx_km_s` or `velocity_x_m_s`.  Other columns are not read.  A file that this library wrote with
the columns position and velocity is one.
"""

from __future__ import annotations

import re
from typing import BinaryIO

import numpy as np

from ...errors import FormatError, InputError
from ...frames.rotations import INERTIAL_FRAMES, TURNING_FRAMES
from ...times.instants import Instants, as_instants
from ...times.iso8601 import parse_times
from ..orbits import OrbitRows, OrbitSegment
from ..schema import epoch_of_record
from .csv import metadata_of
from .text_table import TextTable


def parse_orbit(stream: BinaryIO, source: str, object_name: str | None = None) -> OrbitRows:
    """Orbit in a table; FormatError with the line of what is wrong."""
    if object_name is not None:
        raise FormatError(f"one object without a name, not {object_name!r}", source)
    table = _StateTable.read(stream, source)
    meta = metadata_of(table.lines[:64], source) or {}
    instants = table.instants(meta)
    form, names = r"(?:velocity_|vel_|v)([xyz])_(k?m)_s", "velocity_x_m_s, velocity_y_m_s and velocity_z_m_s"
    velocities = table.vectors(form, names, False)
    form, names = r"(?:position_|pos_)?([xyz])_(k?m)", "position_x_m, position_y_m and position_z_m"
    positions = table.vectors(form, names, True)
    assert positions is not None
    later = np.diff(instants.seconds) > 0.0
    if not later.all():
        number = table.numbers[int(np.argmin(later)) + 1]
        raise FormatError("an instant that is not after the one before", source, number)
    useable = float(instants.seconds[0]), float(instants.seconds[-1])
    frame = meta.get("frame", "")
    if frame not in ("", *INERTIAL_FRAMES, *TURNING_FRAMES):
        raise FormatError(f"frame {frame!r} of the metadata is not known", source)
    return OrbitRows((OrbitSegment(instants, positions, velocities, None, useable),), frame, "", source)


class _StateTable(TextTable):
    """Columns of states."""

    def vectors(self, form: str, expected: str, is_needed: bool) -> np.ndarray | None:
        """(n, 3) in SI; None where there are no such columns."""
        matches = {i: match for i, name in enumerate(self.names) if (match := re.fullmatch(form, name))}
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

"""An astropy QTable, one row an instant, and ECSV through it."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from astropy import units as u
from astropy.table import QTable

from ..errors import FormatError, InputError
from . import parts

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris


def to_table(ephemeris: Ephemeris) -> QTable:
    """See `Ephemeris.to_table`."""
    if len(ephemeris.instants.shape) != 1:
        raise InputError(
            "instants", f"shape {ephemeris.instants.shape}", "a list of instants, for the rows of a table"
        )
    table = QTable(meta=parts.metadata(ephemeris))
    if ephemeris.epoch is not None:
        table["time"] = ephemeris.time
        table["time"].info.serialize_method["ecsv"] = "jd1_jd2"  # as text it would lose digits
    table["elapsed"] = ephemeris.elapsed * u.s
    if ephemeris.instants.rest is not None:
        table["elapsed_rest"] = ephemeris.instants.rest * u.s
    row = len(ephemeris.batch_shape)
    table["quaternion"] = np.moveaxis(ephemeris.quaternion("wxyz"), row, 0)
    if ephemeris.has_rate:
        table["angular_velocity"] = np.moveaxis(ephemeris.angular_velocity, row, 0) * (u.rad / u.s)
    return table


def from_table(table: QTable, source: str) -> Ephemeris:
    """The ephemeris that `to_table` made it of."""
    for name, unit in (("elapsed", u.s), ("quaternion", None), ("angular_velocity", u.rad / u.s)):
        if name == "angular_velocity" and name not in table.colnames:
            continue
        if name not in table.colnames or (unit is not None and getattr(table[name], "unit", None) != unit):
            raise FormatError(f"no column {name!r}" + (f" in {unit}" if unit is not None else ""), source)
    row = len(table.meta.get("shape", [0])) - 1
    columns = {parts.ELAPSED: table["elapsed"].value}
    if "elapsed_rest" in table.colnames:
        columns[parts.REST] = table["elapsed_rest"].value
    quaternion = np.moveaxis(np.asarray(table["quaternion"]), 0, row)
    columns.update((name, quaternion[..., i]) for i, name in enumerate(parts.QUATERNION))
    if "angular_velocity" in table.colnames:
        rate = np.moveaxis(table["angular_velocity"].value, 0, row)
        columns.update((name, rate[..., i]) for i, name in enumerate(parts.RATE))
    return parts.ephemeris_from(table.meta, columns, source)


def blocks(ephemeris: Ephemeris, progress: Callable[[float], None]) -> Iterator[bytes]:
    text = io.StringIO()
    to_table(ephemeris).write(text, format="ascii.ecsv")
    yield text.getvalue().encode()
    progress(1.0)


def parse(text: bytes, source: str) -> Ephemeris:
    try:
        table = QTable.read(text.decode(), format="ascii.ecsv")
    except Exception as error:  # astropy's reader raises a dozen kinds; none may leave as it is
        raise FormatError(
            f"not ECSV that astropy reads: {' '.join(str(error).split())[:200]}", source
        ) from None
    return from_table(table, source)

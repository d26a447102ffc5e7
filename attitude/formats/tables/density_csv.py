"""Densities of the air over the altitude in CSV: altitude_km or altitude_m, and density_kg_m3."""

from __future__ import annotations

import numpy as np

from ...errors import file_errors
from .text_table import TextTable


def read_density(path: str) -> tuple[np.ndarray, np.ndarray]:
    """(n,) altitudes, m, and (n,) densities, kg/m3; FormatError for a file that has no such columns."""
    with file_errors(path), open(path, "rb") as stream:
        table = TextTable.read(stream, path)
    scales = {"altitude_km": 1e3, "altitude_m": 1.0}
    names = [name for name in scales if name in table.names]
    if len(names) != 1 or "density_kg_m3" not in table.names:
        found = ", ".join(table.names)[:200]
        raise table.error(f"columns altitude_km and density_kg_m3 belong here; there are {found}")
    altitude, density = (table.column(table.names.index(name)) for name in (names[0], "density_kg_m3"))
    return scales[names[0]] * altitude, density

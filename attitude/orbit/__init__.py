"""The document's `orbit`: Keplerian elements (`kepler`), a TLE (`tle`), positions (`tabulated`) or a file."""

from __future__ import annotations

from typing import Annotated, Any

from ..documents.fields import Chosen
from ..errors import InputError
from .orbit import OrbitDefinition


def parse_orbit(value: Any) -> OrbitDefinition:
    """Choose the form of an orbit by the keys of the document; orbits made in Python pass through."""
    if isinstance(value, OrbitDefinition):
        return value
    if not isinstance(value, dict):
        raise InputError("", value, "an orbit: Keplerian elements, a tle, times and positions, or a file")
    kepler, tle, table, file = orbit_forms()
    tabular = {"times", "positions", "velocities", "file", "oem", "stk", "csv"} & value.keys()
    if "j2" in value and (tabular or "tle" in value):
        reason = "a tle, whose model has its own" if "tle" in value else "a table"
        raise InputError("j2", value["j2"], f"no j2 beside {reason}")
    if {"file", "oem", "stk", "csv"} & value.keys():
        from .from_file import with_path

        return file.model_validate(with_path(value))
    if "tle" in value:
        return tle.model_validate(value)
    return (table if tabular else kepler).model_validate(value)


def orbit_forms() -> tuple[type[OrbitDefinition], ...]:
    """The classes of all forms, imported when a document has an orbit."""
    from .from_file import OrbitFile
    from .kepler import Kepler
    from .tabulated import OrbitTable
    from .tle import TwoLine

    return Kepler, TwoLine, OrbitTable, OrbitFile


AnyOrbit = Annotated[OrbitDefinition, Chosen(parse_orbit, orbit_forms)]

"""The document's `orbit`: Keplerian elements (`kepler`), a TLE (`tle`) or positions (`tabulated`)."""

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
        raise InputError("", value, "an orbit: Keplerian elements, a tle, or times and positions")
    kepler, tle, table = orbit_forms()
    if "tle" in value:
        return tle.model_validate(value)
    return (table if {"times", "positions", "velocities"} & value.keys() else kepler).model_validate(value)


def orbit_forms() -> tuple[type[OrbitDefinition], type[OrbitDefinition], type[OrbitDefinition]]:
    """The classes of Keplerian elements, of a TLE and of a table, imported when a document has an orbit."""
    from .kepler import Kepler
    from .tabulated import OrbitTable
    from .tle import TwoLine

    return Kepler, TwoLine, OrbitTable


AnyOrbit = Annotated[OrbitDefinition, Chosen(parse_orbit, orbit_forms)]

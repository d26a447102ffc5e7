"""Where the centre of mass goes: the document's `orbit`, and positions along it.

Three forms: Keplerian elements (`kepler`), two lines of a TLE (`tle`), a table of positions (`table`).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any

from ..documents.fields import Chosen, Part
from ..errors import InputError
from .orbit import Orbit


def _pick(value: Any) -> Orbit:
    """The part that the keys of a document tell."""
    if isinstance(value, Orbit):
        return value
    if not isinstance(value, dict):
        raise InputError("", value, "an orbit: Keplerian elements, a tle, or times and positions")
    kepler, tle, table = _kinds()
    if "tle" in value:
        return tle.model_validate(value)
    return (table if "times" in value or "positions" in value else kepler).model_validate(value)


def _kinds() -> tuple[type[Orbit], type[Orbit], type[Orbit]]:
    from .kepler import Kepler
    from .tabulated import Table
    from .tle import TwoLine

    return Kepler, TwoLine, Table


def _parts() -> Iterable[type[Part]]:
    return _kinds()


AnyOrbit = Annotated[Orbit, Chosen(_pick, _parts)]

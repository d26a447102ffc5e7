"""A density over the altitude by a table: its logarithm is linear between rows."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, model_validator

from .. import units
from ..documents.fields import Number, exactly_one
from ..documents.quantities import Measured
from ..errors import FormatError, InputError
from ..formats.tables.density_csv import read_density
from ..orbit.path_states import position
from ..problem.initial_state import InitialState
from .atmosphere import Atmosphere
from .effect import required_orbit_path

Rows = Annotated[list[Number], Field(min_length=2, fail_fast=True)]


class Altitudes(Measured):
    """Altitudes of a table, with their unit."""

    LIKE: ClassVar[Any] = units.LENGTH
    value: Rows
    unit: str = Field(examples=["km"])


class Densities(Measured):
    """Densities of a table, with their unit."""

    LIKE: ClassVar[Any] = units.DENSITY
    value: Rows
    unit: str = Field(examples=["kg/m3"])


class DensityTable(Atmosphere):
    """`{"altitudes": {...}, "densities": {...}}`, or `{"file": "density.csv"}`: exponential between rows.

    Altitudes ascend and are above the central body's radius, a sphere's.  The file has the columns
    altitude_km or altitude_m and density_kg_m3; a relative path is relative to the document's folder.
    """

    altitudes: Altitudes | None = None
    densities: Densities | None = None
    file: str | None = Field(None, min_length=1, examples=["density.csv"])
    _table: tuple[np.ndarray, np.ndarray]

    @model_validator(mode="after")
    def _read(self) -> DensityTable:
        if exactly_one(self, ("altitudes", "file")) == "file":
            if self.densities is not None:
                raise InputError("densities", "a value", "no densities beside file, which has them")
            assert self.file is not None
            try:
                self._table = read_density(self.file)
            except FormatError as error:
                raise InputError("file", self.file, str(error)) from None
            self._check_rows(("file", "file"))
            return self
        if self.densities is None or self.altitudes is None:
            raise InputError("densities", None, "densities beside altitudes, one for each")
        rows = self.altitudes, self.densities
        altitudes, densities = (np.array(each.value) * each.factor for each in rows)
        self._table = altitudes, densities
        self._check_rows(("altitudes.value", "densities.value"))
        return self

    def _check_rows(self, names: tuple[str, str]) -> None:
        altitudes, densities = self._table
        if len(densities) != len(altitudes):
            expected = f"{len(altitudes)}, one for each of altitudes"
            raise InputError(names[1], f"{len(densities)} densities", expected)
        behind = np.concatenate([[False], ~(np.diff(altitudes) > 0.0)])
        wrong = (
            (names[0], altitudes, behind, "m, above the one before"),
            (names[1], densities, ~(densities > 0.0), "kg/m3, greater than 0"),
        )
        for name, values, is_wrong, expected in wrong:
            if is_wrong.any():
                i = int(np.argmax(is_wrong))
                raise InputError(f"{name}[{i}]", float(values[i]), f"a number, {expected}")

    def check(self, initial_state: InitialState) -> None:
        """Refuse a central body whose radius is not known."""
        self._radius(initial_state)

    @staticmethod
    def _radius(initial_state: InitialState) -> float:
        central = initial_state.central_body
        if central is None or central.radius is None:
            expected = "a radius of the central body in orbit, from which altitudes are measured"
            raise InputError("altitudes", None, expected)
        return central.radius

    def range(self) -> tuple[float, float]:
        """The first and the last altitude, m."""
        return float(self._table[0][0]), float(self._table[0][-1])

    def levels(self) -> np.ndarray:
        """The altitudes between the ends, m."""
        return self._table[0][1:-1]

    def altitude_along(self, initial_state: InitialState, t: np.ndarray) -> np.ndarray:
        """(n,) m, above a sphere."""
        r = position(required_orbit_path(initial_state), t)
        return np.sqrt((r**2).sum(axis=1)) - self._radius(initial_state)

    def log_densities(self, initial_state: InitialState, t: np.ndarray) -> np.ndarray:
        """(n,): linear between rows."""
        altitudes, densities = self._table
        return np.interp(self.altitude_along(initial_state, t), altitudes, np.log(densities))

    def name(self) -> str:
        """The table's size and range, for plans."""
        first, last = self.range()
        rows = f"{len(self._table[0])} rows, {first / 1e3:g} km to {last / 1e3:g} km"
        return f"the table {self.file} ({rows})" if self.file else f"the table ({rows})"

"""An orbit given by a table of positions, with velocities or without."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, model_validator

from .. import units
from ..documents.fields import Number, Part, Vector, one_form
from ..documents.quantities import Measured
from ..errors import InputError
from ..problem.initial_state import OrbitPath
from ..times.instants import as_instants
from ..times.iso8601 import Scale, parse_time, parse_times
from .orbit import AboutABody
from .state_table import MIN_POINTS, StateTable, check_table, table_path

if TYPE_CHECKING:
    from astropy.time import Time


class OrbitTimes(Part):
    """Instants of a table: `value`s in a `unit` since the epoch; or `dates` in a `scale`."""

    value: Annotated[list[Number], Field(min_length=MIN_POINTS, fail_fast=True)] | None = None
    unit: str | None = Field(None, examples=["s"])
    dates: Annotated[list[str], Field(min_length=MIN_POINTS, fail_fast=True)] | None = None
    scale: Scale | None = None

    @model_validator(mode="after")
    def _one_form(self) -> OrbitTimes:
        one_form(self, ("value", "unit"), ("dates", "scale"))
        if self.unit is not None:
            units.parse_unit(self.unit, units.SECOND, "unit")
        return self

    @property
    def form(self) -> str:
        """The field that has them."""
        return "dates" if self.value is None else "value"

    def seconds(self, epoch: Time | None) -> np.ndarray:
        """(n,) s since the epoch; InputError for dates where there is none to count from."""
        if self.dates is None:
            return np.array(self.value) * units.parse_unit(self.unit or "", units.SECOND, "unit")
        if epoch is None:
            raise InputError(
                "times.dates", self.dates[0], "an epoch in the scene, for dates to be counted from"
            )
        return as_instants(parse_times(self.dates, self.scale), epoch, "times.dates").seconds


class OrbitPositions(Measured):
    """Positions of a table, with their unit."""

    LIKE: ClassVar[Any] = units.LENGTH
    value: Annotated[list[Vector], Field(min_length=MIN_POINTS, fail_fast=True)]


class OrbitVelocities(Measured):
    """Velocities of a table, with their unit."""

    LIKE: ClassVar[Any] = units.SPEED
    value: Annotated[list[Vector], Field(min_length=MIN_POINTS, fail_fast=True)]


class OrbitTable(AboutABody):
    """`times`, `positions` from the central body and, optionally, `velocities`, in the scene's frame.

    At least four instants, in any steps.
    """

    FORM: ClassVar[str] = "table of positions"

    times: OrbitTimes
    positions: OrbitPositions
    velocities: OrbitVelocities | None = None

    @model_validator(mode="after")
    def _check(self) -> OrbitTable:
        dates = self.times.dates  # of which the order does not depend on the epoch
        self._table(None if dates is None else parse_time(dates[0], self.times.scale, "times.dates[0]"))
        return self

    def _table(self, epoch: Time | None) -> StateTable:
        positions, velocities = self.positions, self.velocities
        speeds = None if velocities is None else np.array(velocities.value) * velocities.factor
        table = StateTable(self.times.seconds(epoch), np.array(positions.value) * positions.factor, speeds)
        check_table(
            table, self.central(), (f"times.{self.times.form}", "positions.value", "velocities.value")
        )
        return table

    def path(self, start: float, stop: float, epoch: Time | None, frame: str) -> OrbitPath:
        """Interpolate the table over the span."""
        return table_path(self._table(epoch), start, stop, self.central(), f"times.{self.times.form}")

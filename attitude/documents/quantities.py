"""Physical quantities of a document: numbers beside their unit, and instants.

Each class is one kind of quantity; its `si` is what the document says in SI units and radians.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from astropy import units as u
from astropy.time import Time
from pydantic import Field, model_validator

from .. import units
from ..errors import InputError
from ..times import iso8601
from ..times.instants import as_instants
from .fields import Number, Part, Vector, one_form

# Products of several quantities must stay doubles; no physical quantity comes near it.
GREATEST = 1e50


class Measured(Part):
    """A value beside a unit that converts to `LIKE`."""

    LIKE: ClassVar[u.UnitBase]

    value: Any
    unit: str

    @model_validator(mode="after")
    def _check_size(self) -> Measured:
        factor = units.parse_unit(self.unit, self.LIKE, "unit")
        with np.errstate(over="ignore"):
            size = np.abs(np.asarray(self.value) * factor).max()
        if not size <= GREATEST:
            raise InputError("value", self.value, f"a magnitude up to {GREATEST:g} {self.LIKE}")
        return self

    @property
    def factor(self) -> float:
        """SI units in one unit of the document."""
        return units.parse_unit(self.unit, self.LIKE, "unit")


class Quantity(Measured):
    """A number beside its unit."""

    value: Number

    @property
    def si(self) -> float:
        """In SI units and radians."""
        return float(self.value * self.factor)


class VectorQuantity(Measured):
    """Three numbers beside their unit."""

    value: Vector

    @property
    def si(self) -> np.ndarray:
        """(3,), in SI units and radians."""
        return np.array(self.value) * self.factor


def _unit(*examples: str) -> Any:
    return Field(examples=list(examples))


class Angle(Quantity):
    """An angle."""

    LIKE = units.ANGLE
    unit: str = _unit("deg")


class Rate(Quantity):
    """An angular velocity about one axis."""

    LIKE = units.RATE
    unit: str = _unit("rad/s")


class TimeInterval(Quantity):
    """A length of time."""

    LIKE = units.SECOND
    unit: str = _unit("s")


class Length(Quantity):
    """A length."""

    LIKE = units.LENGTH
    unit: str = _unit("km")


class LengthVector(VectorQuantity):
    """A position or a displacement."""

    LIKE = units.LENGTH
    unit: str = _unit("m")


class SpeedVector(VectorQuantity):
    """A velocity."""

    LIKE = units.SPEED
    unit: str = _unit("m/s")


class AngleVector(VectorQuantity):
    """Angles about three axes."""

    LIKE = units.ANGLE
    unit: str = _unit("deg")


class RateVector(VectorQuantity):
    """Angular velocities about three axes."""

    LIKE = units.RATE
    unit: str = _unit("deg/s")


class MomentVector(VectorQuantity):
    """Three principal moments."""

    LIKE = units.MOMENT
    unit: str = _unit("kg m2")


class AccelerationVector(VectorQuantity):
    """An acceleration."""

    LIKE = units.ACCELERATION
    unit: str = _unit("m/s2")


class Mass(Quantity):
    """A mass."""

    LIKE = units.MASS
    unit: str = _unit("kg")


class Area(Quantity):
    """An area."""

    LIKE = units.AREA
    unit: str = _unit("m2")


class TorqueVector(VectorQuantity):
    """A torque."""

    LIKE = units.TORQUE
    unit: str = _unit("N m")


class ImpulseVector(VectorQuantity):
    """An impulse."""

    LIKE = units.IMPULSE
    unit: str = _unit("N s")


class AngularImpulseVector(VectorQuantity):
    """An angular impulse, or an angular momentum."""

    LIKE = units.ANGULAR_IMPULSE
    unit: str = _unit("N m s")


class DissipationCoefficient(Quantity):
    """The rate of dissipation over the momentum."""

    LIKE = units.PER_ANGULAR_IMPULSE
    unit: str = _unit("1/(N m s)")


class DipoleVector(VectorQuantity):
    """A magnetic dipole moment."""

    LIKE = units.DIPOLE
    unit: str = _unit("A m2")


class FieldStrength(Quantity):
    """A magnetic flux density."""

    LIKE = units.FIELD
    unit: str = _unit("T")


class MassDensity(Quantity):
    """A density of mass."""

    LIKE = units.DENSITY
    unit: str = _unit("kg/m3")


class GravitationalParameter(Quantity):
    """GM of a central body."""

    LIKE = units.GRAVITATIONAL_PARAMETER
    unit: str = _unit("km3/s2")


class Instant(Part):
    """A point in time: `value` in a `unit` since the epoch; or a `date` in a `scale`."""

    value: Number | None = None
    unit: str | None = Field(None, examples=["s"])
    date: str | None = Field(None, examples=["2026-01-01T00:00:00"])
    scale: iso8601.Scale | None = None

    @model_validator(mode="after")
    def _one_form(self) -> Instant:
        one_form(self, ("value", "unit"), ("date", "scale"))
        if self.value is not None and not abs(self._elapsed()) <= GREATEST:
            raise InputError("value", self.value, f"a magnitude up to {GREATEST:g} s")
        return self

    def _elapsed(self) -> float:
        return float((self.value or 0.0) * units.parse_unit(self.unit or "", units.SECOND, "unit"))

    def seconds(self, epoch: Time | None) -> float:
        """Seconds since the epoch.  Raises InputError for a date where there is none to count from."""
        if self.date is None:
            return self._elapsed()
        if epoch is None:
            raise InputError("date", self.date, "an epoch in the scene, for dates to be counted from")
        time = iso8601.parse_time(self.date, self.scale, "date")
        return float(as_instants(time, epoch, "date").seconds)


def check_positive(part: Part, *names: str) -> None:
    """Refuses quantities that are there and not greater than zero."""
    for name in names:
        quantity = getattr(part, name)
        if quantity is not None and not quantity.si > 0.0:
            raise InputError(f"{name}.value", quantity.value, "a number greater than 0")


def check_not_negative(part: Part, *names: str) -> None:
    """Refuse quantities that are there and less than zero."""
    for name in names:
        quantity = getattr(part, name)
        if quantity is not None and not quantity.si >= 0.0:
            raise InputError(f"{name}.value", quantity.value, "a number not below 0")


def unit_vector(values: list[float], field: str) -> np.ndarray:
    """(3,), of length 1, in the direction of values; InputError where they have none."""
    vector = np.array(values)
    largest = np.abs(vector).max()
    if largest == 0.0:
        raise InputError(field, values, "a direction, not zero")
    scaled = vector / largest
    return scaled / np.sqrt(scaled @ scaled)

"""Physical quantities of a document: numbers beside their unit, and instants.

Each class is one kind of quantity; its `si` is what the document says in SI units and radians.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, TypeVar

import numpy as np
from astropy import units as u
from astropy.time import Time
from pydantic import AfterValidator, Field, model_validator

from .. import units
from ..errors import InputError
from ..times import iso8601
from ..times.instants import as_instants
from .fields import Number, Part, Vector, one_form

# Products of several quantities must stay doubles; no physical quantity comes near it.
GREATEST = 1e50


class Measured(Part):
    """A value beside a unit that converts to `LIKE`, such as the example of the class."""

    LIKE: ClassVar[u.UnitBase]

    value: Any
    unit: str

    def __init_subclass__(cls, like: u.UnitBase | None = None, example: str = "", **options: Any):
        super().__init_subclass__(**options)
        if like is not None:
            cls.LIKE = like
            cls.__annotations__["unit"] = Annotated[str, Field(examples=[example])]

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
        """The value in SI units and radians."""
        return float(self.value * self.factor)


class VectorQuantity(Measured):
    """Three numbers beside their unit."""

    value: Vector

    @property
    def si(self) -> np.ndarray:
        """(3,), in SI units and radians."""
        return np.array(self.value) * self.factor


class Angle(Quantity, like=units.ANGLE, example="deg"):
    """An angle."""


class Rate(Quantity, like=units.RATE, example="rad/s"):
    """An angular velocity about one axis."""


class TimeInterval(Quantity, like=units.SECOND, example="s"):
    """A length of time."""


class Length(Quantity, like=units.LENGTH, example="km"):
    """A length."""


class LengthVector(VectorQuantity, like=units.LENGTH, example="m"):
    """A position or a displacement."""


class SpeedVector(VectorQuantity, like=units.SPEED, example="m/s"):
    """A velocity."""


class AngleVector(VectorQuantity, like=units.ANGLE, example="deg"):
    """Angles about three axes."""


class RateVector(VectorQuantity, like=units.RATE, example="deg/s"):
    """Angular velocities about three axes."""


class MomentVector(VectorQuantity, like=units.MOMENT, example="kg m2"):
    """Three principal moments."""


class AccelerationVector(VectorQuantity, like=units.ACCELERATION, example="m/s2"):
    """An acceleration."""


class Mass(Quantity, like=units.MASS, example="kg"):
    """A mass."""


class Area(Quantity, like=units.AREA, example="m2"):
    """An area."""


class TorqueVector(VectorQuantity, like=units.TORQUE, example="N m"):
    """A torque."""


class ImpulseVector(VectorQuantity, like=units.IMPULSE, example="N s"):
    """An impulse."""


class AngularImpulseVector(VectorQuantity, like=units.ANGULAR_IMPULSE, example="N m s"):
    """An angular impulse, or an angular momentum."""


class DissipationCoefficient(Quantity, like=units.PER_ANGULAR_IMPULSE, example="1/(N m s)"):
    """The rate of dissipation over the momentum."""


class DipoleVector(VectorQuantity, like=units.DIPOLE, example="A m2"):
    """A magnetic dipole moment."""


class FieldStrength(Quantity, like=units.FIELD, example="T"):
    """A magnetic flux density."""


class MassDensity(Quantity, like=units.DENSITY, example="kg/m3"):
    """A density of mass."""


class GravitationalParameter(Quantity, like=units.GRAVITATIONAL_PARAMETER, example="km3/s2"):
    """GM of a central body."""


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


AnyQuantity = TypeVar("AnyQuantity", bound=Quantity)


def above_zero(quantity: AnyQuantity) -> AnyQuantity:
    """The quantity; InputError where it is not greater than zero."""
    if not quantity.si > 0.0:
        raise InputError("value", quantity.value, "a number greater than 0")
    return quantity


def _not_below_zero(quantity: AnyQuantity) -> AnyQuantity:
    if not quantity.si >= 0.0:
        raise InputError("value", quantity.value, "a number not below 0")
    return quantity


def unit_vector(values: list[float], field: str) -> np.ndarray:
    """(3,), of length 1, in the direction of values; InputError where they have none."""
    vector = np.array(values)
    largest = np.abs(vector).max()
    if largest == 0.0:
        raise InputError(field, values, "a direction, not zero")
    scaled = vector / largest
    return scaled / np.sqrt(scaled @ scaled)


def _with_direction(values: list[float]) -> list[float]:
    unit_vector(values, "")
    return values


# Annotations of quantities in a part.
ABOVE_ZERO, NOT_BELOW_ZERO = AfterValidator(above_zero), AfterValidator(_not_below_zero)
Direction = Annotated[Vector, AfterValidator(_with_direction)]

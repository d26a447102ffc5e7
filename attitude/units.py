"""Conversion of users' quantities to SI floats, or an error that names the field."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from astropy import units as u

from .errors import InputError

MOMENT = u.kg * u.m**2
RATE = u.rad / u.s
SECOND = u.s
ANGLE = u.rad
RATIO = u.dimensionless_unscaled
LENGTH = u.m
SPEED = u.m / u.s
ACCELERATION = u.m / u.s**2
MASS = u.kg
AREA = u.m**2
TORQUE = u.N * u.m
IMPULSE = u.N * u.s
ANGULAR_IMPULSE = u.N * u.m * u.s
PER_ANGULAR_IMPULSE = 1 / (u.N * u.m * u.s)
DIPOLE = u.A * u.m**2
FIELD = u.T
DENSITY = u.kg / u.m**3
GRAVITATIONAL_PARAMETER = u.m**3 / u.s**2


def si_array(value: Any, unit: u.UnitBase, field: str) -> np.ndarray:
    """Finite float64 array in SI from a Quantity or bare numbers (taken as SI already).

    Raises InputError for a wrong dimension, for what is not a number, and for missing or
    non-finite values (naming the first).
    """
    if isinstance(value, u.Quantity):
        try:
            with np.errstate(over="ignore"):
                value = value.to_value(unit)
        except u.UnitConversionError:
            raise InputError(
                field, value.unit.to_string(), f"a unit of {unit.physical_type} ({unit})"
            ) from None
    return finite_array(value, field)


def finite_array(value: Any, field: str) -> np.ndarray:
    """Finite float64 array (always a copy, in C order)."""
    array = float_array(value, field)
    if array.size and not np.isfinite(extremes(array)).all():
        refuse_where(~np.isfinite(array), array, field, "finite numbers")
    return array


def float_array(value: Any, field: str) -> np.ndarray:
    """float64 array, a copy in C order, not checked for finite values."""
    if np.ma.is_masked(value):
        raise InputError(field, "a masked array with missing values", "a value for every element")
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iufO":  # text, dates and booleans would be converted to numbers
            raise TypeError
        return np.array(array, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError):
        raise InputError(field, value, "numbers") from None


def refuse_where(wrong: np.ndarray, values: np.ndarray, field: str, expected: str) -> None:
    """Raises InputError with the index of the first wrong element, if there is one."""
    if wrong.any():
        index = tuple(int(i) for i in np.unravel_index(int(np.argmax(wrong)), wrong.shape))
        raise InputError(field + "".join(f"[{i}]" for i in index), values[index].tolist(), expected)


def extremes(array: np.ndarray) -> tuple[float, float]:
    """Least and greatest, NaN if any is: a test for finite values that allocates nothing."""
    return float(array.min()), float(array.max())


@lru_cache(maxsize=256)
def parse_unit(name: str, like: u.UnitBase, field: str) -> float:
    """One unit `name` in SI units (or radians); InputError for a unit of another kind than `like`."""
    try:
        return float(u.Unit(name).to(like))
    except (ValueError, TypeError, u.UnitConversionError):
        kind, examples = _KINDS[like]
        raise InputError(field, name, f"a unit of {kind}, such as {examples}") from None


# Physical type of each unit, and examples.  By unit, since to astropy a torque has the type of an energy.
_KINDS = {
    MOMENT: (str(MOMENT.physical_type), '"kg m2"'),
    RATE: (str(RATE.physical_type), '"rad/s", "deg/s" or "deg/d"'),
    RATIO: ("ratio", '"%"'),
    ANGLE: ("angle", '"deg" or "rad"'),
    SECOND: ("time", '"s", "min", "h" or "d"'),
    LENGTH: ("length", '"m" or "km"'),
    SPEED: ("speed", '"m/s" or "km/s"'),
    ACCELERATION: ("acceleration", '"m/s2"'),
    MASS: ("mass", '"kg"'),
    AREA: ("area", '"m2"'),
    TORQUE: ("torque", '"N m"'),
    IMPULSE: ("impulse", '"N s"'),
    ANGULAR_IMPULSE: ("angular momentum", '"N m s"'),
    PER_ANGULAR_IMPULSE: ("inverse angular momentum", '"1/(N m s)"'),
    DIPOLE: ("magnetic moment", '"A m2"'),
    FIELD: ("magnetic flux density", '"T" or "nT"'),
    DENSITY: ("density", '"kg/m3"'),
    GRAVITATIONAL_PARAMETER: ("gravitational parameter", '"m3/s2" or "km3/s2"'),
}

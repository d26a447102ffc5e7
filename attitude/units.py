"""Where units end: what users give becomes SI floats, or an error that names the field."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from astropy import units as u

from .errors import InputError

MOMENT = u.kg * u.m**2
RATE = u.rad / u.s
SECOND = u.s


def si_array(value: Any, unit: u.UnitBase, field: str) -> np.ndarray:
    """Finite float64 array in SI from a Quantity or bare numbers (taken as SI already).

    Raises InputError for a wrong dimension, for what is not a number, and for missing or
    non-finite values (naming the first).
    """
    if isinstance(value, u.Quantity):
        try:
            value = value.to_value(unit)
        except u.UnitConversionError:
            raise InputError(
                field, value.unit.to_string(), f"a unit of {unit.physical_type} ({unit})"
            ) from None
    return finite_array(value, field)


def finite_array(value: Any, field: str) -> np.ndarray:
    """Finite float64 array (always a copy, in C order)."""
    if np.ma.is_masked(value):
        raise InputError(field, "a masked array with missing values", "a value for every element")
    try:
        array = np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise InputError(field, value, "numbers") from None
    if array.size and not np.isfinite(extremes(array)).all():
        place = tuple(int(i[0]) for i in np.nonzero(~np.isfinite(array)))
        where = field + "".join(f"[{i}]" for i in place)
        raise InputError(where, float(array[place]), "finite numbers")
    return array


def extremes(array: np.ndarray) -> tuple[float, float]:
    """Least and greatest, NaN if any is: a test for finiteness that allocates nothing."""
    return float(array.min()), float(array.max())


@lru_cache(maxsize=256)
def parse_unit(name: str, like: u.UnitBase, field: str) -> float:
    """How many SI units (or radians) one `name` is; refuses what is no unit of that kind."""
    try:
        return float(u.Unit(name).to(like))
    except (ValueError, TypeError, u.UnitConversionError):
        kind = str(like.physical_type)
        raise InputError(field, name, f"a unit of {kind}, such as {_EXAMPLES[kind]}") from None


_EXAMPLES = {
    str(MOMENT.physical_type): '"kg m2"',
    str(RATE.physical_type): '"rad/s", "deg/s" or "deg/d"',
    str(u.rad.physical_type): '"deg" or "rad"',
    str(SECOND.physical_type): '"s", "min", "h" or "d"',
}

"""Conversion of users' quantities to SI floats, or an error that names the field."""

from __future__ import annotations

import re
import warnings
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from astropy import units as u

from .errors import InputError, suggestion

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
# Units in which spinners and older mass properties are stated, and which astropy does not know unasked.
CUSTOMARY_UNITS = {
    "rpm": u.cycle / u.min,
    "RPM": u.cycle / u.min,
    "rps": u.cycle / u.s,
    "rev": u.cycle,
    "revolution": u.cycle,
    "turn": u.cycle,
    "lb": u.Unit(0.45359237 * u.kg),
    "lbm": u.Unit(0.45359237 * u.kg),
    "lbf": u.Unit(4.4482216152605 * u.N),
    "slug": u.Unit(4.4482216152605 / 0.3048 * u.kg),  # lbf s2/ft
    "oz": u.Unit(0.028349523125 * u.kg),
    "ft": u.Unit(0.3048 * u.m),
    "in": u.Unit(0.0254 * u.m),
    "inch": u.Unit(0.0254 * u.m),
    "sec": u.s,
}
# How units are typeset: kg·m², slug-ft2, deg s⁻¹.
TYPESET = str.maketrans("·⋅×⁻⁰¹²³⁴", "   -01234")
FACTOR = r"([A-Za-z%]+)(?:\^|\*\*)?(-?\d+)?"  # a word and its power


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
        if isinstance(name, str) and len(name) > 100:
            raise ValueError(name)  # astropy takes seconds to parse 200,000 factors
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", u.UnitsWarning)  # of the style of m/s/s
            return float(_unit(name).to(like))
    except (ValueError, TypeError, OverflowError) as error:
        kind, examples, others = KINDS[like]
        known = [*re.findall('"(.+?)"', examples), *filter(None, others.split(", "))]
        meant = "" if isinstance(error, u.UnitConversionError) else suggestion(name, known)
        raise InputError(field, name, f"a unit of {kind}, such as {examples}{meant}") from None


def positive_quantity(text: str, like: tuple[u.UnitBase, str], field: str, expected: str) -> float:
    """SI units, above 0, of a number and a unit such as "10 min"; without a unit in that of `like`."""
    match = re.fullmatch(r"\s*([-+.\deE]+)\s*([a-zA-Z/]*)\s*", text)
    try:
        value = float(match[1]) * parse_unit(match[2] or like[1], like[0], field) if match else 0.0
    except ValueError:  # of InputError too: the unit is none
        value = 0.0
    if not 0.0 < value < np.inf:
        raise InputError(field, text, expected)
    return value


def _unit(name: str) -> u.UnitBase:
    """Unit of a name of astropy's, or of factors among which are CUSTOMARY_UNITS.

    These are not enabled in astropy itself, where they would be for all code of the process.
    """
    if isinstance(name, str):
        name = re.sub(r"(?<=[A-Za-z])-(?=[A-Za-z])", " ", name.translate(TYPESET))
    try:
        return u.Unit(name)
    except ValueError:
        if not isinstance(name, str) or not re.fullmatch(rf"{FACTOR}(?:(?:[ .*]|\s*/\s*){FACTOR})*", name):
            raise
    unit = u.dimensionless_unscaled
    numerator, *denominators = name.split("/")
    if any(len(re.findall(FACTOR, part)) > 1 for part in denominators):
        raise ValueError(f"{name}: several factors after a slash")
    for part, sign in ((numerator, 1), *((part, -1) for part in denominators)):
        for word, power in re.findall(FACTOR, part):
            unit *= (CUSTOMARY_UNITS.get(word) or u.Unit(word)) ** (sign * int(power or 1))
    return unit


class UnitKind(NamedTuple):
    """The physical type of a unit, examples, and others that are suggested for what is like them."""

    name: str
    examples: str
    others: str = ""


# By unit, since to astropy a torque has the type of an energy.
KINDS = {
    MOMENT: UnitKind(
        "moment of inertia",
        '"kg m2"',
        "g cm2, kg cm2, kg mm2, lb ft2, lb in2, slug ft2, oz in2, lbf ft s2, lbf in s2",
    ),
    RATE: UnitKind(
        str(RATE.physical_type),
        '"rad/s", "deg/s" or "deg/d"',
        "rpm, rev/s, rev/min, rev/d, deg/min, deg/h, arcsec/s, mrad/s, rad/d, cycle/s",
    ),
    RATIO: UnitKind("ratio", '"%"'),
    ANGLE: UnitKind("angle", '"deg" or "rad"', "arcmin, arcsec, mrad, rev"),
    SECOND: UnitKind("time", '"s", "min", "h" or "d"'),
    LENGTH: UnitKind("length", '"m" or "km"', "cm, mm, ft, in, au"),
    SPEED: UnitKind("speed", '"m/s" or "km/s"'),
    ACCELERATION: UnitKind("acceleration", '"m/s2"'),
    MASS: UnitKind("mass", '"kg"', "g, t, lb, slug"),
    AREA: UnitKind("area", '"m2"'),
    TORQUE: UnitKind("torque", '"N m"', "mN m, uN m, lbf ft, lbf in, kg m2/s2"),
    IMPULSE: UnitKind("impulse", '"N s"'),
    ANGULAR_IMPULSE: UnitKind("angular momentum", '"N m s"'),
    PER_ANGULAR_IMPULSE: UnitKind("inverse angular momentum", '"1/(N m s)"'),
    DIPOLE: UnitKind("magnetic moment", '"A m2"'),
    FIELD: UnitKind("magnetic flux density", '"T" or "nT"'),
    DENSITY: UnitKind("density", '"kg/m3"'),
    GRAVITATIONAL_PARAMETER: UnitKind("gravitational parameter", '"m3/s2" or "km3/s2"'),
}

"""Columns that users choose for tables: parts of the ephemeris, and what follows from them, in degrees."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from ..errors import InputError, RegimeError, suggestion
from ..frames import rotations
from ..samples.ephemeris_data import EphemerisData
from . import targets
from .spin_state import spin_state

# What may be asked for, and what it means.
KINDS = {
    "time": "dates",
    "elapsed": "seconds since the epoch",
    "quaternion": "wxyz, body to frame",
    "angular_velocity": "rad/s, body axes",
    "angular_momentum": "N m s, along the axes of the frame",
    "position": "m, of the centre of mass where it was followed, else of the orbit",
    "velocity": "m/s, likewise",
    "euler:SEQUENCE": "angles of intrinsic rotations, such as euler:ZYX, deg",
    "radec:AXIS": "right ascension and declination of a body axis, ICRS, deg",
    "direction:AXIS": "unit vector of a body axis along the axes of the frame",
    "direction_to:TARGET": "unit vector to sun, nadir, velocity ... along the axes of the frame",
    "angle:AXIS:TARGET": "to sun, nadir, velocity, orbit_normal, momentum or magnetic_field, deg",
    "attitude_sigma": "1 sigma of the small rotation about each body axis, deg",
    "angular_velocity_sigma": "1 sigma of each component, rad/s",
    "attitude_covariance": "of the small rotation about the body axes: xx, yy, zz, xy, xz, yz, rad2",
    "angular_velocity_covariance": "of the components: xx, yy, zz, xy, xz, yz, rad2/s2",
    "direction_sigma:AXIS": "1 sigma of a body axis's direction, where it is greatest, deg",
    "euler_sigma:SEQUENCE": "1 sigma of each of the Euler angles, deg",
    "spin": "of the angular momentum and about the body's z axis, deg and deg/s",
}
AXES = {f"{sign}{axis}": f"{'minus_' if sign == '-' else ''}{axis}" for sign in ("", "-") for axis in "xyz"}
WORDS = {  # that stand for those in capitals
    "AXIS": tuple(AXES),
    "TARGET": targets.NAMES,
    "SEQUENCE": tuple(f"{a}{b}{c}" for a, b, c in product("XYZ", repeat=3) if a != b != c),
}
# Every request that there is, by name.
REQUESTS = tuple(
    ":".join([kind, *words])
    for kind, *places in (name.split(":") for name in KINDS)
    for words in product(*(WORDS[place] for place in places))
)
ELEMENTS = ("xx", "yy", "zz", "xy", "xz", "yz")  # of a covariance, and where they are in it
INDICES = (..., (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2))
COVARIANCES = (
    "attitude_sigma",
    "angular_velocity_sigma",
    "attitude_covariance",
    "angular_velocity_covariance",
)
SPIN = dict.fromkeys(("ra", "dec", "nutation", "precession", "phase"), "deg") | {"rate": "deg/s"}


# What tables of an ephemeris with an uncertainty hold besides, where nothing else is chosen.
UNCERTAINTY = (
    "attitude_covariance",
    "angular_velocity_covariance",
    *(f"direction_sigma:{axis}" for axis in "xyz"),
)


class VectorColumn(NamedTuple):
    """Columns that belong together.

    label : of all of them
    names : of each, with its unit
    unit : of all; "" for none
    values : (..., k)
    """

    label: str
    names: tuple[str, ...]
    unit: str
    values: np.ndarray


def parse(text: str | Sequence[str]) -> tuple[str, ...]:
    """The requests of a list, or of a text with commas; InputError for what is none, or there twice."""
    requests = [part.strip() for part in text.split(",")] if isinstance(text, str) else list(text)
    requests = [request.replace(":+", ":") for request in requests]  # an axis "+x" is the axis "x"
    for i, request in enumerate(requests):
        if request not in REQUESTS:
            expected = f"each of {', '.join(KINDS)}{suggestion(request, REQUESTS)}"
            raise InputError("columns", request, expected)
        if request in requests[:i]:
            raise InputError("columns", request, "each once")
    return tuple(requests)


class Derived(NamedTuple):
    """Columns that an ephemeris does not hold itself.

    endings : of their names, after the label
    unit : of all; values : (..., k), of the ephemeris and of what the request names
    """

    endings: tuple[str, ...]
    unit: str
    values: Callable[..., np.ndarray]


def sigma(covariance: np.ndarray) -> np.ndarray:
    """Standard deviations (..., k) of a covariance (..., k, k)."""
    return np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))


def euler_sigma(data: EphemerisData, sequence: str) -> np.ndarray:
    """(..., 3) rad: 1 sigma of Euler angles, to first order; RegimeError where two are undetermined."""
    covariance, q = data.attitude_covariance, data.quaternion("wxyz")
    angles = rotations.euler_angles(q, sequence)
    axes = np.eye(3)[["XYZ".index(letter) for letter in sequence]]
    # body components of the axes that the angles turn about: the first two stand before other rotations
    after_first = rotations.product(
        rotations.conjugate(rotations.from_euler(sequence[0], angles[..., :1])), q
    )
    last = rotations.from_euler(sequence[2], angles[..., 2:])
    columns = [
        rotations.rotate(rotations.conjugate(turn), axis)
        for turn, axis in zip((after_first, last), axes, strict=False)
    ]
    matrix = np.stack([*columns, np.broadcast_to(axes[2], columns[0].shape)], axis=-1)
    if (np.abs(np.linalg.det(matrix)) < 1e-9).any():  # sine of the second angle, or its cosine
        raise RegimeError(f"euler_sigma:{sequence}: where the second angle leaves the others undetermined")
    by_attitude = np.linalg.inv(matrix)
    variance = np.einsum("...ij,...jk,...ik->...i", by_attitude, covariance, by_attitude)
    return np.sqrt(np.maximum(variance, 0.0))


DERIVED = {
    "euler": Derived(
        ("_1_deg", "_2_deg", "_3_deg"),
        "deg",
        lambda data, sequence: np.rad2deg(rotations.euler_angles(data.quaternion("wxyz"), sequence)),
    ),
    "euler_sigma": Derived(
        ("_1_deg", "_2_deg", "_3_deg"),
        "deg",
        lambda data, sequence: np.rad2deg(euler_sigma(data, sequence)),
    ),
    "direction": Derived(("_x", "_y", "_z"), "", targets.direction),
    "direction_to": Derived(("_x", "_y", "_z"), "", targets.target),
    "direction_sigma": Derived(
        ("_deg",),
        "deg",
        lambda data, axis: np.rad2deg(data.direction_sigma(targets.body_axis(axis, "axis")))[..., None],
    ),
    "angle": Derived(
        ("_deg",), "deg", lambda data, axis, to: np.rad2deg(targets.angle(data, axis, to))[..., None]
    ),
    "attitude_sigma": Derived(
        ("_x_deg", "_y_deg", "_z_deg"), "deg", lambda data: np.rad2deg(sigma(data.attitude_covariance))
    ),
    "angular_velocity_sigma": Derived(
        ("_x_rad_s", "_y_rad_s", "_z_rad_s"), "rad/s", lambda data: sigma(data.rate_covariance)
    ),
    "attitude_covariance": Derived(
        tuple(f"_{element}_rad2" for element in ELEMENTS),
        "rad2",
        lambda data: data.attitude_covariance[INDICES],
    ),
    "angular_velocity_covariance": Derived(
        tuple(f"_{element}_rad2_s2" for element in ELEMENTS),
        "rad2/s2",
        lambda data: data.rate_covariance[INDICES],
    ),
}


def layout(request: str) -> tuple[tuple[str, tuple[str, ...], str], ...]:
    """Label, names and unit of each of a request's `VectorColumn`s, none of one that is not `derived`."""
    kind, *parts = request.split(":")
    if kind == "spin":
        names = {name: f"spin_{name}_{unit.replace('/', '_')}" for name, unit in SPIN.items()}
        return tuple((f"spin_{name}", (names[name],), unit) for name, unit in SPIN.items())
    label = "_".join([kind, *(AXES.get(part, part.lower()) for part in parts)])
    if kind == "radec":
        both = (label.replace(kind, name) for name in ("ra", "dec"))
        return tuple((name, (f"{name}_deg",), "deg") for name in both)
    if kind not in DERIVED:
        return ()
    derived_columns = DERIVED[kind]
    names_of = tuple(label + ending for ending in derived_columns.endings)
    return ((label, names_of, derived_columns.unit),)


def derived(data: EphemerisData, request: str) -> Iterator[VectorColumn]:
    """The columns of a request that the ephemeris does not hold itself.

    Raises RegimeError or InputError where it lacks what they need: an orbit, dates, inertia ...
    """
    kind, *parts = request.split(":")
    if kind == "spin":
        values = [np.rad2deg(each)[..., None] for each in spin_state(data)]
    elif kind == "radec":
        values = [np.rad2deg(each)[..., None] for each in targets.radec(data, parts[0])]
    else:
        values = [DERIVED[kind].values(data, *parts)] if kind in DERIVED else []
    for description, array in zip(layout(request), values, strict=True):
        yield VectorColumn(*description, array)

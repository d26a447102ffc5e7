"""Columns that users choose for tables: parts of the ephemeris, and what follows from them, in degrees."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
    "direction_to:TARGET": "unit vector to sun, earth, velocity ... along the axes of the frame",
    "angle:AXIS:TARGET": "to sun, earth, velocity, orbit_normal, momentum or magnetic_field, deg",
    "attitude_sigma": "1 sigma of the small rotation about each body axis, deg",
    "angular_velocity_sigma": "1 sigma of each component, rad/s",
    "attitude_covariance": "of the small rotation about the body axes: xx, yy, zz, xy, xz, yz, rad2",
    "angular_velocity_covariance": "of the components: xx, yy, zz, xy, xz, yz, rad2/s2",
    "direction_sigma:AXIS": "1 sigma of a body axis's direction, where it is greatest, deg",
    "euler_sigma:SEQUENCE": "1 sigma of each of the Euler angles, deg",
    "spin": "of the angular momentum and about the body's z axis, deg and deg/s",
}
AXES = {f"{sign}{axis}": f"{'minus_' if sign == '-' else ''}{axis}" for sign in ("", "-") for axis in "xyz"}
SEQUENCES = tuple(f"{a}{b}{c}" for a, b, c in product("XYZ", repeat=3) if a != b != c)
# Elements of what follows from a covariance, and its unit in names and of tables.
ELEMENTS = ("xx", "yy", "zz", "xy", "xz", "yz")
COVARIANCES = {
    "attitude_sigma": ("xyz", ("deg", "deg")),
    "angular_velocity_sigma": ("xyz", ("rad_s", "rad/s")),
    "attitude_covariance": (ELEMENTS, ("rad2", "rad2")),
    "angular_velocity_covariance": (ELEMENTS, ("rad2_s2", "rad2/s2")),
}
LEAST_SINE = 1e-9  # of the second Euler angle, or its cosine: below it the others are undetermined
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


# Every request that there is, by name.
REQUESTS = (
    *(kind for kind in KINDS if ":" not in kind),
    *(f"{kind}:{sequence}" for kind in ("euler", "euler_sigma") for sequence in SEQUENCES),
    *(f"{kind}:{axis}" for kind in ("radec", "direction", "direction_sigma") for axis in AXES),
    *(f"direction_to:{target}" for target in targets.TARGETS),
    *(f"angle:{axis}:{target}" for axis in AXES for target in targets.TARGETS),
)


def parse(text: str | Sequence[str]) -> tuple[str, ...]:
    """The requests of a list, or of a text with commas; InputError for what is none, or there twice."""
    requests = [part.strip() for part in text.split(",")] if isinstance(text, str) else list(text)
    for i, request in enumerate(requests):
        if request not in REQUESTS:
            expected = f"each of {', '.join(KINDS)}{suggestion(request, REQUESTS)}"
            raise InputError("columns", request, expected)
        if request in requests[:i]:
            raise InputError("columns", request, "each once")
    return tuple(requests)


def layout(request: str) -> tuple[tuple[str, tuple[str, ...], str], ...]:
    """Label, names and unit of each of a request's `VectorColumn`s, none of one that is not `derived`."""
    kind, *parts = request.split(":")
    label = f"{kind}_{AXES.get(parts[0], parts[0].lower())}" if parts else kind
    if kind == "spin":
        names = {name: f"spin_{name}_{unit.replace('/', '_')}" for name, unit in SPIN.items()}
        return tuple((f"spin_{name}", (names[name],), unit) for name, unit in SPIN.items())
    if kind in COVARIANCES:
        elements, (name, unit) = COVARIANCES[kind]
        return ((label, tuple(f"{label}_{element}_{name}" for element in elements), unit),)
    if kind == "radec":
        both = (label.replace(kind, name) for name in ("ra", "dec"))
        return tuple((name, (f"{name}_deg",), "deg") for name in both)
    target = "_".join([label, *parts[1:]])
    one = {
        "euler": (label, tuple(f"{label}_{i}_deg" for i in (1, 2, 3)), "deg"),
        "euler_sigma": (label, tuple(f"{label}_{i}_deg" for i in (1, 2, 3)), "deg"),
        "direction": (label, tuple(f"{label}_{axis}" for axis in "xyz"), ""),
        "direction_to": (label, tuple(f"{label}_{axis}" for axis in "xyz"), ""),
        "direction_sigma": (label, (f"{label}_deg",), "deg"),
        "angle": (target, (f"{target}_deg",), "deg"),
    }
    return (one[kind],) if kind in one else ()


def derived(data: EphemerisData, request: str) -> Iterator[VectorColumn]:
    """The columns of a request that the ephemeris does not hold itself.

    Raises RegimeError or InputError where it lacks what they need: an orbit, dates, inertia ...
    """
    kind, *parts = request.split(":")
    if kind == "euler":
        values = [np.rad2deg(rotations.euler_angles(data.quaternion("wxyz"), parts[0]))]
    elif kind == "euler_sigma":
        values = [np.rad2deg(_euler_sigma(data, parts[0]))]
    elif kind == "radec":
        values = [np.rad2deg(each)[..., None] for each in targets.radec(data, parts[0])]
    elif kind == "direction":
        values = [targets.direction(data, parts[0])]
    elif kind == "direction_to":
        values = [targets.target(data, parts[0])]
    elif kind == "direction_sigma":
        values = [np.rad2deg(data.direction_sigma(targets.body_axis(parts[0], "axis")))[..., None]]
    elif kind in COVARIANCES:
        values = [_of_covariance(data, kind)]
    elif kind == "angle":
        values = [np.rad2deg(targets.angle(data, *parts))[..., None]]
    else:
        values = [np.rad2deg(each)[..., None] for each in spin_state(data)] if kind == "spin" else []
    for description, array in zip(layout(request), values, strict=True):
        yield VectorColumn(*description, array)


def _euler_sigma(data: EphemerisData, sequence: str) -> np.ndarray:
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
    if (np.abs(np.linalg.det(matrix)) < LEAST_SINE).any():
        raise RegimeError(f"euler_sigma:{sequence}: where the second angle leaves the others undetermined")
    by_attitude = np.linalg.inv(matrix)
    variance = np.einsum("...ij,...jk,...ik->...i", by_attitude, covariance, by_attitude)
    return np.sqrt(np.maximum(variance, 0.0))


def _of_covariance(data: EphemerisData, kind: str) -> np.ndarray:
    """Standard deviations (..., 3), or elements (..., 6), of the attitude's or the rate's covariance."""
    covariance = data.attitude_covariance if kind.startswith("attitude") else data.rate_covariance
    if kind.endswith("covariance"):
        return covariance[..., (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
    sigma = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    return np.rad2deg(sigma) if kind == "attitude_sigma" else sigma

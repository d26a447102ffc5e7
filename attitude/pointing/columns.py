"""Columns that users choose for tables: parts of the ephemeris, and what follows from them, in degrees."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..errors import InputError
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
    "direction:AXIS": "unit vector of a body axis along the axes of the frame",
    "angle:AXIS:TARGET": "angle from a body axis to sun, earth, velocity, momentum or magnetic_field, deg",
    "spin": "of the angular momentum and about the body's z axis, deg and deg/s",
}
AXES = {f"{sign}{axis}": f"{'minus_' if sign == '-' else ''}{axis}" for sign in ("", "-") for axis in "xyz"}
SPIN = ("ra", "dec", "nutation", "precession", "phase", "rate")


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
    for i, request in enumerate(requests):
        if not isinstance(request, str) or not _is_known(request) or request in requests[:i]:
            raise InputError("columns", request, f"each once, of {', '.join(KINDS)}")
    return tuple(requests)


def _is_known(request: str) -> bool:
    kind, *parts = request.split(":")
    if kind == "euler":
        return len(parts) == 1 and bool(re.fullmatch(r"(?!.*(.)\1)[XYZ]{3}", parts[0]))
    if kind == "direction":
        return len(parts) == 1 and parts[0] in AXES
    if kind == "angle":
        return len(parts) == 2 and parts[0] in AXES and parts[1] in targets.TARGETS
    return not parts and kind in KINDS


def derived(data: EphemerisData, request: str) -> Iterator[VectorColumn]:
    """The columns of a request that the ephemeris does not hold itself.

    Raises RegimeError or InputError where it lacks what they need: an orbit, dates, inertia ...
    """
    kind, *parts = request.split(":")
    if kind == "euler":
        angles = np.rad2deg(rotations.euler_angles(data.quaternion("wxyz"), parts[0]))
        label = f"euler_{parts[0].lower()}"
        yield VectorColumn(label, tuple(f"{label}_{i}_deg" for i in (1, 2, 3)), "deg", angles)
    elif kind == "direction":
        label = f"direction_{AXES[parts[0]]}"
        names = tuple(f"{label}_{axis}" for axis in "xyz")
        yield VectorColumn(label, names, "", targets.direction(data, parts[0]))
    elif kind == "angle":
        label = f"angle_{AXES[parts[0]]}_{parts[1]}"
        angle = np.rad2deg(targets.angle(data, *parts))
        yield VectorColumn(label, (f"{label}_deg",), "deg", angle[..., None])
    elif kind == "spin":
        for name, values in zip(SPIN, spin_state(data), strict=True):
            unit = ("deg/s", "_deg_s") if name == "rate" else ("deg", "_deg")
            label = f"spin_{name}"
            yield VectorColumn(label, (f"{label}{unit[1]}",), unit[0], np.rad2deg(values)[..., None])

"""Directions that an angle is measured to: Sun, Earth, velocity, momentum, field, a vector, a body axis."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .. import units
from ..errors import InputError, RegimeError, suggestion
from ..frames import rotations
from ..frames.celestial import dipole_field, sun_at
from ..frames.rotations import ORBITAL_FRAMES
from ..samples.ephemeris_data import EphemerisData
from ..samples.transform import in_frame, rotation_between

AXES = {"x": 0, "y": 1, "z": 2}
AXIS = '"x", "y", "z", "-x", "-y", "-z", or a vector of three numbers along the body axes'


def body_axis(axis: Any, field: str = "body_axis") -> np.ndarray:
    """(3,) unit vector along the body axes; InputError for what is no axis."""
    if isinstance(axis, str):
        name = axis.lower().lstrip("+-")
        if name not in AXES or len(axis) - len(name) > 1:
            raise InputError(field, axis, AXIS)
        vector = np.zeros(3)
        vector[AXES[name]] = -1.0 if axis.startswith("-") else 1.0
        return vector
    return unit_vector(axis, field, AXIS)


def unit_vector(value: Any, field: str, expected: str) -> np.ndarray:
    """(3,) unit vector of three numbers that are not all zero; InputError for others."""
    vector = units.finite_array(value, field)
    with np.errstate(over="ignore"):  # whose length no double holds is refused
        size = float(np.sqrt((vector**2).sum())) if vector.shape == (3,) else 0.0
    if not 0.0 < size < np.inf:
        raise InputError(field, value, expected)
    return vector / size


def direction(data: EphemerisData, axis: Any) -> np.ndarray:
    """(..., 3) unit vectors of a body axis along the axes of the ephemeris's frame."""
    return rotations.rotate(data.quaternion("wxyz"), body_axis(axis))


def radec(data: EphemerisData, axis: Any) -> tuple[np.ndarray, np.ndarray]:
    """Right ascension, from 0 to a turn, and declination of a body axis in the ICRS, (...,) rad each."""
    x, y, z = np.moveaxis(direction(in_frame(data, "ICRF"), axis), -1, 0)
    return np.arctan2(y, x) % (2.0 * np.pi), np.arctan2(z, np.hypot(x, y))


def target(data: EphemerisData, to: Any) -> np.ndarray:
    """(..., 3) unit vectors to a target along the axes of the ephemeris's frame; `to` of `target_vector`."""
    vectors = unit_vectors(target_vector(data, to), f"the direction of {to!r:.40}")
    return np.broadcast_to(vectors, (*data.shape, 3))


def target_vector(data: EphemerisData, to: Any) -> np.ndarray:
    """Vectors (3,), (instants, 3) or (..., 3) to a target along the axes of the ephemeris's frame, SI units.

    to : "sun", "nadir" (or "earth"), "velocity", "orbit_normal", "momentum", "magnetic_field"; a direction of
        three numbers along the axes of the frame; {"body_axis": axis}; {"position": (3,) m, along the axes of
        the frame, from the central body}

    Raises
    ------
    InputError : another target; one that needs a date where there is no epoch.
    RegimeError : one that needs an orbit, is not known in the axes of an orbit, or has no direction, as the
        momentum at rest.
    """
    if isinstance(to, str):
        if to not in NAMES:
            known = f"one of {', '.join(NAMES)}, a direction, a body axis or a position"
            raise InputError("to", to, known + suggestion(to, NAMES))
        return TARGETS[SYNONYMS.get(to, to)](data)
    if isinstance(to, dict) and set(to) == {"body_axis"}:
        return direction(data, to["body_axis"])
    if isinstance(to, dict) and set(to) == {"position"}:
        place = np.asarray(units.si_array(to["position"], units.LENGTH, "to.position"))
        return np.asarray(place - position(data))
    return unit_vector(to, "to", f"one of {', '.join(NAMES)}, or a direction of three numbers")


def unit_vectors(vectors: np.ndarray, noun: str) -> np.ndarray:
    """Vectors (..., 3), each divided by its length, whatever its magnitude; RegimeError for a zero one."""
    greatest = np.abs(vectors).max(axis=-1, keepdims=True)
    if not greatest.all():
        raise RegimeError(f"{noun} is not defined where its vector is zero")
    scaled = vectors / greatest
    return np.asarray(scaled / np.linalg.norm(scaled, axis=-1, keepdims=True))


def angle(data: EphemerisData, axis: Any, to: Any) -> np.ndarray:
    """(...,) rad between a body axis and a target; of vectors, so that small angles keep their digits."""
    return angle_between(direction(data, axis), target(data, to))


def angle_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(...,) rad between unit vectors (..., 3), broadcast."""
    across = np.sqrt((np.cross(a, b) ** 2).sum(axis=-1))
    return np.asarray(np.arctan2(across, (a * b).sum(axis=-1)))


# -- where the body is, and what is seen from there ------------------------------------------------


def orbit_state(data: EphemerisData) -> tuple[np.ndarray, np.ndarray]:
    """Position (..., 3), m, and inertial velocity, m/s, of the orbit, along the axes of the frame."""
    if data.orbit is None:
        raise RegimeError(
            "orbit: this ephemeris is of no scene that has an orbit (`attitude plot --orbit FILE` adds one)"
        )
    vectors = data.orbit.state(data.instants.flattened())
    return _in_frame(data, vectors[0], data.orbit.frame), _in_frame(data, vectors[1], data.orbit.frame)


def position(data: EphemerisData) -> np.ndarray:
    """(..., 3) m of the orbit, from the central body along the axes of the frame."""
    return orbit_state(data)[0]


def sun(data: EphemerisData) -> np.ndarray:
    """(..., 3) m to the Sun: from the body where an orbit about the Earth is known, else from the Earth."""
    vectors = sun_from_centre(data)
    return vectors if data.orbit is None else np.asarray(vectors - position(data))


def sun_from_centre(data: EphemerisData) -> np.ndarray:
    """(..., 3) m from the Earth, about which the body is in orbit where an orbit is known, to the Sun."""
    if data.epoch is None:
        raise InputError("epoch", None, "a date, for the position of the Sun")
    if data.orbit is not None and not data.orbit.is_about_the_earth:
        raise RegimeError(
            "sun: the central body of this orbit is not the Earth, so the Sun's place is unknown"
        )
    return _in_frame(data, sun_at(data.instants.flattened()), "GCRF")


def orbit_normal(data: EphemerisData) -> np.ndarray:
    """(..., 3) m2/s, the orbital momentum over the mass."""
    return np.cross(*orbit_state(data))


def magnetic_field(data: EphemerisData) -> np.ndarray:
    """(..., 3) T, the field of the Earth's dipole at the body."""
    if data.orbit is not None and not data.orbit.is_about_the_earth:
        raise RegimeError("magnetic_field: the field of a central body that is not the Earth is unknown")
    place = position(data)
    to_itrf = rotation_between(data.frame, "ITRF", data.instants, data.ut1)
    turn = np.array([1.0, 0, 0, 0]) if to_itrf is None else to_itrf.quaternion
    return rotations.rotate(rotations.conjugate(turn), dipole_field(rotations.rotate(turn, place)))


def momentum(data: EphemerisData) -> np.ndarray:
    """(..., 3) kg m2 rad/s; RegimeError in a frame that turns, and without inertia."""
    return np.asarray(data.angular_momentum)


TARGETS: dict[str, Callable[[EphemerisData], np.ndarray]] = {
    "sun": sun,
    "earth": lambda data: -position(data),
    "velocity": lambda data: orbit_state(data)[1],
    "orbit_normal": orbit_normal,
    "momentum": momentum,
    "magnetic_field": magnetic_field,
}
SYNONYMS = {"nadir": "earth"}  # whatever the central body is
NAMES = (*TARGETS, *SYNONYMS)


def _in_frame(data: EphemerisData, vectors: np.ndarray, frame: str) -> np.ndarray:
    """Vectors (n, 3) along the axes of a frame, as (instants, 3) along those of the ephemeris."""
    if data.frame in ORBITAL_FRAMES:
        raise RegimeError(
            f"to: targets are not known along the axes of {data.frame}; ask the original ephemeris"
        )
    vectors = vectors.reshape(*data.instants.shape, 3)
    rotation = rotation_between(frame, data.frame, data.instants, data.ut1)
    return vectors if rotation is None else rotations.rotate(rotation.quaternion, vectors)

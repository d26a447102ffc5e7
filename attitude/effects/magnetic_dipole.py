"""A residual magnetic dipole in the field of the central body."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np

from ..documents.fields import Part
from ..documents.quantities import ABOVE_ZERO, Angle, DipoleVector, FieldStrength, Length, Rate
from ..errors import InputError
from ..frames.celestial import G10, G11, H11, REFERENCE_RADIUS
from ..kernels.layout import EffectCode
from ..orbit.path_states import least_distance, normals
from ..problem.initial_state import InitialState
from ..times import turn_rates
from . import central_body_rotation
from .effect import Torque, required_orbit_path, row

NO_ANGLE = Angle(value=0.0, unit="deg")


class RotatingDipole(NamedTuple):
    """The central body's dipole, fixed in the rotating body.

    Attributes
    ----------
    strength : T m3, field at the magnetic equator times the cube of the distance
    direction : (3,) of the dipole, from its south-seeking pole, in axes that rotate with the body, z its pole
    turns : rotation, turns/s in two parts
    """

    strength: float
    direction: np.ndarray
    turns: tuple[float, float]


class DipoleField(Part):
    """A dipole's field: `strength` at the magnetic equator of a sphere of this `radius`.

    The axis through the pole at which the field points inwards (the Earth's is in the north) is `tilt`
    away from the axis of rotation, at an eastern `longitude`; `rotation` is the body's, the Earth's if
    left out.
    """

    strength: Annotated[FieldStrength, ABOVE_ZERO]
    radius: Annotated[Length, ABOVE_ZERO]
    tilt: Angle = NO_ANGLE
    longitude: Angle = NO_ANGLE
    rotation: Rate | None = None

    def source(self) -> RotatingDipole:
        """Return the dipole in SI units."""
        tilt, longitude = self.tilt.si, self.longitude.si
        equatorial = math.sin(tilt)
        inwards = [equatorial * math.cos(longitude), equatorial * math.sin(longitude), math.cos(tilt)]
        rotation = self.rotation
        turns = central_body_rotation.earth_turns() if rotation is None else turn_rates.turns(rotation.si)
        return RotatingDipole(self.strength.si * self.radius.si**3, -np.array(inwards), turns)


class MagneticDipole(Torque):
    """`{"type": "magnetic_dipole", "dipole": {"value": [0, 0, 1], "unit": "A m2"}}`: torque dipole x B.

    B is that of a tilted dipole which rotates with the central body: the Earth's of IGRF-14 at 2025.0, whose
    other terms are a tenth of it at low orbits; or `field`.  The longitude at the epoch is the
    Earth rotation angle (0 where the scene has no epoch).
    """

    NEEDS_ORBIT: ClassVar[bool] = True

    type: Literal["magnetic_dipole"]
    dipole: DipoleVector
    field: DipoleField | None = None

    def check(self, initial_state: InitialState) -> None:
        """Refuse a central body whose field is not known."""
        central = initial_state.central_body
        if self.field is None and central is not None and not central.is_earth:
            raise InputError("field", None, "the field of the central body, which is not the Earth")

    def source(self) -> RotatingDipole:
        """Return the dipole of the central body."""
        if self.field is not None:
            return self.field.source()
        gauss = np.array([G11, H11, G10])
        size = float(np.linalg.norm(gauss))
        return RotatingDipole(size * REFERENCE_RADIUS**3, gauss / size, central_body_rotation.earth_turns())

    def rows(self, initial_state: InitialState) -> np.ndarray:
        """One row: the body's dipole, and the central body's as a function of time."""
        strength, direction, turns = self.source()
        x, y, pole = central_body_rotation.equator(initial_state)
        angle = central_body_rotation.longitude_of_x(initial_state)
        c, s = math.cos(angle), math.sin(angle)
        at_epoch = np.array([c * direction[0] - s * direction[1], s * direction[0] + c * direction[1]])
        a = direction[2] * pole
        b = at_epoch[0] * x + at_epoch[1] * y
        dipole = initial_state.axes @ self.dipole.si
        return row(EffectCode.MAGNETIC, dipole, strength, a, b, np.cross(pole, b), turns)[None]

    def size(self, initial_state: InitialState) -> float:
        """Dipole times field at the least distance of the orbit and its highest magnetic latitude, N m."""
        orbit_path = required_orbit_path(initial_state)
        strength, direction, _ = self.source()
        pole = central_body_rotation.equator(initial_state)[2]
        latitude = _max_magnetic_latitude(normals(orbit_path) @ pole, direction)
        shape = math.sqrt(1.0 + 3.0 * math.sin(latitude) ** 2)
        field = strength / least_distance(orbit_path) ** 3 * shape
        return float(np.linalg.norm(self.dipole.si)) * field


def _max_magnetic_latitude(polar: np.ndarray, direction: np.ndarray) -> float:
    """rad; polar (n,) cosines between orbit normal and pole.

    In a plane inclined by i, a dipole off the pole by t comes to latitude i + t, 90 degrees at most.
    """
    if polar.size == 0:
        return 0.5 * math.pi
    inclination = np.arccos(np.clip(np.abs(polar), 0.0, 1.0)).max()  # of the plane, up to 90 degrees
    tilt = math.acos(min(1.0, abs(float(direction[2]))))
    return min(0.5 * math.pi, float(inclination) + tilt)

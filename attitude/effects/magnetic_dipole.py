"""A residual magnetic dipole in the field of the central body."""

from __future__ import annotations

import math
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import model_validator

from ..documents.fields import Part
from ..documents.quantities import Angle, DipoleVector, FieldStrength, Length, Rate, check_positive
from ..errors import InputError
from ..kernels import layout
from ..orbit.path_states import least_distance, normals
from ..problem.initial_state import InitialState
from ..times import turn_rates
from . import central_body_rotation
from .effect import Torque, row

# The Earth's dipole for 2025.0: g10, g11, h11 in T and the radius they belong to in m (IGRF-14, IAGA 2024).
G10, G11, H11 = -29350.0e-9, -1410.3e-9, 4545.5e-9
RADIUS = 6371.2e3


class Source(NamedTuple):
    """The central body's dipole.

    Attributes
    ----------
    strength : T m3, field at the equator times the cube of the distance
    direction : (3,) of the dipole, from its south-seeking pole, in axes that turn with the body, z its pole
    turns : turns/s in two parts
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

    strength: FieldStrength
    radius: Length
    tilt: Angle = Angle(value=0.0, unit="deg")
    longitude: Angle = Angle(value=0.0, unit="deg")
    rotation: Rate | None = None

    @model_validator(mode="after")
    def _check(self) -> DipoleField:
        check_positive(self, "strength", "radius")
        return self

    def source(self) -> Source:
        tilt, longitude = self.tilt.si, self.longitude.si
        equatorial = math.sin(tilt)
        inwards = np.array(
            [equatorial * math.cos(longitude), equatorial * math.sin(longitude), math.cos(tilt)]
        )
        turns = (
            central_body_rotation.earth_turns()
            if self.rotation is None
            else turn_rates.turns(self.rotation.si)
        )
        return Source(self.strength.si * self.radius.si**3, -inwards, turns)


class MagneticDipole(Torque):
    """`{"type": "magnetic_dipole", "dipole": {"value": [0, 0, 1], "unit": "A m2"}}`: torque dipole x B.

    B is that of a tilted dipole which turns with the central body: the Earth's of IGRF-14 at 2025.0, whose
    other terms are a tenth of it at low orbits; or what `field` says.  The longitude at the epoch is by the
    Earth rotation angle (0 where the scene has no epoch).
    """

    NEEDS_ORBIT: ClassVar[bool] = True

    type: Literal["magnetic_dipole"]
    dipole: DipoleVector
    field: DipoleField | None = None

    def check(self, initial_state: InitialState) -> None:
        course = initial_state.course
        if (
            self.field is None
            and course is not None
            and course.central is not None
            and not course.central.is_earth
        ):
            raise InputError("field", None, "the field of the central body, which is not the Earth")

    def source(self) -> Source:
        if self.field is not None:
            return self.field.source()
        gauss = np.array([G11, H11, G10])
        size = float(np.linalg.norm(gauss))
        return Source(size * RADIUS**3, gauss / size, central_body_rotation.earth_turns())

    def rows(self, initial_state: InitialState) -> np.ndarray:
        strength, direction, turns = self.source()
        x, y, pole = central_body_rotation.equator(initial_state)
        angle = central_body_rotation.longitude_of_x(initial_state)
        c, s = math.cos(angle), math.sin(angle)
        at_epoch = np.array([c * direction[0] - s * direction[1], s * direction[0] + c * direction[1]])
        a = direction[2] * pole
        b = at_epoch[0] * x + at_epoch[1] * y
        dipole = initial_state.axes @ self.dipole.si
        return row(layout.MAGNETIC, dipole, strength, a, b, np.cross(pole, b), turns)[None]

    def size(self, initial_state: InitialState) -> float:
        """m B at the nearest point of the orbit and the highest magnetic latitude that it reaches."""
        if initial_state.course is None:
            raise InputError("orbit", None, "an orbit")
        strength, direction, _ = self.source()
        highest = _highest_latitude(
            normals(initial_state.course) @ central_body_rotation.equator(initial_state)[2], direction
        )
        field = (
            strength
            / least_distance(initial_state.course) ** 3
            * math.sqrt(1.0 + 3.0 * math.sin(highest) ** 2)
        )
        return float(np.linalg.norm(self.dipole.si)) * field


def _highest_latitude(polar: np.ndarray, direction: np.ndarray) -> float:
    """rad; polar (n,) cosines between orbit normal and pole.

    In a plane inclined by i, a dipole off the pole by t comes to latitude i + t, 90 degrees at most.
    """
    if polar.size == 0:
        return 0.5 * math.pi
    inclination = np.arccos(np.clip(np.abs(polar), 0.0, 1.0)).max()  # of the plane, up to 90 degrees
    tilt = math.acos(min(1.0, abs(float(direction[2]))))
    return min(0.5 * math.pi, float(inclination) + tilt)
